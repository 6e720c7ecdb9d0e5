"""Time to collision against an independent oracle, and the cases where corner-edge codes go wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from results_logs import drive_straight, log_of, relaxed, times, track

from pytest_dvp.metrics import compute
from pytest_dvp.metrics._box_collision_time import time_to_collision

Box = tuple[float, float, float, float, float, float, float]  # x, y, yaw, length, width, vx, vy

place = st.floats(-20.0, 20.0)
angle = st.floats(-math.pi, math.pi)
side = st.floats(0.2, 6.0)
speed = st.integers(-15_000, 15_000).map(lambda v: v / 1000.0)  # no speeds of 1e-35 m/s
boxes = st.tuples(place, place, angle, side, side, speed, speed)


def ttc(i: Box, j: Box) -> float:
    return float(time_to_collision(np.array([i], dtype=np.float64), np.array([j], dtype=np.float64))[0])


def oracle(i: Box, j: Box, grow: float = 0.0) -> float:
    """First time at which no axis separates the boxes, j being `grow` [m] larger on each side.

    Separating axes instead of corners and edges: for convex shapes that translate, each of the four edge normals is a
    separating axis outside one interval of time; they touch in the intersection of the four.
    """
    enter, leave = 0.0, math.inf
    for axis in (i[2], i[2] + math.pi / 2, j[2], j[2] + math.pi / 2):
        normal = np.array([math.cos(axis), math.sin(axis)])
        reach = sum(
            (half + extra) * abs(math.cos(yaw - axis))
            for yaw, half, extra in (
                (i[2], i[3] / 2, 0.0),
                (i[2] + math.pi / 2, i[4] / 2, 0.0),
                (j[2], j[3] / 2, grow),
                (j[2] + math.pi / 2, j[4] / 2, grow),
            )
        )
        gap = float(normal @ np.array([j[0] - i[0], j[1] - i[1]]))
        rate = float(normal @ np.array([j[5] - i[5], j[6] - i[6]]))
        if abs(rate) < 1e-15:
            if abs(gap) > reach:
                return math.inf
            continue
        first, last = sorted(((-reach - gap) / rate, (reach - gap) / rate))
        enter, leave = max(enter, first), min(leave, last)
    return enter if enter <= leave else math.inf


@relaxed
@given(boxes, boxes)
@example((0, 0, 0.3, 4, 2, 5, 0), (10, 0, 0.3, 4, 2, 0, 0))
@example((0, 0, 0, 6, 0.2, 0, 0), (0, 0, math.pi / 2, 6, 0.2, 0, 0))
@example((0, 0, 0, 2, 2, 1, 0), (5, 2, 0, 2, 2, 0, 0))
def test_agrees_with_separating_axes(i: Box, j: Box) -> None:
    # Grazing contacts are a matter of rounding: a box a micrometre larger touches no later, a smaller one no earlier.
    assert oracle(i, j, 1e-6) - 1e-9 <= ttc(i, j) <= oracle(i, j, -1e-6) + 1e-9


@relaxed
@given(boxes, boxes)
def test_no_separation_before_contact_and_contact_then(i: Box, j: Box) -> None:
    """Fine time stepping: apart just before the TTC, together just after it."""
    time = ttc(i, j)
    if not 1e-3 < time < 100.0:
        return
    relative = math.hypot(j[5] - i[5], j[6] - i[6])
    early = time - 1e-5 / relative
    assert oracle(_still(i, early), _still(j, early), -1e-4) == math.inf
    assert oracle(_still(i, time), _still(j, time), 1e-4) == 0.0


@relaxed
@given(boxes, boxes)
def test_does_not_depend_on_who_is_asked(i: Box, j: Box) -> None:
    assert oracle(i, j, 2e-6) - 1e-9 <= ttc(j, i) <= oracle(i, j, -2e-6) + 1e-9


@relaxed
@given(boxes, boxes, st.floats(-math.pi, math.pi))
def test_does_not_depend_on_the_map_frame(i: Box, j: Box, turn: float) -> None:
    assert oracle(i, j, 1e-6) - 1e-9 <= ttc(_turned(i, turn), _turned(j, turn)) <= oracle(i, j, -1e-6) + 1e-9


def test_head_on() -> None:
    assert ttc((0, 0, 0, 4, 2, 5, 0), (14, 0, 0, 4, 2, 0, 0)) == pytest.approx((14 - 4) / 5)


@pytest.mark.parametrize("yaw", [0.0, 0.1, 0.3, 1.0, 2.5, -3.1])
def test_flush_boxes_of_equal_width_do_not_miss_each_other(yaw: float) -> None:
    c, s = math.cos(yaw), math.sin(yaw)
    assert ttc((0, 0, yaw, 4, 2, 5 * c, 5 * s), (14 * c, 14 * s, yaw, 4, 2, 0, 0)) == pytest.approx(2.0)


def test_crossing_boxes_without_a_corner_inside_overlap() -> None:
    assert ttc((0, 0, 0, 6, 1, 3, 0), (0, 0, math.pi / 2, 6, 1, 0, 2)) == 0.0


def test_box_inside_another_overlaps() -> None:
    assert ttc((0, 0, 0, 6, 6, 3, 0), (1, 1, 0.5, 1, 1, 3, 0)) == 0.0


def test_pedestrian_steps_before_the_car() -> None:
    # Front at x = 2, reaches the pedestrian's back edge x = 9.75 after 1.55 s; he is in the car's strip from 1.0 s on.
    assert ttc((0, 0, 0, 4, 2, 5, 0), (10, -3.25, 0, 0.5, 0.5, 0, 2)) == pytest.approx(7.75 / 5)


def test_passing_in_the_next_lane_never_meets() -> None:
    assert ttc((0, 0, 0, 4, 2, 10, 0), (50, 3.5, 0, 4, 2, -10, 0)) == math.inf


def test_same_speed_never_meets() -> None:
    assert ttc((0, 0, 0, 4, 2, 10, 3), (6, 1, 0.2, 4, 2, 10, 3)) == math.inf


def test_moving_away_never_meets() -> None:
    assert ttc((0, 0, 0, 4, 2, -1, 0), (6, 0, 0, 4, 2, 1, 0)) == math.inf


def test_inverse_of_a_constant_closing_speed() -> None:
    # Ego front at x = 1.2 + 1.5 + 5 t, object's back at 60: at t = 10 s a gap of 7.3 m at 5 m/s.
    log = drive_straight(5.0, objects={"target": track(times()[::5], 62.0, 0.0)})
    result = compute("max_ttc_inverse", log)
    assert result.value == pytest.approx(5.0 / 7.3)
    assert (result.t, result.object) == (10.0, "target")


def test_series_follows_the_gap() -> None:
    log = drive_straight(5.0, objects={"target": track(times()[::5], 62.0, 0.0)})
    series = compute("max_ttc_inverse", log).series
    assert series is not None
    assert series.value == pytest.approx(5.0 / (60.0 - 2.7 - 5.0 * series.t))


def test_exposure_to_a_critical_ttc() -> None:
    # The gap of 57.3 - 5 t closes to 10 m, a TTC of 2 s, at t = 9.46 s: samples at 9.50 ... 9.95 s count 0.05 s each.
    log = drive_straight(5.0, objects={"target": track(times()[::5], 62.0, 0.0)})
    assert compute("tet", log).value == pytest.approx(0.5)


def test_exposure_counts_each_road_user() -> None:
    cars = {name: track(times()[::5], 62.0, 0.0) for name in ("a", "b")}
    assert compute("tet", drive_straight(5.0, objects=cars)).value == pytest.approx(1.0)


def test_exposure_threshold_is_a_parameter() -> None:
    # TTC below 1 s from t = 10.46 s on: never in this log.
    log = drive_straight(5.0, objects={"target": track(times()[::5], 62.0, 0.0)})
    assert compute("tet", log, critical=1.0).value == 0.0


@pytest.mark.parametrize("since", [9.95, 10.0])  # two samples 0.05 s apart, or the very last one alone
def test_who_appears_at_the_very_end_is_an_exposure(since: float) -> None:
    """A car 3.3 m ahead of the bumper in the last sample: a log that a contact ends holds no step of it."""
    t = times()[::5]
    cars = {"far": track(t, 500.0, 0.0), "near": track(t[t >= since - 1e-9], 58.0, 0.0)}
    log = drive_straight(5.0, objects=cars)
    found = compute("tet", log)
    assert (found.value, found.object) == (pytest.approx(0.05 if since < 10.0 else 0.01), "near")
    rss = {"response_time": 0.5, "max_acceleration": 2.0, "max_braking": 8.0, "min_braking": 4.0,
           "lateral_acceleration": 0.2, "lateral_braking": 0.8, "lateral_margin": 0.1}  # fmt: skip
    assert compute("rss_violation", log, **rss).value == found.value


def test_an_exposure_in_the_last_sample_of_a_track_counts_a_step() -> None:
    """At 5 m/s the gap of 59.8 - 5 t [m] falls below 10 m, a TTC of 2 s, in the last sample alone."""
    log = drive_straight(5.0, objects={"target": track(times()[::5], 64.5, 0.0)})
    assert compute("tet", log).value == pytest.approx(0.05)


def test_standing_beside_a_static_object_is_no_danger() -> None:
    log = log_of(objects={"parked": track(times()[::5], 1.2, 2.0)})
    result = compute("max_ttc_inverse", log)
    assert (result.value, result.valid, result.object) == (0.0, True, "")
    assert compute("tet", log).value == 0.0


def test_contact_counts_as_the_resolution_of_the_log() -> None:
    log = log_of(objects={"hit": track(times()[::5], 2.0, 0.0)})
    assert compute("max_ttc_inverse", log).value == pytest.approx(100.0)


def test_turning_ego_moves_the_middle_of_its_box() -> None:
    # Turning on the spot about the rear axle: the middle, 1.2 m ahead, moves at 1.2 m/s to the left.
    log = log_of(1.0, columns={"yaw_rate": 1.0}, objects={"left": track(times(1.0)[::5], 1.2, 5.0)})
    # half widths 0.75 and 1.0: a gap of 3.25 m
    assert compute("max_ttc_inverse", log).value == pytest.approx(1.2 / 3.25)


@pytest.mark.parametrize("name", ["max_ttc_inverse", "tet"])
def test_without_objects_it_is_undefined(name: str) -> None:
    result = compute(name, drive_straight(5.0))
    assert (result.value, result.valid, result.reason) == (None, False, "no other road user in the log")


def test_position_that_was_not_measured_makes_it_undefined() -> None:
    car = track(times()[::5], 62.0, 0.0)
    car.x[40] = np.nan
    result = compute("max_ttc_inverse", drive_straight(5.0, objects={"car": car}))
    assert not result.valid
    assert result.reason == "position or speed of car is not measured at t=2.00 s"


def test_size_of_the_ego_that_is_not_told_makes_it_undefined() -> None:
    log = drive_straight(5.0, objects={"car": track(times()[::5], 62.0, 0.0)}, meta={"ego": {"length": 3.0}})
    assert compute("tet", log).reason == "the log does not tell the width of the ego (meta: ego)"


def _still(box: Box, time: float) -> Box:
    x, y, yaw, length, width, vx, vy = box
    return x + vx * time, y + vy * time, yaw, length, width, 0.0, 0.0


def _turned(box: Box, turn: float) -> Box:
    x, y, yaw, length, width, vx, vy = box
    c, s = math.cos(turn), math.sin(turn)
    return c * x - s * y, s * x + c * y, yaw + turn, length, width, c * vx - s * vy, s * vx + c * vy


def test_who_is_away_is_no_danger_meanwhile() -> None:
    """Ahead for 1 s, 1 s short of a contact, then away for 10 s, and there again for 1 s."""
    t = np.concatenate([np.arange(0.0, 1.0, 0.01), np.arange(11.0, 12.0, 0.01)])
    columns = {"x": 5.0 * times(20.0), "v": 5.0, "vx": 5.0}
    car = track(t, 5.0 * t + 1.2 + 8.0, 0.0)
    log = log_of(20.0, columns=columns, objects={"car": car})
    assert compute("tet", log).value == pytest.approx(2.0, abs=0.05)
