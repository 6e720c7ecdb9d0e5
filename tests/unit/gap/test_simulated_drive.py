"""A simulated drive: the limits that it must keep, its columns, and the robot that plays it."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES
from pytest_dvp.gap.manoeuvres.driving_limits import Area
from pytest_dvp.gap.manoeuvres.limit_violations import violations
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive, _set, columns, inputs_of
from pytest_dvp.gap.manoeuvres.steering_robot import CommandPlayer
from tests.unit.gap.drivers import ENVELOPE
from vehicle.model.car import make_car
from vehicle.model.command_inputs import Inputs

CAR = make_car({"wheelbase": 2.45, "cg_to_front_axle": 1.15, "mass": 1150.0})


def drive_of(v: float, n: int = 100, **given: float) -> tuple[Any, ...]:
    t = 0.02 * np.arange(n)
    motion = np.zeros((n, 5))
    motion[:, 3] = v
    for name, value in given.items():
        motion[:, {"x": 0, "y": 1, "yaw": 2, "rate": 4}[name]] = value
    return t, motion, np.zeros(n)


BIG = Area(-50.0, 50.0, -30.0, 30.0)


def test_what_keeps_within_the_limits_violates_nothing() -> None:
    t, motion, steer = drive_of(10.0, rate=0.4)
    steer[:] = -0.45
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_each_limit_is_told_just_beyond_it(sign: float) -> None:
    t, motion, steer = drive_of(sign * 10.01)
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ("speed 10, at most 10 m/s",)
    t, motion, steer = drive_of(5.0, rate=sign * 0.81)
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ("lateral acceleration 4.05, at most 4 m/s^2",)
    t, motion, steer = drive_of(5.0)
    steer[7] = sign * 0.46
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ("steering 0.46, at most 0.45 rad",)
    for slope, told in ((1.99, ()), (2.02, ("acceleration 2.02, at most 2 m/s^2",)), (-3.99, ()),
                        (-4.02, ("deceleration 4.02, at most 4 m/s^2",))):  # fmt: skip
        motion[:, 3] = 5.0 + slope * (t - 1.0)
        assert violations(t, motion, np.zeros(100), ENVELOPE, BIG, CAR) == told


@pytest.mark.parametrize("slope", [0.0, 0.4, -0.4])
def test_who_brakes_less_than_a_low_limit_violates_nothing(slope: float) -> None:
    low = dataclasses.replace(ENVELOPE, max_acceleration=0.5, max_deceleration=0.5)
    t, motion, steer = drive_of(5.0)
    motion[:, 3] += slope * t
    assert violations(t, motion, steer, low, BIG, CAR) == ()
    assert violations(t[:3], motion[:3], steer[:3], low, BIG, CAR) == ()  # too short for an acceleration


def test_an_acceleration_is_that_over_a_tenth_of_a_second() -> None:
    t, motion, steer = drive_of(5.0)
    motion[50, 3] = 5.19  # for a row: 9.5 m/s^2 from row to row, 1.9 over five
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ()
    motion[50, 3] = 5.21
    assert len(violations(t, motion, steer, ENVELOPE, BIG, CAR)) == 1


def test_no_corner_of_the_car_leaves_the_ground() -> None:
    ahead, behind, side = CAR.center_x + 0.5 * CAR.length, CAR.center_x - 0.5 * CAR.length, 0.5 * CAR.width
    for yaw, limits in (
        (0.0, (-50.0 - behind, 50.0 - ahead, -30.0 + side, 30.0 - side)),
        (0.5 * math.pi, (-50.0 + side, 50.0 - side, -30.0 - behind, 30.0 - ahead)),
    ):
        for k, value in enumerate(limits):
            out = -1.0 if k % 2 == 0 else 1.0
            where = {"x": 0.0, "y": 0.0, ("x" if k < 2 else "y"): value}
            for off, words in ((-0.01, ()), (0.02, ("the area of 100 x 60 m, by 0.02 m",))):
                place = dict(where)
                place["x" if k < 2 else "y"] += off * out
                assert violations(*drive_of(1.0, yaw=yaw, **place), ENVELOPE, BIG, CAR) == words


@pytest.mark.parametrize("yaw", [0.5, -0.5, math.pi - 0.5, 0.5 - math.pi])
def test_of_a_car_that_stands_at_an_angle_each_corner_counts(yaw: float) -> None:
    """Each of the four is the one that lies farthest to the left, or to the right, at one of these headings."""
    corners = [(CAR.center_x + a * 0.5 * CAR.length, b * 0.5 * CAR.width) for a in (1.0, -1.0) for b in (1.0, -1.0)]
    across = [u * math.cos(yaw) - w * math.sin(yaw) for u, w in corners]
    for border, reach in ((-50.0, min(across)), (50.0, max(across))):
        for off, told in ((-0.01, False), (0.01, True)):
            x = border - reach + off * math.copysign(1.0, border)
            assert bool(violations(*drive_of(1.0, yaw=yaw, x=x), ENVELOPE, BIG, CAR)) is told


def test_an_acceleration_becomes_shares_of_full_pedals() -> None:
    inputs = Inputs(
        longitudinal=("throttle_cmd", "brake_pressure"), full_throttle=2.5, full_brake=8.0, full_pressure=60.0
    )
    accel = np.array([1.0, -2.0, 9.0, -20.0])
    found = inputs_of(inputs, accel, np.array([1.0, 2.0, 3.0, 4.0]))
    assert list(found) == ["throttle_cmd", "brake_pressure"]
    assert found["throttle_cmd"] == pytest.approx([0.4, 0.0, 1.0, 0.0])
    assert found["brake_pressure"] == pytest.approx([0.0, 15.0, 0.0, 60.0])
    current = inputs_of(
        Inputs(longitudinal=("motor_current",), full_throttle=2.0, full_brake=4.0, full_current=30.0), accel, accel
    )
    assert current["motor_current"] == pytest.approx([15.0, -15.0, 30.0, -30.0])
    assert inputs_of(Inputs(longitudinal=("speed_cmd",)), accel, np.arange(4.0))["speed_cmd"].tolist() == [
        0.0,
        1.0,
        2.0,
        3.0,
    ]


@pytest.mark.parametrize(
    ("name", "value", "row"),
    [("accel_cmd", 0.5, [0, 0.5, 0, 0, 0, 0]), ("throttle_cmd", 0.5, [0, 0, 0.5, 0, 0, 0]),
     ("brake_cmd", 0.5, [0, 0, 0, 0.5, 0, 0]), ("speed_cmd", 0.5, [0, 0, 0, 0, 0.5, 0]),
     ("v", 0.5, [0, 0, 0, 0, 0, 0.5]),
     ("brake_pressure", 30.0, [0, 0, 0, 0.5, 0, 0]), ("motor_current", 12.0, [0, 0, 0.4, 0, 0, 0]),
     ("motor_current", -12.0, [0, 0, 0, 0.4, 0, 0])],
)  # fmt: skip
def test_an_input_has_its_place_in_the_row_of_the_kernel(name: str, value: float, row: list[float]) -> None:
    inputs = Inputs(full_pressure=60.0, full_current=30.0)
    found = np.zeros((1, 6))
    _set(found, inputs, name, value)
    assert found[0] == pytest.approx(row)


def test_commands_of_a_drive_are_in_the_scale_of_their_columns() -> None:
    inputs = Inputs(steer="wheel", longitudinal=("accel_cmd",), steer_scale=0.5, steer_zero=0.1)
    wishes = np.array([[1.0, 0.3, 5.0], [-2.0, -0.1, 4.0]])
    drive = Drive(MANOEUVRES[0], 1.0, BIG, np.array([0.0, 0.02]), wishes, np.zeros((2, 5)))
    found = columns(drive, inputs)
    assert list(found) == ["t", "wheel", "accel_cmd"]
    assert found["wheel"] == pytest.approx([0.4, -0.4])
    assert found["accel_cmd"].tolist() == [1.0, -2.0]
    assert drive.seconds == 0.02


def test_a_robot_plays_the_command_of_now_and_shares_of_the_pedals(tmp_path: Path) -> None:
    path = tmp_path / "wanted.csv"
    path.write_text(
        "wanted_accel [m/s^2],t [s],wanted_steer [rad]\n1,0,0.1\n-3,0.5,0.2\n9,1,0.3\n-20,1.5,0.4\n-1,2,0.5\n"
    )
    robot = CommandPlayer(path, SimpleNamespace(max_acceleration=2.0, max_deceleration=6.0))  # type: ignore[arg-type]
    asked = [robot.tick(SimpleNamespace(t=t)) for t in (-1.0, 0.0, 0.4, 0.5, 1.2, 1.5, 2.0, 99.0)]  # type: ignore[arg-type]
    assert [c.t for c in asked] == [-1.0, 0.0, 0.4, 0.5, 1.2, 1.5, 2.0, 99.0]
    assert [c.steer for c in asked] == pytest.approx([0.1, 0.1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.5])
    assert [c.accel for c in asked] == pytest.approx([1.0, 1.0, 1.0, -3.0, 9.0, -20.0, -1.0, -1.0])
    assert [c.throttle for c in asked] == pytest.approx([0.5, 0.5, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert [c.brake for c in asked] == pytest.approx([0.0, 0.0, 0.0, 0.5, 0.0, 1.0, 1.0 / 6.0, 1.0 / 6.0])
