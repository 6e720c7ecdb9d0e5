"""What the guard decided, for the log: its output beside the request, and each finding with its reasons.

With it go the troubles of the wire behind the gate. `said_of` reads a finished log: where the gate had the car, what
is measured of the drive is not the stack's doing, and a reader must know.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.wire_log import WireLog
from pytest_dvp.logs.obeyed_commands import GATE

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.recorder import LogRecorder
    from vehicle.guard.messages import Decision


class GuardLog:
    """Takes every decision (`record`) and hands them to a recorder once a tick (`drain`), those of the `wire` too."""

    def __init__(self) -> None:
        self._decisions: list[Decision] = []
        self._last: Decision | None = None
        self.wire = WireLog()
        self.punctuality: Callable[[], dict[str, Any]] = dict  # of a car in real time

    def record(self, decision: Decision) -> None:
        """Keep a decision."""
        self._decisions.append(decision)

    def drain(self, recorder: LogRecorder) -> None:
        """What it let out, several times a tick, and an event `gate` where outcome or reasons change, text as
        `clamped: angle, rate`."""
        for decision in self._decisions:
            out = decision.output
            passed = {"steer": out.steer, "accel": out.accel, "throttle": out.throttle, "brake": out.brake}
            recorder.hold(decision.t, {f"{GATE}{name}_cmd": value for name, value in passed.items()})
            before, self._last = self._last, decision
            same = before is not None and (before.outcome, before.reasons) == (decision.outcome, decision.reasons)
            if same or (before is None and not decision.reasons):
                continue
            recorder.event(decision.t, "gate", decision.outcome.value, ", ".join(decision.reasons))
        self._decisions.clear()
        self.wire.drain(recorder)

    @property
    def output(self) -> dict[str, float]:
        """Further columns that hold from now on; none here."""
        return {}


WORDS = {"overspeed": "far over the highest speed", "speed": "at the highest speed", "area": "at the edge of the area"}
"""What reasons of the gate that an envelope sets mean; the others are words."""


def guard_notes(log: Log) -> tuple[str, ...]:
    """A line each for the stop profile, traction that was taken away, and hands that took over; usually nothing."""
    armed = log.meta.get("vehicle", {}).get("armed") is not False
    spans = _spans(log)
    lines = []
    for what, does in (
        ("stop", "braked" if armed else "would have braked"),
        ("speed", "let no traction through" if armed else "would have let no traction through"),
        ("handed_over", "left the car to its driver"),
    ):
        mine = [span for span in spans if span[2] == what or (what in span[3] and span[2] == "clamped")]
        if not mine:
            continue
        t, seconds = mine[0][0], sum(end - begin for begin, end, _, _ in mine)
        reasons = dict.fromkeys(reason for span in mine for reason in span[3] if reason != "not_armed")
        why = [what] if what == "speed" else [reason for reason in reasons if what != "handed_over"]
        told = ", ".join(WORDS.get(reason, reason.replace("_", " ")) for reason in why)
        lines.append(f"guard: {does} for {seconds:.2f} s from t={t:.2f} s on{f' ({told})' if told else ''}")
    return tuple(line + _bound(log, line) for line in lines)


def _bound(log: Log, line: str) -> str:
    bound = log.meta.get("vehicle", {}).get("envelope_speed")
    return f", the envelope allows {bound:g} m/s" if bound is not None and "speed" in line else ""


def _spans(log: Log) -> list[tuple[float, float, str, list[str]]]:
    """When one finding held: from and to [s], what the gate did, why."""
    events = [event for event in log.events if event.kind == "gate"]
    ends = [*(later.t for _, later in pairwise(events)), float(log.t[-1]) if len(log.t) else 0.0]
    return [
        (event.t, max(end, event.t), event.element, event.text.split(", ") if event.text else [])
        for event, end in zip(events, ends, strict=False)
    ]
