"""The stack's estimate and its detections against the truth."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from results_logs import EGO, drive_straight, log_of, times, track

from pytest_dvp.logs.log_contents import DetectionTable, FloatArray
from pytest_dvp.metrics import compute

FRONT = EGO["center_x"] + 0.5 * EGO["length"]  # m ahead of the reference point
TICKS = times()[::5]  # 20 Hz


def seen(x: FloatArray, y: float, kind: str = "vehicle") -> DetectionTable:
    flat = {name: np.zeros(len(TICKS)) for name in ("yaw", "length", "width", "vx", "vy")}
    return DetectionTable(t=TICKS, kind=(kind,) * len(TICKS), x=x, y=np.full(len(TICKS), y), **flat)


def test_a_constant_offset_of_the_estimate_is_its_error() -> None:
    t = times()
    columns = {"x": 5.0 * t, "ads.x": np.repeat(5.0 * TICKS, 5)[: len(t)] + 0.3, "ads.y": 0.4}
    assert compute("localization_error", log_of(columns=columns)).value == pytest.approx(0.5)


def test_an_estimate_that_holds_until_the_next_tick_is_not_late() -> None:
    t = times()
    columns = {"x": 5.0 * t, "ads.x": np.repeat(5.0 * TICKS, 5)[: len(t)], "ads.y": 0.0}
    assert compute("localization_error", log_of(columns=columns)).value == pytest.approx(0.0, abs=1e-9)


def test_the_time_before_the_first_estimate_does_not_count() -> None:
    t = times()
    estimate = np.where(t < 2.0, np.nan, np.repeat(5.0 * TICKS, 5)[: len(t)] + 0.2)
    result = compute("localization_error", log_of(columns={"x": 5.0 * t, "ads.x": estimate, "ads.y": 0.0}))
    assert result.value == pytest.approx(0.2)


@pytest.mark.parametrize(("metric", "column", "truth"), [("localization_error", "ads.x", "x"),
                                                         ("speed_error", "ads.v", "v"),
                                                         ("heading_error", "ads.yaw", "yaw")])  # fmt: skip
def test_an_estimate_that_is_stuck_is_wrong_for_as_long_as_it_is_believed(metric: str, column: str, truth: str) -> None:
    t = times()
    moves = 0.1 * t  # 1 at the end
    columns = {truth: moves, "ads.y": 0.0, column: 0.0}
    greatest = compute(metric, log_of(columns=columns), statistic="greatest")
    assert (greatest.value, greatest.t) == (pytest.approx(1.0), pytest.approx(10.0))
    assert compute(metric, log_of(columns=columns)).value == pytest.approx(math.sqrt(1.0 / 3.0), rel=0.01)
    stuck = np.where(t < 5.0, np.repeat(0.1 * TICKS, 5)[: len(t)], 0.5)
    assert compute(metric, log_of(columns={**columns, column: stuck}), statistic="greatest").value == pytest.approx(0.5)


def test_an_estimate_that_comes_seldom_in_a_foreign_log_is_not_late_either() -> None:
    """Nobody knows when the stack of that log looked at it."""
    t = times()
    seldom = np.repeat(5.0 * t[::20], 20)[: len(t)]  # 5 Hz
    log = log_of(columns={"x": 5.0 * t, "ads.x": seldom, "ads.y": 0.0}, meta={"stage": ""})
    assert compute("localization_error", log).value == 0.0


@pytest.mark.parametrize(("hold", "period"), [(10, 0.1), (90, 0.9)])
def test_in_a_run_an_estimate_is_believed_at_every_tick(hold: int, period: float) -> None:
    """At 5 m/s an estimate of age a is 5 a wrong; ages at the ticks are 0, 0.05 ... up to the last before the next."""
    t = times()
    columns = {"x": 5.0 * t, "ads.x": np.repeat(5.0 * t[::hold], hold)[: len(t)], "ads.y": 0.0}
    ages = 0.05 * np.arange(round(period / 0.05))
    log = dataclasses.replace(log_of(columns=columns), meta={"stage": "dt"})
    assert compute("localization_error", log).value == pytest.approx(5.0 * math.sqrt(np.mean(ages**2)), rel=0.02)
    greatest = compute("localization_error", log, statistic="greatest").value
    assert greatest == pytest.approx(5.0 * ages[-1])


def test_a_tick_that_comes_a_little_late_is_no_missed_one() -> None:
    t = times()
    changes = np.arange(0.0, 10.0, 0.05) + np.where(np.arange(200) % 3 == 1, 0.02, 0.0)
    last = np.searchsorted(changes, t + 1e-9, side="right") - 1
    columns = {"x": 5.0 * t, "ads.x": 5.0 * changes[last], "ads.y": 0.0}
    log = dataclasses.replace(log_of(columns=columns), meta={"stage": "rw"})
    assert compute("localization_error", log, statistic="greatest").value == pytest.approx(0.0, abs=1e-9)


def test_without_an_estimate_it_is_undefined() -> None:
    assert not compute("localization_error", drive_straight(5.0)).valid
    assert not compute("localization_error", log_of(columns={"ads.x": math.nan, "ads.y": math.nan})).valid


def test_error_of_detections_is_the_distance_of_the_middles() -> None:
    car = track(TICKS, 15.0, 1.0)
    log = log_of(objects={"car": car}, detections=seen(np.full(len(TICKS), 15.3), 1.4))
    assert compute("detection_error", log).value == pytest.approx(0.5)
    assert compute("missed_objects", log).value == 0.0


def test_a_detection_of_another_kind_is_a_miss() -> None:
    walker = track(TICKS, 15.0, 1.0, kind="pedestrian")
    log = log_of(objects={"walker": walker}, detections=seen(np.full(len(TICKS), 15.0), 1.0))
    result = compute("missed_objects", log)
    # ahead for 10 s, of which the first does not count; ticks at 1.00, 1.05 ... 10.00 s
    assert result.value == pytest.approx(181 * 0.05)
    assert (result.t, result.object) == (pytest.approx(1.0), "walker")
    assert compute("detection_error", log).reason == "no road user ahead of the ego was seen"


@pytest.mark.parametrize(("off", "missed"), [(2.9, False), (3.1, True)])
def test_what_is_more_than_three_metres_off_is_another_one(off: float, missed: bool) -> None:
    log = log_of(objects={"car": track(TICKS, 15.0, 1.0)}, detections=seen(np.full(len(TICKS), 15.0 + off), 1.0))
    assert compute("detection_error", log).valid is not missed
    assert compute("missed_objects", log).value == pytest.approx(181 * 0.05 if missed else 0.0)


@pytest.mark.parametrize(("x", "y"), [(FRONT + 20.1, 0.0), (FRONT - 0.1, 0.0), (10.0, 4.1)])
def test_what_is_far_beside_or_behind_is_not_asked_for(x: float, y: float) -> None:
    log = log_of(objects={"car": track(TICKS, x, y)})
    assert compute("missed_objects", log).reason == "no road user was ahead of the ego"


def test_what_was_ahead_for_less_than_a_second_is_not_asked_for() -> None:
    assert not compute("missed_objects", log_of(objects={"car": track(TICKS[:20], 10.0, 0.0)})).valid
    assert compute("missed_objects", log_of(objects={"car": track(TICKS[:22], 10.0, 0.0)})).value == pytest.approx(0.1)
