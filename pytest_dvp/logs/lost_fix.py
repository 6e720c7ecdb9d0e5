"""Where the reference system of a log says itself that it did not know the place well: satellites lost, no RTK fix."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.held_values import held
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

SIGMA = "position_sigma"
AFFECTED = ("x", "y", "yaw", "v")
"""Columns that come out of one filter with the position, and drift with it."""
WORSE = 2.0  # times the best of a drive: then the error has outgrown what a start of a segment takes out; chosen
FIXED = 0.02  # m, 1 sigma: an RTK fix while driving, as makers of receivers print it (0.01 m + 1 ppm); never too bad
NO_FIX = 0.1  # m: better than what receivers state without fixed ambiguities (float: some decimetres)
TOO_MUCH = 1.0 / 3.0  # of a drive; what is left then is no longer the drive that was to be compared; chosen
_BEST = 0.1  # share of the rows from which the best state of a drive is taken


def lost_fix(columns: Mapping[str, FloatArray]) -> NDArray[np.bool_]:
    """Rows (n,) at which the stated deviation of the position is more than WORSE times the drive's best and than FIXED.

    `columns` with `t` [s] and, where the log has it, `position_sigma` [m]; none without. One that is stated seldom
    holds until the next. What counts is the drive's own best: a receiver that is poor from the beginning to the end is
    `no_evidence_of_place`'s to tell.
    """
    sigma = columns.get(SIGMA)
    if sigma is None or not np.isfinite(sigma).any():
        return np.zeros(len(columns["t"]), dtype=np.bool_)
    limit = max(WORSE * float(np.nanquantile(sigma, _BEST)), FIXED)
    return np.asarray(np.nan_to_num(held(sigma), nan=0.0) > limit)


def with_fix(columns: Mapping[str, FloatArray], name: str) -> FloatArray:
    """A column (n,) in its unit, NaN where it is of AFFECTED and the fix was lost."""
    values = columns[name]
    if name not in AFFECTED or SIGMA not in columns:
        return values
    return np.where(lost_fix(columns), np.nan, values)


def lost_for(log: Log) -> float:
    """How long [s] the fix was lost in a log; 0 where nothing is stated."""
    lost = lost_fix(log.columns)
    return float(np.sum(np.diff(log.t)[lost[:-1]])) if len(lost) > 1 else 0.0


def no_evidence_of_place(log: Log) -> str:
    """Why a drive is no evidence about a twin, as its reference system did not know where it was; "" if it is."""
    sigma = log.columns.get(SIGMA)
    if sigma is None or not np.isfinite(sigma).any():
        return ""
    best, lost = float(np.nanquantile(sigma, _BEST)), lost_for(log)
    if best > NO_FIX:
        return f"its reference system states no position better than {best:.2g} m ({SIGMA}): it had no fix"
    if lost > TOO_MUCH * log.duration:
        return f"its reference system had no fix for {lost:.1f} s of {log.duration:.1f} s"
    return ""
