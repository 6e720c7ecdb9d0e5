"""The cases of a parameter value distribution: counted without being built, each made when it is asked for."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Final, Protocol

from openscenario.draws import Inverse, inverse, share
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.distributions import (
    Deterministic,
    DeterministicMultiParameterDistribution,
    DeterministicParameterDistribution,
    DistributionFile,
    DistributionRange,
    DistributionSet,
    Stochastic,
)
from openscenario.values import spelled

MOST: Final = 2**63 - 1  # cases; the number of one still fits 64 bits
WHOLE: Final = ("integer", "int", "unsignedInt", "unsignedShort")
_SLACK: Final = Fraction(1, 10**9)  # of a step: limits that were computed end in ...999 or ...001

Values = dict[str, str]


@dataclass(frozen=True, slots=True)
class Cases:
    """The cases of a distribution. `count`: how many; `scenario`: what they vary; `varied`: names that differ at all.

    `cases[n]`: the values of case n, 0 <= n < count, by parameter, as a file spells them.
    """

    count: int
    scenario: Path | None
    varied: tuple[str, ...]
    _values: Callable[[int], Values]

    def __getitem__(self, number: int) -> Values:
        if not 0 <= number < self.count:
            raise IndexError(f"case {number} of {self.count}")
        return self._values(number)

    def __iter__(self) -> Iterator[Values]:
        return (self._values(number) for number in range(self.count))

    def sample(self, size: int, seed: int) -> list[int]:
        """The numbers of `size` cases, ascending; all, if there are no more. Same seed, same numbers."""
        if size >= self.count:
            return list(range(self.count))
        return sorted(random.Random(seed).sample(range(self.count), size))


class Axis(Protocol):
    """What one deterministic distribution contributes: `count` values of its parameters."""

    @property
    def count(self) -> int:
        """How many values it has, at least 0."""

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that it sets."""

    def __call__(self, number: int) -> Values: ...


@dataclass(frozen=True, slots=True)
class Rows:
    """Values that are listed."""

    rows: Sequence[Values]

    @property
    def count(self) -> int:
        """How many rows are listed."""
        return len(self.rows)

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters of all rows, in the order in which they first appear."""
        return tuple(dict.fromkeys(name for row in self.rows for name in row))

    def __call__(self, number: int) -> Values:
        return self.rows[number]


@dataclass(frozen=True, slots=True)
class Steps:
    """Values from `low` in steps; computed in decimals as the file has them, so that 1.1 + 0.2 is 1.3."""

    name: str
    low: Fraction
    step: Fraction
    high: Fraction

    @classmethod
    def of(cls, name: str, distribution: DistributionRange) -> Steps:
        """The steps of a DistributionRange, as exact decimals, for the parameter `name`."""
        limits = distribution.range
        low, step, high = (
            Fraction(repr(value)) for value in (limits.lower_limit, distribution.step_width, limits.upper_limit)
        )
        return cls(name, low, step, high)

    @property
    def count(self) -> int:
        """How many steps lie between both ends, ends included; 0 if the upper limit lies below the lower."""
        return 0 if self.high < self.low else math.floor((self.high - self.low) / self.step + _SLACK) + 1

    @property
    def names(self) -> tuple[str, ...]:
        """The one parameter that is varied."""
        return (self.name,)

    def value(self, number: int) -> float:
        """The value of step `number`, counted from 0, in the unit of the parameter; never above the upper limit."""
        return float(min(self.low + number * self.step, self.high))

    def __call__(self, number: int) -> Values:
        return {self.name: spelled(self.value(number))}


def cases_of(file: DistributionFile, declared: Sequence[ParameterDeclaration] = (), *, seed: int = 7) -> Cases:
    """The cases of a distribution that was read without errors.

    Deterministic: every combination, the last distribution of the file changes fastest. Stochastic: numberOfTestRuns
    draws from its randomSeed.

    Args:
        declared: parameters of the scenario: a drawn number for a whole one is rounded to the nearest.
        seed: of a stochastic distribution that names none.
    """
    definition = file.distribution.definition
    scenario = file.distribution.scenario_file.path
    if isinstance(definition, Stochastic):
        return _stochastic(definition, scenario, declared, seed)
    axes = [axis(distribution) for distribution in definition.distributions]
    varied = tuple(name for each in axes if each.count > 1 for name in each.names)
    return Cases(count_of(definition), scenario, varied, lambda number: _combination(axes, number))


def count_of(definition: Deterministic | Stochastic) -> int:
    """How many cases a distribution has; none of them is built."""
    if isinstance(definition, Stochastic):
        return definition.number_of_test_runs
    return math.prod(axis(distribution).count for distribution in definition.distributions)


def axis(distribution: DeterministicParameterDistribution) -> Axis:
    """The values of one deterministic distribution; one of the user's own has none."""
    if isinstance(distribution, DeterministicMultiParameterDistribution):
        sets = distribution.value_set_distribution.parameter_value_sets
        return Rows([{a.parameter_ref.removeprefix("$"): a.value for a in row.parameter_assignments} for row in sets])
    match distribution.distribution:
        case DistributionSet(elements=elements):
            return Rows([{distribution.parameter_name: element.value} for element in elements])
        case DistributionRange() as steps:
            return Steps.of(distribution.parameter_name, steps)
    return Rows([])


def _combination(axes: Sequence[Axis], number: int) -> Values:
    parts: list[Values] = []
    for each in reversed(axes):
        number, place = divmod(number, each.count)
        parts.append(each(place))
    return {name: value for part in reversed(parts) for name, value in part.items()}


def _stochastic(
    definition: Stochastic, scenario: Path | None, declared: Sequence[ParameterDeclaration], seed: int
) -> Cases:
    kinds = {declaration.name: declaration.parameter_type for declaration in declared}
    used = float(seed) if definition.random_seed is None else definition.random_seed
    drawn: Mapping[str, Inverse] = {
        each.parameter_name: inverse(each.distribution) for each in definition.stochastic_distributions
    }

    def values(number: int) -> Values:
        return {name: _spelled(draw(share(used, name, number)), kinds.get(name)) for name, draw in drawn.items()}

    return Cases(definition.number_of_test_runs, scenario, tuple(drawn), values)


def _spelled(value: float | str, kind: str | None) -> str:
    if isinstance(value, str):
        return value
    return spelled(round(value) if kind in WHOLE else value)
