"""Commands that only repeat the one before."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, NotNegative, metric
from vehicle.messages import TICK

SLOW = 0.5  # m/s; an ego that stands may well be told the same again


@metric(name="repeated_commands", unit="-", bigger_is_worse=True, open_loop=True, note="ego faster than {slow} m/s")
def repeated_commands(log: Log, *, signal: str = "steer_cmd", slow: NotNegative = SLOW) -> Measured:
    """Share of the ticks of an ego faster than `slow` [m/s] at which `signal` is exactly what it was a tick before.

    A control loop on noisy sensors hardly ever computes the same number twice: stale, frozen and coarsely rounded
    commands do. t: the first repetition; the longest row of repetitions [s] is in `extra`. Source: repeated-value
    (stuck) check of signal validation, e.g. ISO 26262-5:2018, D.2.10. Undefined if the ego was never so fast, or
    `signal` was not recorded.
    """
    if signal not in log.columns:
        raise Undefined(f"{signal} was not recorded")
    ticks = np.searchsorted(log.t, np.arange(log.t[0], log.t[-1] + 1e-6, TICK) + 1e-6, side="right") - 1
    values, moving = log[signal][ticks], np.abs(log["v"][ticks]) > slow
    fresh = np.isfinite(values[1:]) & np.isfinite(values[:-1]) & moving[1:]
    if not fresh.any():
        raise Undefined(f"the ego was never faster than {slow:g} m/s under a command")
    same = fresh & (values[1:] == values[:-1])
    longest = run = 0
    for repeated in same:
        run = run + 1 if repeated else 0
        longest = max(longest, run)
    first = int(np.argmax(same))
    return Measured(
        float(same.sum() / fresh.sum()), float(log.t[ticks[first + 1]]) if same.any() else None,
        extra={"longest": longest * TICK},
    )  # fmt: skip
