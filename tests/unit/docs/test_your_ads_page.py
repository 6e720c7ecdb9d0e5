"""docs/your-ads.md: its lane follower drives as the page says, and what it lists is there."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import scenarios
from openscenario.road.crosswalks import Crosswalk
from openscenario.road.network import RoadNetwork, load_network
from openscenario.road.positions import Pose, RoadPosition
from openscenario.road.route import RouteLane
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from vehicle import messages
from vehicle.messages import Command, Observation, VehicleDescription

PAGE = (Path(__file__).parents[3] / "docs" / "your-ads.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    return PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The lane follower as printed, as a command line names it."""
    path = tmp_path_factory.mktemp("mine") / "lane_keeper.py"
    (code,) = re.findall(r"```python\n(.*?)```", section("A lane follower"), re.DOTALL)
    path.write_text(code)
    return f"{path}:LaneKeeper"


def drive(stack: str, name: str, P: Mapping[str, float] | None = None, **options: Any) -> RunResult:
    result = run(scenarios.path(name), ads=stack, P=P or {}, **options)
    assert result.error is None
    return result


def test_it_drives_to_its_goal_and_fails_at_the_light_alone(stack: str) -> None:
    result = drive(stack, "traffic_light.xosc")
    failed = [verdict.short for verdict in result.verdicts if verdict.status != "PASS"]
    assert result.ending == "goal"
    assert [re.search(r"\((\w+)\)", text)[1] for text in failed] == ["RunsRed", "WaitsAtRed"]
    printed = re.findall(r"^  (PASS|FAIL) +(\w+ [\d.]+ ?[\w/^]*)", section("A lane follower"), re.MULTILINE)
    assert len(printed) == len(result.verdicts)
    for status, text in printed:
        assert any(v.status == status and text.strip() in v.message for v in result.verdicts), text


@pytest.mark.nightly
def test_round_the_town_it_keeps_to_its_lane_and_its_own_parameter_decides_how_well(stack: str) -> None:
    """Who steers at a point farther ahead cuts the bends more: a chord of length L leaves an arc by L^2 / 8 R."""
    near, far = (drive(stack, "urban.xosc", P, duration=70.0) for P in ({}, {"LK_look": 1.2}))
    assert near.metrics["road_departure"] == 0.0
    assert near.metrics["lateral_rmse_path"] < 0.1
    assert far.metrics["lateral_rmse_path"] > 2.0 * near.metrics["lateral_rmse_path"]


@pytest.mark.parametrize("row", re.findall(r"^\| `\w+` \|.*$", section("What it can ask"), re.MULTILINE))
def test_every_field_of_an_observation_that_is_listed_is_there(row: str) -> None:
    name = re.match(r"\| `(\w+)`", row)[1]
    assert name in Observation.__struct_fields__
    cell = row.split(" | ")[1]
    found = [word for word in re.findall(r"`(\w+)`", cell) if word[0].isupper()]
    fields = {field for kind in found for field in _fields(kind)} | set(VehicleDescription.__struct_fields__)
    for word in re.findall(r"`(?:description\.)?([a-z_]\w*)`", cell):
        assert word in fields, (name, word)


def test_every_field_of_an_observation_is_listed() -> None:
    listed = re.findall(r"^\| `(\w+)` \|", section("What it can ask"), re.MULTILINE)
    assert ["t", *listed] == list(Observation.__struct_fields__)
    assert all(f"`{name}`" in section("What it can ask") for name in Command.__struct_fields__)


def test_what_is_said_of_the_twins_sensors_is_what_they_do() -> None:
    from vehicle.sensors import default_sensors

    sensors = default_sensors()
    for name in ("gnss", "odometry", "imu", "lidar", "camera"):
        timing = getattr(sensors, name).timing
        said = f"{timing.rate:g} Hz" + (f", {timing.latency:g} s" if timing.latency else "")
        (row,) = re.findall(rf"^\| `{name}` \|.*\| (.*) \|$", section("What it can ask"), re.MULTILINE)
        assert row == said


def test_every_call_of_the_map_that_is_listed_can_be_made() -> None:
    network = load_network(scenarios.path("urban.xodr"))
    calls = re.findall(r"`([a-z_]+)\((.*?)\)`", section("What it can ask").split("| call |")[1])
    assert len(calls) >= 12
    at = network.lane_pose("1", -1, 20.0)
    place = network.locate(at.x, at.y, at.h)
    route = network.route(place[:3], network.advance(place, 30.0)[:3])
    values = {
        "x": at.x,
        "y": at.y,
        "h": at.h,
        "road": "1",
        "lane": -1,
        "s": 20.0,
        "offset": 0.5,
        "position": place,
        "ds": 10.0,
        "start": place[:3],
        "goal": route[-1][:2] + route[-1][3:],
        "route": route,
        "step": 0.5,
        "a": place,
        "b": network.advance(place, 10.0),
    }
    for name, arguments in calls:
        getattr(network, name)(*(values[word] for word in arguments.split(", ")))
    assert (type(place), type(at), type(route[0])) == (RoadPosition, Pose, RouteLane)
    assert network.distance(values["a"], values["b"]) == pytest.approx(10.0, abs=0.5)


def test_what_is_listed_of_the_results_is_there() -> None:
    text = section("What it can ask")
    assert all(f"`{name}`" in text for name in (*RoadPosition._fields, *Pose._fields))
    assert {"outline", "road", "s_from", "s_to"} <= set(Crosswalk._fields)
    assert all(hasattr(RoadNetwork, name) for name in ("crosswalks", "dead_end"))


def _fields(kind: str) -> tuple[str, ...]:
    found = getattr(messages, kind)
    return getattr(found, "__struct_fields__", None) or found._fields
