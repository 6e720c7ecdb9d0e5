"""CPU time of a call: what the rows of every benchmark are made of."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One line of the table. `ours` and `peer` in `unit`; `goal` as text; more is better unless the unit is a time."""

    name: str
    ours: float
    unit: str
    goal: str = ""
    peer_name: str = ""
    peer: float | None = None
    note: str = ""


def cpu_seconds(call: Callable[[], object], *, repeats: int = 5, at_least: float = 0.05) -> float:
    """Median CPU time [s] of one `call`, warm: called once before, then in batches of at least `at_least` seconds.

    CPU time, not wall time: the machines that run this are shared and noisy.
    """
    call()
    batch = 1
    while True:
        begin = time.process_time()
        for _ in range(batch):
            call()
        spent = time.process_time() - begin
        if spent >= at_least:
            break
        batch *= 2 if spent <= 0 else max(2, int(at_least / spent) + 1)
    samples = [spent / batch]
    for _ in range(repeats - 1):
        begin = time.process_time()
        for _ in range(batch):
            call()
        samples.append((time.process_time() - begin) / batch)
    return statistics.median(samples)
