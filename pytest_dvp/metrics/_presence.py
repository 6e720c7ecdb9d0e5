"""How long a sample stands for, of a road user or of the log, and whether samples stand for enough of a drive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined

GAP = 3.0  # steps; a longer one is a time in which nothing was there or recorded; chosen: two lost samples are none

LEAST = 0.5  # share of a drive for which a signal must have been measured; chosen: less tells nothing of the drive


def check_share(t: FloatArray, known: NDArray[np.bool_], name: str) -> None:
    """Raises Undefined if the samples `known` (n,) of a signal stand for less than LEAST of the drive, t (n,) [s]."""
    from pytest_dvp.gap.compare.segments import stands_for

    share = float(stands_for(t, known).mean())
    if share < LEAST:
        whole = float(t[-1] - t[0])
        raise Undefined(f"{name} was measured for {share * whole:.1f} s of {whole:.1f} s only")


def steps(t: FloatArray) -> FloatArray:
    """Time [s] until the next sample, (n,), of samples at `t` (n,) [s]; the last one stands for none, and one before a
    longer gap, in which the road user was not there or nothing was recorded, for the usual step."""
    step = np.diff(t, append=t[-1])
    if len(t) < 3:
        return np.asarray(step)
    usual = float(np.median(np.diff(t)))
    return np.where(step > GAP * usual, usual, step)


def exposed(t: FloatArray, rows: NDArray[np.bool_], step: float) -> float:
    """Time [s] of the `rows` (n,) of samples at `t` (n,) [s], by `steps`; of some rows at least one usual step.

    A moment in the last sample, as before a contact that ends the run, has no step of its own but is one all the same.
    step: the usual one [s] where `t` is a single sample.
    """
    if not rows.any():
        return 0.0
    usual = float(np.median(np.diff(t))) if len(t) > 1 else step
    return max(float(steps(t)[rows].sum()), usual)
