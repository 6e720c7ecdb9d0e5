"""A speed that reads 0 while the car still rolls: wheels that turn too slowly for their sensors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.unmeasured import unmeasured

LEAST = 0.25  # m/s, below which a dead band is lost in the noise of a speed; chosen
SUDDEN = 2.5  # times the step to the next sample that a speed jumps from 0 at least; chosen
EDGES = 3  # beginnings and ends of standstills that all must say so; chosen
GENTLE = 0.4  # m/s^2: slower than cars usually come to rest or set off; chosen


class DeadBand(NamedTuple):
    """speed [m/s] below which the sensor shows 0; rows (n,) in which the car may have rolled though it shows 0."""

    speed: float
    rows: NDArray[np.bool_]


def dead_band(log: Log) -> DeadBand | None:
    """What `v` does not show, None if it shows all: if it jumps from 0 and to 0, and takes no value between.

    Rolling in the band lasts for speed/GENTLE at most; what lies farther within a stretch of zeros is a standstill.
    Needs v that is exactly 0 there, and EDGES beginnings and ends of such stretches.
    """
    v = log.columns.get("v")
    if v is None:
        return None
    known = np.flatnonzero(np.isfinite(v))
    t, speed = log.t[known], np.abs(v[known])
    zero = speed == 0.0
    if not zero.any() or zero.all():
        return None
    starts = np.flatnonzero(np.diff(zero.astype(np.int8)) == 1)  # the last row that rolls
    ends = np.flatnonzero(np.diff(zero.astype(np.int8)) == -1) + 1  # the first row that rolls again
    jumps = [(speed[k], abs(speed[k] - speed[k - 1])) for k in starts if k > 0 and not zero[k - 1]]
    jumps += [(speed[k], abs(speed[k + 1] - speed[k])) for k in ends if k + 1 < len(speed) and not zero[k + 1]]
    least = float(speed[~zero].min())
    if len(jumps) < EDGES or least < LEAST or not all(size > SUDDEN * step for size, step in jumps):
        return None
    lasts = least / GENTLE
    near = np.zeros(len(t), dtype=np.bool_)
    for k in starts:
        near |= (t > t[k]) & (t <= t[k] + lasts)
    for k in ends:
        near |= (t < t[k]) & (t >= t[k] - lasts)
    rows = np.zeros(len(v), dtype=np.bool_)
    rows[known] = near & zero
    return DeadBand(least, rows)


def without_dead_speed(log: Log) -> Log:
    """The log with such a speed as not measured (NaN) where the car may have rolled; the log itself if it shows all."""
    found = dead_band(log)
    return log if found is None else unmeasured(log, {"v": found.rows})


def check_dead_speed(log: Log, file: str, findings: Findings) -> None:
    """A warning for a speed with a dead band."""
    found = dead_band(log)
    if found is None:
        return
    findings.add(
        "log.dead_speed", file, None, "column v",
        f"v is 0 or at least {found.speed:.3g} m/s and nothing between: wheels that turn slowly are not seen",
        hint=f"v counts as not measured in the first and last {found.speed / GENTLE:.2g} s of each stretch of zeros",
        severity="warning",
    )  # fmt: skip
