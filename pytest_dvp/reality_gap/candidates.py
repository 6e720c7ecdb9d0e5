"""Which effects are tried on a log, and from where a fit of each begins."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable
from math import inf, isinf

import numpy as np

from pytest_dvp.reality_gap.fit import Coordinate
from vehicle.model.effect import Effect, Key
from vehicle.model.model import VehicleModel

_NEED_DATA = ("accel_controller", "motor_damping", "motor_inertia", "motor_torque")
"""Parts of a drive train whose data sheet must be known: tried only on a model that has one of them."""
_POINTS = 5  # of one parameter
_POINTS_EACH = 4  # of two


@dataclasses.dataclass(frozen=True, slots=True)
class Candidate:
    """An effect to be tried: its coordinates, and points (each a value for every key) from the strongest on."""

    effect: Effect
    coordinates: tuple[Coordinate, ...]
    points: tuple[dict[tuple[str, str], float], ...]

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


def candidates(model: VehicleModel, effects: Iterable[Effect], *, ay: bool = False) -> tuple[Candidate, ...]:
    """What can be tried on a model, in the order of `effects`: those that suit its base and its inputs.

    ay: lateral acceleration is measured. On a car whose tyres slip it matters where, and logs seldom say: both usual
    places, rear axle and centre of gravity, are tried, unless the model names one.
    """
    places = (0.0, model.car.cg_to_rear_axle) if ay and model.car.ay_x == 0.0 else ()
    present = {a.name for a in model.effects}
    found = []
    for effect in effects:
        if effect.slot == "perception" or model.base not in effect.base:
            continue
        if effect.name in _NEED_DATA and not present & set(_NEED_DATA):
            continue
        if effect.name == "speed_controller" and model.inputs.longitudinal != ("speed_cmd",):
            continue
        coordinates = tuple(Coordinate(effect.name, key) for key in effect.parameters)
        points = _points(coordinates)
        if effect.tyres and places:
            points = tuple({**point, ("parameters", "ay_x"): place} for point in points for place in places)
        found.append(Candidate(effect, coordinates, points))
    return tuple(found)


def _points(coordinates: tuple[Coordinate, ...]) -> tuple[dict[tuple[str, str], float], ...]:
    count = _POINTS if len(coordinates) == 1 else _POINTS_EACH if len(coordinates) == 2 else 2
    lines = [_line(c, count) for c in coordinates]
    points = [dict(zip((c.name for c in coordinates), values, strict=True)) for values in itertools.product(*lines)]
    return tuple(sorted(points, key=lambda p: -sum(_strength(c, p[c.name]) for c in coordinates)))


def _line(c: Coordinate, count: int) -> list[float]:
    """Values spread over the range without the neutral one."""
    if c.key.neutral <= c.key.low or isinf(c.key.neutral):
        first = 0.0 if c.key.low != c.key.neutral else 1.0 / count
        return [c.value(float(u)) for u in np.linspace(first, 1.0, count)]
    if c.key.unit == "rad" and c.key.name == "heading":  # a direction: all round
        return [2.0 * np.pi * k / count for k in range(count)]
    return [c.value((k + 0.5) / (count + 1 - count % 2)) for k in range(count + 1 - count % 2)
            if abs(c.value((k + 0.5) / (count + 1 - count % 2)) - c.key.neutral) > 1e-9]  # fmt: skip


def _strength(c: Coordinate, value: float) -> float:
    """How far a value is from doing nothing, 0..1."""
    if c.key.neutral == inf:
        return 1.0 - c.place(value)
    return abs(c.place(value) - c.place(c.key.neutral)) if not isinf(c.key.neutral) else 0.0


def least(key: Key, value: float) -> bool:
    """True if a value is far enough from neutral to be worth naming."""
    if isinf(key.neutral):
        return True
    return abs(value - key.neutral) >= key.least
