"""What did not take place is INCONCLUSIVE; what is bad and has no gate is said aloud."""

from __future__ import annotations

from typing import Any

import pytest
from results_logs import drive_straight, log_of

from pytest_dvp.logs.event_names import unique_names
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics import compute, known_metrics
from pytest_dvp.verdicts.judging import Gate, default_gates, judge, never_fired, overall, unjudged
from pytest_dvp.verdicts.result_text import asked_verdicts, undecided
from pytest_dvp.verdicts.silent_events import without_optional

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
    assert verdicts[-1].short == "storyboard INCONCLUSIVE: 2 of 2 events never fired: 'Brake', 'Swerve'"


@pytest.mark.parametrize("gates", [default_gates().gates, (Gate("collision", max=0.0),)], ids=["default", "own"])
def test_one_event_that_never_fired_is_no_pass(gates: tuple[Gate, ...]) -> None:
    """The manoeuvre is what the scenario is for: without it the run proves nothing, whatever else held."""
    log = log_of(columns={"on_road": 1.0}, meta=EVENTS, events=(FIRED, LogEvent(10.0, "stop", "storyboard")))
    verdict = judge(gates, log)[-1]
    assert verdict.status == overall(judge(gates, log)) == "INCONCLUSIVE"
    assert verdict.short == "storyboard INCONCLUSIVE: event 'Swerve' never fired"
    assert verdict.message.endswith('a gate on events_fired with max = 0 and optional = ["Swerve"]')


@pytest.mark.parametrize(
    "meant",
    [
        Gate("events_fired", max=0.0, options={"optional": ["Swerve"]}),
        Gate("events_fired", max=1.0),
        Gate("event_started", max=0.0, options={"event": "Swerve"}),
    ],
    ids=["optional", "bound", "must_not_happen"],
)
def test_an_event_that_need_not_fire_is_said_so_by_a_gate(meant: Gate) -> None:
    assert (
        overall(judge([Gate("collision", max=0.0), meant], drive_straight(5.0, meta=EVENTS, events=(FIRED,)))) == "PASS"
    )


def test_what_is_optional_must_exist_and_the_rest_must_still_fire() -> None:
    log = drive_straight(5.0, meta=EVENTS, events=(FIRED,))
    (wrong,) = judge([Gate("events_fired", max=0.0, options={"optional": ["Swirl"]})], log)
    assert (wrong.status, "no storyboard event 'Swirl'; it has: Brake, Swerve" in wrong.message) == ("ERROR", True)
    (missed,) = judge([Gate("events_fired", max=0.0, options={"optional": ["Brake"]})], log)
    assert (missed.status, missed.object) == ("INCONCLUSIVE", "Swerve")


def as_result(gates: tuple[Gate, ...], log: Log) -> dict[str, Any]:
    verdicts = judge(gates, log)
    events = {"events": EVENTS["storyboard_events"], "never_fired": list(never_fired(gates, log))}
    return {"status": overall(verdicts), "verdicts": [verdict.as_dict() for verdict in verdicts], **events}


COLLISION, COUNTED = Gate("collision", max=0.0), Gate("events_fired", max=0.0)


@pytest.mark.parametrize(
    ("gates", "optional", "decides"),
    [
        ((COLLISION,), [], False),
        ((COLLISION,), ["Swerve"], True),
        ((COLLISION,), ["Brake"], False),
        ((COLLISION, COUNTED), [], False),
        ((COLLISION, COUNTED), ["Swerve"], True),
        ((COLLISION, Gate("events_fired", max=0.0, options={"optional": ["Swerve"]})), [], True),
        ((COLLISION, Gate("events_fired", max=1.0)), [], True),
        ((COLLISION, Gate("event_started", max=0.0, options={"event": "Swerve"})), [], True),
        ((COLLISION, Gate("event_started", min=1.0, options={"event": "Swerve"})), [], False),
    ],
)
@pytest.mark.parametrize("metrics", [["collision"], None])
def test_no_choice_of_metrics_passes_where_an_event_never_fired(
    gates: tuple[Gate, ...], optional: list[str], decides: bool, metrics: list[str] | None
) -> None:
    result = without_optional(as_result(gates, drive_straight(5.0, meta=EVENTS, events=(FIRED,))), optional)
    verdicts = asked_verdicts(result, metrics)
    assert all(verdict["status"] == "PASS" for verdict in verdicts) is decides
    assert undecided(result, metrics) is (not decides and not any(v["status"] == "FAIL" for v in verdicts))


def test_an_event_is_missed_although_a_gate_that_is_not_asked_fails() -> None:
    """What failed is left out by the test; that the manoeuvre did not take place is not."""
    failing = Gate("max_ttc_inverse", min=1e6)
    result = as_result((COLLISION, failing), drive_straight(5.0, meta=EVENTS, events=(FIRED,)))
    assert [verdict["gate"] for verdict in asked_verdicts(result, ["collision"])] == ["collision <= 0", "storyboard"]


def test_an_event_that_waits_for_a_collision_of_the_ego_need_not_fire() -> None:
    log = drive_straight(5.0, meta={**EVENTS, "collision_events": ["Swerve"]}, events=(FIRED,))
    assert overall(judge([Gate("collision", max=0.0)], log)) == "PASS"


def test_events_of_one_name_are_counted_one_by_one() -> None:
    """A catalogue manoeuvre that two groups use: the cut-in of B does not stand for that of C."""
    paths = [("Story", "Act", group, "CutIn", "Start") for group in ("GroupOfB", "GroupOfC")]
    names = unique_names([*paths, ("Story", "Act", "GroupOfC", "CutIn", "End")])
    assert list(names.values()) == ["GroupOfB::CutIn::Start", "GroupOfC::CutIn::Start", "End"]
    fired = [LogEvent(1.0, "story.event", name, "standbyState -> runningState") for name in (names[paths[0]], "End")]
    log = drive_straight(5.0, meta={"storyboard_events": list(names.values())}, events=tuple(fired))
    assert judge([Gate("collision", max=0.0)], log)[-1].short.endswith("event 'GroupOfC::CutIn::Start' never fired")
    assert compute("event_started", log, event="Start").value == 1.0
    assert compute("event_started", log, event="GroupOfC::CutIn::Start").value == 0.0


def test_a_default_gate_that_is_missed_and_not_judged_is_said() -> None:
    log = log_of(columns={"on_road": 0.0}, events=(LogEvent(10.0, "stop", "storyboard"),))
    verdicts = judge([Gate("collision", max=0.0)], log)
    assert unjudged(verdicts, log) == ["not judged: road_departure 10.00 s (no gate on it)"]


def test_what_is_judged_or_good_or_unknown_is_not_said() -> None:
    log = log_of(columns={"on_road": 0.0})
    assert unjudged(judge(default_gates(), log), log) == []
    ended = drive_straight(5.0, events=(LogEvent(10.0, "stop", "storyboard"),))  # and on_road was not measured
    assert unjudged(judge([Gate("tet", max=0.0)], ended), ended) == []
