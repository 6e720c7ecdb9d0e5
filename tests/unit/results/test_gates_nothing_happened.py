"""What did not take place is INCONCLUSIVE; what is bad and has no gate is said aloud."""

from __future__ import annotations

import pytest
from results_logs import drive_straight, log_of

from pytest_dvp.gates import Gate, default_gates, judge, overall, unjudged
from pytest_dvp.log import LogEvent
from pytest_dvp.metrics import known_metrics

EVENTS = {"storyboard_events": ["Brake", "Swerve"]}
FIRED = LogEvent(1.0, "story.event", "Brake", "standbyState -> runningState", "a.xosc", 12)


@pytest.mark.parametrize(
    ("gate", "meta"),
    [(Gate("events_fired", max=0.0), EVENTS), (Gate("goal_reached", min=1.0), {"task": {"goal": {"road": "1"}}})],
)
def test_a_miss_of_what_should_have_happened_is_inconclusive(gate: Gate, meta: dict[str, object]) -> None:
    (verdict,) = judge([gate], drive_straight(5.0, meta=meta, events=(FIRED,)))
    assert (verdict.status, verdict.margin) == ("INCONCLUSIVE", -1.0)


def test_the_metric_declares_it() -> None:
    assert {name for name, metric in known_metrics().items() if metric.miss == "INCONCLUSIVE"} == {
        "events_fired",
        "goal_reached",
    }


def test_a_storyboard_of_which_nothing_fired_never_passes() -> None:
    verdicts = judge([Gate("collision", max=0.0)], drive_straight(5.0, meta=EVENTS))
    assert [verdict.status for verdict in verdicts] == ["PASS", "INCONCLUSIVE"]
    assert overall(verdicts) == "INCONCLUSIVE"
    assert verdicts[-1].short == "storyboard INCONCLUSIVE: none of its 2 events ever fired"


def test_one_event_that_fired_is_enough_for_gates_to_decide() -> None:
    verdicts = judge([Gate("collision", max=0.0)], drive_straight(5.0, meta=EVENTS, events=(FIRED,)))
    assert overall(verdicts) == "PASS"


def test_a_default_gate_that_is_missed_and_not_judged_is_said() -> None:
    log = log_of(columns={"on_road": 0.0}, events=(LogEvent(10.0, "stop", "storyboard"),))
    verdicts = judge([Gate("collision", max=0.0)], log)
    assert unjudged(verdicts, log) == ["not judged: road_departure 10.00 s (no gate on it)"]


def test_what_is_judged_or_good_or_unknown_is_not_said() -> None:
    log = log_of(columns={"on_road": 0.0})
    assert unjudged(judge(default_gates(), log), log) == []
    ended = drive_straight(5.0, events=(LogEvent(10.0, "stop", "storyboard"),))  # and on_road was not measured
    assert unjudged(judge([Gate("tet", max=0.0)], ended), ended) == []
