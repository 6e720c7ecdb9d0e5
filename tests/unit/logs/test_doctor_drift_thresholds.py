"""Each limit by which positions are said to drift, just short of it and just past it.

Speed and heading are exact, and so are the positions but for what a test adds to them.
"""

from __future__ import annotations

import numpy as np
import pytest
from known_motion import rate_and_integral, way

from openscenario.findings import Finding, Findings
from pytest_dvp.doctor.position_drift import check_drift
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

TOLD = ["log.position_drift"]
GENTLE, ANGLE = rate_and_integral(0.02, 0.08)
USUAL = 0.2 * np.sqrt(0.5)  # m, of `sway`


def speed(t: FloatArray) -> FloatArray:
    return 10.0 + GENTLE(t + 400.0)


def sway(t: FloatArray) -> FloatArray:
    """Positions sway by 10 cm to both sides of a straight road, with a period of 10 s: after 5 s they are apart by 20
    cm times a cosine, whose median size is sqrt(1/2)."""
    return np.asarray(0.1 * np.sin(2.0 * np.pi * t / 10.0))


def driven(seconds: float, step: float = 0.1) -> dict[str, FloatArray]:
    """A car at some 10 m/s on a winding road."""
    t = np.arange(round(seconds / step) + 1) * step
    v, yaw = speed(t), 0.1 * ANGLE(t)
    return {"t": t, **way(t, v, yaw), "v": v, "yaw": yaw}


def drifts(columns: dict[str, FloatArray], begins: float, seconds: float, rate: float) -> dict[str, FloatArray]:
    """The positions leave the way by `rate` [m/s] for a while, and stay where they are then."""
    t = columns["t"]
    return {**columns, "x": columns["x"] + rate * np.clip(t - begins, 0.0, seconds)}


def found(columns: dict[str, FloatArray]) -> list[Finding]:
    findings = Findings()
    check_drift(Log(columns), "log.csv", findings)
    return findings.found


def told(columns: dict[str, FloatArray]) -> list[str]:
    return [finding.code for finding in found(columns)]


@pytest.mark.parametrize(("parts_by", "codes"), [(0.185, []), (0.215, TOLD)])
def test_a_drift_parts_from_the_way_by_two_decimetres_in_five_seconds(parts_by: float, codes: list[str]) -> None:
    assert told(drifts(driven(300.0), 100.0, 8.0, parts_by / 5.0)) == codes


@pytest.mark.parametrize(("share", "codes"), [(0.87, []), (1.13, TOLD)])
def test_a_drift_is_eight_times_what_is_usual(share: float, codes: list[str]) -> None:
    t = np.arange(6001) * 0.1
    columns = {"t": t, **way(t, speed(t), 0.0 * t), "v": speed(t), "yaw": 0.0 * t}
    columns["y"] = sway(t)
    assert told(drifts(columns, 300.0, 8.0, share * 8.0 * USUAL / 5.0)) == codes


@pytest.mark.parametrize(("seconds", "codes"), [(28.0, []), (33.0, TOLD)])
def test_a_drift_needs_half_a_minute_of_driving(seconds: float, codes: list[str]) -> None:
    assert told(drifts(driven(seconds), 0.0, 1.0, 1.0)) == codes


@pytest.mark.parametrize(("step", "codes"), [(0.19, TOLD), (0.21, [])])
def test_between_values_that_are_a_fifth_of_a_second_apart_a_line_is_a_measurement(
    step: float, codes: list[str]
) -> None:
    assert told(drifts(driven(300.0, step), 100.0, 8.0, 0.2)) == codes


@pytest.mark.parametrize(("creeps", "codes"), [(0.18, []), (0.22, TOLD)])
def test_a_drift_is_seen_where_the_car_drives_a_metre_in_five_seconds(creeps: float, codes: list[str]) -> None:
    t = np.arange(4001) * 0.1
    v = np.where(t < 350.0, speed(t), creeps)
    yaw = 0.1 * ANGLE(t)
    assert told(drifts({"t": t, **way(t, v, yaw), "v": v, "yaw": yaw}, 370.0, 8.0, 0.1)) == codes


@pytest.mark.parametrize(
    ("slow", "beside", "codes"), [(10.0, 0.14, TOLD), (10.0, 0.16, []), (2.8, 0.3, TOLD), (3.2, 0.3, [])]
)
def test_a_car_that_slides_is_no_drift(slow: float, beside: float, codes: list[str]) -> None:
    """For 8 s it goes by an angle [rad] beside where it points: faster than 3 m/s and by more than 0.15 rad that is a
    slide. A direction needs 0.5 s of it, in which the car goes no farther than eight times what is usual, 1.1 m."""
    t = np.arange(4001) * 0.1
    v = np.where((t >= 190.0) & (t < 220.0), slow, speed(t))
    course = np.where((t >= 200.0) & (t < 208.0), beside, 0.0)
    columns = {"t": t, **way(t, v, course), "v": v, "yaw": 0.0 * t}
    columns["y"] = columns["y"] + sway(t)
    assert told(columns) == codes


def test_the_beginning_of_a_drift_is_told_to_a_tenth_of_a_second() -> None:
    """Two decimetres need 4.05 s of the drift from 100 s on: the window from 99.1 s on is the first to hold them."""
    (finding,) = found(drifts(driven(300.0), 100.0, 8.0, 0.2 / 4.05))
    assert "from t = 99.1 to" in finding.text


@pytest.mark.parametrize(("late", "codes"), [(0.9, []), (1.2, TOLD)])
def test_positions_may_come_a_second_late(late: float, codes: list[str]) -> None:
    """A lag moves positions by the speed, and by half of its square times the acceleration, which shows where the car
    goes over from 5 m/s^2 to braking by 8: 0.2 s more than are allowed for are 0.26 m."""
    t = np.arange(3001) * 0.1
    accel = np.select([(t >= 150.0) & (t < 154.0), (t >= 154.0) & (t < 156.5)], [5.0, -8.0], 0.3 * GENTLE(t))
    v = 10.0 + np.concatenate([[0.0], np.cumsum(0.05 * (accel[1:] + accel[:-1]))])
    x = np.interp(t - late, t, way(t, v, 0.0 * t)["x"])
    assert told({"t": t, "x": x, "y": 0.0 * t, "v": v, "yaw": 0.0 * t}) == codes
