"""Each parameter of S: its values in the paper, the one place that it sets, and what it moves there: car or sensor.

At one end of their ranges seven of them change no metric of a scenario that ships (docs/ads.md), so drives alone would
not notice one that is read nowhere, or two that are exchanged.
"""

from __future__ import annotations

from dataclasses import fields
from math import radians
from pathlib import Path

import numpy as np
import pytest

from vehicle.messages import Surroundings
from vehicle.model.model_file import read_model
from vehicle.model.open_loop import Replay
from vehicle.model.simulator_parameters import S_PARAMETERS, apply_s, preset_s, scenario_parameters
from vehicle.model.vehicle_model import VehicleModel
from vehicle.sensors import default_sensors

# Table of Arango et al., Sensors 2026, 26, 1338: 1st | 5th | 10th iteration; PEDESTRIAN_speed of the 1st: DT; PE; RW.
PAPER = {
    "PEDESTRIAN_speed": "3.0; 1.75; 1.75 | 1.75 | 1.75",
    "EGO_mass": "1000 | 4000 | 8500",
    "EGO_max_steer_angle": "25 | 25 | 20",
    "EGO_dr_full_throttle": "0.15 | 0.05 | 0.05",
    "EGO_dr_zero_throttle": "0.10 | 0.50 | 0.50",
    "EGO_moi": "1.0 | 0.75 | 0.75",
    "THROTTLE_kp": "0.5 | 1.25 | 1.25",
    "THROTTLE_ki": "0.025 | 0.005 | 0.005",
    "THROTTLE_delay": "- | 0.15 | 0.15",
    "BRAKE_kp": "1.0 | 0.09 | 0.09",
    "BRAKE_ki": "0.0 | 0.0005 | 0.0005",
    "GNSS_x": "-0.6 | -0.6 | -1.0",
    "CAMERA_x": "0.375 | 0.375 | 0.4",
}
# A value of each unlike the twin's, and what of the model it sets: effect and key, or the car's own.
SETS = {
    "EGO_mass": (1460.0, {("car", "mass"): 1460.0, ("car", "yaw_inertia"): None}),  # inertia grows with the mass
    "EGO_max_steer_angle": (9.0, {("steer_angle_limit", "limit"): radians(9.0)}),
    "EGO_dr_full_throttle": (0.61, {("motor_damping", "full"): 0.61}),
    "EGO_dr_zero_throttle": (0.62, {("motor_damping", "zero"): 0.62}),
    "EGO_moi": (0.63, {("motor_inertia", "J"): 0.63}),
    "THROTTLE_kp": (0.64, {("accel_controller", "kp_drive"): 0.64}),
    "THROTTLE_ki": (0.65, {("accel_controller", "ki_drive"): 0.65}),
    "THROTTLE_delay": (0.66, {("drive_delay", "T"): 0.66}),
    "BRAKE_kp": (0.67, {("accel_controller", "kp_brake"): 0.67}),
    "BRAKE_ki": (0.68, {("accel_controller", "ki_brake"): 0.68}),
}
MOVED = {"GNSS_x": 1.3, "CAMERA_x": -0.9}  # m from the ego's centre


@pytest.fixture(scope="module")
def tabby(scenarios_dir: Path) -> VehicleModel:
    return read_model(scenarios_dir / "models" / "tabby_evo.toml")


def state(model: VehicleModel) -> dict[tuple[str, str], float]:
    """Every number of a model; of effects that it lacks, nothing."""
    car = {("car", field.name): getattr(model.car, field.name) for field in fields(model.car)}
    return car | {(a.name, key): value for a in model.effects for key, value in a.values.items()}


def test_every_preset_is_the_papers_table() -> None:
    assert [parameter.name for parameter in S_PARAMETERS] == list(PAPER)
    for column, iteration in enumerate((1, 5, 10)):
        for place, stage in enumerate(("dt", "pe", "rw")):
            told = {name: row.split("|")[column].split(";") for name, row in PAPER.items()}
            values = {name: cells[place if len(cells) > 1 else 0].strip() for name, cells in told.items()}
            expected = {name: float(value) for name, value in values.items() if value != "-"}
            assert preset_s(iteration, stage) == expected  # type: ignore[arg-type]


def test_every_parameter_is_tested_here() -> None:
    assert sorted([*SETS, *MOVED, "PEDESTRIAN_speed"]) == sorted(PAPER)


@pytest.mark.parametrize("name", SETS)
def test_it_sets_its_own_place_and_no_other(tabby: VehicleModel, name: str) -> None:
    value, places = SETS[name]
    before, after = state(tabby), state(apply_s(tabby, default_sensors(), {name: value})[0])
    neutral = {  # of an effect that this adds, the other values say that it does nothing
        key: 0.0 for key in after if key not in before and key not in places
    }
    assert {key: after[key] for key in neutral} == neutral
    changed = {key for key in after if key not in neutral and after[key] != before.get(key)}
    assert changed == set(places)
    for key, expected in places.items():
        assert expected is None or after[key] == pytest.approx(expected)


@pytest.mark.parametrize("name", SETS)
def test_it_moves_the_car(tabby: VehicleModel, name: str) -> None:
    """Full throttle, rolling, braking, all of it in a bend at the end stop of the steering."""
    t = np.arange(0.0, 9.0, 0.02)
    throttle, brake = np.where(t < 4.0, 0.6, 0.0), np.where(t > 6.5, 0.3, 0.0)
    commands = {"throttle_cmd": throttle, "brake_cmd": brake, "steer_cmd": np.full(len(t), 0.3)}

    def driven(model: VehicleModel) -> np.ndarray:
        return np.asarray(Replay(model, t, commands).run())

    other = driven(apply_s(tabby, default_sensors(), {name: SETS[name][0]})[0])
    assert np.abs(other - driven(tabby)).max() > 0.05  # m, m/s or rad


def test_the_antenna_moves_with_its_parameter(tabby: VehicleModel) -> None:
    assert default_sensors().gnss.mount.x - tabby.car.center_x == pytest.approx(float(PAPER["GNSS_x"].split("|")[2]))
    moved = apply_s(tabby, default_sensors(), {"GNSS_x": MOVED["GNSS_x"]})[1]
    assert moved.gnss.mount.x == pytest.approx(tabby.car.center_x + MOVED["GNSS_x"])
    assert moved.camera == default_sensors().camera
    assert moved.describe(tabby.description()).gnss_x == pytest.approx(tabby.car.center_x + MOVED["GNSS_x"])


def test_the_camera_sees_from_where_its_parameter_puts_it(tabby: VehicleModel) -> None:
    """Lower edge of a box on the ground: focal length times height of the camera over the distance from it."""
    assert default_sensors().camera.mount.x - tabby.car.center_x == pytest.approx(
        float(PAPER["CAMERA_x"].split("|")[2])
    )
    box = np.array([[25.0, 0.0, 0.75, 0.0, 4.0, 1.8, 1.5, 0.0, 0.0]])  # its nearer face 23 m ahead of the rear axle
    world = Surroundings(box, np.zeros(1), ("box",))
    for offset in (MOVED["CAMERA_x"], 0.4):
        sensors = apply_s(tabby, default_sensors(), {"CAMERA_x": offset})[1]
        assert sensors.gnss == default_sensors().gnss
        assert sensors.describe(tabby.description()).camera_x == pytest.approx(tabby.car.center_x + offset)
        edges = []
        for seed in range(200):  # the detector's noise is 2 px
            running = sensors.camera.start(0.0, np.random.SeedSequence(seed))
            running.measure(0.0, 0.0, 0.0, 0.0, 0.0, world)
            frame = running.arrived(sensors.camera.timing.latency)
            edges += [seen.v_max for seen in frame.boxes] if frame is not None else []
        distance = 23.0 - tabby.car.center_x - offset
        assert np.mean(edges) == pytest.approx(360.0 + 800.0 * sensors.camera.mount.z / distance, abs=0.6)


def test_the_pedestrians_speed_is_the_scenarios() -> None:
    assert scenario_parameters({"PEDESTRIAN_speed": 1.4}) == {"pedestrian_speed": 1.4}
