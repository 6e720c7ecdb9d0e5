"""Values that hold until the next one."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray


def held(column: FloatArray) -> FloatArray:
    """Each value of a column (n,) until the next one, in its unit; NaN before the first."""
    known = np.isfinite(column)
    last = np.maximum.accumulate(np.where(known, np.arange(len(column)), -1))
    return np.where(last >= 0, column[np.maximum(last, 0)], np.nan)
