"""Stretches where the measured heading says another thing than the measured yaw rate: one of the two is wrong there."""

from __future__ import annotations

import numpy as np

from pytest_dvp.gap.compare.start_correction import BoolArray, IntArray
from pytest_dvp.logs.log_contents import FloatArray

_GROSS = 0.25  # rad within a segment of about 5 s: more than any bias of a gyroscope adds up to,
_UNLIKE = 10.0  # and this many times what the log's segments usually show
_LATE = np.arange(-0.5, 0.51, 0.05)  # s by which the yaw rate may be late against the heading
_FEWEST = 5  # rows, or segments


def heading_faults(
    t: FloatArray, yaw: FloatArray, rate: FloatArray, starts: IntArray, ends: IntArray, counted: BoolArray
) -> BoolArray:
    """Which segments (m,) have a heading that their yaw rate contradicts.

    t [s], yaw (without turns of 2 pi) [rad] and rate [rad/s] (n,), NaN = not measured; starts, ends (m,) rows;
    counted (n,): rows that are looked at. A heading that aligns itself while a car sets off turns by a radian that
    nothing else saw, and one such segment outweighs a whole log. A late yaw rate, a bias and a wrong scale are no
    faults of this kind: every segment has them.
    """
    faulty: BoolArray = np.zeros(len(starts), dtype=np.bool_)
    known = np.isfinite(rate)
    if known.sum() < _FEWEST or len(starts) < _FEWEST:
        return faulty
    whole = np.interp(t, t[known], rate[known])
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (whole[1:] + whole[:-1]) * np.diff(t))])
    seen = counted & np.isfinite(yaw)
    best, least = faulty, np.inf
    for late in _LATE:
        apart = yaw - np.interp(t + late, t, turned)
        pieces = [apart[a:b][seen[a:b]] for a, b in zip(starts, ends, strict=True)]
        spread = np.array([np.ptp(piece) if len(piece) >= _FEWEST else np.nan for piece in pieces])
        if np.isfinite(spread).sum() < _FEWEST:
            return faulty
        usual = float(np.nanmedian(spread))
        if usual < least:
            least = usual
            best = np.asarray(np.nan_to_num(spread) > max(_GROSS, _UNLIKE * usual))
    return best
