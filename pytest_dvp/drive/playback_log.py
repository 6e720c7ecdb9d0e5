"""What a stack asked for beside what was asked for in the recording that is played to it: for the log, and the metrics.

An event of the kind `replay` says when the two have gone apart; from then on nothing measured of the ego's motion says
anything about the stack, so that metrics of a closed loop are invalid in such a log.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pytest_dvp.drive.guard_log import GuardLog
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.obeyed_commands import REPLAY, divergence_time

if TYPE_CHECKING:
    from pytest_dvp.logs.recorder import LogRecorder
    from pytest_dvp.metrics import MetricValue
    from vehicle.adapters.replay import Difference

ERRORS = ("replay_steer_error", "replay_accel_error")  # metrics


class PlaybackLog(GuardLog):
    """Takes every difference (`compare`) and hands what follows to a recorder once a tick.

    length: of the recording [s]
    """

    def __init__(self, length: float) -> None:
        from vehicle.adapters.replay import Judge

        super().__init__()
        self.length = length
        self._judge = Judge()
        self._newest: Difference | None = None
        self._told: list[tuple[float, str]] = []

    def compare(self, difference: Difference) -> None:
        """Keep what was asked for at one instant."""
        self._newest = difference
        if self._judge.hear(difference) and self._judge.diverged is not None:
            text = f"steering {difference.steer_off:+.3f} rad, acceleration {difference.accel_off:+.2f} m/s^2 off"
            self._told.append((self._judge.diverged, text))

    def drain(self, recorder: LogRecorder) -> None:
        """An event `replay` when the two have gone apart."""
        super().drain(recorder)
        for t, text in self._told:
            recorder.event(t, REPLAY, "apart", text)
        self._told.clear()

    @property
    def output(self) -> dict[str, float]:
        """What was asked for then: columns replay.steer_cmd [rad], replay.accel_cmd [m/s^2]."""
        if self._newest is None:
            return {}
        return {"replay.steer_cmd": self._newest.steer, "replay.accel_cmd": self._newest.accel}


def playback_notes(log: Log, metrics: Mapping[str, MetricValue]) -> tuple[str, ...]:
    """One line about what a stack asked for in a replay, whether a gate judges it or not; nothing for other runs.

    metrics: those of the log by name
    """
    if log.meta.get("vehicle", {}).get("name") != REPLAY:
        return ()
    off = [metrics[name] for name in ERRORS]
    if not all(each.valid for each in off):
        return ("recording: it holds no commands; whether this stack would have driven so, nobody can tell",)
    parts = [f"{each.value:.2g} {each.unit} (at most {each.extra['greatest']:.2g} at t={each.t:.2f} s)" for each in off]
    line = f"recording: off its commands by {parts[0]}, {parts[1]}, root mean square"
    apart = divergence_time(log)
    more = "" if apart is None else f"; apart from t={apart:.2f} s on: metrics of the ego's motion are INVALID"
    return (line + more,)
