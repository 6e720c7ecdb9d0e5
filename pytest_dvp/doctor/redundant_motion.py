"""The motion of a log as several witnesses tell it, on one even grid, so that they can be held against each other.

Means over a window of a rate and differences of its integral over the same window are the same thing, whatever the
stamps: d(yaw)/W against mean(yaw_rate) needs no differentiation, so noise and uneven stamps do no harm.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

WINDOW = 0.4  # [s] of means and differences: long against the noise of a position, short against a manoeuvre
COURSE_WINDOW = 0.8  # [s]: the direction of the path is noisier
FARTHEST = 40.0  # [s]: GPS time is 18 s ahead of UTC since 2017, TAI 37 s (IERS Bulletin C)
ALIKE = 0.9  # correlation below which two witnesses of one thing do not fit, and above which they do; chosen
TURN = 2.0 * math.pi + 0.1  # rad, beyond which a heading is not wrapped to one turn
_PART = 0.4  # of a log, the farthest that is looked: most of it still lies one upon the other
_GRID = 0.02  # [s] finest grid
_THIN = 0.1  # [s] between the rows that scales and signs are judged by
_MOST = 20_000  # of them
_LONGEST = 200_000  # grid points; longer logs get a coarser grid


@dataclasses.dataclass(frozen=True)
class Motion:
    """Witnesses on the grid `t` [s]; NaN where unknown, absent where the log lacks the column.

    path_speed [m/s] and path_turn [rad/s] come from x, y; turn [rad/s] from yaw; accel [m/s^2] from v; mean of each
    other column under its own name. `moving` is where directions mean something.
    """

    t: FloatArray
    step: float
    of: dict[str, FloatArray]
    course: FloatArray
    heading: FloatArray
    moving: NDArray[np.bool_]

    def has(self, *names: str) -> bool:
        """Whether each of the names is a column of `of`."""
        return all(name in self.of for name in names)


def part_of(motion: Motion, begin: int, end: int) -> Motion:
    """The rows begin..end of a motion."""
    rows = slice(begin, end)
    return Motion(
        motion.t[rows], motion.step, {name: values[rows] for name, values in motion.of.items()}, motion.course[rows],
        motion.heading[rows], motion.moving[rows],
    )  # fmt: skip


def rows_between(motion: Motion) -> int:
    """Every how many rows of the grid there is something new to tell: means over WINDOW are that slow."""
    return max(1, round(_THIN / motion.step), math.ceil(len(motion.t) / _MOST))


def motion_of(log: Log) -> Motion | None:
    """None for a log shorter than a few windows."""
    t = log.t
    if len(t) < 8 or not t[-1] - t[0] > 4 * COURSE_WINDOW or np.any(np.diff(t) <= 0):
        return None
    median = float(np.median(np.diff(t)))
    step = max(_GRID, median, (t[-1] - t[0]) / _LONGEST)
    window = max(WINDOW, 4.0 * median)
    course_window = max(COURSE_WINDOW, 8.0 * median)
    margin = 0.5 * course_window
    grid = np.arange(t[0] + margin, t[-1] - margin, step)
    if len(grid) < 20:
        return None
    low, high = grid - 0.5 * window, grid + 0.5 * window
    of: dict[str, FloatArray] = {}
    for name in ("v", "yaw_rate", "ax", "ay", "steer", "steer_cmd", "accel_cmd", "speed_cmd", "vx"):
        mean = _mean(log, name, low, high)
        if mean is not None:
            of[name] = mean
    yaw = _known(log, "yaw")
    heading = np.full(len(grid), np.nan)
    if yaw is not None:
        at, values = yaw
        unwrapped = np.unwrap(values)
        heading = np.interp(grid, at, unwrapped)
        of["turn"] = (np.interp(high, at, unwrapped) - np.interp(low, at, unwrapped)) / window
        # Degrees taken for radians jump by 360: their steps are those of the values. What stays within a turn are
        # radians that wrap, often where a car goes west.
        steps = unwrapped if np.abs(values).max() < TURN else values
        of["yaw_step"] = (np.interp(high, at, steps) - np.interp(low, at, steps)) / window
    speed = _known(log, "v")
    if speed is not None:
        of["accel"] = (np.interp(high, *speed) - np.interp(low, *speed)) / window
    course = np.full(len(grid), np.nan)
    x, y = _known(log, "x"), _known(log, "y")
    if x is not None and y is not None:
        east, north = np.interp(high, *x) - np.interp(low, *x), np.interp(high, *y) - np.interp(low, *y)
        course = np.arctan2(north, east)
        of["path_speed"] = np.hypot(east, north) / window
        of["path_turn"] = _path_turn(grid, x, y, course_window)
    reference = of.get("path_speed", of.get("v"))
    moving = np.zeros(len(grid), bool)
    if reference is not None and np.isfinite(reference).any():
        moving = np.abs(reference) > max(0.2, 0.3 * float(np.nanpercentile(np.abs(reference), 80)))
    if "path_turn" in of:
        of["path_turn"] = np.where(moving, of["path_turn"], np.nan)  # a standing car's path has no direction
    return Motion(grid, step, of, course, heading, moving)


def _known(log: Log, name: str) -> tuple[FloatArray, FloatArray] | None:
    """Stamps and values of a column where it was measured; None if it was hardly."""
    values = log.columns.get(name)
    if values is None:
        return None
    seen = np.isfinite(values)
    count = int(np.count_nonzero(seen))
    if count < 8:
        return None
    return (log.t, values) if count == len(values) else (log.t[seen], values[seen])


def _mean(log: Log, name: str, low: FloatArray, high: FloatArray) -> FloatArray | None:
    known = _known(log, name)
    if known is None:
        return None
    t, values = known
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))])
    return np.asarray((np.interp(high, t, integral) - np.interp(low, t, integral)) / (high - low))


def _path_turn(
    grid: FloatArray, x: tuple[FloatArray, FloatArray], y: tuple[FloatArray, FloatArray], window: float
) -> FloatArray:
    """Turn rate of the path [rad/s]: angle between its halves before and after each point."""
    half = 0.5 * window
    x0, x1, x2 = (np.interp(grid + k, *x) for k in (-half, 0.0, half))
    y0, y1, y2 = (np.interp(grid + k, *y) for k in (-half, 0.0, half))
    ax, ay, bx, by = x1 - x0, y1 - y0, x2 - x1, y2 - y1
    return np.asarray(np.arctan2(ax * by - ay * bx, ax * bx + ay * by) / half)


def slope(a: FloatArray, b: FloatArray) -> float:
    """k of the straight line a = k b + c through most of the points: least squares after the worst 5 % are dropped.

    Samples (n,) of both, in any units; k has the unit of `a` over that of `b`. NaN below 20 samples, or if `b` does not
    vary.
    """
    if len(a) < 20:
        return float("nan")
    kept = np.ones(len(a), bool)
    k = float("nan")
    for _ in range(2):
        u, w = a[kept] - a[kept].mean(), b[kept] - b[kept].mean()
        energy = float(w @ w)
        if energy <= 0.0:
            return float("nan")
        k = float(u @ w) / energy
        miss = np.abs((a - a[kept].mean()) - k * (b - b[kept].mean()))
        kept = miss <= np.percentile(miss, 95)
    return k


def correlation(a: FloatArray, b: FloatArray) -> float:
    """Correlation coefficient; 0 if one of them does not vary.

    Samples (n,) of both, in any units; without a unit, -1 to 1. 0 below 20 samples as well.
    """
    if len(a) < 20:
        return 0.0
    u, w = a - a.mean(), b - b.mean()
    energy = float(u @ u) * float(w @ w)
    return float(u @ w) / energy**0.5 if energy > 0.0 else 0.0


def best_lag(
    a: FloatArray, b: FloatArray, step: float, longest: float, *, positive: bool = False
) -> tuple[float, float]:
    """Lag [s] by which `a` comes later than `b`, and the correlation there, the largest in size (or the largest
    positive one); NaN rows are left out.

    Parabola through the three points around the peak.

    `a` and `b` (n,) have one sample each `step` [s]; `longest` [s] is the reach to both sides. (0, 0) if there are too
    few samples for that reach.
    """
    reach = round(longest / step)
    n = len(a)
    if n < 4 * reach + 20:
        return 0.0, 0.0
    return _peak(_correlations(a, b, reach), step, positive=positive)


def _peak(found: FloatArray, step: float, *, positive: bool) -> tuple[float, float]:
    """Lag [s] and value of the largest of correlations (n,) that lie `step` [s] apart around the lag 0."""
    reach = len(found) // 2
    top = int(np.argmax(found if positive else np.abs(found)))
    lag = float(top - reach)
    if 0 < top < 2 * reach:
        left, peak, right = np.abs(found[top - 1 : top + 2])
        bend = left - 2.0 * peak + right
        lag += 0.5 * (left - right) / bend if bend < 0 else 0.0
    return lag * step, float(found[top])


def far_lag(a: FloatArray, b: FloatArray, step: float, near: float) -> float | None:
    """Lag [s] up to FARTHEST at which `a` and `b` (n,) are alike, for two whose correlation `near` at hand is poor: two
    clocks that were set apart. None if there is none, or none that leaves half as much unexplained: a drive that
    repeats itself is nearly as much alike a period later. They have one sample each `step` [s]."""
    reach = min(round(FARTHEST / step), int(_PART * len(a)))
    lag, alike = _peak(_correlations(a, b, reach), step, positive=True)
    better = alike > ALIKE and 1.0 - alike**2 < 0.5 * (1.0 - near**2)
    return lag if better and abs(lag) < (reach - 1) * step else None


def _correlations(a: FloatArray, b: FloatArray, reach: int) -> FloatArray:
    """Correlation coefficient of a[i + k] and b[i] for k = -reach .. reach, over the rows where both are known."""
    size = 1 << int(len(a) + reach).bit_length()
    here, there = np.isfinite(a), np.isfinite(b)
    if not here.any() or not there.any():
        return np.zeros(2 * reach + 1)
    u = np.where(here, a - np.mean(a[here]), 0.0)
    w = np.where(there, b - np.mean(b[there]), 0.0)
    fu, fuu, fh = (np.fft.rfft(part, size) for part in (u, u * u, here.astype(np.float64)))
    fw, fww, ft = (np.conj(np.fft.rfft(part, size)) for part in (w, w * w, there.astype(np.float64)))
    k = np.arange(-reach, reach + 1)

    def at(product: np.ndarray[tuple[int], np.dtype[np.complex128]]) -> FloatArray:
        return np.asarray(np.fft.irfft(product, size)[k])

    count = np.maximum(at(fh * ft), 1.0)
    sum_u, sum_w = at(fu * ft), at(fh * fw)
    energy = (at(fuu * ft) - sum_u**2 / count) * (at(fh * fww) - sum_w**2 / count)
    good = (energy > 0.0) & (count > 19.5)
    shared = at(fu * fw) - sum_u * sum_w / count
    return np.where(good, shared / np.sqrt(np.where(good, energy, 1.0)), 0.0)
