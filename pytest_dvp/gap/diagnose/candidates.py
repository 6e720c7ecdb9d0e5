"""Which effects are tried on a log, and from where a fit of each begins."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import inf, isfinite, isinf
from typing import TypeAlias

import numpy as np

from pytest_dvp.gap.diagnose.input_scales import input_map
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit
from pytest_dvp.gap.diagnose.ranges_by_size import usual_range
from vehicle.model.effect import Effect, Key
from vehicle.model.vehicle_model import VehicleModel

_FINER = ("lead", "inertia", "release", "brakes", "braking")  # keys that only a fit finds: no grid begins with them
_SHAPE = (
    "heading",
    "tau",
    "v0",
    "v1",
    "step",
    "demand",
    "frequency",
    "damping",
    *_FINER,
)  # keys that say how, not how much
BEYOND = 1e-6  # of a range, for rounding
_FINE = (5, 4, 2)  # points of each coordinate of an effect with one, two, more
_LIMITS = 9  # points of a limit: between one that is never met and one always met the error has a narrow valley
_COARSE = (3, 3, 2)
_VAGUE = 0.33  # of a limit's range: an interval wider than that says nothing
_CLEAR_OF_NEUTRAL = 1.2  # half-widths of the 95 % interval, three standard deviations


Point: TypeAlias = dict[tuple[str, str], float]


@dataclasses.dataclass(frozen=True, slots=True)
class Candidate:
    """An effect to be tried: its coordinates, and points (each a value for every key) from the strongest on.

    coarse: fewer of them, for when the model is nearly right and the fit finds the rest. own: what the model has of
    it already, from where it may change; {} if it lacks it. seen: values that a log shows without any model, {} if it
    shows none. detail: tried only where nothing plainer pays.
    """

    effect: Effect
    coordinates: tuple[Coordinate, ...]
    points: tuple[Point, ...]
    coarse: tuple[Point, ...]
    own: Mapping[tuple[str, str], float] = dataclasses.field(default_factory=dict)
    seen: Mapping[tuple[str, str], float] = dataclasses.field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def detail(self) -> bool:
        """See the class."""
        return bool(self.effect.diagnosed.details)

    def is_tied(self, other: Candidate) -> bool:
        """True if the two effects are often confused."""
        return other.name in self.effect.ties or self.name in other.effect.ties

    def weaker(self, point: Point, share: float) -> list[Point]:
        """The point with its effect on the car reduced to `share`, none if its strength has no zero (a limit). Of an
        effect that the model has, that share of the way from there to the point."""
        found = dict(point)
        if self.own:
            for c in sizes(self.coordinates):
                if not isfinite(self.own[c.name]):
                    return []
                found[c.name] = self.own[c.name] + share * (point[c.name] - self.own[c.name])
            return [found]
        for c in self.coordinates:
            if says_how(c.key):
                continue
            if isinf(c.key.neutral):
                return []
            found[c.name] = c.key.neutral + share * (point[c.name] - c.key.neutral)
        return [found]


def candidates(
    model: VehicleModel, effects: Iterable[Effect], *, ay: bool = False, refined: bool = False
) -> tuple[Candidate, ...]:
    """What can be tried on a model, in the order of `effects`: those that suit its base and its inputs.

    ay: lateral acceleration is measured. On a car whose tyres slip it matters where, and logs seldom say: both usual
    places, rear axle and centre of gravity, are tried, unless the model names one.
    refined: also effects that refine a constant one (`Diagnosed.refines`) and are not in the model yet. A search
    tries them at its end only: they can do what many others do, which would make it slower and less sure.
    """
    places = (0.0, model.car.cg_to_rear_axle) if ay and model.car.ay_x == 0.0 else ()
    present = {a.name: {(a.name, key): value for key, value in a.values.items()} for a in model.effects}
    groups = {a.effect.diagnosed.needs for a in model.effects}
    scales = {c.key.name for c in input_map(model)[0]}
    found = []
    for effect in effects:
        if effect.slot == "perception" or model.base not in effect.base:
            continue
        tried = effect.diagnosed
        if tried.refines and not refined and effect.name not in present:
            continue
        if tried.needs and tried.needs not in groups:
            continue
        if tried.input and model.inputs.longitudinal != (tried.input,):
            continue
        coordinates = tuple(
            Coordinate(effect.name, key, tried.grid_points > 0, _samples_unsure(effect, key), bool(tried.grid))
            for key in (usual_range(each, model.car.wheelbase) for each in effect.parameters)
            if key.name not in tried.held and not any((s, key.name) in tried.scaled_by for s in scales)
        )
        mounts = places if effect.tyres else ()
        limit = len(coordinates) == 1 and isinf(coordinates[0].key.neutral)
        fine, coarse = (
            (tried.grid_points,) if tried.grid_points else each for each in ((_LIMITS,) if limit else _FINE, _COARSE)
        )
        own, grid = present.get(effect.name, {}), dict(tried.grid)
        points, few = (_points(coordinates, n, mounts, grid, own) for n in (fine, coarse))
        found.append(Candidate(effect, coordinates, points, few, own))
    return tuple(found)


def _samples_unsure(effect: Effect, key: Key) -> float:
    """Share of a sample by which a dead time is never known, 0 for what is none."""
    return effect.diagnosed.delay_error if key.name == effect.delay else 0.0


def _points(
    coordinates: tuple[Coordinate, ...],
    counts: tuple[int, ...],
    places: tuple[float, ...],
    grid: Mapping[str, tuple[float, ...]],
    own: Mapping[tuple[str, str], float],
) -> tuple[Point, ...]:
    count = counts[min(len(coordinates), len(counts)) - 1]
    names = [c.name for c in coordinates]
    lines = (grid.get(c.key.name) or _line(c, count, own.get(c.name, inf)) for c in coordinates)
    points: list[Point] = [dict(zip(names, values, strict=True)) for values in itertools.product(*lines)]
    points.sort(key=lambda p: -sum(_strength(c, p[c.name]) for c in coordinates))
    if places:
        points = [{**point, ("parameters", "ay_x"): place} for point in points for place in places]
    return tuple(points)


def _line(c: Coordinate, count: int, own: float) -> list[float]:
    """Values spread over the range without the neutral one; of a key that only a fit finds, the model's own, if it has
    one (finite)."""
    if is_finer(c.key):
        return [own if isfinite(own) else c.key.neutral]
    if c.key.name == "heading":  # the slope has both signs, so half the way round is all round
        return [np.pi * k / count for k in range(count)]
    if c.key.neutral <= c.key.low or isinf(c.key.neutral):
        first = 0.0 if c.key.low != c.key.neutral else 1.0 / count
        return [c.value(float(u)) for u in np.linspace(first, 1.0, count)]
    odd = count + 1 - count % 2
    middle = [c.value((k + 0.5) / odd) for k in range(odd)]
    return [value for value in middle if abs(value - c.key.neutral) > 1e-9]


def _strength(c: Coordinate, value: float) -> float:
    """How far a value is from doing nothing, 0..1."""
    if c.key.neutral == inf:
        return 1.0 - c.to_unit(value)
    return abs(c.to_unit(value) - c.to_unit(c.key.neutral)) if not isinf(c.key.neutral) else 0.0


def is_finer(key: Key) -> bool:
    """True for a key that only a fit finds, from its neutral value on."""
    return key.late or key.name in _FINER


def candidates_of(model: VehicleModel, names: Collection[str]) -> list[Candidate]:
    """Effects that a model has, to be fitted again: with those of their parameters that are switched on."""
    found: list[Candidate] = []
    for applied in model.effects:
        keys = (usual_range(k, model.car.wheelbase) for k in applied.effect.parameters)
        on = tuple(Coordinate(applied.name, k) for k in keys if isfinite(applied.values[k.name]))
        if applied.name in names and on:
            found += [dataclasses.replace(c, coordinates=on) for c in candidates(model, [applied.effect], refined=True)]
    return found


def says_how(key: Key) -> bool:
    """True for a key that says how an effect acts, or where, not how much."""
    return key.late or key.where or key.name in _SHAPE


def sizes(coordinates: Sequence[Coordinate]) -> Sequence[Coordinate]:
    """Those that say how much, not how; of an effect that only says how (a lag) all."""
    return [c for c in coordinates if not says_how(c.key)] or coordinates


def without_finer(found: Fit, name: str) -> Fit:
    """The fit as if the keys that say how an effect acts were known: whether it is there at all does not hang on them,
    and what shows in three segments cannot have five values."""
    sized = sizes([c for c in found.coordinates if c.effect == name])
    kept = [k for k, c in enumerate(found.coordinates) if c.effect != name or c in sized or not is_finer(c.key)]
    return dataclasses.replace(
        found, coordinates=tuple(found.coordinates[k] for k in kept), jacobian=found.jacobian[kept]
    )


def is_usual(key: Key, value: float) -> bool:
    """True if a value is not farther from doing nothing than the range that is met in practice."""
    slack = BEYOND * (key.high - key.low)
    if isinf(key.neutral):  # a limit that is hardly met does little
        return value >= key.low - slack
    if key.neutral <= key.low:
        return value <= key.high + slack
    if key.neutral >= key.high:
        return value >= key.low - slack
    return key.low - slack <= value <= key.high + slack


def has_price(c: Coordinate, values: Mapping[tuple[str, str], float]) -> bool:
    """False for a value that comes late and is too near to doing nothing to be worth a name: it is as good as none."""
    return not c.key.late or is_worth_naming(c.key, values[c.name])


def is_worth_naming(key: Key, value: float) -> bool:
    """True if a value is far enough from neutral to be worth naming."""
    if isinf(key.neutral):
        return True
    return abs(value - key.neutral) >= key.least


def is_certain(c: Coordinate, value: float, interval: tuple[float, float]) -> bool:
    """True if the 95 % interval is clear of the neutral value, for a limit if it is no wider than a third of its range;
    value and interval in the unit of the value."""
    low, high = interval
    if not low < high:  # nothing that was measured moves with it
        return False
    if isinf(c.key.neutral):
        return c.to_unit(high) - c.to_unit(low) < _VAGUE
    return abs(value - c.key.neutral) > _CLEAR_OF_NEUTRAL * 0.5 * (high - low)
