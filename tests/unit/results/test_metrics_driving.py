"""Lateral comfort, steering, standstill, lane, speed limit, traffic lights and the age of commands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from results_logs import EGO, drive_straight, log_of, times
from scipy.signal import butter, sosfiltfilt

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics import compute

LINE = np.array([[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]])
LIGHT = {"stop_lines": [{"signal": "1", "x": 30.0, "y": 0.0, "heading": 0.0, "width": 3.5}]}
FRONT = EGO["center_x"] + EGO["length"] / 2


def test_lateral_acceleration_and_jerk_of_a_sinusoid() -> None:
    """v * r with r = A sin(w t): A v, and its derivative A v w, both damped as the filter says: f = f_c / 2."""
    t, w = times(60.0), np.pi
    log = log_of(60.0, columns={"v": 8.0, "yaw_rate": 0.2 * np.sin(w * t)})
    damped = 1.6 / (1.0 + 0.5**4)
    acceleration, jerk = (compute(name, log).series for name in ("max_lateral_acceleration", "max_lateral_jerk"))
    assert acceleration is not None
    assert jerk is not None
    assert np.abs(acceleration.value[500:-500]).max() == pytest.approx(damped, rel=2e-3)
    assert np.abs(jerk.value[500:-500]).max() == pytest.approx(damped * w, rel=2e-3)


def test_a_sideslip_that_grows_is_lateral_acceleration() -> None:
    log = log_of(20.0, columns={"v": 5.0, "vy": 0.7 * times(20.0)})
    assert compute("max_lateral_acceleration", log).value == pytest.approx(0.7, rel=1e-6)


def test_steer_rate_of_a_ramp() -> None:
    log = log_of(columns={"steer": 0.05 * times()})
    assert compute("max_steer_rate", log).value == pytest.approx(0.05, rel=1e-6)


def test_steer_roughness_is_what_scipys_filter_leaves_of_the_rate() -> None:
    steer = np.random.default_rng(7).normal(0.0, 0.01, len(times(20.0))).cumsum()
    steer[:5] = np.nan  # before the first command
    rate = np.gradient(steer[5:], 0.01)
    smooth = sosfiltfilt(butter(2, 1.0, fs=100.0, output="sos"), rate, padtype="odd", padlen=600)
    found = compute("steer_roughness", log_of(20.0, columns={"steer_cmd": steer}))
    assert found.value == pytest.approx(float(np.sqrt(np.mean((rate - smooth) ** 2))), rel=1e-6)


def test_steering_in_steps_is_rougher_than_the_same_without() -> None:
    smooth = 0.1 * np.sin(0.5 * times(20.0))
    step = np.deg2rad(2.0)
    values = [
        compute("steer_roughness", log_of(20.0, columns={"steer_cmd": angle})).value
        for angle in (smooth, np.round(smooth / step) * step)
    ]
    assert values[0] is not None
    assert values[1] is not None
    assert values[1] > 10.0 * values[0]


def stopping_at(end: float) -> Log:
    """Comes to rest at x = end [m] after 8 s."""
    t = np.minimum(times(), 8.0)
    meta = {"task": {"goal": {"road": "1"}}}
    x = end - 0.5 * (t - 8.0) ** 2
    return log_of(columns={"x": x, "v": 8.0 - t, "y": 0.2}, reference=LINE, meta=meta)


@pytest.mark.parametrize(("end", "beyond"), [(103.0, 3.0), (98.5, -1.5)])
def test_stop_error_on_both_sides_of_the_goal(end: float, beyond: float) -> None:
    found = compute("stop_error", stopping_at(end))
    assert found.value == pytest.approx(abs(beyond))
    assert (found.extra["beyond"], found.extra["left"]) == (pytest.approx(beyond), pytest.approx(0.2))
    assert found.t == pytest.approx(7.96, abs=0.02)


def test_stop_error_needs_a_goal_and_a_stop() -> None:
    assert compute("stop_error", log_of()).reason == "the task has no goal"
    moving = log_of(columns={"v": 1.0}, reference=LINE, meta={"task": {"goal": {"road": "1"}}})
    assert "did not stand" in compute("stop_error", moving).reason


def test_creep_is_the_way_rolled_while_standing() -> None:
    t = times(20.0)
    v = np.where(t < 5.0, 3.0, np.where(t < 15.0, 0.04, 3.0))
    found = compute("creep", log_of(20.0, columns={"v": v}))
    assert (found.value, found.t) == (pytest.approx(0.04 * 9.99), pytest.approx(5.0))
    assert not compute("creep", drive_straight(3.0)).valid


def test_time_outside_the_lane() -> None:
    y = np.where((times() >= 2.0) & (times() < 5.0), 1.2, 0.9)  # the side is 0.75 m further; half a lane is 1.75 m
    log = log_of(columns={"x": 1.0 + times(), "y": y, "lane_width": 3.5}, reference=LINE)
    found = compute("lane_time_outside", log)
    assert (found.value, found.t) == (pytest.approx(3.0), pytest.approx(2.0))
    assert compute("lane_time_outside", log, width=4.0).value == 0.0
    old = log_of(columns={"x": times()}, reference=LINE)
    assert "declare width" in compute("lane_time_outside", old).reason


def test_speed_excess_is_signed() -> None:
    limit = np.where(times() < 5.0, 10.0, 6.0)
    log = log_of(columns={"v": 7.5, "speed_limit": limit})
    assert (compute("speed_excess", log).value, compute("speed_excess", log).t) == (1.5, pytest.approx(5.0))
    assert compute("speed_excess", log_of(columns={"v": 5.0, "speed_limit": 10.0})).value == -5.0
    assert compute("speed_excess", log_of(columns={"v": -20.0, "speed_limit": 5.0})).value == 15.0  # backwards
    assert not compute("speed_excess", log_of(columns={"speed_limit": np.nan})).valid
    assert not compute("speed_excess", log_of()).valid


def at_light(speed: float, *phases: tuple[float, str], stop: float = np.inf) -> Log:
    """Towards the line at x = 30 m, standing with its front at `stop` [m]."""
    x = np.minimum(speed * times(), stop - FRONT)
    events = [LogEvent(t, "signal", "1", state) for t, state in phases]
    return log_of(columns={"x": x, "v": speed}, events=events, meta=LIGHT)


def test_red_light_counts_lines_crossed_while_red() -> None:
    crossed = (30.0 - FRONT) / 4.0
    run = compute("red_light", at_light(4.0, (0.0, "green"), (3.0, "red")))
    assert (run.value, run.t, run.object) == (1.0, pytest.approx(crossed, abs=0.011), "1")
    for phases in [((0.0, "green"),), ((0.0, "red"), (5.0, "green")), ((0.0, "amber"),)]:
        assert compute("red_light", at_light(4.0, *phases)).value == 0.0
    # About to turn green: it must still wait (Vienna Convention on Road Signs, article 23)
    assert compute("red_light", at_light(4.0, (0.0, "red"), (5.0, "red;amber"), (7.0, "green"))).value == 1.0
    assert not compute("red_light", at_light(4.0)).valid
    assert not compute("red_light", log_of()).valid


@pytest.mark.parametrize("stop", [28.0, 31.5])
def test_stop_line_is_how_far_the_front_came(stop: float) -> None:
    found = compute("stop_line", at_light(4.0, (2.0, "red"), stop=stop))
    assert (found.value, found.object) == (pytest.approx(stop - 30.0), "1")


def test_a_light_that_turns_red_behind_the_ego_is_not_its_own() -> None:
    assert not compute("stop_line", at_light(4.0, (0.0, "green"), (7.5, "red"))).valid
    assert compute("red_light", at_light(4.0, (0.0, "green"), (7.5, "red"))).value == 0.0


@pytest.mark.parametrize(
    ("phases", "found"),
    [
        (((0.0, "red"), (4.0, "green")), 1.5),
        (((0.0, "on;off;off"), (3.0, "on;on;off"), (3.5, "off;off;on")), 2.0),
        (((0.0, "red"), (2.0, "green"), (2.5, "green")), 3.5),  # told twice
        (((0.0, "red"), (6.5, "green")), None),  # it ran the light
        (((0.0, "green"), (3.0, "red")), None),
    ],
)
def test_start_up_delay_runs_from_green_until_it_moves(
    phases: tuple[tuple[float, str], ...], found: float | None
) -> None:
    v = np.where(times() > 5.495, 2.0, 0.0)
    events = [LogEvent(t, "signal", "1", state) for t, state in phases]
    waits = log_of(columns={"x": 20.0 + np.cumsum(v) * 0.01, "v": v}, events=events, meta=LIGHT)
    measured = compute("start_up_delay", waits)
    assert measured.valid == (found is not None)
    assert measured.value == (None if found is None else pytest.approx(found, abs=0.011))


def test_start_up_of_an_ego_that_never_sets_off_lasts_to_the_end() -> None:
    events = [LogEvent(t, "signal", "1", state) for t, state in ((0.0, "red"), (4.0, "green"))]
    assert compute("start_up_delay", log_of(columns={"x": 20.0}, events=events, meta=LIGHT)).value == pytest.approx(6.0)


def test_command_age_is_the_greatest() -> None:
    age = np.zeros(len(times()))
    age[400:410] = 0.1
    found = compute("command_age", log_of(columns={"command_age": age}))
    assert (found.value, found.t) == (0.1, pytest.approx(4.0))
    assert not compute("command_age", log_of()).valid


def test_detections_keep_number_and_covariance_in_the_file(tmp_path: Path) -> None:
    from pytest_dvp.logs.recorder import LogRecorder
    from vehicle.messages import Detection

    recorder = LogRecorder({})
    recorder.ego_rows(np.array([[0.01 * k, *[0.0] * 11] for k in range(3)]))
    some = Detection(0.0, "vehicle", *[1.0] * 7, track=4, covariance=(0.2, 0.1, 0.3))
    recorder.tick(0.0, detections=[some, Detection(0.0, "vehicle", *[1.0] * 7)])
    recorder.finish().save(tmp_path / "a.mcap")
    read = Log.load(tmp_path / "a.mcap").detections
    assert read.track is not None
    assert read.cov_xy is not None
    assert read.track.tolist()[0] == 4.0
    assert np.isnan(read.track[1])
    assert read.cov_xy.tolist() == [0.1, 0.0]


@pytest.mark.parametrize("none", [(0.0, 0.0, 0.0), [0.0, 0.0, 0.0]], ids=["here", "from another process"])
def test_logs_without_number_and_covariance_have_neither(tmp_path: Path, none: Any) -> None:
    from pytest_dvp.logs.recorder import LogRecorder
    from vehicle.messages import Detection

    recorder = LogRecorder({})
    recorder.ego_rows(np.array([[0.01 * k, *[0.0] * 11] for k in range(3)]))
    recorder.tick(0.0, detections=[Detection(0.0, "vehicle", *[1.0] * 7, covariance=none)])
    recorder.finish().save(tmp_path / "a.mcap")
    assert Log.load(tmp_path / "a.mcap").detections.tracking == {}
