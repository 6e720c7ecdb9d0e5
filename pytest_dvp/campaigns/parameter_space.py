"""The space of a campaign: one axis for each thing that varies, from shares of its probability to values."""

from __future__ import annotations

import dataclasses
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from pytest_dvp.campaigns.constraint_range import WORDS, FuzzError, Range, joined, widest_ranges
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.errors import SettingError

if TYPE_CHECKING:
    from openscenario.model.declarations import ParameterDeclaration
    from openscenario.model.distributions import DistributionFile

Shares: TypeAlias = tuple[float, ...]
"""A point: for each axis the share of its probability that lies below the value, 0 to 1."""
Values: TypeAlias = dict[str, str]

DIGITS = 6  # significant digits of a drawn number: what a person can type again, and what is hashed
FINE = 4  # decimals of a range's width that a number has at least: a narrow range far from 0 needs more than DIGITS


@dataclasses.dataclass(frozen=True)
class Axis:
    """One independent thing that varies.

    name     the parameter, or several joined by "+" where a distribution sets them together
    at       the values at a share 0 to 1 of the probability
    nominal  the values that the scenario declares
    count    how many different values there are; None for a continuous range
    weights  of the values of a list, more than 0; empty: all alike
    endless  True for a distribution that has no least or no greatest value
    """

    name: str
    at: Callable[[float], Values]
    nominal: Values
    count: int | None
    weights: tuple[float, ...] = ()
    endless: bool = False

    def middle(self, k: int) -> float:
        """The middle of the shares of value `k` of a list."""
        assert self.count is not None
        if self.weights:
            return (sum(self.weights[:k]) + 0.5 * self.weights[k]) / sum(self.weights)
        return (k + 0.5) / self.count

    def number_of(self, values: Mapping[str, str]) -> int | None:
        """Which value of a list these are; None if it has them not."""
        for k in range(self.count or 0):
            if all(_same(self.at(self.middle(k))[n], values[n]) for n in self.nominal):
                return k
        return None

    def even_share_of(self, values: Mapping[str, str]) -> float:
        """As `share_of`, but each value of a list takes as much of 0 to 1 as any other, however seldom it is drawn."""
        number = self.number_of(values)
        return self.share_of(values) if number is None else (number + 0.5) / (self.count or 1)

    def share_of(self, values: Mapping[str, str]) -> float:
        """A share at which these values lie: by halving for a number, by trying for a list. 0.5 if none has them."""
        if self.count is not None:
            number = self.number_of(values)
            return 0.5 if number is None else self.middle(number)
        wanted = float(values[self.name])
        edges = []
        for inside in (operator.lt, operator.le):
            low, high = 0.0, 1.0
            for _ in range(50):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if inside(float(self.at(middle)[self.name]), wanted) else (low, middle)
            edges.append(0.5 * (low + high))
        return 0.5 * (edges[0] + edges[1])  # the middle of what is rounded to this value


@dataclasses.dataclass(frozen=True)
class Space:
    """What a campaign varies of one scenario: `file` as it was named, `scenario` that is driven, `gates` beside a
    distribution (None: those of the scenario), and the axes."""

    file: Path
    scenario: Path
    gates: Path | None
    axes: tuple[Axis, ...]

    def values(self, shares: Shares) -> Values:
        """The values of all parameters that vary, as a file spells them."""
        found: Values = {}
        for axis, share in zip(self.axes, shares, strict=True):
            found |= axis.at(min(max(share, 0.0), 1.0))
        return found

    @property
    def nominal(self) -> Values:
        """What the scenario itself declares for the parameters that vary."""
        return {name: value for axis in self.axes for name, value in axis.nominal.items()}

    @property
    def nominal_shares(self) -> Shares:
        """The point of the nominal values, or the nearest one."""
        return tuple(axis.share_of(axis.nominal) for axis in self.axes)


def space_of(path: Path, settings: RunSpec) -> Space:
    """The space of a scenario with constraint groups, or of a parameter distribution.

    Raises ScenarioError for a file that is wrong, FuzzError and SettingError where nothing can vary.
    """
    from openscenario.read import read_declarations, read_distribution
    from pytest_dvp.campaigns.cases import is_distribution

    if is_distribution(path):
        file = read_distribution(path, library=settings.library, rootdir=settings.rootdir)
        scenario = file.distribution.scenario_file.path
        if scenario is None:
            raise SettingError(f"{path}: names no scenario")
        declared = {each.name: each for each in read_declarations(scenario)}
        beside = path.with_name(f"{path.stem}.gates.toml")
        axes = _distributed(file, declared)
        space = Space(path, scenario, beside if beside.is_file() else None, axes)
    else:
        every = read_declarations(path)
        ranges = widest_ranges(path, every, settings.set.scenario)
        axes = tuple(_constrained(each, ranges.get(each.name, [])) for each in every if each.constraint_groups)
        space = Space(path, path, None, axes)
    axes = tuple(axis for axis in space.axes if axis.name.split("+")[0] not in settings.set.scenario)
    if not axes:
        raise FuzzError(f"{path}: no parameter has a ConstraintGroup or a distribution, so there is nothing to vary")
    return dataclasses.replace(space, axes=axes)


def _constrained(declared: ParameterDeclaration, ranges: Sequence[Range]) -> Axis:
    """An axis of a declaration: evenly over the lengths of its ranges, or over its words."""
    name = declared.name
    if declared.parameter_type in WORDS:
        words = [c.value for group in declared.constraint_groups for c in group.value_constraints]
        return _listed(
            name, [{name: word} for word in dict.fromkeys([str(declared.value), *words])], _declared(declared)
        )
    whole = declared.parameter_type not in ("double", "float")
    ranges = joined(ranges)
    spans = [each.high - each.low + (1.0 if whole else 0.0) for each in ranges]
    total = sum(spans)
    if total <= 0.0:
        return _listed(name, [{name: _inside(each.low, whole, each.low, each.high)} for each in ranges],
                       _declared(declared))  # fmt: skip

    places = DIGITS - math.ceil(math.log10(total))

    def at(share: float) -> Values:
        way = share * total
        for each, span in zip(ranges, spans, strict=True):
            if way <= span:
                value = min(each.low + (way // 1.0 if whole else round(way, places)), each.high)
                return {name: _inside(value, whole, each.low, each.high)}
            way -= span
        return {name: _inside(ranges[-1].high, whole, ranges[-1].low, ranges[-1].high)}

    return Axis(name, at, {name: _declared(declared)}, round(total) if whole and total < 1e6 else None)


def _distributed(file: DistributionFile, declared: Mapping[str, ParameterDeclaration]) -> tuple[Axis, ...]:
    from openscenario.distributions import WHOLE, axis
    from openscenario.draws import inverse
    from openscenario.model.distributions import (
        LogNormalDistribution,
        NormalDistribution,
        PoissonDistribution,
        ProbabilityDistributionSet,
        Stochastic,
    )

    definition = file.distribution.definition
    axes: list[Axis] = []
    if isinstance(definition, Stochastic):
        for each in definition.stochastic_distributions:
            name = each.parameter_name
            weights: tuple[float, ...] = ()
            if isinstance(each.distribution, ProbabilityDistributionSet):
                weights = tuple(element.weight for element in each.distribution.elements if element.weight > 0.0)
            draw, whole = inverse(each.distribution), declared[name].parameter_type in WHOLE
            low, high, common = draw(0.0), draw(1.0), (draw(0.001), draw(0.999))

            def at(share: float, name: str = name, draw: Callable[[float], float | str] = draw, whole: bool = whole,
                   low: Any = low, high: Any = high, common: Any = common) -> Values:  # fmt: skip
                value = draw(min(max(share, 1e-15), 1.0 - 1e-15))
                return {name: value if isinstance(value, str) else _inside(value, whole, low, high, common)}

            endless = (
                isinstance(each.distribution, NormalDistribution | LogNormalDistribution | PoissonDistribution)
                and each.distribution.range is None
            )
            axes.append(Axis(name, at, {name: _declared(declared[name])}, len(weights) or None, weights, endless))
        return tuple(axes)
    for one in definition.distributions:
        steps = axis(one)
        if steps.count < 1:
            continue

        nominal = {name: _declared(declared[name]) for name in steps.names}

        def step(share: float, steps: Callable[[int], Values] = steps, count: int = steps.count,
                 nominal: Values = nominal) -> Values:  # fmt: skip
            return {**nominal, **steps(min(int(share * count), count - 1))}  # a set may leave one as declared

        axes.append(Axis("+".join(steps.names), step, nominal, steps.count))
    return tuple(axes)


def _listed(name: str, rows: Sequence[Values], nominal: str) -> Axis:
    def at(share: float) -> Values:
        return dict(rows[min(int(share * len(rows)), len(rows) - 1)])

    return Axis(name, at, {name: nominal}, len(rows))


def _declared(declared: ParameterDeclaration) -> str:
    """A declared number as drawn ones are spelled, so that 60.0 and 60 are one drive; a word as it stands."""
    from openscenario.values import spelled

    value = str(declared.value)
    if declared.parameter_type in WORDS:
        return value
    try:
        return spelled(float(value))
    except (ValueError, OverflowError):  # a number that is not finite
        return value


def _inside(
    value: float, whole: bool, low: float, high: float, common: tuple[float, float] | None = None
) -> str:  # fmt: skip
    """A number between two ends as a file spells it, with as many digits as its range needs; rounding leads to none
    beyond an end, which the scenario's constraints may exclude. common: where nearly all numbers of the range are."""
    from openscenario.values import spelled

    if whole:
        return spelled(round(value))
    return spelled(min(max(float(f"{value:.{_digits(*(common or (low, high)))}g}"), low), high))


def _digits(low: float, high: float) -> int:
    """Significant digits that tell numbers between these two apart."""
    away, width = max(abs(low), abs(high)), high - low
    if not 0.0 < width < math.inf:
        return DIGITS
    return min(max(DIGITS, math.ceil(math.log10(away / width)) + FINE), 17)  # 17 digits tell all doubles apart


def _same(one: str, other: str) -> bool:
    try:
        return float(one) == float(other)
    except ValueError:
        return one == other
