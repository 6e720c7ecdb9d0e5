"""How long a sample of a road user stands for."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

GAP = 3.0  # steps; a longer one is a time in which the road user was not there; chosen: two lost samples are none


def steps(t: FloatArray) -> FloatArray:
    """Time [s] until the next sample, (n,), of samples at `t` (n,) [s]; the last one stands for none, and one before a
    longer gap, in which the road user was not there, for the usual step."""
    step = np.diff(t, append=t[-1])
    if len(t) < 3:
        return np.asarray(step)
    usual = float(np.median(np.diff(t)))
    return np.where(step > GAP * usual, usual, step)
