"""Whether a log tells where the car was all the time: what is played to a stack must have been measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytest_dvp.doctor.missing_values import LONGEST
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError

NEEDED = ("x", "y", "yaw", "v")


def check_motion(name: str, t: FloatArray, columns: Mapping[str, FloatArray]) -> None:
    """Raises LogError if one of NEEDED is missing in `columns` (n,), holds no value, or has a hole.

    A hole is longer than LONGEST and than three of the column's usual intervals; also one at the begin or the end.
    name  of the log, for the error; its times `t` [s] (n,) are named as they are
    """
    needs = f"{name}: a recording needs x, y, yaw and v"
    for column in NEEDED:
        if column not in columns:
            raise LogError(f"{needs}; it has no {column}", "log.no_motion")
        known = np.flatnonzero(np.isfinite(columns[column]))
        if not len(known):
            raise LogError(f"{needs}; its {column} holds no value", "log.no_motion")
        allowed = max(LONGEST, 3.0 * float(np.median(np.diff(t[known])))) if len(known) > 1 else LONGEST
        ends = np.concatenate([t[:1], t[known], t[-1:]])
        lasts = np.diff(ends)
        longest = int(np.argmax(lasts))
        if lasts[longest] > allowed + 1e-9:
            raise LogError(
                f"{needs}; its {column} holds no value from t = {ends[longest]:.6g} to {ends[longest + 1]:.6g} s, "
                f"allowed: holes up to {allowed:.2g} s; a log can be cut: LOG@FROM:TO",
                "log.no_motion",
            )
