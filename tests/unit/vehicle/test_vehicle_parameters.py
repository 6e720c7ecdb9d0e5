"""S of the paper: declared, checked, and applied on model and sensors."""

from __future__ import annotations

from math import radians
from pathlib import Path

import pytest

from vehicle.model.errors import ModelError
from vehicle.model.model_file import read_model
from vehicle.model.simulator_parameters import S_PARAMETERS, apply_s, preset_s, scenario_parameters
from vehicle.model.vehicle_model import VehicleModel
from vehicle.sensors import default_sensors


@pytest.fixture
def tabby(scenarios_dir: Path) -> VehicleModel:
    return read_model(scenarios_dir / "models" / "tabby_evo.toml")


def test_presets_are_those_of_the_papers_table() -> None:
    assert preset_s(10)["EGO_mass"] == 8500.0
    assert preset_s(5)["BRAKE_kp"] == 0.09
    assert preset_s(1)["GNSS_x"] == -0.6
    assert "THROTTLE_delay" not in preset_s(1)
    assert (preset_s(1, "dt")["PEDESTRIAN_speed"], preset_s(1, "rw")["PEDESTRIAN_speed"]) == (3.0, 1.75)


def test_every_parameter_has_unit_range_and_meaning_and_presets_within() -> None:
    for parameter in S_PARAMETERS:
        declared = parameter.declaration
        assert all((declared.unit, declared.meaning))
        for value in (parameter.first, parameter.fifth, parameter.tenth):
            assert value is None or declared.check(value) == value


def test_every_preset_can_be_applied(tabby: VehicleModel) -> None:
    for iteration in (1, 5, 10):
        apply_s(tabby, default_sensors(), preset_s(iteration))  # type: ignore[arg-type]


def test_each_parameter_goes_where_its_meaning_says(tabby: VehicleModel) -> None:
    values = {
        "EGO_mass": 900.0,
        "EGO_max_steer_angle": 25.0,
        "EGO_moi": 0.75,
        "EGO_dr_zero_throttle": 0.5,
        "THROTTLE_delay": 0.15,
        "THROTTLE_kp": 1.25,
        "BRAKE_ki": 0.0005,
        "GNSS_x": -0.6,
        "CAMERA_x": 0.375,
    }
    model, sensors = apply_s(tabby, default_sensors(), values)
    assert model.car.mass == 900.0
    assert model.car.command_mass == 730.0
    assert model.value("steer_angle_limit", "limit") == pytest.approx(radians(25.0))
    assert model.value("motor_inertia", "J") == 0.75
    assert model.value("motor_damping", "zero") == 0.5
    assert model.value("drive_delay", "T") == 0.15
    assert model.value("accel_controller", "kp_drive") == 1.25
    assert model.value("accel_controller", "ki_brake") == 0.0005
    assert sensors.gnss is not None
    assert sensors.gnss.mount.x == pytest.approx(1.18 - 0.6)
    assert sensors.camera is not None
    assert sensors.camera.mount.x == pytest.approx(1.18 + 0.375)


def test_the_stack_is_not_told_of_a_mass_set_through_s(tabby: VehicleModel) -> None:
    heavy, _ = apply_s(tabby, default_sensors(), {"EGO_mass": 1500})
    assert heavy.description().mass == 730.0
    assert heavy.description().max_acceleration == tabby.description().max_acceleration


def test_the_pedestrians_speed_belongs_to_the_scenario(tabby: VehicleModel) -> None:
    assert apply_s(tabby, default_sensors(), {"PEDESTRIAN_speed": 1.5})[0] == tabby
    assert scenario_parameters({"PEDESTRIAN_speed": "1.5", "EGO_mass": 800}) == {"pedestrian_speed": 1.5}


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("EGO_mas", 900, "did you mean 'EGO_mass'?"),
        ("EGO_mass", 20, "300 to 10000 kg"),
        ("EGO_mass", float("nan"), "found nan"),
        ("EGO_mass", "heavy", "must be a number"),
    ],
)
def test_wrong_names_and_values_are_refused(tabby: VehicleModel, name: str, value: object, says: str) -> None:
    with pytest.raises(ModelError) as caught:
        apply_s(tabby, default_sensors(), {name: value})  # type: ignore[dict-item]
    assert says in str(caught.value)
