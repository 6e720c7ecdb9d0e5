"""Likeness of one signal in two logs: MNCC, and the lag and gain without which it must not stand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from pytest_dvp.log import FloatArray, Log
from pytest_dvp.metrics.base import Measured, Series, Undefined, metric

MAX_LAG = 5.0  # s
_NOTE = "lag within +-{max_lag} s"


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Likeness:
    """Result of `likeness`: mncc in [-1, 1], lag [s] (> 0: the measurement comes later), gain measured/model.

    lags, correlation: the normalised cross-correlation (m,) over the lag [s].
    """

    mncc: float
    lag: float
    gain: float
    lags: FloatArray
    correlation: FloatArray


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
    a, b = a - a.mean(), b - b.mean()
    power = _dot(a, a)
    gain = _dot(a, b) / power if power > 0.0 else float("nan")
    return Likeness(float(correlation[best]), k * step, gain, lags.astype(np.float64) * step, correlation)


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


@metric(name="mncc", unit="-", bigger_is_worse=False, note=_NOTE)
def mncc(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Maximum normalised cross-correlation of a signal in two logs. Blind to gain, delay and bias: see lag and gain.

    `signal` is a column, or `object.NAME.x` (x, y, yaw, vx, vy) for the motion of an object.
    """
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.mncc, {"lag": result.lag, "gain": result.gain})


@metric(name="lag", unit="s", bigger_is_worse=None, note=_NOTE)
def lag(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Lag at which two logs are most alike in a signal; > 0: the measurement comes later than the model."""
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.lag, {"mncc": result.mncc, "gain": result.gain})


@metric(name="gain", unit="-", bigger_is_worse=None, note=_NOTE)
def gain(model: Log, measured: Log, *, signal: str, max_lag: float = MAX_LAG) -> Measured:
    """Slope of the measured signal against the model's at the lag at which they are most alike; 1 is right."""
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.gain, {"mncc": result.mncc, "lag": result.lag})


def _measured(result: Likeness, value: float, extra: dict[str, float]) -> Measured:
    return Measured(value, None, "", Series(result.lags, result.correlation), extra)


def _compare(model: Log, measured: Log, signal: str, max_lag: float) -> Likeness:
    """Both on the finer time base, over the time they have in common."""
    t1, x1 = _signal(model, signal)
    t2, x2 = _signal(measured, signal)
    start, end = max(t1[0], t2[0]), min(t1[-1], t2[-1])
    step = float(min(np.median(np.diff(t1)), np.median(np.diff(t2))))
    if step <= 0.0 or end - start < step:
        raise Undefined("the logs have no time in common")
    grid = start + step * np.arange(int((end - start) / step + 1e-6) + 1)
    return likeness(np.interp(grid, t1, x1), np.interp(grid, t2, x2), step, max_lag)


def _signal(log: Log, name: str) -> tuple[FloatArray, FloatArray]:
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
