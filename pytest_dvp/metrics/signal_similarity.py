"""Likeness of one signal in two logs: MNCC, and the lag and gain without which it must not stand."""

from __future__ import annotations

import dataclasses
import math
from typing import TypeAlias

import numpy as np

from pytest_dvp.logs.log import FloatArray, Log
from pytest_dvp.logs.signals import describe
from pytest_dvp.metrics.metric import Measured, Series, Undefined, metric

MAX_LAG = 5.0  # s
SEEN = {"objects.x": "ahead", "objects.y": "left"}  # of the ego, where the stack saw road users
Course: TypeAlias = tuple[FloatArray, FloatArray]  # times [s] and values
_NOTE = "lag within +-{max_lag} s"


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Likeness:
    """Result of `likeness`: mncc in [-1, 1], lag [s] (> 0: the measurement comes later), gain measured/model, bias
    measured - model at that lag.

    lags, correlation: the normalised cross-correlation (m,) over the lag [s].
    """

    mncc: float
    lag: float
    gain: float
    lags: FloatArray
    correlation: FloatArray
    bias: float = 0.0


def likeness(model: FloatArray, measured: FloatArray, step: float, max_lag: float = MAX_LAG) -> Likeness:
    """Compare two signals (n,) sampled every `step` [s].

    MNCC: maximum over the lag of the cross-correlation of the mean-removed signals, divided by both their norms. The
    gain is the slope of measured against model in the overlap at that lag. Raises Undefined for a constant signal.
    Source: Arango et al., Sensors 2026, 26, 1338.
    """
    if len(model) != len(measured) or len(model) < 2:
        raise Undefined("too few common samples")
    x, y = model - model.mean(), measured - measured.mean()
    norm = math.sqrt(_dot(x, x)) * math.sqrt(_dot(y, y))
    floor = 1e-12 * len(x) * max(float(np.abs(model).max()), 1e-300) * max(float(np.abs(measured).max()), 1e-300)
    if norm <= floor:
        raise Undefined("the signal is constant")
    n = len(x)
    reach = min(n - 1, round(max_lag / step))
    correlation = np.clip(_correlate(x, y, reach) / norm, -1.0, 1.0)
    lags = np.arange(-reach, reach + 1)
    best = int(np.argmax(correlation))
    k = int(lags[best])
    a, b = model[max(0, -k) : n - max(0, k)], measured[max(0, k) : n - max(0, -k)]
    off = float(b.mean() - a.mean())
    a, b = a - a.mean(), b - b.mean()
    power = _dot(a, a)
    gain = _dot(a, b) / power if power > 0.0 else float("nan")
    return Likeness(float(correlation[best]), k * step, gain, lags.astype(np.float64) * step, correlation, off)


def peak(lags: FloatArray, correlation: FloatArray) -> float:
    """Place of the maximum between the samples, by the parabola through the three highest."""
    k = int(np.argmax(correlation))
    if k in (0, len(lags) - 1):
        return float(lags[k])
    left, top, right = correlation[k - 1 : k + 2]
    bend = left - 2.0 * top + right
    shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0
    return float(lags[k] + shift * (lags[k + 1] - lags[k]))


def _dot(a: FloatArray, b: FloatArray) -> float:
    # Not BLAS: its sum depends on the number of threads, and for vectors the threads cost more than they bring.
    return float(np.einsum("i,i->", a, b))


def _correlate(x: FloatArray, y: FloatArray, reach: int) -> FloatArray:
    """Sum over i of x[i] y[i + k] for the lags k = -reach ... reach: array (2 reach + 1,).

    Overlap-save: x in blocks, each against the piece of y it can meet, the products summed as spectra. Unlike one
    transform over all of both it computes no lag that nobody asked for.
    """
    from scipy.fft import irfft, next_fast_len, rfft

    block = min(len(x), max(256, 6 * reach))
    count = -(-len(x) // block)
    window = block + 2 * reach
    pieces = np.zeros(count * block)
    pieces[: len(x)] = x
    around = np.zeros(count * block + 2 * reach)
    around[reach : reach + len(y)] = y
    met = np.lib.stride_tricks.sliding_window_view(around, window)[::block]
    size = next_fast_len(window, real=True)
    spectrum = np.einsum("ij,ij->j", rfft(pieces.reshape(count, block), size).conj(), rfft(met, size))
    return np.asarray(irfft(spectrum, size)[: 2 * reach + 1], dtype=np.float64)


@metric(name="mncc", unit="-", bigger_is_worse=False, note=_NOTE, ideal=1.0)
def mncc(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Maximum normalised cross-correlation of a signal in two logs. Blind to gain, delay and bias: see lag and gain.

    `signal` is a column, `object.NAME.x` (x, y, yaw, vx, vy) for the true motion of an object, or `objects.x`,
    `objects.y` for all that the stack detected: ahead and to the left of the ego, tracks matched by assignment first,
    each figure the mean over the matched tracks, weighted by their duration.
    """
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.mncc, {"lag": result.lag, "gain": result.gain})


@metric(name="bias", unit="-", bigger_is_worse=None, note=_NOTE)
def bias(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Mean of the measured signal less the model's at the lag at which they are most alike, in the signal's unit."""
    result = _compare(model, measured, signal, max_lag)
    extra = {"mncc": result.mncc, "lag": result.lag, "gain": result.gain}
    return Measured(result.bias, None, "", Series(result.lags, result.correlation), extra, _unit(signal))


@metric(name="lag", unit="s", bigger_is_worse=None, note=_NOTE)
def lag(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Lag at which two logs are most alike in a signal; > 0: the measurement comes later than the model."""
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.lag, {"mncc": result.mncc, "gain": result.gain})


@metric(name="gain", unit="-", bigger_is_worse=None, note=_NOTE, ideal=1.0)
def gain(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Slope of the measured signal against the model's at the lag at which they are most alike; 1 is right."""
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.gain, {"mncc": result.mncc, "lag": result.lag})


def _measured(result: Likeness, value: float, extra: dict[str, float]) -> Measured:
    return Measured(value, None, "", Series(result.lags, result.correlation), extra)


def _compare(model: Log, measured: Log, signal: str, max_lag: float) -> Likeness:
    if signal in SEEN:
        return _compare_seen(model, measured, signal, max_lag)
    return _on_one_base(_signal(model, signal), _signal(measured, signal), max_lag)


def _on_one_base(model: Course, measured: Course, max_lag: float) -> Likeness:
    """Both on the finer time base, over the time they have in common."""
    (t1, x1), (t2, x2) = model, measured
    start, end = max(t1[0], t2[0]), min(t1[-1], t2[-1])
    step = float(min(np.median(np.diff(t1)), np.median(np.diff(t2))))
    if step <= 0.0 or end - start < step:
        raise Undefined("the logs have no time in common")
    grid = start + step * np.arange(int((end - start) / step + 1e-6) + 1)
    return likeness(np.interp(grid, t1, x1), np.interp(grid, t2, x2), step, max_lag)


def _compare_seen(model: Log, measured: Log, signal: str, max_lag: float) -> Likeness:
    """Mean over the matched tracks; they are moved onto one clock first, so that short ones keep their time in common.

    The lag is that of the clocks, as two drives meet a road user, plus what is left.
    """
    from pytest_dvp.logs.detected_tracks import matched_tracks

    found: list[tuple[float, Likeness]] = []
    side = SEEN[signal]
    for one, other, shift in matched_tracks(model, measured):
        try:
            alike = _on_one_base((one.t, getattr(one, side)), (other.t - shift, getattr(other, side)), max_lag)
        except Undefined:
            continue  # a road user that keeps its place beside the ego: nothing varies
        found.append((min(one.duration, other.duration), dataclasses.replace(alike, lag=alike.lag + shift)))
    if not found:
        raise Undefined("no road user was seen in both logs whose place varied")
    weights = np.array([weight for weight, _ in found])
    mean = (weights / weights.sum()) @ np.array([(a.mncc, a.lag, a.gain, a.bias) for _, a in found])
    longest = max(found, key=lambda pair: pair[0])[1]
    mncc, lag, gain, bias = mean.tolist()
    return Likeness(mncc, lag, gain, longest.lags, longest.correlation, bias)


def _unit(signal: str) -> str:
    """Unit of a signal of `mncc` as far as it is known."""
    if signal in SEEN:
        return "m"
    if signal.startswith("object."):
        return {"x": "m", "y": "m", "yaw": "rad", "vx": "m/s", "vy": "m/s"}.get(signal.rpartition(".")[2], "-")
    unit = describe(signal).unit
    return unit if unit != "?" else "-"


def _signal(log: Log, name: str) -> Course:
    if name.startswith("object."):
        who, _, what = name.removeprefix("object.").rpartition(".")
        track = log.objects.get(who)
        if track is None or what not in ("x", "y", "yaw", "vx", "vy"):
            raise Undefined(f"no {name} in the log")
        t, values = track.t, getattr(track, what)
    else:
        t, values = log.t, log[name]
    known = np.isfinite(values) & np.isfinite(t)
    if known.sum() < 2:
        raise Undefined(f"{name} was not measured")
    return t[known], values[known]
