"""What the command gate decided, for the log: its output beside the request, and each finding with its reasons.

With it go the troubles of the wire behind the gate.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pytest_dvp.wire_log import WireLog

if TYPE_CHECKING:
    from pytest_dvp.recorder import LogRecorder
    from vehicle.gate_messages import Decision


class GateLog:
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
        """An event `gate` where outcome or reasons change, text as `clamped: angle, rate`."""
        for decision in self._decisions:
            before, self._last = self._last, decision
            same = before is not None and (before.outcome, before.reasons) == (decision.outcome, decision.reasons)
            if same or (before is None and not decision.reasons):
                continue
            recorder.event(decision.t, "gate", decision.outcome.value, ", ".join(decision.reasons))
        self._decisions.clear()
        self.wire.drain(recorder)

    @property
    def output(self) -> dict[str, float]:
        """The newest output: columns gate.steer_cmd [rad], gate.accel_cmd [m/s^2]; none before the first decision."""
        if self._last is None:
            return {}
        return {"gate.steer_cmd": self._last.output.steer, "gate.accel_cmd": self._last.output.accel}
