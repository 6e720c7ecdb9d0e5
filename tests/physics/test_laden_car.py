"""A load: forces of drive, brakes and air, and their limits, stay what they are, while weight and inertia grow."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from vehicle_models import CAR, model

from vehicle.messages import VehicleState
from vehicle.model.open_loop import Replay
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import Inputs

G = 9.80665
V, AX = 3, 5  # columns of a row
LADEN = 1.4
MASS = CAR["mass"]
FORCE = CAR["gear_ratio"] / CAR["wheel_radius"]  # of the wheels over torque of the motor [1/m]

Effects = dict[str, dict[str, float]]


def laden(effects: Effects, accel: float, v: float = 0.0, seconds: float = 1.0) -> float:
    """Speed [m/s] after some time of a command."""
    car = Plant(model(effects={"mass": {"ratio": LADEN}, **effects}))
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=v))
    car.command(0.0, accel=accel)
    return float(car.advance(round(1e3 * seconds))[-1, 5])


def test_a_motor_gives_its_torque_to_a_laden_car_too() -> None:
    """128 N m through a gear of 6 on wheels of 0.3 m: 2560 N on 1400 kg, however much more is asked for."""
    motor = {"torque": 128.0, "corner_speed": 500.0, "power": 1e6, "rated_speed": 600.0}
    assert laden({"motor_torque": motor}, 9.0) == pytest.approx(128.0 * FORCE / (LADEN * MASS), rel=1e-9)


def test_power_speeds_a_laden_car_up_by_the_square_root_law() -> None:
    """P = 10 W/kg of the car without its load: m v^2/2 grows by P t."""
    assert laden({"power_limit": {"limit": 10.0}}, 9.0, 5.0, 5.0) == pytest.approx(
        math.sqrt(5.0**2 + 2.0 * 10.0 / LADEN * 5.0), rel=3e-4
    )


@pytest.mark.parametrize(
    ("limit", "asked", "found"),
    [("drive_torque_limit", 9.0, 2.0), ("drive_torque_limit", 1.0, 1.0), ("brake_limit", -9.0, -4.0)],
)
def test_limits_of_drive_and_brake_are_forces(limit: str, asked: float, found: float) -> None:
    """2 and 4 m/s^2 of the car without its load."""
    gained = laden({limit: {"limit": abs(found) if abs(asked) > 5.0 else 5.0}}, asked, 10.0) - 10.0
    assert gained == pytest.approx(found / LADEN, rel=1e-9)


def test_a_torque_that_is_ramped_up_takes_as_long_with_a_load() -> None:
    """Up to 3 m/s^2 by 2 m/s^3 in 1.5 s, then held: the force has the same course."""
    assert laden({"jerk_limit": {"limit": 2.0}}, 3.0, 0.0, 2.5) == pytest.approx(
        (0.5 * 3.0 * 1.5 + 3.0 * 1.0) / LADEN, rel=1e-6
    )


def test_the_air_slows_a_laden_car_down_less() -> None:
    """v = v0/(1 + k v0 t/ratio)."""
    assert laden({"aero_drag": {"k": 0.004}}, 0.0, 25.0, 8.0) == pytest.approx(
        25.0 / (1.0 + 0.004 / LADEN * 25.0 * 8.0), rel=1e-4
    )


def test_weight_and_what_rolls_under_it_grow_with_the_load() -> None:
    """Down a slope of 0.05 rad with a rolling resistance of 0.2 m/s^2: g sin(slope) - c, whatever the mass."""
    downhill: Effects = {"road_grade": {"slope": -0.05}, "rolling_resistance": {"c": 0.2}}
    assert laden(downhill, 0.0, 5.0) == pytest.approx(5.0 + G * math.sin(0.05) - 0.2, rel=1e-9)


def test_the_throttle_of_a_laden_car_is_the_pedal() -> None:
    """At full throttle the motor damps by 0.4 N m s, at none by nothing: it holds back 0.4 (i/r)^2 v of its force."""
    car = Plant(
        replace(
            model(effects={"mass": {"ratio": LADEN}, "motor_damping": {"full": 0.4}}),
            inputs=Inputs(longitudinal=("throttle_cmd", "brake_cmd"), full_throttle=4.0),
        )
    )
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=3.0))
    car.command(0.0, throttle=1.0)
    v1 = car.advance(1000)[-1, 5]
    rate = 0.4 * FORCE**2 / (LADEN * MASS)
    last = 4.0 / LADEN / rate  # speed at which the motor holds all of its force back
    assert v1 == pytest.approx(last + (3.0 - last) * math.exp(-rate), rel=1e-3)


def test_a_lifted_pedal_slows_a_laden_car_down_less_and_brakes_allow_for_it() -> None:
    """The drag of the drive is a force; beside it, the brakes add what is missing to the one that is asked for."""
    lifted: Effects = {"lift_off_braking": {"a": 0.7}}
    assert laden(lifted, 0.0, 10.0) == pytest.approx(10.0 - 0.7 / LADEN, rel=1e-9)
    assert laden(lifted, -2.0, 10.0) == pytest.approx(10.0 - 2.0 / LADEN, rel=1e-9)


@pytest.mark.parametrize(
    "effects",
    [
        {"motor_inertia": {"J": 0.4}, "motor_damping": {"zero": 0.2, "full": 0.05}},
        {"gear_inertia": {"share": 0.3, "v1": 4.0}, "power_limit": {"limit": 9.0}},
        {"drive_lag": {"tau": 0.3}, "brake_lag": {"tau": 0.2}, "brake_limit": {"limit": 1.5}},
        {"lift_off_braking": {"a": 0.6, "lag": 0.2}, "creep": {"a": 0.4}, "viscous_resistance": {"c": 0.03}},
        {"headwind": {"speed": 6.0, "k": 0.003}, "road_grade": {"slope": 0.06}, "drive_delay": {"T": 0.13}},
    ],
)
def test_a_load_is_the_same_whether_it_stands_among_the_effects_or_in_the_data_of_the_car(effects: Effects) -> None:
    """A file that says mass = 1400 and command_mass = 1000 means what one of 1000 kg with a ratio of 1.4 does."""
    t = np.arange(0.0, 30.0, 0.02)
    commands = {"steer_cmd": 0.0 * t, "accel_cmd": 2.5 * np.sin(0.7 * t)}
    start = {"starts": np.array([0]), "states": np.array([[0.0, 0.0, 0.0, 5.0, math.nan, math.nan]])}
    light = model(effects={"mass": {"ratio": LADEN}, **effects})
    heavy = model(effects=effects).with_car({"mass": LADEN * MASS, "command_mass": MASS})
    shown, stated = (Replay(one, t, commands).run(**start) for one in (light, heavy))  # type: ignore[arg-type]
    assert np.ptp(shown[:, V]) > 3.0
    assert shown[:, [V, AX]] == pytest.approx(stated[:, [V, AX]], abs=1e-9)
