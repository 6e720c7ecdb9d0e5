"""What metrics say of a line of one point, of stamps that stand twice, of shares and times just at a bound."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times, track

from pytest_dvp.gap.compare import match_bounds
from pytest_dvp.gap.words import comparison as words
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, LogEvent
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics import MetricError, compute, model_match
from pytest_dvp.metrics._even_time import uniform
from pytest_dvp.metrics.path_distance import STRIDE

EGO = {"length": 2.0, "width": 2.0, "height": 1.4, "center_x": 1.0}  # its front is 2 m ahead of the reference point

# --- lines


@pytest.mark.parametrize(
    ("name", "options", "says"),
    [
        ("lane_time_outside", {"width": 3.0}, "the log has no reference line: the task has neither lane nor route"),
        ("lateral_rmse", {}, "the log has no reference line: the task has neither lane nor route"),
        ("stop_error", {}, "the task has no goal"),
    ],
)
def test_one_point_is_no_line_and_two_are_one(name: str, options: dict[str, float], says: str) -> None:
    line = np.array([[-1.0, 0.5], [9.0, 0.5]])
    found = [compute(name, log_of(reference=line[:n], meta={"task": {"goal": [1]}}), **options) for n in range(3)]
    assert [one.valid for one in found] == [False, False, True]
    assert (found[0].reason, found[1].reason) == (says, says)


@pytest.mark.parametrize(("beyond", "valid"), [(0.0, True), (0.05, False)])
def test_half_of_a_path_beside_the_other_one_tells_a_distance(beyond: float, valid: bool) -> None:
    """100 points lie beside the first one's line of 5 m, and as many behind its end, or one more."""
    t = times()
    short = log_of(columns={"x": np.minimum(t, 5.02)})
    whole = log_of(columns={"x": 0.02 + 0.1 * t * (9.98 + beyond), "y": 0.5})
    found = compute("path_distance", short, whole)
    assert found.valid is valid
    if valid:
        assert found.value == pytest.approx(0.5)
        assert found.series is not None
        assert np.isfinite(found.series.value).sum() == 100
        assert len(found.series.t) == 200 == round(10.0 / STRIDE)


# --- stamps


def test_a_time_base_is_left_as_it_is_up_to_a_thousandth_of_its_step() -> None:
    """Whenever its clock began; beyond that it is made even, with as many rows."""
    for apart, same in ((0.9e-3, True), (1.1e-3, False)):
        t = 64.0 + 0.25 * np.arange(41.0)
        t[1::2] += 0.25 * apart
        t[-1] = 74.0
        v = np.sin(t)
        found, values = uniform(Log({"t": t, "v": v}), "v")
        assert (found.tolist() == t.tolist()) is same
        assert (values.tolist() == v.tolist()) is same
        assert len(found) == 41
        assert np.diff(found) == pytest.approx(0.25, rel=1.2e-3 if same else 1e-9)


@pytest.mark.parametrize(
    ("t", "says"),
    [([0.0, 1.0, 2.0], "too few samples"), ([0.0, 1.0, 1.0, 2.0], "the time of the log does not increase"),
     ([0.0, 2.0, 1.0, 3.0], "the time of the log does not increase"), ([0.0, 1.0, np.nan, 3.0], "v was not measured")],
)  # fmt: skip
def test_what_no_time_base_can_be_made_of(t: list[float], says: str) -> None:
    with pytest.raises(Undefined, match=says):
        uniform(Log({"t": np.array(t), "v": np.zeros(len(t))}), "v")
    four = np.arange(4.0)
    assert uniform(Log({"t": four, "v": four}), "v")[1].tolist() == four.tolist()


def test_signals_whose_stamps_mostly_stand_twice_are_not_compared() -> None:
    """Three rows an instant: half of the steps are none, and no grid can be laid."""
    t = np.repeat(np.arange(8.0), 3)
    log = Log({"t": t, "v": np.sin(t), "steer_cmd": np.sin(t), "steer": np.sin(t)})
    assert compute("mncc", log, log, signal="v").reason == "the logs have no time in common"
    assert compute("response_lag", log).reason == "the time of the log does not increase"


# --- lights and events


def test_a_red_line_that_is_crossed_twice_counts_once_and_since_the_first_time() -> None:
    """It is before its line at 0, 4 and 8 s, behind it at 2, 6 and 10 s; another light is crossed at 1 and at 9 s."""
    x = np.interp(times(), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0], [0.0, 8.0, 0.0, 8.0, 0.0, 8.0]) + 1e-6
    lines = [{"signal": name, "x": at, "y": 0.0, "heading": 0.0, "width": 4.0} for name, at in (("a", 8.0), ("b", 6.0))]
    events = tuple(LogEvent(0.0, "signal", name, "red") for name in "ab")
    both, one = (
        compute("red_light", log_of(columns={"x": x}, meta={"stop_lines": there, "ego": EGO}, events=events))
        for there in (lines, lines[:1])
    )
    assert (both.value, both.t, both.object) == (2.0, pytest.approx(1.0), "b")
    assert (one.value, one.t, one.object) == (1.0, pytest.approx(1.5), "a")


def test_of_several_events_that_never_fired_the_first_is_named() -> None:
    fired = LogEvent(1.0, "story.event", "b", "standbyState -> runningState")
    found = compute("events_fired", log_of(meta={"storyboard_events": ["a", "b", "c", "d"]}, events=(fired,)))
    assert (found.value, found.object) == (3.0, "a")


# --- road users


def closing(x: float, speed: float, kind: str = "vehicle") -> Log:
    """An ego that stands, and somebody of 4 m by 2 m at x with a speed towards it, as one instant tells it."""
    return log_of(2.0, meta={"ego": EGO}, objects={"a": track(0.25 * np.arange(9.0), x, 0.0, vx=-speed, kind=kind)})


def test_a_time_to_collision_at_the_critical_one_is_not_below_it() -> None:
    """8 m between them, closed at 4 m/s: 2 s; nine instants of 0.25 s, of which the last lasts no time."""
    assert compute("tet", closing(12.0, 4.0)).value == 0.0
    assert compute("tet", closing(12.0, 4.0), critical=2.01).value == pytest.approx(2.0)
    assert compute("max_ttc_inverse", closing(12.0, 4.0)).value == pytest.approx(0.5)


@pytest.mark.parametrize(("name", "value"), [("max_ttc_inverse", 0.5), ("min_distance", 8.0)])
def test_a_road_user_that_was_there_only_before_or_after_the_ego_is_none_of_its(name: str, value: float) -> None:
    """The log lasts from 0 to 2 s. Who is there is 8 m ahead of the ego's front and, it says, comes at 4 m/s: 2 s."""
    here, later, earlier = (
        track(start + 0.25 * np.arange(9.0), x, 0.0, vx=-4.0) for start, x in ((0.0, 12.0), (3.0, 4.5), (-3.0, 4.5))
    )
    alone, both = (
        log_of(2.0, meta={"ego": EGO}, objects={"a": later, "b": earlier, **more}) for more in ({}, {"c": here})
    )
    assert compute(name, alone).reason == "no other road user at a time at which the ego was recorded"
    found = compute(name, both)
    assert (found.value, found.object) == (pytest.approx(value), "c")


@pytest.mark.parametrize(
    ("x", "y", "hit"), [(0.0, 1.9, 1.0), (0.0, -1.9, 1.0), (0.0, 2.1, 0.0), (3.9, 0.0, 1.0), (4.1, 0.0, 0.0)]
)
def test_who_is_hit_is_told_by_the_sizes_of_both_boxes_and_not_by_where_they_go(x: float, y: float, hit: float) -> None:
    """The ego covers 0 to 2 m along and 1 m to each side, the other one 2 m and 1 m from its middle at x. It comes from
    ahead at 9 m/s, and the ego goes on at 3 m/s: the log has them a quarter of a second at this place."""
    at = 0.25 * np.arange(2.0)
    log = log_of(0.25, columns={"v": 3.0, "vx": 3.0}, meta={"ego": EGO}, objects={"a": track(at, x, y, vx=-9.0)})
    found = compute("collision", log)
    assert (found.value, found.t, found.object) == ((1.0, 0.0, "a") if hit else (0.0, None, ""))


@pytest.mark.parametrize(
    ("name", "option"),
    [("max_ttc_inverse", "resolution"), ("required_deceleration", "resolution"), ("time_headway", "slow")],
)
def test_what_is_divided_by_is_more_than_nought(name: str, option: str) -> None:
    log = drive_straight(5.0, objects={"a": track(times()[::5], 60.0, 0.0)})
    for value in (0.0, -0.5):
        with pytest.raises(MetricError, match=f"option '{option}' .* must be > 0.*, found {value:g}$"):
            compute(name, log, **{option: value})
    assert compute(name, log, **{option: 0.1}).valid


def test_each_detection_of_a_moving_road_user_has_its_own_delay() -> None:
    """0.2 s at 2 m/s and 0.5 s at 4 m/s; least squares weigh them by the square of the speed."""
    t = 0.25 * np.arange(21.0)
    speeds, delays = (2.0, 4.0), (0.2, 0.5)
    objects = {f"at {v:g}": track(t, 5.0 + 2.0 * k, 3.0 * k, vx=v) for k, v in enumerate(speeds)}
    of, at = np.tile([0, 1], len(t)), np.repeat(t, 2)
    x = 5.0 + 2.0 * of - np.array(speeds)[of] * np.array(delays)[of]
    flat = np.zeros(len(at))
    table = DetectionTable(t=at, kind=("vehicle",) * len(at), x=x, y=3.0 * of, yaw=flat, length=flat + 4.0,
                           width=flat + 2.0, vx=flat, vy=flat)  # fmt: skip
    found = compute("track_latency", log_of(5.0, meta={"ego": EGO}, objects=objects, detections=table))
    assert found.value == pytest.approx((0.2 * 4.0 + 0.5 * 16.0) / 20.0)
    assert found.object == "at 4"
    assert found.series is not None
    assert sorted(set(found.series.value.round(9).tolist())) == [0.2, 0.5]


# --- motion


@pytest.mark.parametrize("slides", [None, np.nan, 0.5])
def test_sideslip_counts_where_it_was_measured_throughout(slides: float | None) -> None:
    """4 m/s and 0.3 rad/s make 1.2 m/s^2; a sideslip that grows by 0.5 m/s^2 is that much more."""
    t = times()
    columns = {"t": t, "v": np.full(len(t), 4.0), "yaw_rate": np.full(len(t), 0.3)}
    if slides is not None:
        columns["vy"] = np.where(t < 5.0, 0.5, slides) * t
    expected = 1.7 if slides == 0.5 else 1.2
    assert compute("max_lateral_acceleration", Log(columns)).value == pytest.approx(expected)


# --- models


@pytest.mark.parametrize(
    ("rest", "t", "place"),
    [([np.nan, -3.0, 2.0], 0.5, "braking"), ([1.0, np.nan, 2.0], 1.0, ""), ([np.nan, np.nan, np.nan], None, "")],
)
def test_an_open_loop_error_is_worst_where_most_is_left_either_way(
    rest: list[float], t: float | None, place: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    found: Any = SimpleNamespace(t=np.array([0.0, 0.5, 1.0]), residuals={"v": np.array(rest)}, where=())
    monkeypatch.setattr(model_match, "_compared", lambda *given: found)
    judged = SimpleNamespace(value=0.7, unit="m/s")
    monkeypatch.setattr(match_bounds, "judge_bounds", lambda comparison, bounds: [judged])
    places = {"v": place}
    monkeypatch.setattr(words, "worst_place", lambda where, signal: places[signal])
    monkeypatch.setattr(words, "sentence", lambda found: f"most in {found}")
    file = tmp_path / "car.toml"
    file.write_text("")
    error, lag = (compute(name, log_of(), model=str(file), signal="v") for name in ("open_loop_error", "model_lag"))
    assert (error.value, error.t, error.unit, error.object) == (0.7, t, "m/s", place and f"most in {place}")
    assert (lag.value, lag.t, lag.unit) == (0.7, t, "s")
