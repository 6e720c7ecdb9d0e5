"""Each limit by which the doctor tells the unit of an angle, just short of it and just past it.

A car at 10 m/s weaves. What is told costs one for each wrong column, and two for what is impossible: two witnesses that
disagree, a turn harder or a wheel wider than any car's.
"""

from __future__ import annotations

from math import degrees, radians, sqrt

import numpy as np
import pytest
from known_motion import STEP, findings, rate_and_integral, times

from openscenario.findings import Finding
from pytest_dvp.logs.log_contents import FloatArray

SPEED = 10.0  # m/s
T = times(60.0)
V = np.full(len(T), SPEED)
RATE, YAW = (signal(T) for signal in rate_and_integral(0.1, 0.6, deviation=0.1))  # rad/s, rad
TURNED = {"t": T, "v": V, "yaw_rate": RATE, "ay": SPEED * RATE}
DEGREES = "degrees stored as radians"
RADIANS = "radians stored as degrees"
HAND_WHEEL = "the hand wheel's angle for the road wheel's"


def told(columns: dict[str, FloatArray]) -> list[Finding]:
    return findings(columns, "log.implausible_range")


def steered(wheelbase: float) -> FloatArray:
    """Angle [rad] of the road wheels of a car with this wheelbase [m]."""
    return np.asarray(wheelbase * RATE / SPEED)


@pytest.mark.parametrize(("read", "text"), [(degrees(1.0), DEGREES), (radians(1.0), RADIANS)])
@pytest.mark.parametrize(("scale", "seen"), [(2.4, True), (1 / 2.4, True), (2.6, False), (1 / 2.6, False)])
def test_a_gyro_in_another_unit_may_differ_by_two_and_a_half_times_as_well(
    read: float, text: str, scale: float, seen: bool
) -> None:
    """Farther away no unit explains what it says."""
    gyro = 0.2 * read * scale * RATE
    found = told({"t": T, "v": V, "yaw": 0.2 * YAW, "yaw_rate": gyro, "ay": 0.2 * SPEED * RATE})
    assert [(each.element, each.text) for each in found] == [("column yaw_rate", text)] * seen


@pytest.mark.parametrize(("lateral", "text"), [(57.0, []), (63.0, [DEGREES])])
def test_no_vehicle_turns_harder_than_sixty_metres_per_second_squared(lateral: float, text: list[str]) -> None:
    turn = lateral / SPEED * np.sign(np.sin(0.5 * T) + 1e-9)
    assert [each.text for each in told({"t": T, "v": V, "yaw_rate": turn})] == text


def test_no_road_wheel_turns_wider_than_one_and_a_fifth_radians() -> None:
    """Nothing else tells the ratio of a hand wheel: then it is the middle of the usual ones, 8 to 25."""
    wave = np.sin(0.5 * T)
    assert told({"t": T, "v": V, "steer": 1.15 * wave}) == []
    (finding,) = told({"t": T, "v": V, "steer": 1.25 * wave})
    assert finding.text.startswith(DEGREES)
    assert finding.allowed == "a road-wheel angle, up to 1.2 rad"
    assert f"`ratio = {sqrt(8.0 * 25.0):.0f}`, or what the car has" in finding.hint


@pytest.mark.parametrize(
    ("wheelbase", "text"),
    [(0.075, [RADIANS]), (0.085, []), (19.0, []), (21.0, [f"{DEGREES}, or {HAND_WHEEL}"])],
)
def test_a_wheelbase_is_that_of_a_model_car_or_of_a_bus_that_understeers(wheelbase: float, text: list[str]) -> None:
    """8 cm to 20 m."""
    assert [each.text for each in told({**TURNED, "steer": steered(wheelbase)})] == text


@pytest.mark.parametrize(("ratio", "first"), [(26.5, "give the steering ratio"), (29.7, "write `steer [deg]`")])
def test_a_hand_wheel_is_told_rather_than_degrees_where_its_ratio_is_nearer(ratio: float, first: str) -> None:
    """Of a usual car, 2.7 m long between its axles. As a factor, 28.3 is as far from 14 as from 57.3."""
    (finding,) = told({**TURNED, "steer": ratio * steered(2.7)})
    assert finding.element == "column steer"
    assert finding.hint.startswith(first)
    assert f"`ratio = {ratio:.0f}`" in finding.hint  # the wheelbase is taken for the usual one


@pytest.mark.parametrize(("ratio", "elements"), [(4.8, []), (5.2, ["column steer_cmd"])])
@pytest.mark.parametrize("inverse", [False, True])
def test_wanted_and_measured_steering_may_differ_by_five_times(
    ratio: float, elements: list[str], inverse: bool
) -> None:
    """The larger one is told."""
    small, large = ("steer_cmd", "steer") if inverse else ("steer", "steer_cmd")
    found = told({"t": T, "v": V, small: 0.6 * RATE, large: 0.6 * ratio * RATE})
    assert [each.element for each in found] == [each.replace("steer_cmd", large) for each in elements]


@pytest.mark.parametrize(("late", "elements"), [(0.9, ["column yaw_rate"]), (1.2, [])])
def test_a_sensor_may_be_a_second_late_and_is_not_compared_beyond(late: float, elements: list[str]) -> None:
    """Turns without any memory: means over 0.4 s that begin 0.2 s apart share half of it, and are alike by half, where
    0.6 would be needed. What is later than a second is therefore like nothing."""
    turn = 0.05 * np.random.default_rng(4).normal(size=round(300.0 / STEP))
    t, gyro = times(300.0), degrees(1.0) * np.roll(turn, round(late / STEP))
    found = told({"t": t, "v": np.full(len(t), SPEED), "yaw_rate": gyro, "ay": SPEED * turn})
    assert [each.element for each in found] == elements


@pytest.mark.parametrize(("wheelbase", "doubt"), [(5.3, ""), (6.5, f"; or yaw_rate holds {RADIANS}")])
def test_a_second_explanation_is_told_if_it_is_worse_by_less_than_half_a_wrong_column(
    wheelbase: float, doubt: str
) -> None:
    """Yaw turns 57.3 times as fast as yaw_rate: one of the two is wrong, and the steering tells which. Read by yaw_rate
    the car has a large wheelbase L, read by yaw it has L / 57.3, and each factor of e between that and 2.7 m costs a
    twentieth, twice for steer and twice for steer_cmd: 0.2 ln(2.7 / (L / 57.3)) - 0.2 ln(L / 2.7) is 0.5 at 5.86 m."""
    steer = 0.5 * steered(wheelbase)
    columns = {"t": T, "v": V, "yaw": 0.5 * degrees(1.0) * YAW, "yaw_rate": 0.5 * RATE}
    (finding,) = told({**columns, "steer": steer, "steer_cmd": steer})
    assert (finding.element, finding.text) == ("column yaw", DEGREES + doubt)
