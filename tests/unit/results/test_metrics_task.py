"""Task, contact and lateral offset."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from results_logs import drive_straight, log_of, relaxed, times, track

from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._polyline import lateral_offsets
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.judging import judge

STRAIGHT = np.column_stack((np.arange(-10.0, 111.0), np.zeros(121)))


def test_completion_is_from_start_to_goal() -> None:
    log = drive_straight(5.0, events=(LogEvent(1.25, "start", "Ego"), LogEvent(8.5, "goal", "Ego")))
    result = compute("completion_time", log)
    assert (result.value, result.t) == (7.25, 8.5)


def test_completion_without_start_zone_counts_from_the_first_sample() -> None:
    assert compute("completion_time", drive_straight(5.0, events=(LogEvent(8.5, "goal", "Ego"),))).value == 8.5


def test_completion_is_undefined_without_goal() -> None:
    assert compute("completion_time", drive_straight(5.0)).reason == "the goal was never reached"
    events = (LogEvent(2.0, "goal", "Ego"), LogEvent(5.0, "start", "Ego"), LogEvent(8.5, "goal", "Ego"))
    assert compute("completion_time", drive_straight(5.0, events=events)).value == 3.5  # of what began at the start
    assert not compute("completion_time", drive_straight(5.0, events=events[:2])).valid


def test_completion_without_goal_says_how_far_away_the_ego_ended() -> None:
    """At 5 m/s for 10 s it is at x = 50 m; the line to the goal ends at x = 110 m."""
    log = drive_straight(5.0, reference=STRAIGHT, meta={"task": {"goal": {"road": "1", "lane": -1, "s": 110.0}}})
    reason = compute("completion_time", log).reason
    assert reason == "the goal was never reached: the ego ended 60.0 m from it at t=10.00 s"


@pytest.mark.parametrize(("events", "value"), [((LogEvent(8.5, "goal", "Ego"),), 1.0), ((), 0.0)])
def test_goal_reached(events: tuple[LogEvent, ...], value: float) -> None:
    log = drive_straight(5.0, events=events, meta={"task": {"goal": ["1", -1, 420.0]}})
    assert compute("goal_reached", log).value == value


def test_goal_reached_is_undefined_for_a_task_without_goal() -> None:
    assert compute("goal_reached", drive_straight(5.0)).reason == "the task has no goal"


@pytest.mark.parametrize(("kind", "value"), [("stop", 1.0), ("goal", 1.0), ("timeout", 0.0)])
def test_scenario_ended_by_itself(kind: str, value: float) -> None:
    assert compute("scenario_ended", drive_straight(5.0, events=(LogEvent(9.0, kind, ""),))).value == value


def test_events_that_never_fired_are_counted_and_named() -> None:
    fired = LogEvent(2.0, "story.event", "Story/Act/Cross", "standbyState -> runningState")
    waiting = LogEvent(0.0, "story.event", "Story/Act/Brake", "init -> standbyState")
    meta = {"storyboard_events": ["Story/Act/Cross", "Story/Act/Brake"]}
    result = compute("events_fired", drive_straight(5.0, events=(waiting, fired), meta=meta))
    assert (result.value, result.object) == (1.0, "Story/Act/Brake")


def test_scenario_without_events_is_no_pass() -> None:
    assert not compute("events_fired", drive_straight(5.0, meta={"storyboard_events": []})).valid


def test_collision_counts_objects_not_contacts() -> None:
    events = tuple(LogEvent(t, "collision", name) for t, name in ((4.0, "b"), (3.0, "a"), (5.0, "a")))
    result = compute("collision", drive_straight(5.0, events=events))
    assert (result.value, result.t, result.object) == (2.0, 3.0, "a")


def test_overlapping_boxes_collide_without_a_world_that_says_so() -> None:
    # Ego front at 2.7 + 5 t meets the back at 40 m at t = 7.46 s: first sample of the object after it is 7.50 s.
    log = drive_straight(5.0, objects={"target": track(times()[::5], 42.0, 0.0)})
    result = compute("collision", log)
    assert (result.value, result.object) == (1.0, "target")
    assert result.t == pytest.approx(7.5)


def test_a_reported_collision_stands_whatever_else_was_not_measured() -> None:
    """The world reports that a was hit; where b was at 2 s, or how large the ego is, is not known."""
    car = track(times()[::5], 500.0, 0.0)
    car.x[40] = np.nan
    hit = (LogEvent(4.0, "collision", "a"),)
    for meta in ({}, {"ego": None}):
        log = drive_straight(5.0, events=hit, objects={"b": car}, meta=meta)
        found = compute("collision", log)
        assert (found.value, found.t, found.object, found.reason) == (1.0, 4.0, "a", "")
        assert [verdict.status for verdict in judge([Gate("collision", max=0.0)], log)] == ["FAIL"]
    unknown = compute("collision", drive_straight(5.0, objects={"b": car}))
    assert unknown.reason == "position or speed of b is not measured at t=2.00 s"


def test_empty_world_has_no_collision() -> None:
    result = compute("collision", drive_straight(5.0))
    assert (result.value, result.valid) == (0.0, True)


def test_log_without_samples_has_no_collision_metric_at_all() -> None:
    log = log_of(0.0)
    assert compute("collision", log).reason == "the log has no samples"


def test_time_off_the_road() -> None:
    t = times()
    log = drive_straight(5.0)
    log.columns["on_road"] = np.where((t > 3.995) & (t < 4.345), 0.0, 1.0)
    result = compute("road_departure", log)
    assert result.value == pytest.approx(0.35)
    assert result.t == pytest.approx(4.0)


def test_departure_in_the_last_sample_counts() -> None:
    log = drive_straight(5.0)
    log.columns["on_road"] = np.where(times() < 9.995, 1.0, 0.0)
    assert compute("road_departure", log).value == pytest.approx(0.01)


def test_road_departure_that_was_not_measured_is_undefined() -> None:
    assert not compute("road_departure", drive_straight(5.0)).valid


@pytest.mark.parametrize("offset", [0.59, -0.59])
def test_rmse_of_a_constant_offset(offset: float) -> None:
    log = drive_straight(5.0, reference=STRAIGHT)
    log.columns["y"][:] = offset
    assert compute("lateral_rmse", log).value == pytest.approx(0.59)


def test_rmse_of_a_sine_is_its_amplitude_over_root_two() -> None:
    log = drive_straight(5.0, reference=STRAIGHT)
    log.columns["y"][:] = 0.8 * np.sin(2.0 * math.pi * times() / 2.5)
    result = compute("lateral_rmse", log)
    assert result.value == pytest.approx(0.8 / math.sqrt(2.0), rel=1e-3)
    assert result.extra["greatest"] == pytest.approx(0.8, rel=1e-4)


def test_rmse_counts_from_start_to_goal_only() -> None:
    log = drive_straight(5.0, reference=STRAIGHT, events=(LogEvent(2.0, "start", "Ego"), LogEvent(8.0, "goal", "Ego")))
    log.columns["y"][:] = np.where((times() > 1.995) & (times() < 8.005), 0.3, 5.0)
    assert compute("lateral_rmse", log).value == pytest.approx(0.3)


def test_offset_to_a_circle_is_signed_to_the_left() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 2001)
    circle = 50.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    at = np.linspace(0.1, 6.0, 50)
    offsets = lateral_offsets(49.0 * np.cos(at), 49.0 * np.sin(at), circle)  # inside, left of counter-clockwise travel
    assert offsets == pytest.approx(np.ones(50), abs=1e-4)


def test_beside_the_ends_of_the_line_nothing_is_said() -> None:
    offsets = lateral_offsets(np.array([-1.0, 5.0, 11.0]), np.ones(3), np.array([[0.0, 0.0], [10.0, 0.0]]))
    assert np.isnan(offsets[[0, 2]]).all()
    assert offsets[1] == 1.0


@relaxed
@given(seed=st.integers(0, 10**6))
def test_nearest_segment_is_found_on_any_line(seed: int) -> None:
    rng = np.random.default_rng(seed)
    line = rng.normal(size=(rng.integers(2, 40), 2)).cumsum(axis=0)
    x, y = rng.normal(size=(2, 30)) * 6.0
    offsets = lateral_offsets(x, y, line)
    start, along = line[:-1], np.diff(line, axis=0)
    for i in np.flatnonzero(np.isfinite(offsets)):
        away = np.array([x[i], y[i]]) - start
        share = np.clip((away * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
        assert abs(offsets[i]) == pytest.approx(np.hypot(*(away - share[:, None] * along).T).min(), abs=1e-9)


def test_path_rmse_is_to_the_path_planned_at_that_time() -> None:
    shifted = STRAIGHT + np.array([0.0, 2.0])
    log = drive_straight(5.0, paths=[(0.0, STRAIGHT), (5.0, shifted)], reference=STRAIGHT)
    log.columns["y"][times() > 4.995] = 2.1
    assert compute("lateral_rmse_path", log).value == pytest.approx(0.1 * math.sqrt(501 / 1001))
    assert compute("lateral_rmse", log).value == pytest.approx(2.1 * math.sqrt(501 / 1001))


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("lateral_rmse", "the log has no reference line: the task has neither lane nor route"),
        ("lateral_rmse_path", "no planned path in the log"),
    ],
)
def test_rmse_without_a_line_is_undefined(name: str, reason: str) -> None:
    assert compute(name, drive_straight(5.0)).reason == reason


def test_rmse_beside_the_line_most_of_the_time_is_undefined() -> None:
    for length, share in ((10.0, 20), (24.5, 49)):  # of 50 m
        log = drive_straight(5.0, reference=np.array([[0.0, 0.0], [length, 0.0]]))
        said = compute("lateral_rmse", log).reason
        assert said == f"the ego is beside the line for {share} % of the time only"
