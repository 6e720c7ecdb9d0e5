"""What two drives of one scenario differ in: line on the ground, commands it took, road users seen on the way."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times

from pytest_dvp.logs.detected_tracks import matched, seen_tracks
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, LogEvent
from pytest_dvp.metrics import compute

WHEELBASE, SPEED, ANGLE = 2.5, 5.0, 0.1

CIRCLE = f"""
[model]
base = "kinematic_bicycle"
[inputs]
steer = "steer_cmd"
longitudinal = "v"
[parameters]
wheelbase = {WHEELBASE}
[[effect]]
name = "steer_ratio"
[effect.parameters.g]
value = {{gain}}
unit = "-"
"""


def circle(gain: float = 1.0) -> Log:
    """Twenty seconds of a circle at a constant wheel angle; its meta holds a twin whose steering gain is `gain`.

    The twin's speed is the measured one: a start speed of its own would explain a part of what it turns too much.
    """
    t = times(20.0)
    rate = SPEED * math.tan(ANGLE) / WHEELBASE
    columns: dict[str, FloatArray | float] = {
        "x": SPEED / rate * np.sin(rate * t),
        "y": SPEED / rate * (1.0 - np.cos(rate * t)),
        "yaw": rate * t,
        "v": SPEED,
        "yaw_rate": rate,
        "steer_cmd": ANGLE,
        "accel_cmd": 0.0,
    }
    return log_of(20.0, columns=columns, meta={"model": {"toml": CIRCLE.format(gain=gain)}})


def test_the_twin_that_is_the_car_has_no_open_loop_error() -> None:
    assert compute("twin_error", circle(), circle()).value == pytest.approx(0.0, abs=1e-3)


def test_a_twin_that_steers_a_quarter_too_much_turns_a_quarter_too_fast() -> None:
    """Both cars are on their circles at once: r = v tan(g d) / L."""
    found = compute("twin_error", circle(1.25), circle(), signal="yaw_rate")
    assert found.value == pytest.approx(SPEED / WHEELBASE * (math.tan(1.25 * ANGLE) - math.tan(ANGLE)), rel=0.02)
    assert found.unit == "rad/s"
    position = compute("twin_error", circle(1.25), circle())
    assert position.value is not None
    assert position.value > 0.1
    assert position.unit == "m"


def noisy(drive: Log, sigma: float) -> Log:
    rate = drive["yaw_rate"] + np.random.default_rng(4).normal(0.0, sigma, len(drive.t))
    return dataclasses.replace(drive, columns={**drive.columns, "yaw_rate": rate})


def test_of_the_twin_that_is_the_car_only_the_noise_is_left() -> None:
    found = compute("twin_chi2", circle(), noisy(circle(), 0.01), signal="yaw_rate")
    assert found.value == pytest.approx(1.0, abs=0.15)


def test_a_wrong_twin_is_off_by_so_many_sigma_in_the_turn() -> None:
    """chi^2 = 1 + (dr / sigma)^2 with r = v tan(g d) / L."""
    found = compute("twin_chi2", circle(1.25), noisy(circle(), 0.01), signal="yaw_rate")
    off = SPEED / WHEELBASE * (math.tan(1.25 * ANGLE) - math.tan(ANGLE))
    assert found.value == pytest.approx(1.0 + (off / 0.01) ** 2, rel=0.1)
    assert found.extra[found.object] == found.value == max(v for name, v in found.extra.items() if name != "all")
    turn = compute("twin_chi2", circle(1.25), noisy(circle(), 0.01), regime="steady_turn")
    assert turn.value == pytest.approx(1.0 + (off / 0.01) ** 2, rel=0.1)
    whole = compute("twin_chi2", circle(1.25), noisy(circle(), 0.01), regime="all")
    assert whole.value == found.extra["all"]
    assert whole.note.endswith("of the all regime")


def slalom(gain: float = 1.0, twin: float = 1.0) -> Log:
    """Twenty seconds at a constant speed, left and right; the car turns `gain` times as fast as the twin says for 1."""
    straight = circle(twin)
    angle = ANGLE * np.sin(1.5 * straight.t)
    rate = gain * SPEED * np.tan(angle) / WHEELBASE
    yaw = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(straight.t))])
    way = np.concatenate([[0.0], np.cumsum(SPEED * np.exp(1j * 0.5 * (yaw[1:] + yaw[:-1])) * np.diff(straight.t))])
    columns = {**straight.columns, "x": way.real, "y": way.imag, "yaw": yaw, "yaw_rate": rate, "steer_cmd": angle}
    return dataclasses.replace(straight, columns=columns)


@pytest.mark.parametrize("gain", [0.97, 1.0, 1.05])
def test_the_gain_of_a_twin_is_what_it_answers_too_weakly(gain: float) -> None:
    found = compute("twin_gain", slalom(), noisy(slalom(gain), 0.01))
    assert found.value == pytest.approx(gain, abs=0.003)


def test_an_answer_that_does_not_vary_has_no_gain() -> None:
    found = compute("twin_gain", circle(), noisy(circle(), 0.01), signal="v")
    assert not found.valid


def test_a_regime_that_was_not_driven_tells_nothing() -> None:
    for regime, says in (("braking", "braking lasted less than 2 s"), ("flying", "no regime 'flying'; there are ")):
        found = compute("twin_chi2", circle(), circle(), regime=regime)
        assert not found.valid
        assert found.reason.startswith(says)


def played(drive: Log, apart: bool = True) -> Log:
    """The drive as a recording that was played to a stack which wanted to go straight on."""
    recorded = {f"replay.{name}": drive[name] for name in ("steer_cmd", "accel_cmd")}
    wanted = {name: np.zeros_like(drive.t) for name in ("steer_cmd", "accel_cmd")}
    events = (LogEvent(0.0, "replay", "apart"),) if apart else ()
    meta = {**drive.meta, "stage": "rw-replay", "vehicle": {"name": "replay"}}
    return dataclasses.replace(drive, columns={**drive.columns, **wanted, **recorded}, events=events, meta=meta)


def test_of_a_replay_the_recorded_commands_judge_the_twin_not_what_the_stack_asked_for() -> None:
    """The twin is the car: what a stack beside it wanted instead is no fault of either."""
    assert compute("twin_error", circle(), played(circle())).value == pytest.approx(0.0, abs=1e-3)
    t = times(40.0)
    wave, late = ((t - at) * np.exp(-(((t - at) / 2.0) ** 2)) for at in (20.0, 20.3))
    drive = log_of(40.0, columns={"steer_cmd": wave, "accel_cmd": 0.0, "steer": 0.9 * late})
    assert compute("response_lag", played(drive)).value == pytest.approx(0.3, abs=0.005)
    assert compute("response_gain", played(drive)).value == pytest.approx(0.9, abs=0.005)


def test_a_recording_without_commands_tells_no_open_loop_error() -> None:
    drive = circle()
    meta = {**drive.meta, "vehicle": {"name": "replay"}}
    found = compute("twin_error", circle(), dataclasses.replace(drive, meta=meta))
    assert (found.valid, found.reason) == (False, "the recording that was played holds no commands")


def test_two_drives_are_not_alike_or_unlike_once_the_stack_wanted_another_than_the_recorded() -> None:
    assert compute("path_distance", circle(), played(circle(), apart=False)).valid
    found = compute("path_distance", circle(), played(circle()))
    assert not found.valid
    assert found.reason.startswith("the ego's motion is a recording's, and from t=0.00 s on the stack asked")


def test_a_log_that_holds_no_model_tells_no_open_loop_error() -> None:
    found = compute("twin_error", drive_straight(5.0), circle())
    assert not found.valid
    assert "holds no model" in found.reason


def test_the_distance_of_two_paths_does_not_ask_when() -> None:
    """One drives at 5 m/s, the other half a metre beside it at 4 m/s and stands for the last two seconds."""
    t = times()
    slow = log_of(columns={"x": np.minimum(4.0 * t, 32.0), "y": 0.5, "v": 4.0})
    found = compute("path_distance", drive_straight(5.0), slow)
    assert found.value == pytest.approx(0.5)
    assert found.extra["mean"] == pytest.approx(0.5)  # to the left


def test_a_path_elsewhere_has_no_distance() -> None:
    t = times()
    behind = log_of(columns={"x": -5.0 * t, "v": -5.0})
    assert not compute("path_distance", drive_straight(5.0), behind).valid


@pytest.mark.parametrize(("end", "defined"), [(24.0, False), (26.0, True)])
def test_a_path_that_ends_before_half_of_the_other_has_no_distance(end: float, defined: bool) -> None:
    """50 m at 5 m/s; the measured one stops at `end` [m], with no error until then."""
    short = log_of(columns={"x": np.minimum(5.0 * times(), end), "v": 5.0})
    assert compute("path_distance", drive_straight(5.0), short).valid == defined


def test_bias_is_what_is_left_at_the_best_lag() -> None:
    t = times(40.0)
    wave = np.exp(-(((t - 20.0) / 2.0) ** 2))
    late = np.exp(-(((t - 20.4) / 2.0) ** 2))
    model, measured = log_of(40.0, columns={"v": wave}), log_of(40.0, columns={"v": late + 0.25})
    found = compute("bias", model, measured, signal="v")
    assert (found.value, found.unit) == (pytest.approx(0.25, abs=1e-6), "m/s")


TICKS = times(30.0)[::10]  # 10 Hz


def seen(*courses: tuple[str, FloatArray, FloatArray, FloatArray]) -> Log:
    """A standing ego's log that saw (kind, t, x, y) each; two at one time are told in the order of the courses."""
    rows = sorted(
        (t, k, kind, x, y) for k, (kind, ts, xs, ys) in enumerate(courses) for t, x, y in zip(ts, xs, ys, strict=True)
    )
    table = {name: np.array([row[i] for row in rows]) for i, name in ((0, "t"), (3, "x"), (4, "y"))}
    flat = {name: np.zeros(len(rows)) for name in ("yaw", "length", "width", "vx", "vy")}
    kinds = tuple(str(row[2]) for row in rows)
    return log_of(30.0, detections=DetectionTable(kind=kinds, **table, **flat))


def walker(speed: float, since: float = 5.0, y: float = 0.0) -> tuple[str, FloatArray, FloatArray, FloatArray]:
    """Along y = const from x = 10 m at `since`, for 15 s."""
    t = TICKS[(since - 1e-6 <= TICKS) & (since + 15.0 + 1e-6 >= TICKS)]
    return "pedestrian", t, 10.0 + speed * (t - since), np.full(len(t), y)


def test_detections_become_tracks_that_a_gap_does_not_end() -> None:
    kind, t, x, y = walker(1.0)
    hole = (t < 10.0) | (t > 10.6)
    tracks = seen_tracks(seen((kind, t[hole], x[hole], y[hole]), walker(1.0, y=8.0)))
    assert [(len(track.t), track.kind) for track in tracks] == [(int(hole.sum()), kind), (151, kind)]


def test_tracks_of_two_logs_are_matched_by_place_not_by_order() -> None:
    near, far = walker(1.0, y=0.0), walker(1.0, y=8.0)
    one, other = seen_tracks(seen(near, far)), seen_tracks(seen(far, near))
    assert [(a.y[0], b.y[0]) for a, b, _ in matched(one, other)] == [(0.0, 0.0), (8.0, 8.0)]


def test_a_walker_met_a_second_later_is_the_same_one_and_its_likeness_says_so() -> None:
    first, later = seen(walker(1.5)), seen(walker(1.5, since=6.0))
    found = compute("mncc", first, later, signal="objects.x")
    assert found.value == pytest.approx(1.0, abs=1e-6)
    assert found.extra["lag"] == pytest.approx(1.0, abs=0.06)
    assert found.extra["gain"] == pytest.approx(1.0, abs=0.02)


def test_a_car_is_no_walker() -> None:
    _, t, x, y = walker(1.5)
    assert not compute("mncc", seen(walker(1.5)), seen(("vehicle", t, x, y)), signal="objects.x").valid


def test_without_a_common_road_user_the_likeness_is_undefined() -> None:
    found = compute("mncc", seen(walker(1.5)), seen(walker(1.5, y=30.0)), signal="objects.x")
    assert found.reason == "no road user was seen in both logs whose place varied"
