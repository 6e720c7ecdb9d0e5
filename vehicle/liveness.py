"""Whether a process that owes an answer still does something: found out from the system, not by the wall clock.

On a busy machine an answer may take seconds, and a bound in seconds would give up cars that only wait for a processor.
A process that waits for one is runnable; one that waits for messages wakes up again and again to look for them; one
that works gets processor time. So what sleeps and does not even wake up, and what works for far longer than any
answer takes, hangs, however busy the machine is. Looks tell of sleep only if time lies between them: one that sleeps
until its next message is the same asleep process in ten looks of a millisecond.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

APART = 0.02  # s between two looks that count; nothing that polls sleeps for longer in one piece
ASLEEP = 8  # looks in a row
WORKING = 2.0  # s of its own processor time for one answer, which takes a hundredth of that


class Life(NamedTuple):
    """A process as the system tells it: state of its main thread ("S" asleep), how often that has gone to sleep so far,
    processor time [s] of all its threads."""

    state: str
    sleeps: int
    cpu: float


class Pulse:
    """Looks at the process `pid`, whenever nothing has come from it; a look sooner than APART after another does not
    count, so it does no harm to look often.

    Its main thread must not sleep for longer than APART without waking up: it polls. `read` tells of it; where the
    system does not, nothing is ever found. `clock` [s] never goes back.
    """

    def __init__(
        self,
        pid: int,
        read: Callable[[int], Life | None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._pid, self._read, self._clock = pid, read or life, clock
        self._step: int | None = None
        self._looked = 0.0
        self._begin = 0.0
        self._sleeps, self._looks = -1, 0

    def look(self, step: int) -> str:
        """Why it will not answer `step`, or "" as long as it may."""
        at = self._clock()
        if step == self._step and at - self._looked < APART:
            return ""
        now = self._read(self._pid)
        if now is None:
            return ""
        self._looked = at
        if step != self._step:
            self._step, self._begin = step, now.cpu
            self._sleeps, self._looks = -1, 0
        still = now.state == "S" and now.sleeps == self._sleeps
        self._sleeps, self._looks = now.sleeps, self._looks + 1 if still else 0
        if self._looks >= ASLEEP:
            return f"hangs: it is asleep, and has not woken up in {ASLEEP + 1} looks"
        if now.cpu - self._begin >= WORKING:
            return f"hangs: it has worked for {now.cpu - self._begin:.1f} s of processor time on one answer"
        return ""


def life(pid: int) -> Life | None:
    """What Linux tells of a process; None elsewhere, or if it is gone."""
    try:
        told = Path(f"/proc/{pid}/status").read_text(encoding="utf-8", errors="replace")
        times = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
        fields = dict(line.split(":", 1) for line in told.splitlines() if ":" in line)
        return Life(
            fields["State"].split()[0],
            int(fields["voluntary_ctxt_switches"]),
            (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK"),
        )
    except (OSError, LookupError, ValueError):
        return None
