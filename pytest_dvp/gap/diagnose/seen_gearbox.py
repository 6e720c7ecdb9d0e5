"""A gearbox that a log shows by itself: gaps of the acceleration, and less of it in each longer gear.

A gearbox is hard to find by simulation. Each change lasts half a second, so a fit finds it only from speeds of change
that are right within half a metre a second, and until it is found other effects take its place. The acceleration that
was measured shows both things that a gearbox does, without any model. Of all gearboxes on a grid

- the one whose force falls by its ratios leaves least of what the pedals ask for, if the drive is no plainer one
  without gears, whose force or power has an end;
- the one whose gaps are the measured ones explains most of what the acceleration leaves beside its own median over
  some seconds.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from machine_code import compiled
from pytest_dvp.gap.compare.segments import CHANNELS, filled
from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effects.gear_changes import BACK, DEMAND, LEAST, PROGRESSION

if TYPE_CHECKING:
    from vehicle.model.command_inputs import Inputs

BoolArray: TypeAlias = NDArray[np.bool_]

NAME = "gear_changes"
FALLS = 0.65  # of what a drive without gears leaves, that one whose force falls with the gears may leave; chosen: of
# strangers' cars those with such gears left 0.30 to 0.56, those without one 1.0, a lorry among them for which powers
# that end had to be tried as well
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
_SLOWLY = 0.1  # s between rows where the force is looked at
_PRESSED = 0.2  # m/s^2 that must be asked for where the force is looked at
_ENOUGH = 100  # rows of it, ten seconds
_GAP = 0.5  # s of a change, where the force is looked at
_FALL = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
_POWERS = (*np.geomspace(2.0, 40.0, 14), np.inf)  # W/kg of a drive without gears
_FORCES = (0.7, 1.0, 1.4, 2.0, 2.8, np.inf)  # m/s^2 of one
_TERMS = 4  # of the force: the pull, what is lost in gaps, resistance, drag
_GEARS = 12  # as many as any car has, and some more
_SLOW = 0.5  # m/s, below which nobody changes gear
_V, _AX = CHANNELS.index("v"), CHANNELS.index("ax")


class SeenGearbox(NamedTuple):
    """A gearbox that logs show best, as values of `gear_changes`. gaps: share of what is left beside the median that
    its gaps explain; left: what a force leaves that falls with its gears, over what a drive without gears leaves."""

    gaps: float
    left: float
    values: dict[str, float]

    @property
    def is_clear(self) -> bool:
        """True if no car without a gearbox was seen to show as much."""
        return self.gaps >= SHOWN or self.left <= FALLS


def with_seen_gearbox(candidates: Iterable[Candidate], target: ExperimentSet) -> tuple[Candidate, ...]:
    """The candidates; changes of gear that the logs show, and the model has not, also begin from what they show."""
    found = []
    for one in candidates:
        box = seen_gearbox(target) if one.name == NAME and not one.own else None
        if box is not None and box.is_clear:
            seen = {c.name: box.values.get(c.key.name, c.key.neutral) for c in one.coordinates}
            one = dataclasses.replace(one, points=(seen, *one.points), coarse=(seen, *one.coarse), seen=seen)
        found.append(one)
    return tuple(found)


def seen_gearbox(target: ExperimentSet) -> SeenGearbox | None:
    """The gearbox that the logs show best; None if no log has an acceleration and a request of the drive, or none
    shows a gap."""
    logs = [(e, seen, asked) for e in target.experiments if (seen := _seen(e)) and (asked := _asked(e)) is not None]
    gaps, fall = _by_gaps(logs), _by_force(logs)
    if gaps is None and fall is None:
        return None
    left, pulls = fall or (1.0, {})
    share, opens = gaps or (0.0, {})
    return SeenGearbox(share, left, pulls if left <= FALLS else opens or pulls)


def _by_force(logs: Sequence[Driven]) -> tuple[float, dict[str, float]] | None:
    """What the best gearbox whose force falls with its ratios leaves, over what the best drive without gears leaves;
    and its values. None if no log shows enough of the drive."""
    every = [_slowly(e, asked) for e, _, asked in logs]
    if sum(len(one.accel) for one in every) < _ENOUGH:
        return None
    plain, best, found = np.inf, np.inf, {}
    for late in _LATE:
        sums = np.zeros((len(_FIRST), len(_STEPS), len(_DEMANDS), len(_FALL), _TERMS + 1, _TERMS + 1))
        shown = [(one, np.interp(one.t - late, one.asked_at, one.asked)) for one in every]
        for one, then in shown:
            sums += _pulled(one.speed, then, one.accel, one.shows, _SLOWLY, _FIRST, _STEPS, _DEMANDS, _FALL, _GAP)
        left = _left(sums)
        place = np.unravel_index(int(np.argmin(left)), left.shape)
        if left[place] < best:
            best = float(left[place])
            products = sums[place]
            force, lost = np.linalg.lstsq(products[:-1, :-1], products[:-1, -1], rcond=None)[0][:2]
            cut = float(np.clip(-lost / max(force, 1e-9), 0.0, 1.0))
            first, step, demand, fall = place
            found = {"T": _GAP, "v1": _FIRST[first], "step": _STEPS[step], "demand": _DEMANDS[demand], "cut": cut,
                     "fall": _FALL[fall]}  # fmt: skip
        for power in _POWERS:
            for most in _FORCES:
                products = np.zeros((_TERMS, _TERMS))
                for one, then in shown:
                    force = np.minimum(np.minimum(then, most), power / np.maximum(one.speed, 0.1))
                    rows = np.column_stack([force, np.ones(len(then)), one.speed**2, one.accel])[one.shows]
                    products += rows.T @ rows
                plain = min(plain, float(_left(products)))
    return best / max(plain, 1e-12), {key: float(value) for key, value in found.items()}


def _left(sums: FloatArray) -> FloatArray:
    """Sum of squares that the terms leave of the last column, from all products of the columns (..., n, n)."""
    inner, outer = sums[..., :-1, :-1], sums[..., :-1, -1]
    scale = np.sqrt(np.maximum(np.diagonal(inner, axis1=-2, axis2=-1), 1e-12))
    inner = inner / scale[..., :, None] / scale[..., None, :] + 1e-9 * np.eye(inner.shape[-1])
    outer = outer / scale
    found = np.linalg.solve(inner, outer[..., None])[..., 0]
    return np.asarray(sums[..., -1, -1] - np.sum(found * outer, axis=-1))


def _by_gaps(logs: Sequence[Driven]) -> tuple[float, dict[str, float]] | None:
    """The share that the gaps of the best gearbox explain, and its values; None if nothing shows a gap."""
    gain, best = 0.0, None
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
    return gain / total, {key: float(value) for key, value in values.items()}


class _Seen(NamedTuple):
    """By row at _RATE (n,): stamps [s], speed [m/s], the median of the acceleration, and what the acceleration is
    beside that [m/s^2], both 0 where no gap could be seen."""

    t: FloatArray
    speed: FloatArray
    level: FloatArray
    rest: FloatArray


Driven: TypeAlias = tuple[Experiment, _Seen, FloatArray]  # a log, what it shows of gaps, what is asked of its drive


class _Slowly(NamedTuple):
    """By row at 1/_SLOWLY Hz (n,): stamps [s], speed [m/s], acceleration [m/s^2], and whether the drive may show in it;
    by row of the log (m,): stamps, and what the drive is asked for [m/s^2]."""

    t: FloatArray
    speed: FloatArray
    accel: FloatArray
    shows: BoolArray
    asked_at: FloatArray
    asked: FloatArray


def _slowly(e: Experiment, asked: FloatArray) -> _Slowly:
    """What a log shows of the force of its drive."""
    t, motion = e.log.t, filled(e.log.t, e.measured)
    rows = np.arange(t[0], t[-1], _SLOWLY)
    speed = np.abs(_mean(t, motion[:, _V], rows, _SLOWLY))
    if np.isfinite(e.measured[:, _AX]).any():
        accel = _mean(t, motion[:, _AX], rows, _SLOWLY)
    else:
        accel = np.gradient(speed, _SLOWLY) if len(rows) > 1 else np.full(len(rows), np.nan)
    known = np.isfinite(accel) & np.isfinite(speed)
    shows = known & (speed > _SLOW) & (np.interp(rows, t, asked) > _PRESSED)
    return _Slowly(rows, np.where(known, speed, 0.0), np.where(known, accel, 0.0), shows, t, np.maximum(asked, 0.0))


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
def _pulled(
    speed: FloatArray, asked: FloatArray, accel: FloatArray, shows: BoolArray, step: float,
    firsts: FloatArray, steps: FloatArray, demands: FloatArray, falls: FloatArray, gap: float,
) -> FloatArray:  # fmt: skip
    """For each gearbox and fall: all products of pull, pull in gaps, one, squared speed and acceleration, summed."""
    sums = np.zeros((len(firsts), len(steps), len(demands), len(falls), 5, 5))
    up, pulls = np.zeros(_GEARS), np.ones((_GEARS, len(falls)))
    in_gear = np.zeros((_GEARS, 2, 4))  # sums without and within gaps of asked^2, asked, asked v^2, asked accel
    for i in range(len(firsts)):
        for j in range(len(steps)):
            up[0], ratio = firsts[i], steps[j]
            for gear in range(1, _GEARS):
                up[gear] = up[gear - 1] * max(ratio, LEAST)
                for m in range(len(falls)):
                    pulls[gear, m] = pulls[gear - 1, m] / max(ratio, LEAST) ** falls[m]
                ratio /= PROGRESSION
            for k in range(len(demands)):
                in_gear[:] = 0.0
                gear, since = 0, 1e9
                while gear < _GEARS - 1 and speed[0] >= up[gear] * (1.0 + demands[k] * (asked[0] - DEMAND)):
                    gear += 1
                for n in range(len(speed)):
                    later = 1.0 + demands[k] * (asked[n] - DEMAND)
                    if gear < _GEARS - 1 and asked[n] > 0.0 and speed[n] >= up[gear] * later:
                        gear, since = gear + 1, 0.0
                    elif gear > 0 and speed[n] < BACK * up[gear - 1] * later:
                        gear, since = gear - 1, 0.0
                    if shows[n]:
                        held = in_gear[gear, 1 if since < gap else 0]
                        held[0] += asked[n] * asked[n]
                        held[1] += asked[n]
                        held[2] += asked[n] * speed[n] * speed[n]
                        held[3] += asked[n] * accel[n]
                    since += step
                for m in range(len(falls)):
                    one = sums[i, j, k, m]
                    for gear in range(_GEARS):
                        for within in range(2):
                            held, pull = in_gear[gear, within], pulls[gear, m]
                            for a in range(within + 1):
                                for b in range(within + 1):
                                    one[a, b] += pull * pull * held[0]
                                for b in range(1, 4):
                                    one[a, b + 1] += pull * held[b]
                    for a in range(2):
                        for b in range(2, 5):
                            one[b, a] = one[a, b]
    others = np.ones((3, len(speed)))
    others[0], others[1], others[2] = shows * 1.0, shows * speed * speed, shows * accel
    sums[..., 2:, 2:] += others @ others.T
    return sums


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
