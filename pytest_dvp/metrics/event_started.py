"""How often an event of the storyboard began: a scenario's own definition of what must, or must not, happen."""

from __future__ import annotations

from pytest_dvp.logs.event_reference import means_event
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, metric


@metric(name="event_started", unit="-", bigger_is_worse=None)
def event_started(log: Log, *, event: str) -> Measured:
    """How often the storyboard event `event` began: bound it with `max = 0` or `min = 1`.

    `event` is its name, or the end of it where several have the same (`Start` of `GroupOfB::CutIn::Start`: all are
    counted). Undefined if the scenario has no event of that name (meta `storyboard_events`).
    """
    declared = log.meta.get("storyboard_events")
    if not isinstance(declared, list | tuple) or not any(means_event(event, str(name)) for name in declared):
        raise Undefined(f"the scenario has no storyboard event {event!r}")
    began = [e for e in log.events if e.kind == "story.event" and e.text.endswith("> runningState")]
    times = [e.t for e in began if means_event(event, e.element)]
    return Measured(float(len(times)), times[0] if times else None, event)
