"""What keeps a run in real time from being late: nothing is collected, and the system is asked to put it first.

A busy machine that lets harness or car wait for more than 100 ms makes the guard stop the car, as it must: the
drive then fails by its own braking. Where the system allows it (root, or `ulimit -r`), the threads of this process and
of those that it has started are scheduled in real time instead; else they wait with all others.
"""

from __future__ import annotations

import contextlib
import gc
import os
from collections.abc import Iterator
from pathlib import Path

PRIORITY = 1  # the least of the real-time ones: before ordinary processes, behind everything else


@contextlib.contextmanager
def punctual() -> Iterator[bool]:
    """For as long as it lasts; whether the system schedules this process in real time."""
    gc.collect()
    gc.freeze()
    gc.disable()
    everyone = [os.getpid(), *_started_by(os.getpid())]
    granted = _schedule([thread for process in everyone for thread in _threads(process)], first=True)
    try:
        yield granted
    finally:
        # A process of a stack goes on to the next run, which may not be in real time.
        _schedule([thread for process in everyone for thread in _threads(process)], first=False)
        gc.enable()
        gc.unfreeze()


def _schedule(threads: list[int], *, first: bool) -> bool:
    """True if all of them are; one that has ended meanwhile does not matter. Only Linux can."""
    if not threads or not hasattr(os, "sched_setscheduler"):
        return False
    policy, parameter = (os.SCHED_RR, os.sched_param(PRIORITY)) if first else (os.SCHED_OTHER, os.sched_param(0))
    for thread in threads:
        try:
            os.sched_setscheduler(thread, policy, parameter)
        except ProcessLookupError:
            continue
        except OSError:  # not permitted
            return False
    return True


def _threads(process: int) -> list[int]:
    try:
        return sorted(int(task.name) for task in Path(f"/proc/{process}/task").iterdir())
    except OSError:
        return []


def _started_by(process: int) -> list[int]:
    """Processes that a process has started, and those that they have."""
    parents: dict[int, list[int]] = {}
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            said = status.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue  # it has ended
        parent = next((int(line.split()[1]) for line in said.splitlines() if line.startswith("PPid:")), 0)
        parents.setdefault(parent, []).append(int(status.parent.name))
    found: list[int] = []
    left = [process]
    while left:
        children = parents.get(left.pop(), [])
        found += children
        left += children
    return found
