"""A signal that several fields make: the mean of two wheels, the norm of a velocity, the rate of a position."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

WAYS = ("mean of", "norm of", "rate of")
"""How fields are combined, written before their unit in a mapping: `field = "vE + vN"`, `unit = "norm of m/s"`."""

MARK = " + "  # between the fields
_HALF = 0.1  # s on both sides, over which a rate is taken: two samples of a slow receiver, short against a manoeuvre


def way_of(unit: str) -> tuple[str, str]:
    """How a mapping's unit combines fields, and their own unit: "norm of m/s" is "norm of" and "m/s"; else "" first."""
    for way in WAYS:
        if unit.startswith(way + " "):
            return way, unit[len(way) :].strip()
    return "", unit


def combined(way: str, t: FloatArray, fields: list[FloatArray]) -> FloatArray:
    """One column (n,) of fields (n,) at times t (n,) [s], in their unit; "rate of": in their unit a second.

    A rate is the length of the difference over 0.2 s, or over four samples if these are longer, and of one field the
    difference with its sign; NaN at both ends.
    """
    if way == "mean of":
        return np.asarray(np.mean(fields, axis=0))
    if way == "norm of":
        return np.asarray(np.sqrt(np.sum(np.square(fields), axis=0)))
    seen = np.isfinite(t) & np.all(np.isfinite(fields), axis=0)
    at = t[seen]
    found = np.full(len(t), np.nan)
    if len(at) < 5:
        return found
    half = max(_HALF, 2.0 * float(np.median(np.diff(at))))
    inside = seen & (t >= at[0] + half) & (t <= at[-1] - half)
    here = t[inside]
    steps = [np.interp(here + half, at, f[seen]) - np.interp(here - half, at, f[seen]) for f in fields]
    found[inside] = (steps[0] if len(steps) == 1 else np.sqrt(np.sum(np.square(steps), axis=0))) / (2.0 * half)
    return found


def yaw_of_quaternion(x: FloatArray, y: FloatArray, z: FloatArray, w: FloatArray) -> FloatArray:
    """Yaw (n,) [rad] of quaternions (n,) of any length; NaN for one of length 0, which states no orientation."""
    yaw = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return np.where(x * x + y * y + z * z + w * w > 0.0, yaw, np.nan)
