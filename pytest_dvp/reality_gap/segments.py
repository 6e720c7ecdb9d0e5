"""Re-initialised segments: the error a model makes in about five seconds, whatever pose and speed it started with.

A model that drives a whole log open loop is judged by its first error: half a degree becomes 50 m. So the motion is set
to the measured one every few seconds. The measured start is noisy; what a wrong start (x, y, yaw, speed) does to each
signal is known to first order from the modelled motion itself, and the start that suits the segment best is taken out
by weighted least squares, without another simulation. This is the objective of a diagnosis, called thousands of times.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pytest_dvp.log import FloatArray

CHANNELS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
"""Columns of a replay's output, and of everything here that has 8 columns."""

UNITS: Mapping[str, str] = {
    "x": "m", "y": "m", "yaw": "rad", "v": "m/s", "yaw_rate": "rad/s", "ax": "m/s^2", "ay": "m/s^2", "steer": "rad",
}  # fmt: skip

LENGTH = 5.0  # s
_GAP = 0.5  # s between stamps, at which a segment ends
_SETTLE = 1.0  # s of a standstill that still counts, at both ends: a late or early start shows there
_FIT = 0.15  # s around a start from which its state is taken
_STOPPED = 1e-3  # m/s: once the model stands, a wrong start speed has no effect any more
_CREEP = 0.5  # m/s, below which the curvature r/v is not taken from the model

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Segments:
    """How a log is cut: starts, ends (m,) row numbers (end excluded); states (m, 6) at the starts: x, y [m], yaw [rad],
    v, vy [m/s], yaw_rate [rad/s]; counted (n,): rows that count (not a standstill, not a spin)."""

    starts: IntArray
    ends: IntArray
    states: FloatArray
    counted: BoolArray


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Residuals:
    """values (n, 8) measured - model with the best start, NaN where nothing was compared; chi2 (8,) mean square of
    values/sigma of each channel (NaN without samples); count (8,) samples; start (m, 4) what the best start differs by
    in x, y [m], yaw [rad], v [m/s]; total: mean square over all channels."""

    values: FloatArray
    chi2: FloatArray
    count: IntArray
    start: FloatArray
    total: float


def measured_array(columns: Mapping[str, FloatArray]) -> FloatArray:
    """The measured channels of a log as one array (n, 8), NaN where not measured; yaw without turns of 2 pi."""
    n = len(columns["t"])
    nothing = np.full(n, np.nan)
    found = np.ascontiguousarray(np.column_stack([columns.get(name, nothing) for name in CHANNELS]))
    known = np.isfinite(found[:, 2])
    found[known, 2] = np.unwrap(found[known, 2])
    return found


def cut(t: FloatArray, measured: FloatArray, *, length: float = LENGTH, wheelbase: float = 2.5) -> Segments:
    """Cut a log of stamps t (n,) [s] and measured channels (n, 8) into segments of about `length` [s].

    A cut is put where the car turns least within half a second, so that the sideways motion has nothing to settle.
    `wheelbase` [m] says which yaw rate is a spin. Rows of a standstill but its first and last second do not count.
    """
    n = len(t)
    whole = _filled(t, measured)
    v, rate = whole[:, 3], whole[:, 4]
    counted = ~(_interior(t, np.abs(v) < still_speed(v)) | _spin(t, v, rate, wheelbase))
    count = max(1, round((t[-1] - t[0]) / length)) if n > 1 else 1
    wanted = t[0] + (t[-1] - t[0]) * np.arange(1, count) / count
    cuts = [0]
    for time in wanted:
        low, high = np.searchsorted(t, [time - 0.5, time + 0.5])
        best = int(low) + int(np.argmin(np.abs(rate[low:high]))) if high > low else int(low)
        if cuts[-1] + 4 < best < n - 4:
            cuts.append(best)
    # What happened in a gap nobody knows: the motion begins anew after it
    gaps = np.flatnonzero(np.diff(t) > _GAP) + 1
    starts = np.union1d(np.array(cuts, dtype=np.int64), gaps.astype(np.int64))
    ends = np.append(starts[1:], n).astype(np.int64)
    return Segments(starts, ends, _states(t, measured, whole, starts), counted)


def still_speed(v: FloatArray) -> float:
    """Speed [m/s] below which a car counts as standing: 0.3 m/s, less for a small car."""
    return min(0.3, 0.1 * float(np.quantile(np.abs(v), 0.95)) + 1e-6)


def residuals(output: FloatArray, measured: FloatArray, t: FloatArray, sigma: FloatArray, segments: Segments,
              *, free_speed: bool = True) -> Residuals:  # fmt: skip
    """Residuals of a model's output (n, 8), re-initialised at the segments' starts, against the measured (n, 8).

    sigma (8,) noise of each channel in its unit, inf or NaN for a channel that does not count. `free_speed` False if
    the speed is imposed, so that no wrong start speed is to be taken out. t (n,) [s].
    """
    weight = np.where(np.isfinite(sigma) & (sigma > 0.0), 1.0 / np.where(sigma > 0.0, sigma, 1.0), 0.0)
    values = np.empty_like(measured)
    start = np.zeros((len(segments.starts), 4))
    chi2, count = np.zeros(8), np.zeros(8, dtype=np.int64)
    _project(output, measured, t, weight, segments.starts, segments.ends, segments.counted, free_speed,
             values, start, chi2, count)  # fmt: skip
    known = int(count.sum())
    total = float(chi2.sum() / known) if known else float("nan")
    mean = np.where(count > 0, chi2 / np.maximum(count, 1), np.nan)
    return Residuals(values, mean, count, start, total)


def restarted(segments: Segments, found: Residuals) -> Segments:
    """The same segments, begun with the start that suited best: a second simulation from there is exact where the
    first order is not, above all in when a car comes to rest."""
    states = segments.states.copy()
    states[:, :4] += found.start
    return dataclasses.replace(segments, states=states)


def posed(output: FloatArray, segments: Segments) -> FloatArray:
    """Output (n, 8) of a model that cannot be restarted, with each segment turned and moved onto its measured start."""
    moved = output.copy()
    for first, end, state in zip(segments.starts, segments.ends, segments.states, strict=True):
        piece = output[first:end]
        known = np.flatnonzero(np.isfinite(piece[:, :3]).all(axis=1))
        if not len(known) or not np.isfinite(state[:3]).all():
            continue
        x, y, yaw = piece[known[0], :3]
        c, s = np.cos(state[2] - yaw), np.sin(state[2] - yaw)
        dx, dy = piece[:, 0] - x, piece[:, 1] - y
        moved[first:end, 0] = state[0] + c * dx - s * dy
        moved[first:end, 1] = state[1] + s * dx + c * dy
        moved[first:end, 2] = piece[:, 2] + state[2] - yaw
    return moved


def _filled(t: FloatArray, measured: FloatArray) -> FloatArray:
    """The measured channels with gaps bridged by straight lines; zeros where nothing was measured at all."""
    whole = np.zeros_like(measured)
    for k in range(measured.shape[1]):
        known = np.isfinite(measured[:, k])
        if known.any():
            whole[:, k] = np.interp(t, t[known], measured[known, k])
    if not np.isfinite(measured[:, 3]).any() and np.isfinite(measured[:, :2]).any() and len(t) > 2:
        whole[:, 3] = np.hypot(np.gradient(whole[:, 0], t), np.gradient(whole[:, 1], t))
    if not np.isfinite(measured[:, 4]).any() and np.isfinite(measured[:, 2]).any() and len(t) > 2:
        whole[:, 4] = np.gradient(whole[:, 2], t)
    return whole


def _interior(t: FloatArray, stands: BoolArray) -> BoolArray:
    """True inside runs of `stands`, away from both ends by _SETTLE."""
    inside = np.zeros(len(t), dtype=np.bool_)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], stands.astype(np.int8), [0]]))).reshape(-1, 2)
    for first, end in edges:
        low, high = np.searchsorted(t, [t[first] + _SETTLE, t[end - 1] - _SETTLE])
        inside[low:high] = True
    return inside


def _spin(t: FloatArray, v: FloatArray, rate: FloatArray, wheelbase: float) -> BoolArray:
    """True where the car turns faster than any steering could make it, and half a second around."""
    spins = np.flatnonzero(np.abs(rate) > np.abs(v) / wheelbase * 1.2 + 0.5)
    mask = np.zeros(len(t), dtype=np.bool_)
    if len(spins):
        low, high = np.searchsorted(t, t[spins] - 0.5), np.searchsorted(t, t[spins] + 0.5)
        np.add.at(edges := np.zeros(len(t) + 1, dtype=np.int64), low, 1)
        np.subtract.at(edges, high, 1)
        mask = np.cumsum(edges[:-1]) > 0
    return mask


def _states(t: FloatArray, measured: FloatArray, whole: FloatArray, starts: IntArray) -> FloatArray:
    """Motion at the starts by a parabola through the samples around each."""
    states = np.zeros((len(starts), 6))
    for j, row in enumerate(starts):
        low, high = np.searchsorted(t, [t[row] - _FIT, t[row] + _FIT + 1e-9])
        s = t[low:high] - t[row]
        for place, channel in ((0, 0), (1, 1), (2, 2), (3, 3), (5, 4)):
            piece = measured[low:high, channel]
            known = np.isfinite(piece)
            # One-sided or thin: a straight line; a parabola would swing at its end
            degree = 2 if known.sum() >= 7 and s[known][0] < 0.0 < s[known][-1] else 1 if known.sum() >= 3 else 0
            if degree and np.ptp(s[known]) > 0.0:
                states[j, place] = np.polynomial.polynomial.polyfit(s[known], piece[known], degree)[0]
            else:
                states[j, place] = whole[row, channel]
    return states


@njit(cache=True, error_model="numpy")
def _project(output: FloatArray, measured: FloatArray, t: FloatArray, weight: FloatArray, starts: IntArray,
             ends: IntArray, counted: BoolArray, free_speed: bool, values: FloatArray, start: FloatArray,
             chi2: FloatArray, count: IntArray) -> None:  # fmt: skip
    """Fill values, start, chi2 (sums) and count; see `residuals`."""
    g = np.zeros(3)  # what 1 m/s more at the start has done to x, y, yaw so far
    for i in range(values.shape[0]):
        for k in range(8):
            values[i, k] = np.nan
    for j in range(len(starts)):
        a = np.zeros((4, 4))
        b = np.zeros(4)
        x0, y0 = output[starts[j], 0], output[starts[j], 1]
        p = np.zeros(4)
        for sweep in range(2):
            g[:] = 0.0
            moving = free_speed
            rate_before, gain_before, speed_before = 0.0, 0.0, 0.0
            yaw_before = output[starts[j], 2]
            for i in range(starts[j], ends[j]):
                v, rate = output[i, 3], output[i, 4]
                if abs(v) < _STOPPED and i > starts[j]:
                    moving = False
                gain = 1.0 if moving else 0.0
                turn = rate / v if moving and abs(v) > _CREEP else 0.0
                if i > starts[j]:
                    dt = t[i] - t[i - 1]
                    mid_yaw = 0.5 * (output[i, 2] + yaw_before)
                    mid_gain = 0.5 * (gain + gain_before)
                    c, s = np.cos(mid_yaw), np.sin(mid_yaw)
                    half = 0.25 * dt * (turn + rate_before)
                    g[2] += half
                    mid_speed = 0.5 * (v + speed_before)
                    g[0] += dt * (c * mid_gain - s * mid_speed * g[2])
                    g[1] += dt * (s * mid_gain + c * mid_speed * g[2])
                    g[2] += half
                rate_before, gain_before, speed_before, yaw_before = turn, gain, v, output[i, 2]
                if not counted[i]:
                    continue
                stops = _stops(output, i, starts[j], ends[j])
                for k in range(8):
                    e = measured[i, k] - output[i, k]
                    if k == 2:
                        e -= 2.0 * np.pi * np.rint(e / (2.0 * np.pi))
                    if not np.isfinite(e) or (k == 5 and stops):
                        continue
                    q0 = q1 = q2 = q3 = 0.0
                    if k == 0:
                        q0, q2, q3 = 1.0, y0 - output[i, 1], g[0]
                    elif k == 1:
                        q1, q2, q3 = 1.0, output[i, 0] - x0, g[1]
                    elif k == 2:
                        q2, q3 = 1.0, g[2]
                    elif k == 3:
                        q3 = gain
                    elif k == 4:
                        q3 = turn
                    elif k == 6:
                        q3 = 2.0 * rate * gain
                    if sweep == 0:
                        w = weight[k]
                        if w > 0.0 and k != 5 and k != 7:
                            w = w * w
                            a[0, 0] += w * q0 * q0
                            a[0, 2] += w * q0 * q2
                            a[0, 3] += w * q0 * q3
                            a[1, 1] += w * q1 * q1
                            a[1, 2] += w * q1 * q2
                            a[1, 3] += w * q1 * q3
                            a[2, 2] += w * q2 * q2
                            a[2, 3] += w * q2 * q3
                            a[3, 3] += w * q3 * q3
                            b[0] += w * q0 * e
                            b[1] += w * q1 * e
                            b[2] += w * q2 * e
                            b[3] += w * q3 * e
                    else:
                        e -= q0 * p[0] + q1 * p[1] + q2 * p[2] + q3 * p[3]
                        values[i, k] = e
                        if weight[k] > 0.0:
                            chi2[k] += (e * weight[k]) ** 2
                            count[k] += 1
            if sweep == 0:
                _solve(a, b, p)
        for k in range(4):
            start[j, k] = p[k]


@njit(cache=True, error_model="numpy")
def _stops(output: FloatArray, i: int, first: int, end: int) -> bool:
    """True within a row of where the model comes to rest: a start speed 1 cm/s off moves that by a row, and one row of
    full deceleration is dozens of sigma."""
    for row in range(max(i - 1, first + 1), min(i + 2, end)):
        if abs(output[row, 3]) < _STOPPED <= abs(output[row - 1, 3]):
            return True
    return False


@njit(cache=True, error_model="numpy")
def _solve(a: FloatArray, b: FloatArray, p: FloatArray) -> None:
    """Solve the symmetric system a p = b (upper triangle given); what the data do not determine stays 0."""
    n = len(b)
    low = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            left = a[j, i]
            for k in range(j):
                left -= low[i, k] * low[j, k]
            if i == j:
                low[i, i] = np.sqrt(left) if left > 1e-9 * a[i, i] and a[i, i] > 0.0 else 0.0
            else:
                low[i, j] = left / low[j, j] if low[j, j] > 0.0 else 0.0
    for i in range(n):
        left = b[i]
        for k in range(i):
            left -= low[i, k] * p[k]
        p[i] = left / low[i, i] if low[i, i] > 0.0 else 0.0
    for i in range(n - 1, -1, -1):
        left = p[i]
        for k in range(i + 1, n):
            left -= low[k, i] * p[k]
        p[i] = left / low[i, i] if low[i, i] > 0.0 else 0.0
