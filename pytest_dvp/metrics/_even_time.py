"""A column on an even time base, and the cut-off of the filter behind which it is differentiated."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Range

CUTOFF = 1.0  # Hz; averages over about the 0.5 s over which UN R79 takes the mean of jerk (-3 dB at 0.89 Hz)

Cutoff: TypeAlias = Annotated[float, Range(0.1)]  # Hz, chosen: less leaves nothing of what takes seconds


def uniform(log: Log, name: str) -> tuple[FloatArray, FloatArray]:
    """Times and values of a column on an even time base; resampled linearly if that of the log is uneven.

    Raises Undefined if it was not measured throughout, which a hole in the time base says as well, or the time does not
    increase.

    Both (n,); times in [s], values in the unit of the column.
    """
    t, values = log.t, log[name]
    if not np.isfinite(values).all() or not np.isfinite(t).all():
        raise Undefined(f"{name} was not measured throughout")
    steps = np.diff(t)
    if len(t) < 4 or steps.min() <= 0.0:
        raise Undefined("too few samples" if len(t) < 4 else "the time of the log does not increase")
    step = float(t[-1] - t[0]) / (len(t) - 1)
    if np.abs(steps - step).max() <= 1e-3 * step:
        return t, values
    from pytest_dvp.gap.compare.segments import longest_step

    hole = int(np.argmax(steps))
    if steps[hole] > longest_step(t):  # a line through it would tell a calm drive
        raise Undefined(f"{name} was not measured throughout: a hole of {steps[hole]:.1f} s from t={t[hole]:.2f} s on")
    even = np.linspace(t[0], t[-1], max(4, round(float(t[-1] - t[0]) / float(np.median(steps))) + 1))
    return even, np.interp(even, t, values)
