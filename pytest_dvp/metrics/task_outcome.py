"""Did the scenario take place and did the ego do what it was asked to?"""

from __future__ import annotations

import math
from collections.abc import Sequence

from pytest_dvp.logs.event_reference import means_event
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, MetricError, metric


def first_time(log: Log, kind: str) -> float | None:
    """Time [s] of the first event of a kind, None if there is none."""
    return min((event.t for event in log.events if event.kind == kind), default=None)


def storyboard_events(log: Log) -> tuple[list[str], list[str]]:
    """Names of the scenario's events as meta `storyboard_events` lists them, and of those that never fired.

    Those that wait for the ego's collision (meta `collision_events`) are not missed: to fire is what they must not.
    """
    names = _listed(log, "storyboard_events")
    fired = {e.element for e in log.events if e.kind == "story.event" and "running" in e.text.lower()}
    fired.update(_listed(log, "collision_events"))
    return names, [name for name in names if name not in fired]


def _listed(log: Log, key: str) -> list[str]:
    declared = log.meta.get(key)
    return [str(name) for name in declared] if isinstance(declared, list | tuple) else []


@metric(name="completion_time", unit="s", bigger_is_worse=True)
def completion_time(log: Log) -> Measured:
    """Time from the start zone to the goal: from the event "start", or the first sample, to the first event "goal".

    Source: Arango et al., Sensors 2026, 26, 1338. Undefined if the goal was never reached.
    """
    start = first_time(log, "start")
    since = float(log.t[0]) if start is None else start
    goals = [event.t for event in log.events if event.kind == "goal" and event.t >= since]
    if not goals:
        raise Undefined(f"the goal was never reached{_away(log)}")
    return Measured(min(goals) - since, min(goals))


def _away(log: Log) -> str:
    """How far from the goal the ego ended: the reference line of a task with a goal ends there."""
    task = log.meta.get("task")
    if not isinstance(task, dict) or not task.get("goal") or not len(log.reference):
        return ""
    x, y = log.reference[-1]
    return f": the ego ended {math.hypot(log['x'][-1] - x, log['y'][-1] - y):.1f} m from it at t={log.t[-1]:.2f} s"


@metric(name="goal_reached", unit="-", bigger_is_worse=False, miss="INCONCLUSIVE")
def goal_reached(log: Log) -> Measured:
    """1 if the ego reached the goal of its task, else 0. Undefined if the task has no goal."""
    goal = first_time(log, "goal")
    if goal is not None:
        return Measured(1.0, goal)
    task = log.meta.get("task")
    if not isinstance(task, dict) or not task.get("goal"):
        raise Undefined("the task has no goal")
    return Measured(0.0, float(log.t[-1]))


@metric(name="scenario_ended", unit="-", bigger_is_worse=False)
def scenario_ended(log: Log) -> Measured:
    """1 if the scenario ended by itself (stop trigger or goal), 0 if the time limit ended it."""
    ends = [t for kind in ("stop", "goal") if (t := first_time(log, kind)) is not None]
    return Measured(1.0, min(ends)) if ends else Measured(0.0, float(log.t[-1]))


@metric(name="events_fired", unit="-", bigger_is_worse=True, miss="INCONCLUSIVE")
def events_fired(log: Log, *, optional: Sequence[str] = ()) -> Measured:
    """Number of storyboard events that never fired, those named in `optional` left out; bound it with `max = 0`.

    The scenario's events are those that meta `storyboard_events` lists (names as in the log's "story.event" events);
    one fired if it was running once. Undefined if the scenario has none.

    Raises MetricError if `optional` names an event that the scenario does not have, and Undefined if it has none.
    """
    names, missing = storyboard_events(log)
    if not names:
        raise Undefined("the scenario has no storyboard events (meta: storyboard_events)")
    for reference in optional:
        if not any(means_event(reference, name) for name in names):
            raise MetricError(
                f"optional: the scenario has no storyboard event {reference!r}; it has: {', '.join(names)}"
            )
    missing = [name for name in missing if not any(means_event(reference, name) for reference in optional)]
    return Measured(float(len(missing)), None, missing[0] if missing else "")
