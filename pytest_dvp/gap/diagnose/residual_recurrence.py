"""Whether an error comes back: at a place, in a direction of travel, at a speed, later in a run."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.gap.compare.regimes import speed_bins
from pytest_dvp.gap.compare.smoothed_motion import Motion, mean_around
from pytest_dvp.logs.log_contents import FloatArray

_CELLS = 32  # along the longer side of the map
_SECTORS = 8  # of heading, 45 degrees each: two directions of the same road are two places
_APART = 20.0  # s between two visits that count as two
_SMOOTH = 0.25  # s on either side
_LEAST = 6  # visits, below which nothing is said


def at_same_place(errors: Sequence[FloatArray], motions: Sequence[Motion]) -> float | None:
    """Share of the smoothed error that repeats whenever the car comes back to a place; None if it hardly comes back.

    errors: of each log (n,), all in one unit. Negative: the mean of the other visits predicts worse than zero does.
    """
    x, y = (np.concatenate([getattr(m, name) for m in motions]) for name in ("x", "y"))
    side = max(float(np.ptp(x)), float(np.ptp(y)), 1e-6) / _CELLS
    cells = np.floor(np.column_stack([x, y]) / side)
    return _comes_back(errors, motions, np.unique(cells, axis=0, return_inverse=True)[1].reshape(-1))


def in_same_direction(errors: Sequence[FloatArray], motions: Sequence[Motion]) -> float | None:
    """Share of the smoothed error that repeats in each of eight travel directions; None if the car hardly comes back.

    errors: of each log (n,), all in one unit. Negative: the mean of the other visits predicts worse than zero does.
    """
    yaw = np.concatenate([m.yaw for m in motions])
    return _comes_back(errors, motions, np.floor((yaw % (2.0 * np.pi)) * _SECTORS / (2.0 * np.pi)).astype(np.int64))


def _comes_back(errors: Sequence[FloatArray], motions: Sequence[Motion], cell: NDArray[Any]) -> float | None:
    """Each visit of a cell predicted by the mean of all other visits of it."""
    visits = []
    start = 0
    for log, (error, m) in enumerate(zip(errors, motions, strict=True)):
        smooth = mean_around(error, max(1, round(_SMOOTH / m.step)))
        own = cell[start : start + len(m.t)]
        start += len(m.t)
        cuts = [0, *(np.flatnonzero(np.diff(own)) + 1).tolist(), len(own)]
        for first, end in itertools.pairwise(cuts):
            if m.moving[first:end].any() and end - first > 3:
                visits.append((own[first], log * 1e6 + m.t[first], end - first, float(smooth[first:end].mean())))
    left = total = 0.0
    pairs = 0
    for k, when, rows, value in visits:
        others = [(n, w) for c, t, n, w in visits if c == k and abs(t - when) > _APART]
        if others:
            mean = sum(n * w for n, w in others) / sum(n for n, _ in others)
            total += rows * value * value
            left += rows * (value - mean) ** 2
            pairs += 1
    return float(1.0 - left / total) if total > 0.0 and pairs >= _LEAST else None


def at_speed(errors: Sequence[FloatArray], motions: Sequence[Motion]) -> dict[str, Any]:
    """The speed bin that holds most error for its time, with its shares of the squared error and of the moving time.

    errors: of each log (n,), all in one unit.
    """
    error, v = np.concatenate(list(errors)) ** 2, np.concatenate([m.v for m in motions])
    moving = np.concatenate([m.moving for m in motions])
    total, samples = max(float(error[moving].sum()), 1e-30), max(int(moving.sum()), 1)
    found = [(float(error[mask & moving].sum()) / total, float((mask & moving).sum()) / samples, name)
             for name, mask in speed_bins(v).items()]  # fmt: skip
    share, time, name = max(found, key=lambda f: f[0] - f[1])
    return {"bin": name, "share_of_error": share, "share_of_time": time}


def over_time(excess: Sequence[FloatArray]) -> dict[str, float]:
    """Rank correlation (-1..1) of the error of segments with their time, and the share of it in the second half.

    excess: of each log, mean square error beyond the noise of each of its segments (m,), in order and in one unit.
    """
    whole = [(own, float(own.sum())) for own in excess if len(own) > 3 and own.any()]
    if not whole:
        return {"rank_correlation": 0.0, "share_in_second_half": 0.5}
    found = [float(np.corrcoef(np.arange(len(own)), _ranks(own))[0, 1]) for own, _ in whole]
    late = sum(float(own[len(own) // 2 :].sum()) for own, _ in whole)
    return {"rank_correlation": float(np.average(found, weights=[w for _, w in whole])),
            "share_in_second_half": late / sum(w for _, w in whole)}  # fmt: skip


def _ranks(y: FloatArray) -> NDArray[Any]:
    return np.argsort(np.argsort(y, kind="stable"), kind="stable")
