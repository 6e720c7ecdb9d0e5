"""Driving regimes of a measured log: what the car was doing in each sample."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.gap.compare.segments import still_speed
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.log_contents import FloatArray

LONGITUDINAL = ("standstill", "reverse", "launch", "cruise", "lift_off", "braking")
LATERAL = ("turn_in", "steady_turn")
REGIMES = ("launch", "cruise", "lift_off", "braking", "standstill", "turn_in", "steady_turn", "reverse")

_LIFT = 2.0  # s after the driver's foot left the pedal that still count as lift-off
_START = 3.0  # s after the first motion that count as launch


def regimes(
    t: FloatArray, v: FloatArray, yaw_rate: FloatArray, demand: FloatArray | None = None
) -> dict[str, BoolArray]:
    """Masks (n,) by regime from t [s], speed v [m/s], yaw rate [rad/s] and, if known, demanded acceleration [m/s^2].

    Of the longitudinal ones (standstill, reverse, launch, cruise, lift_off, braking) one holds in each sample; turn_in
    and steady_turn hold beside them. Thresholds: standing below 0.3 m/s; accelerating or braking beyond 0.5 m/s^2 or
    a fifth of what is usual in this log, if that is less; turning beyond 0.5 m/s^2 sideways, or a fifth of the usual.
    turn_in: the sideways acceleration builds up or fades; launch: the first 3 s from standstill and all strong
    acceleration below 40 % of the usual speed; lift_off: the 2 s after the demand was withdrawn.
    """
    step = float(np.median(np.diff(t)))
    window = max(1, round(0.3 / step))
    speed = _smooth(v, window)
    accel = np.gradient(speed, t)
    wish = _smooth(accel, window) if demand is None or not np.isfinite(demand).any() else _bridged(t, demand)
    stand = np.abs(v) < still_speed(v)
    stand = _smooth(stand.astype(np.float64), window) > 0.5
    back = (speed < 0.0) & ~stand
    moves = ~stand & ~back
    limit = min(0.5, 0.2 * _usual(wish))
    brakes = moves & (wish < -limit)
    drives = moves & (wish > limit)
    slow = np.abs(speed) < 0.4 * _usual(speed)
    launch = moves & ~brakes & ((drives & slow) | _after(t, stand, moves, _START))
    coast = moves & ~brakes & ~drives
    lift = coast & _after(t, drives, coast, _LIFT) & ~launch
    side = _smooth(speed * yaw_rate, window)
    bend = min(0.5, 0.2 * _usual(side))
    change = np.gradient(side, t)
    building = np.abs(change) > max(0.6 * bend, 0.25 * _usual(change))
    building = _smooth(building.astype(np.float64), window) > 0.5  # a turn flickers otherwise
    turns = (np.abs(side) > bend) & ~stand
    near = turns | ((np.abs(side) > 0.3 * bend) & ~stand)
    turn_in = near & building
    masks = {
        "launch": launch,
        "cruise": moves & ~launch & ~brakes & ~lift,
        "lift_off": lift,
        "braking": brakes,
        "standstill": stand,
        "turn_in": turn_in,
        "steady_turn": turns & ~turn_in,
        "reverse": back,
    }
    return {name: masks[name] for name in REGIMES}


def speed_bins(v: FloatArray) -> dict[str, BoolArray]:
    """Masks (n,) of about four bins of the speed v (n,) [m/s] with round edges, named "speed 0-5 m/s"."""
    top = float(np.quantile(np.abs(v), 0.995)) + 1e-9
    raw = top / 4.0
    magnitude = 10.0 ** np.floor(np.log10(raw))
    width = magnitude * next(m for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * magnitude >= 0.8 * raw)
    index = np.minimum(np.abs(v) // width, top // width).astype(np.int64)
    return {
        f"speed {width * k:g}-{width * (k + 1):g} m/s": index == k
        for k in range(int(top // width) + 1)
        if bool((index == k).any())
    }


def ribbon(masks: Mapping[str, BoolArray], names: tuple[str, ...], t: FloatArray) -> list[tuple[str, float, float]]:
    """(regime, from [s], to [s]) of every run of the named masks (n,), by time; t (n,) [s]. A run ends where the log
    pauses, as a line of a page does."""
    steps = np.diff(t)
    last = np.append(steps > max(0.1, 5.0 * float(np.median(steps))), True) if len(steps) else np.ones(len(t), bool)
    runs = []
    for name in names:
        on = masks[name]
        begins = np.flatnonzero(on & np.concatenate([[True], last[:-1] | ~on[:-1]]))
        ends = np.flatnonzero(on & (last | ~np.append(on[1:], False)))
        runs += [(name, float(t[a]), float(t[b if last[b] else b + 1])) for a, b in zip(begins, ends, strict=True)]
    return sorted(runs, key=lambda run: run[1])


def _bridged(t: FloatArray, y: FloatArray) -> FloatArray:
    known = np.isfinite(y)
    return np.asarray(np.interp(t, t[known], y[known]))


def _usual(y: FloatArray) -> float:
    return float(np.quantile(np.abs(y), 0.95)) + 1e-9


def _smooth(y: FloatArray, window: int) -> FloatArray:
    """Mean over 2 window + 1 samples, fewer at the ends."""
    total = np.concatenate([[0.0], np.cumsum(y)])
    i = np.arange(len(y))
    low, high = np.maximum(i - window, 0), np.minimum(i + window + 1, len(y))
    return np.asarray((total[high] - total[low]) / (high - low))


def _after(t: FloatArray, cause: BoolArray, during: BoolArray, reach: float) -> NDArray[np.bool_]:
    """True where `during` has held without break since `cause` last held, for at most `reach` [s]."""
    rows = np.arange(len(t))
    last_cause = np.maximum.accumulate(np.where(cause, rows, -1))
    last_break = np.maximum.accumulate(np.where(~during & ~cause, rows, -1))
    recent = t - t[np.maximum(last_cause, 0)] <= reach
    return np.asarray((last_cause >= 0) & (last_break < last_cause) & recent & during)
