"""The shipped scenarios: valid, complete, and what their catalogues claim is what the paper states."""

from __future__ import annotations

import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest
from lxml import etree

import scenarios

OF_THE_PAPER = ("overtaking", "pedestrian_crossing", "urban")
MORE = (
    "amber_close", "cut_in", "cyclist", "emergency_stop", "follow", "junction", "merging", "occluded_child",
    "red_ahead", "slope_stop", "stop_and_go", "traffic_light", "vehicle_from_behind",
)  # fmt: skip
NAMES = (*OF_THE_PAPER, *MORE)
PARAMETERS = {
    "overtaking": {"ego_speed", "target_position", "target_lateral_offset", "trigger_distance"},
    "pedestrian_crossing": {"ego_speed", "pedestrian_speed", "trigger_distance"},
    "urban": {"ego_speed", "target_position", "target_lateral_offset", "pedestrian_speed", "trigger_distance"},
    "follow": {"ego_speed", "lead_speed", "lead_gap", "lead_deceleration", "stop_time"},
    "traffic_light": {"ego_speed", "trigger_distance", "red_time"},
    "junction": {"ego_speed", "oncoming_speed", "oncoming_position"},
    "amber_close": {"ego_speed", "trigger_distance"},
    "cut_in": {"ego_speed", "trigger_distance", "cut_in_speed"},
    "cyclist": {"ego_speed", "cyclist_speed", "cyclist_gap"},
    "emergency_stop": {"ego_speed", "trigger_distance", "walk_speed"},
    "merging": {"main_speed", "main_position"},
    "occluded_child": {"ego_speed", "trigger_distance", "child_speed"},
    "red_ahead": {"ego_speed", "green_distance"},
    "slope_stop": {"ego_speed", "red_time"},
    "stop_and_go": {"jam_speed", "jam_deceleration"},
    "vehicle_from_behind": {"target_position", "follower_speed"},
}
CATALOGUES = ("catalogs/vehicles/vehicle_catalog.xosc", "catalogs/pedestrians/pedestrian_catalog.xosc")


def read(name: str) -> etree._Element:
    return etree.parse(str(scenarios.path(name))).getroot()


@pytest.mark.parametrize("name", [*(f"{name}.xosc" for name in NAMES), *CATALOGUES])
def test_valid_against_the_1_2_schema(name: str) -> None:
    spec = find_spec("scenariogeneration")
    if spec is None or spec.origin is None:
        pytest.skip("scenariogeneration, which brings the schemas, is not installed")
    schema = Path(spec.origin).parents[1] / "schemas" / "OpenSCENARIO_1_2.xsd"
    etree.XMLSchema(etree.parse(str(schema))).assertValid(read(name))


@pytest.mark.parametrize("name", NAMES)
def test_every_parameter_is_declared_with_a_range_around_its_value(name: str) -> None:
    declared = {item.get("name"): item for item in read(f"{name}.xosc").iter("ParameterDeclaration")}
    assert PARAMETERS[name] <= declared.keys()
    for item in declared.values():
        limits = {limit.get("rule"): float(limit.get("value")) for limit in item.iter("ValueConstraint")}
        assert limits["greaterOrEqual"] < float(item.get("value")) < limits["lessOrEqual"]


@pytest.mark.parametrize("name", NAMES)
def test_ego_is_called_ego(name: str) -> None:
    assert read(f"{name}.xosc").find("Entities/ScenarioObject").get("name") == "Ego"


def test_every_file_is_named_here() -> None:
    folder = scenarios.path("urban.xosc").parent
    assert {file.stem for file in folder.glob("*.xosc")} == set(NAMES)
    assert {file.name.removesuffix(".gates.toml") for file in folder.glob("*.gates.toml")} == set(NAMES)


@pytest.mark.parametrize("name", OF_THE_PAPER)
def test_gates_bound_what_the_issue_fixes(name: str) -> None:
    gates = tomllib.loads(scenarios.path(f"{name}.gates.toml").read_text())
    bounds = {gate["metric"]: gate.get("max", gate.get("min")) for gate in gates["gate"] if "between" not in gate}
    crossing = name == "pedestrian_crossing"
    ttc, tet = (0.5, 0.0) if crossing else (1.0, 1.0)
    assert bounds == {
        "collision": 0, "road_departure": 0, "max_ttc_inverse": ttc, "tet": tet,
        "lateral_rmse_path": 0.4, "max_jerk": 4.0, "events_fired": 0, "goal_reached": 1,
    }  # fmt: skip


def test_tabby_evo_has_the_published_size() -> None:
    vehicle = read(CATALOGUES[0]).find("Catalog/Vehicle[@name='tabby_evo']")
    size = vehicle.find("BoundingBox/Dimensions")
    assert [float(size.get(key)) for key in ("length", "width", "height")] == [3.03, 1.488, 1.38]
    assert float(vehicle.get("mass")) == 730.0
    front = vehicle.find("Axles/FrontAxle")
    assert float(front.get("positionX")) == 2.36
    assert float(front.get("trackWidth")) == 1.315
    assert float(front.get("maxSteering")) == pytest.approx(0.34907, abs=1e-5)  # 20 deg
    assert float(front.get("wheelDiameter")) == pytest.approx(15 * 0.0254 + 2 * 0.55 * 0.175)  # 175/55R15


def test_tabby_evo_is_placed_by_its_rear_axle() -> None:
    vehicle = read(CATALOGUES[0]).find("Catalog/Vehicle[@name='tabby_evo']")
    length, wheelbase = 3.03, 2.36
    overhang = (length - wheelbase) / 2.0
    centre = vehicle.find("BoundingBox/Center")
    assert float(centre.get("x")) == pytest.approx(wheelbase + overhang - length / 2.0)
    assert float(centre.get("z")) == pytest.approx(1.38 / 2.0)
    assert float(vehicle.find("Axles/RearAxle").get("positionX")) == 0.0


def test_unknown_name_says_so() -> None:
    with pytest.raises(FileNotFoundError, match="nothing_such"):
        scenarios.path("nothing_such.xosc")
