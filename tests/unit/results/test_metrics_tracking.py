"""Quality of tracks: planted misses, ghosts, delays, swaps and covariances."""

from __future__ import annotations

import dataclasses
import os

import numpy as np
import pytest
from results_logs import drive_straight, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray
from pytest_dvp.metrics import compute

TICKS = np.arange(0.0, 10.01, 0.05)
N = len(TICKS)
CASES = int(os.environ.get("DVP_CASES", "200"))


def table(x: FloatArray, y: FloatArray, t: FloatArray = TICKS, **more: FloatArray) -> DetectionTable:
    flat = {name: np.zeros(len(t)) for name in ("yaw", "length", "width", "vx", "vy")}
    return DetectionTable(t=t, kind=("vehicle",) * len(t), x=x, y=y, **{**flat, **more})


def seen(detections: DetectionTable, yaw: float = 0.0) -> Log:
    """The ego at 2 m/s, a car 10 m before it at the same speed; it counts from 1 s on."""
    car = track(TICKS, 12.0 + 2.0 * TICKS, 1.0, vx=2.0, yaw=yaw)
    return drive_straight(2.0, objects={"car": car}, detections=detections)


TRUE_X, TRUE_Y = 12.0 + 2.0 * TICKS, np.full(N, 1.0)


def test_recall_is_the_share_that_was_not_planted_as_missed() -> None:
    kept = ~((TICKS > 4.99) & (TICKS < 7.01))  # 41 of the 181 instants from 1 s on
    found = compute("detection_recall", seen(table(TRUE_X[kept], TRUE_Y[kept], TICKS[kept])))
    assert found.value == pytest.approx(1.0 - 41 / 181)
    assert (found.t, found.object) == (pytest.approx(5.0), "car")


def test_a_ghost_counts_its_time_and_a_double_is_none() -> None:
    ghost = (TICKS > 1.99) & (TICKS < 4.99)
    t = np.concatenate([TICKS, TICKS[ghost], TICKS[ghost]])
    x = np.concatenate([TRUE_X, TRUE_X[ghost] - 5.0, TRUE_X[ghost] + 1.0])
    y = np.concatenate([TRUE_Y, TRUE_Y[ghost] - 3.0, TRUE_Y[ghost]])
    order = np.argsort(t, kind="stable")
    found = compute("false_tracks", seen(table(x[order], y[order], t[order])))
    assert (found.value, found.t) == (pytest.approx(3.0), pytest.approx(2.0))
    assert compute("false_tracks", seen(table(TRUE_X, TRUE_Y))).value == 0.0


def test_a_band_of_distance_is_judged_by_itself() -> None:
    """The ego at 2 m/s nears a car that stands: every second look misses it farther than 10 m away, none nearer."""
    x = np.full(N, 22.0)
    car = track(TICKS, x, 1.0)
    bumper = 2.0 * TICKS + 1.2 + 1.5  # of an ego of 3 m whose middle is 1.2 m ahead of its reference point
    kept = (22.0 - bumper < 10.0) | (np.arange(N) % 2 == 0)
    log = drive_straight(2.0, objects={"car": car}, detections=table(x[kept], TRUE_Y[kept], TICKS[kept]))
    assert compute("detection_recall", log, reach=10.0).value == 1.0
    far = compute("detection_recall", log, reach=20.0, beyond=10.0)
    assert far.value == pytest.approx(0.5, abs=0.01)
    whole = compute("detection_recall", log, reach=20.0)
    assert far.value < whole.value < 1.0


def test_nan_positions_are_misses() -> None:
    found = compute("detection_recall", seen(table(TRUE_X * np.nan, TRUE_Y)))
    assert found.value == 0.0


def test_errors_of_place_and_yaw() -> None:
    log = seen(table(TRUE_X + 0.3, TRUE_Y - 0.4, yaw=np.full(N, 0.2 - 0.7)), yaw=0.7)
    assert compute("track_position_error", log).value == pytest.approx(0.5)
    yaw = compute("track_yaw_error", log)  # from 0.7 to -0.5
    assert yaw.value == pytest.approx(1.2)
    turned = seen(table(TRUE_X, TRUE_Y, yaw=np.full(N, np.pi + 0.1)))
    found = compute("track_yaw_error", turned)
    assert found.value == pytest.approx(0.1)
    assert found.extra["with direction"] == pytest.approx(np.pi - 0.1)


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.35, -0.1])
def test_latency_of_late_detections(delay: float) -> None:
    found = compute("track_latency", seen(table(TRUE_X - 2.0 * delay, TRUE_Y)))
    assert found.value == pytest.approx(delay, abs=1e-9)


def test_identity_switches_are_counted() -> None:
    number = np.where(TICKS < 4.0, 1.0, np.where(TICKS < 6.0, 2.0, 1.0))
    number[100:105] = np.nan  # no number is no switch
    found = compute("identity_switches", seen(table(TRUE_X, TRUE_Y, track=number)))
    assert (found.value, found.t, found.object) == (2.0, pytest.approx(4.0), "car")
    assert "Detection.track" in compute("identity_switches", seen(table(TRUE_X, TRUE_Y))).reason


def test_nees_is_the_quadratic_form_and_two_for_a_consistent_stack() -> None:
    rng = np.random.default_rng(6)
    root = np.array([[0.3, 0.0], [0.1, 0.2]])
    error = rng.normal(size=(N, 2)) @ root.T
    p = root @ root.T
    stated = {name: np.full(N, v) for name, v in (("cov_xx", p[0, 0]), ("cov_xy", p[0, 1]), ("cov_yy", p[1, 1]))}
    found = compute("nees", seen(table(TRUE_X + error[:, 0], TRUE_Y + error[:, 1], **stated)))
    rows = TICKS >= 1.0 - 1e-6
    whitened = np.linalg.solve(np.linalg.cholesky(p), error[rows].T)
    assert found.value == pytest.approx(float((whitened**2).sum(axis=0).mean()))
    assert found.value == pytest.approx(2.0, abs=4.0 * 2.0 / np.sqrt(rows.sum()))
    assert "covariance" in compute("nees", seen(table(TRUE_X, TRUE_Y))).reason


def test_nobody_ahead_is_no_recall() -> None:
    log = drive_straight(2.0, detections=table(TRUE_X, TRUE_Y))
    assert not compute("detection_recall", log).valid
    assert compute("false_tracks", log).value == pytest.approx(N * 0.05)


def test_velocity_error_is_that_of_the_vectors() -> None:
    log = seen(table(TRUE_X, TRUE_Y, vx=np.full(N, 2.3), vy=np.full(N, -0.4)))  # the car goes at (2, 0)
    assert compute("track_speed_error", log).value == pytest.approx(0.5)


def test_size_error_is_one_minus_the_overlap_of_concentric_boxes() -> None:
    """Against the overlap counted on a grid of points."""
    rng = np.random.default_rng(12)
    grid = (np.arange(-6.0, 6.0, 0.01) + 0.005)[:, None]
    for length, width in rng.uniform(0.5, 8.0, (CASES // 40, 2)):
        sides = [(np.abs(grid[:, 0]) <= s / 2).sum() for s in (4.0, 2.0, length, width)]
        both = min(sides[0], sides[2]) * min(sides[1], sides[3])
        expected = 1.0 - both / (sides[0] * sides[1] + sides[2] * sides[3] - both)
        log = seen(table(TRUE_X, TRUE_Y, length=np.full(N, length), width=np.full(N, width)))
        assert compute("track_size_error", log).value == pytest.approx(expected, abs=0.02)


def test_kind_error_is_the_share_that_is_called_something_else() -> None:
    wrong = TICKS > 5.51  # 90 of the 181 instants from 1 s on
    log = seen(table(TRUE_X, TRUE_Y))
    kinds = tuple("pedestrian" if w else "vehicle" for w in wrong)
    log = dataclasses.replace(log, detections=dataclasses.replace(log.detections, kind=kinds))
    assert compute("kind_error", log).value == pytest.approx(90 / 181, abs=1 / 181)


def test_coasting_is_the_share_of_rows_that_nothing_was_seen_behind() -> None:
    """Every fourth row keeps the velocity of the row before it, and lies where that leads: the tracker has only moved
    the track on."""
    vx = 2.0 + 0.0001 * np.arange(N)
    coasts = np.arange(N) % 4 == 0
    vx[coasts] = vx[np.flatnonzero(coasts) - 1]
    vx[0] = 1.9
    named = table(TRUE_X, TRUE_Y, vx=vx, track=np.full(N, 7.0))
    found = compute("track_coasting", seen(named))
    assert found.value == pytest.approx(0.25, abs=0.01)
    assert compute("track_coasting", seen(table(TRUE_X, TRUE_Y, vx=vx))).value == 0.0
