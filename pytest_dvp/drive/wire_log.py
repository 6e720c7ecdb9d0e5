"""Troubles with a car's messages, for the log and the verdict: what was measured over a faulty wire proves nothing.

Each trouble is an event of the kind `wire` (element: the topic), written when it begins and again after it has been
away for half a second. A log with one never passes: FAIL and ERROR stay, PASS becomes INCONCLUSIVE. How sound messages
were understood, such as an accuracy that was assumed, is an event `wire_note`, and a note of the run.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.recorder import LogRecorder
    from pytest_dvp.verdicts.judging import Verdict
    from vehicle.wire.health import Trouble

WIRE, NOTE = "wire", "wire_note"
AWAY = 0.5  # s


class WireLog:
    """Takes every trouble (`record`) and hands them to a recorder once a tick (`drain`)."""

    def __init__(self) -> None:
        self._troubles: list[Trouble] = []
        self._last: dict[tuple[str, str], float] = {}

    def record(self, trouble: Trouble) -> None:
        """Keep a trouble."""
        self._troubles.append(trouble)

    def drain(self, recorder: LogRecorder) -> None:
        """An event where a trouble begins."""
        for trouble in self._troubles:
            key = trouble.topic, trouble.what
            if trouble.t - self._last.get(key, -AWAY) >= AWAY or key not in self._last:
                recorder.event(trouble.t, NOTE if trouble.is_note else WIRE, trouble.topic, str(trouble))
            self._last[key] = trouble.t
        self._troubles.clear()


def wire_verdict(log: Log) -> Verdict | None:
    """INCONCLUSIVE, with what was wrong on which topics, if a log has events of the kind `wire`."""
    from pytest_dvp.verdicts.judging import Verdict

    events = [event for event in log.events if event.kind == WIRE]
    if not events:
        return None
    kinds: dict[str, list[str]] = {}
    for event in events:
        topics = kinds.setdefault(event.text.split(" ")[0].rstrip(":"), [])
        if event.element not in topics:
            topics.append(event.element)
    named = "; ".join(f"{what} on {_some(topics)}" for what, topics in kinds.items())
    first = events[0].t
    text = f"faults on the wire: {named}; first at t={first:.2f} s"
    return Verdict("wire", "", "INCONCLUSIVE", None, "", None, None, first, "", text, text, "", None)


def wire_notes(log: Log) -> tuple[str, ...]:
    """A line for each topic and each thing that was understood in a way that its messages do not say; the newest."""
    newest = {(each.element, each.text.partition(":")[0]): each for each in log.events if each.kind == NOTE}
    return tuple(f"{event.element}: {event.text}" for event in newest.values())


def _some(topics: list[str]) -> str:
    return ", ".join(topics[:2]) + (f" and {len(topics) - 2} more" if len(topics) > 2 else "")
