"""Changes of gear that a log shows by itself: gaps of the acceleration, at speeds at which one gearbox makes them.

A gearbox is hard to find by simulation. Each change lasts half a second, so a fit finds it only from speeds of change
that are right within half a metre a second, and until it is found other effects take its place. The acceleration that
was measured shows each gap. Of all gearboxes on a grid, the one is taken whose gaps explain most of what the
acceleration leaves beside its own median over some seconds.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from machine_code import compiled
from pytest_dvp.gap.compare.segments import CHANNELS, filled
from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effects.gear_changes import BACK, DEMAND, LEAST, PROGRESSION

if TYPE_CHECKING:
    from vehicle.model.command_inputs import Inputs

NAME = "gear_changes"
SHOWN = 0.15  # of the square of what is left beside the median, that gaps must explain; chosen: of cars of strangers,
# gearboxes that open their clutch or lower the torque explained 0.22 to 0.55, cars without one 0.07 at most
_LEVEL = 2.6  # s, the median over which a gap does not change; chosen: more than twice the longest gap
_PULLS = 0.3  # m/s^2 of that median, below which a gap is too small to be seen; chosen
_RATE = 25.0  # Hz at which a log is looked at
_FIRST = np.geomspace(2.0, 8.0, 36)  # m/s, of the first change up: 2 to 8
_STEPS = np.linspace(1.3, 2.2, 10)
_DEMANDS = np.linspace(0.0, 0.5, 6)  # s^2/m
_TIMES = np.array([0.3, 0.5, 0.8])  # s
_LATE = (0.0, 0.1, 0.2, 0.3)  # s by which the drive follows what it is asked for
_GEARS = 12  # as many as any car has, and some more
_SLOW = 0.5  # m/s, below which nobody changes gear
_V, _AX = CHANNELS.index("v"), CHANNELS.index("ax")


class GearGaps(NamedTuple):
    """The gearbox whose gaps explain most: share of what is left beside the median, and values of `gear_changes`."""

    share: float
    values: dict[str, float]


def with_gear_gaps(candidates: Iterable[Candidate], target: ExperimentSet) -> tuple[Candidate, ...]:
    """The candidates; changes of gear that the logs show, and the model has not, also begin from what they show."""
    found = []
    for one in candidates:
        gaps = gear_gaps(target) if one.name == NAME and not one.own else None
        if gaps is not None and gaps.share >= SHOWN:
            seen = {c.name: gaps.values.get(c.key.name, c.key.neutral) for c in one.coordinates}
            one = dataclasses.replace(one, points=(seen, *one.points), coarse=(seen, *one.coarse), seen=seen)
        found.append(one)
    return tuple(found)


def gear_gaps(target: ExperimentSet) -> GearGaps | None:
    """The gearbox that the logs show best; None if no log has an acceleration and a request of the drive, or no gap."""
    gain, best = 0.0, None
    logs = [(e, seen, asked) for e in target.experiments if (seen := _seen(e)) and (asked := _asked(e)) is not None]
    total = sum(float(seen.rest @ seen.rest) for _, seen, _ in logs)
    for late in _LATE if total > 0.0 else ():
        sums = np.zeros((len(_FIRST), len(_STEPS), len(_DEMANDS), len(_TIMES), 2))
        for e, seen, asked in logs:
            then = np.interp(seen.t - late, e.log.t, np.maximum(asked, 0.0))
            sums += _scanned(seen.speed, then, seen.level, seen.rest, 1.0 / _RATE, _FIRST, _STEPS, _DEMANDS, _TIMES)
        levels, products = sums[..., 0], sums[..., 1]
        gains = np.divide(products**2, levels, out=np.zeros_like(levels), where=products < 0.0)
        place = np.unravel_index(int(np.argmax(gains)), gains.shape)
        if gains[place] > gain:
            gain, best = float(gains[place]), (place, min(float(-products[place] / levels[place]), 1.0))
    if best is None:
        return None
    (first, step, demand, time), cut = best
    values = {"T": _TIMES[time], "v1": _FIRST[first], "step": _STEPS[step], "demand": _DEMANDS[demand], "cut": cut}
    return GearGaps(gain / total, {key: float(value) for key, value in values.items()})


class _Seen(NamedTuple):
    """By row at _RATE (n,): stamps [s], speed [m/s], the median of the acceleration, and what the acceleration is
    beside that [m/s^2], both 0 where no gap could be seen."""

    t: FloatArray
    speed: FloatArray
    level: FloatArray
    rest: FloatArray


def _seen(e: Experiment) -> _Seen | None:
    """What a log shows of gaps; None if it is too short."""
    t, motion, step = e.log.t, filled(e.log.t, e.measured), 1.0 / _RATE
    rows = np.arange(t[0], t[-1], step)
    if len(rows) < _RATE * _LEVEL:
        return None
    speed = np.abs(_mean(t, motion[:, _V], rows, step))
    if np.isfinite(e.measured[:, _AX]).any():
        accel = _mean(t, motion[:, _AX], rows, step)
    else:
        accel = np.gradient(_mean(t, motion[:, _V], rows, 4.0 * step), step)
    known = np.isfinite(accel) & np.isfinite(speed)
    accel, speed = np.where(known, accel, 0.0), np.where(known, speed, 0.0)
    level = median_filter(accel, size=int(_LEVEL * _RATE) | 1, mode="nearest")
    shows = known & (level > _PULLS) & (speed > _SLOW)
    return _Seen(rows, speed, np.where(shows, level, 0.0), np.where(shows, accel - level, 0.0))


def _asked(e: Experiment) -> FloatArray | None:
    """What the drive is asked for [m/s^2] at the stamps (n,), negative for brakes; None if no pedal moves the model."""
    inputs: Inputs = e.model.inputs
    columns: Any = e.log.columns
    if inputs.longitudinal == ("accel_cmd",) and "accel_cmd" in columns:
        asked = columns["accel_cmd"]
    elif "throttle_cmd" in inputs.longitudinal and "throttle_cmd" in columns:
        asked = inputs.full_throttle * columns["throttle_cmd"]
    else:
        return None
    known = np.isfinite(asked)
    return np.interp(e.log.t, e.log.t[known], asked[known]) if known.any() else None


def _mean(t: FloatArray, values: FloatArray, rows: FloatArray, span: float) -> FloatArray:
    """The mean of a signal over a span about each row, between its samples as a straight line."""
    known = np.isfinite(values)
    if np.count_nonzero(known) < 2:
        return np.full(len(rows), np.nan)
    t, values = t[known], values[known]
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))])
    ends = [np.clip(rows + side, t[0], t[-1]) for side in (-0.5 * span, 0.5 * span)]
    first, last = (np.interp(end, t, area) for end in ends)
    return np.asarray((last - first) / np.maximum(ends[1] - ends[0], 1e-9))


@compiled
def _scanned(
    speed: FloatArray, asked: FloatArray, level: FloatArray, rest: FloatArray, step: float,
    firsts: FloatArray, steps: FloatArray, demands: FloatArray, times: FloatArray,
) -> FloatArray:  # fmt: skip
    """For each gearbox and time of a change: the sums over its gaps of level^2, and of level times rest."""
    sums = np.zeros((len(firsts), len(steps), len(demands), len(times), 2))
    up = np.zeros(_GEARS)
    for i in range(len(firsts)):
        for j in range(len(steps)):
            up[0], ratio = firsts[i], steps[j]
            for gear in range(1, _GEARS):
                up[gear] = up[gear - 1] * max(ratio, LEAST)
                ratio /= PROGRESSION
            for k in range(len(demands)):
                gear, since = 0, 1e9
                while gear < _GEARS - 1 and speed[0] >= up[gear] * (1.0 + demands[k] * (asked[0] - DEMAND)):
                    gear += 1
                for row in range(len(speed)):
                    later = 1.0 + demands[k] * (asked[row] - DEMAND)
                    if gear < _GEARS - 1 and asked[row] > 0.0 and speed[row] >= up[gear] * later:
                        gear, since = gear + 1, 0.0
                    elif gear > 0 and speed[row] < BACK * up[gear - 1] * later:
                        gear, since = gear - 1, 0.0
                    if level[row] > 0.0:
                        for m in range(len(times)):
                            if since < times[m]:
                                sums[i, j, k, m, 0] += level[row] * level[row]
                                sums[i, j, k, m, 1] += level[row] * rest[row]
                    since += step
    return sums
