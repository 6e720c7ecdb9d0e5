"""How much the slope of the road differs along a drive, as the car's own accelerometer tells it.

An accelerometer shows what pushes the car, and gravity is none of that: on a slope the speed changes and the
accelerometer says nothing. So what it has summed up over some seconds, less the change of the speed, is the slope, and
no model of the car is needed for it. Pitch, roll and late sensors leave something there as well, in proportion to the
motion and to its changes, and are taken out.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS, filled
from pytest_dvp.logs.log_contents import FloatArray

WINDOW = 2.5  # s over which a slope is taken, half a segment: as far as the knots of `start_correction` are apart
LEAST = 0.04  # m/s^2
"""Spread from which it is taken for the road's, 0.4 % of slope; chosen: of eight drives of three simulated cars on a
flat road seven show 0.01 to 0.04, one of a pickup 0.06."""
LEAST_TOLD = 0.02  # m/s^2, the same where a model is known, which knows pitch and slip; chosen
LATEST = 0.3  # s
"""By which an acceleration may come late and still be that of an accelerometer; chosen: those of a race car and of a
road car on their tracks come 2.4 and 1.0 s late, through a filter."""
_SURE = 2.0  # standard deviations by which it has to be later; chosen
_LATE = 2  # the change of the acceleration, among what is taken out
SLOWEST = 0.5  # m/s: at a standstill brakes hold the car, and nothing tells a slope
_MEAN = 0.2  # s over which speed and acceleration at the ends of a window are taken
_FEWEST = 10  # windows more than what is taken out of them; chosen
_SAME_GROUND = 0.75  # of the squares of what differs: where one plane or one hill explains that much, an effect of the
# catalogue does, and it is to be named; chosen: of 25 windows on hills of many lengths, one hill explains up to 0.7
_PLACES, _LENGTHS = 15, (10.0, 20.0, 40.0, 80.0)  # across the drive, and m: of the hills that are tried


def slope_spread(t: FloatArray, measured: FloatArray) -> float:
    """Standard deviation [m/s^2] of gravity along the road over a drive; 0 where the log does not tell, where it is
    less than LEAST, or where one plane or one hill explains three quarters of its square. t (n,) [s], measured (n, 8)
    in channel units."""
    there = np.isfinite(measured)
    v_known, ax_known = there[:, CHANNELS.index("v")], there[:, CHANNELS.index("ax")]
    if min(v_known.sum(), ax_known.sum()) < 2 or t[-1] - t[0] < WINDOW:
        return 0.0
    x, y, yaw, v, rate, ax, ay, _ = filled(t, measured).T
    pushed = np.concatenate([[0.0], np.cumsum(0.5 * (ax[1:] + ax[:-1]) * np.diff(t))])
    ends = np.arange(t[0] + _MEAN, t[-1] - _MEAN, WINDOW)
    at = {name: np.array([_about(t, one, end) for end in ends]) for name, one in
          {"pushed": pushed, "v": v, "ax": ax, "rate": rate, "x": x, "y": y}.items()}  # fmt: skip
    rows = [slice(*np.searchsorted(t, pair)) for pair in itertools.pairwise(ends)]
    moving = np.array([row.stop > row.start and float(np.abs(v[row]).min()) > SLOWEST for row in rows], dtype=bool)

    def change(one: FloatArray) -> FloatArray:
        return np.asarray(np.diff(one) / WINDOW)

    def mean(one: FloatArray) -> FloatArray:
        return np.array([one[row].mean() if row.stop > row.start else 0.0 for row in rows])

    slope = change(at["pushed"]) - change(at["v"])
    others = [np.ones(len(rows)), change(at["v"]), change(at["ax"]), mean(rate**2), mean(ay), change(at["rate"]),
              change(at["v"] * at["ax"]), change(np.abs(at["rate"]) * at["v"])]  # fmt: skip
    if moving.sum() < len(others) + _FEWEST:
        return 0.0
    known = np.column_stack(others)[moving]
    fitted = np.linalg.lstsq(known, slope[moving], rcond=None)[0]
    rest = slope[moving] - known @ fitted
    found = float(np.sqrt(rest @ rest / (len(rest) - known.shape[1])))
    unsure = found * float(np.sqrt(np.linalg.pinv(known.T @ known)[_LATE, _LATE]))
    if abs(fitted[_LATE]) > LATEST + _SURE * unsure:
        return 0.0
    c, s = mean(np.cos(yaw))[moving], mean(np.sin(yaw))[moving]
    if found < LEAST or not _differs(known, rest, [(c, s)]):
        return 0.0
    return found if _differs(known, rest, _hills(mean(x)[moving], mean(y)[moving], c, s)) else 0.0


def told_spread(drives: Iterable[tuple[FloatArray, FloatArray, FloatArray]]) -> float:
    """Standard deviation [m/s^2] of gravity along the road over drives that a model is known for; 0 where it is less
    than LEAST_TOLD. Of each drive, for its segments (m,): length [s], by how much the car speeds up more than the model
    [m/s^2], and how much more its accelerometer shows [m/s^2].

    A force that the model lacks shows in both, so what the two differ by is the slope; and where the accelerometer
    errs, the first does not follow. So the slope's square is the mean product of the first and that difference.
    """
    square = length = 0.0
    for lasts, faster, shown in drives:
        weights = lasts / lasts.sum() if len(lasts) else lasts
        faster, shown = faster - weights @ faster, shown - weights @ shown
        square += float(lasts @ (faster * (faster - shown)))
        length += float(lasts.sum())
    found = float(np.sqrt(max(square, 0.0) / length)) if length else 0.0
    return found if found >= LEAST_TOLD else 0.0


def _about(t: FloatArray, one: FloatArray, at: float) -> float:
    near = slice(*np.searchsorted(t, (at - 0.5 * _MEAN, at + 0.5 * _MEAN)))
    return float(one[near].mean()) if near.stop > near.start else float(np.interp(at, t, one))


def _beside(known: FloatArray, values: FloatArray) -> FloatArray:
    """What no sum of the columns of known (n, m) makes of values (n,)."""
    return np.asarray(values - known @ np.linalg.lstsq(known, values, rcond=None)[0])


def _differs(known: FloatArray, rest: FloatArray, grounds: list[tuple[FloatArray, ...]]) -> bool:
    """True if no ground, each as columns (n,), explains _SAME_GROUND of the rest (n,)."""
    squares = [float(np.sum(_beside(np.column_stack([known, *ground]), rest) ** 2)) for ground in grounds]
    return min(squares) > (1.0 - _SAME_GROUND) * float(rest @ rest)


def _hills(x: FloatArray, y: FloatArray, c: FloatArray, s: FloatArray) -> list[tuple[FloatArray, ...]]:
    """How much each of some hills rises along the way at windows (n,): x, y [m] their middle, c, s of their heading."""
    found: list[tuple[FloatArray, ...]] = []
    for x0 in np.linspace(x.min(), x.max(), _PLACES):
        for y0 in np.linspace(y.min(), y.max(), _PLACES):
            for length in _LENGTHS:
                dx, dy = (x - x0) / length, (y - y0) / length
                found.append((np.exp(-0.5 * (dx * dx + dy * dy)) * (dx * c + dy * s),))
    return found
