"""Likeness of one signal in two logs: MNCC, and the lag and gain without which it must not stand."""

from __future__ import annotations

import dataclasses
from typing import TypeAlias

import numpy as np

from pytest_dvp.logs.likeness import MAX_LAG, Likeness, likeness
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.signals import describe
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, NotNegative, Series, metric

SEEN = {"objects.x": "ahead", "objects.y": "left"}  # of the ego, where the stack saw road users
Course: TypeAlias = tuple[FloatArray, FloatArray]  # times [s] and values
LEAST = 0.5  # share of the longer signal that two must have in common; chosen: less is another drive
_NOTE = "lag within +-{max_lag} s"


@metric(name="mncc", unit="-", bigger_is_worse=False, note=_NOTE, ideal=1.0)
def mncc(model: Log, measured: Log, *, signal: str, max_lag: NotNegative = MAX_LAG) -> Measured:
    """Maximum normalised cross-correlation of a signal in two logs. Blind to gain, delay and bias: see lag and gain,
    which are those of what the logs have in common, not of this maximum.

    `signal` is a column, `object.NAME.x` (x, y, yaw, vx, vy) for the true motion of an object, or `objects.x`,
    `objects.y` for all that the stack detected: ahead and to the left of the ego, tracks matched by assignment first,
    each figure the mean over the matched tracks, weighted by their duration. Of a heading (`yaw`, also `ads.yaw` and
    that of an object) whole turns do not count.
    """
    result = _compare(model, measured, signal, max_lag)
    extra = {"lag": result.lag, "gain": result.gain}
    return Measured(result.mncc, None, "", Series(result.lags, result.correlation), extra)


@metric(name="bias", unit="-", bigger_is_worse=None, note=_NOTE)
def bias(model: Log, measured: Log, *, signal: str, max_lag: NotNegative = MAX_LAG) -> Measured:
    """Mean of the measured signal less the model's at the lag at which they are most alike, in the signal's unit."""
    result = _compare(model, measured, signal, max_lag)
    extra = {"mncc": result.mncc, "lag": result.lag, "gain": result.gain}
    return Measured(result.bias, None, "", Series(result.lags, result.overlap), extra, _unit(signal))


@metric(name="lag", unit="s", bigger_is_worse=None, note=_NOTE)
def lag(model: Log, measured: Log, *, signal: str, max_lag: NotNegative = MAX_LAG) -> Measured:
    """Lag at which two logs are most alike in a signal; > 0: the measurement comes later than the model."""
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.lag, {"mncc": result.mncc, "gain": result.gain})


@metric(name="gain", unit="-", bigger_is_worse=None, note=_NOTE, ideal=1.0)
def gain(model: Log, measured: Log, *, signal: str, max_lag: NotNegative = MAX_LAG) -> Measured:
    """Slope of the measured signal against the model's at the lag at which they are most alike; 1 is right."""
    result = _compare(model, measured, signal, max_lag)
    return _measured(result, result.gain, {"mncc": result.mncc, "lag": result.lag})


def _measured(result: Likeness, value: float, extra: dict[str, float]) -> Measured:
    return Measured(value, None, "", Series(result.lags, result.overlap), extra)


def _compare(model: Log, measured: Log, signal: str, max_lag: float) -> Likeness:
    if signal in SEEN:
        return _compare_seen(model, measured, signal, max_lag)
    one, other = _signal(model, signal), _signal(measured, signal)
    _check_common(one[0], other[0])
    return _on_one_base(one, _by_whole_turns(one, other) if _is_heading(signal) else other, max_lag)


def _is_heading(signal: str) -> bool:
    return signal == "yaw" or signal.endswith(".yaw")


def _by_whole_turns(model: Course, measured: Course) -> Course:
    """The measured heading [rad] less the whole turns that lie between both: they point the same way."""
    (t1, x1), (t2, x2) = model, measured
    t = np.unique(np.concatenate([t1, t2]))
    t = t[(t >= max(t1[0], t2[0])) & (t <= min(t1[-1], t2[-1]))]
    apart = float(np.median(np.interp(t, t2, x2) - np.interp(t, t1, x1)))
    return t2, x2 - 2.0 * np.pi * round(apart / (2.0 * np.pi))


def _check_common(one: FloatArray, other: FloatArray) -> None:
    """Raises Undefined unless two signals with the stamps (n,), (m,) [s] share LEAST of the longer one; a hole in one
    of them, through which only a straight line could be drawn, is not shared."""
    from pytest_dvp.gap.compare.segments import longest_step

    start, end = max(one[0], other[0]), min(one[-1], other[-1])
    if end <= start or min(np.median(np.diff(one)), np.median(np.diff(other))) <= 0.0:
        raise Undefined("the logs have no time in common")
    edges = np.unique(np.concatenate([one, other, [start, end]]))
    edges = edges[(edges >= start) & (edges <= end)]
    middle, known = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    for t in (one, other):
        after = np.searchsorted(t, middle)
        known = np.where(t[after] - t[after - 1] > longest_step(t), 0.0, known)
    common, whole = float(known.sum()), float(max(one[-1] - one[0], other[-1] - other[0]))
    if common < LEAST * whole:
        raise Undefined(f"both logs have it for {common:.1f} s only, one of them for {whole:.1f} s")


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
    return Likeness(mncc, lag, gain, longest.lags, longest.correlation, longest.overlap, bias)


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
    # A stack or a driver may state headings between -pi and pi: their jumps are no motion
    return t[known], np.unwrap(values[known]) if _is_heading(name) else values[known]
