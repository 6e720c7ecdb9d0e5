"""A car whose residuals are linear in the values of its effects, so that what a search must find follows by hand."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model
from vehicle.model.remainder_shape import RemainderShape

ROWS, SEGMENTS = 1000, 50
DRIVE, BRAKE = ("drive_gain", "g"), ("brake_gain", "g")
MOTOR = ("brake_gain", "motor")  # what a motor takes over: none here
MODEL = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n")
NEUTRAL = {(name, key.name): key.neutral for name in ("drive_gain", "brake_gain", "mass", "steer_ratio", "steer_offset",
           "gyro_bias", "rolling_resistance", "aero_drag", "viscous_resistance", "brake_fade", "steer_asymmetry",
           "brake_limit", "body_roll", "gear_inertia") for key in find_effect(name).parameters}  # fmt: skip
_BASIS = np.linalg.qr(np.random.default_rng(0).normal(size=(ROWS, 12)))[0].T
NOISE = np.where(np.random.default_rng(1).random(ROWS) < 0.5, 1.0, -1.0)
NOISE = NOISE - _BASIS.T @ (_BASIS @ NOISE)
NOISE *= np.sqrt(ROWS / (NOISE @ NOISE))


def direction(k: int, other: int = 0, share: float = 0.0) -> FloatArray:
    """A vector (ROWS,) of length 1, at right angles to those of other numbers and to the noise; share: of `other`."""
    return np.asarray(np.sqrt(1.0 - share**2) * _BASIS[k] + share * _BASIS[other])


@dataclasses.dataclass(eq=False)
class World:
    """does: (effect, key) -> what one unit of it adds to the residual (ROWS,); hidden: values of the car."""

    does: dict[tuple[str, str], FloatArray]
    hidden: dict[tuple[str, str], float] = dataclasses.field(default_factory=dict)
    noise: FloatArray = dataclasses.field(default_factory=lambda: NOISE)
    excused: bool = False
    lasts: bool = False
    channels: dict[str, float] | None = None
    other: World | None = None
    count: int = ROWS
    sample: float = 0.02
    known: dict[str, float] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        self.settled: list[Any] = []
        self.model: Any = SimpleNamespace(
            effects=[], remainder_shape=RemainderShape(), car=SimpleNamespace(wheelbase=2.7)
        )
        self.experiments = [SimpleNamespace(model=self.model)]

    def whitened(self, values: Any) -> FloatArray:
        found = self.noise.copy()
        for key, row in self.does.items():
            found += (values.get(key, NEUTRAL[key]) - self.hidden.get(key, NEUTRAL[key])) * row
        return found

    def lasting(self) -> Any:
        return self.other or self

    def reckoned(self) -> Any:
        return self

    def settle(self, values: Any) -> None:
        self.settled.append(dict(values))

    def starts(self) -> Any:
        return np.arange(0, ROWS, ROWS // SEGMENTS)

    def by_segment(self, whitened: FloatArray) -> FloatArray:
        return np.asarray((whitened**2).reshape(SEGMENTS, -1).sum(axis=1))

    def by_channel(self, values: Any) -> dict[str, float]:
        left = self.whitened(values)
        return self.channels if self.channels is not None else {"v": float(left @ left) / self.count}

    def anew(self) -> dict[str, float]:
        return defaultdict(lambda: 1.0, self.known)

    def rmse(self, values: Any) -> dict[str, float]:
        return {"v": float(np.sqrt(np.mean(self.whitened(values) ** 2)))}


def tried(*names: str) -> tuple[Candidate, ...]:
    """Candidates of these effects."""
    return candidates(MODEL, [find_effect(name) for name in names], refined=True)


def a_search(world: World, *names: str, refiners: tuple[str, ...] = ()) -> Search:
    """A search for these effects in a world."""
    return Search(world, tried(*names), refiners=tried(*refiners))  # type: ignore[arg-type]


def a_trial(chi2: float, *names: str, segments: Any = None, values: Any = None, fitted: int = 1) -> Trial:
    """A set of effects that leaves so much, evenly over all segments."""
    coordinates = tuple(Coordinate(name, find_effect(name).parameters[0]) for name in names)[:fitted]
    fit = Fit(coordinates, {}, np.zeros(1), chi2, np.zeros((len(coordinates), 1)))
    rows = np.full(SEGMENTS, chi2 / SEGMENTS) if segments is None else segments
    return Trial(names, values or {}, fit, rows)


class Given(Search):
    """A search in which a set leaves a given chi^2, whatever its values; vague: effects whose value means nothing."""

    leaves: dict[frozenset[str], float]
    vague: tuple[str, ...] = ()

    def trial(self, names: Any, start: Any, **options: Any) -> Trial:  # type: ignore[override]
        rows = np.full(50, self.leaves.get(frozenset(names), 9e3) / 50.0)
        parts = tuple(Coordinate(name, self.known[name].effect.parameters[0]) for name in names)
        fit = Fit(parts, {}, np.zeros(1), float(rows.sum()), np.zeros((len(parts), 1)))
        return Trial(tuple(names), dict(start), fit, rows)

    def is_credible(self, trial: Trial, name: str, target: Any = None, certain: bool = True) -> bool:
        return name not in self.vague

    def misfit(self, now: Trial) -> bool:
        return now.chi2 > 1300.0

    def _matters(self, trial: Trial, name: str, target: Any) -> bool:
        return True

    def _scan(self, now: Trial, names: Any, needed: float = 0.0) -> Any:
        sets = {name: frozenset((*now.names, name)) for name in names if name not in now.names}
        return sorted((self.leaves.get(each, 9e3), name, {}) for name, each in sets.items())


def given(leaves: dict[str, float], *names: str, refiners: tuple[str, ...] = (), excused: bool = False,
          channels: float = 3.0, vague: tuple[str, ...] = ()) -> Given:  # fmt: skip
    """leaves: chi^2 by names with a blank between."""
    world = World({}, excused=excused, channels={"v": channels})
    found = Given(world, tried(*names), refiners=tried(*refiners))  # type: ignore[arg-type]
    found.leaves, found.vague = {frozenset(key.split()): value for key, value in leaves.items()}, vague
    return found


class SettledSearch:
    """A search of which all that was found is credible, and to whose sets nothing is added or taken away."""

    def __init__(self) -> None:
        self.count = 1000
        self.target = SimpleNamespace(excused=False, settle=lambda values: None)

    def tick(self, text: str) -> None: ...

    def is_credible(self, trial: Any, name: str) -> bool:
        return True

    def grown(self, trial: Any, turns: Any) -> Any:
        return trial

    def pruned(self, trial: Any) -> Any:
        return trial


class Applied:
    """A model with effects that have the values given, all other things of `linear_world`."""

    def __init__(self, **values: float) -> None:
        self.effects = [SimpleNamespace(name=n, effect=find_effect(n), values={find_effect(n).parameters[0].name: v})
                        for n, v in values.items()]  # fmt: skip


class Having(World):
    """A world whose model has gains of 0.9, which the car lacks or not."""

    def whitened(self, values: Any) -> Any:
        return super().whitened({DRIVE: 0.9, BRAKE: 0.9} | dict(values))


class Limited(World):
    """What a limit does is in proportion to its inverse."""

    def whitened(self, values: Any) -> Any:
        rows = [(1.0 / values.get(key, inf) - 1.0 / self.hidden[key]) * row for key, row in self.does.items()]
        return self.noise + np.sum(rows, axis=0)
