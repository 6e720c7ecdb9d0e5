"""The range of a number that a constraint group of a parameter declaration bounds."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from openscenario.read import declarations_with
from openscenario.values import spelled

if TYPE_CHECKING:
    from openscenario.model.declarations import ParameterDeclaration, ValueConstraint, ValueConstraintGroup

SIDES = 6  # parameters of which all 64 corners are looked at for how far a range reaches; each costs a reading
WORDS = ("string", "dateTime", "boolean")
"""Types of parameters whose constraints list values instead of bounding a range."""


class FuzzError(ValueError):
    """A scenario that cannot be varied; one line."""


@dataclasses.dataclass(frozen=True)
class Range:
    """Allowed values of a number: low to high, both included; `whole` for integers."""

    low: float
    high: float
    whole: bool


def range_of(group: ValueConstraintGroup, whole: bool, declaration: ParameterDeclaration) -> Range:
    """The range that one constraint group bounds. Raises FuzzError if it bounds none."""
    low, high = -math.inf, math.inf
    for constraint in group.value_constraints:
        value = float(constraint.value)
        inside = 1.0 if whole else max(abs(value), 1.0) * 1e-9  # the nearest value that a strict bound allows
        low, high = _narrowed(constraint, value, inside, low, high)
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        at = declaration.at
        raise FuzzError(f"{at.file}:{at.line}: constraints of {declaration.name} bound no range: {low:g} to {high:g}")
    return Range(low, high, whole)


def widest_ranges(path: Path, declared: Sequence[ParameterDeclaration], fixed: Mapping[str, str | float | bool]
                  ) -> dict[str, list[Range]]:  # fmt: skip
    """The ranges of the numbers that constraint groups bound, by name, a range for each group.

    A constraint may compare two parameters, as "slower than the ego". Its range then reaches as far as it does for any
    value of the other one; which values go together is for the constraints to say. fixed: values that do not vary.

    Raises FuzzError for a group that bounds none.
    """
    if fixed:
        declared = declarations_with(path, fixed)
    varied = [one for one in declared if one.constraint_groups and one.parameter_type not in WORDS]
    found = {one.name: _ranges(one) for one in varied}
    varied = [one for one in varied if one.name not in fixed]
    for _ in varied:  # one that is compared with one that is compared needs another round
        ends = {one.name: (min(r.low for r in found[one.name]), max(r.high for r in found[one.name])) for one in varied}
        wider = {name: list(ranges) for name, ranges in found.items()}
        for corner in _corners(ends):
            values = {name: spelled(round(end) if found[name][0].whole else end) for name, end in corner.items()}
            for one in declarations_with(path, {**fixed, **values}):
                for k, group in enumerate(one.constraint_groups if one.name in ends else ()):
                    with contextlib.suppress(FuzzError):  # at this corner the group allows nothing
                        here, so_far = range_of(group, found[one.name][k].whole, one), wider[one.name][k]
                        wider[one.name][k] = Range(min(here.low, so_far.low), max(here.high, so_far.high), here.whole)
        if wider == found:
            break
        found = wider
    return found


def _ranges(one: ParameterDeclaration) -> list[Range]:
    return [range_of(group, one.parameter_type not in ("double", "float"), one) for group in one.constraint_groups]


def _corners(ends: Mapping[str, tuple[float, float]]) -> Iterator[dict[str, float]]:
    """The corners of a box, of many sides only those of each edge from its lowest and its highest corner."""
    if len(ends) <= SIDES:
        for values in itertools.product(*ends.values()):
            yield dict(zip(ends, values, strict=True))
        return
    for side in (0, 1):
        corner = {name: pair[side] for name, pair in ends.items()}
        yield corner
        yield from ({**corner, name: pair[1 - side]} for name, pair in ends.items())


def joined(ranges: Sequence[Range]) -> list[Range]:
    """The same values as ranges that do not overlap, the lowest first: a value that two groups allow is there once."""
    found: list[Range] = []
    for each in sorted(ranges, key=lambda each: (each.low, each.high)):
        if found and each.low <= found[-1].high:
            found[-1] = dataclasses.replace(found[-1], high=max(found[-1].high, each.high))
        else:
            found.append(each)
    return found


def _narrowed(constraint: ValueConstraint, value: float, inside: float, low: float, high: float) -> tuple[float, float]:
    match constraint.rule:
        case "equalTo":
            return max(low, value), min(high, value)
        case "greaterOrEqual":
            return max(low, value), high
        case "greaterThan":
            return max(low, value + inside), high
        case "lessOrEqual":
            return low, min(high, value)
        case "lessThan":
            return low, min(high, value - inside)
    return low, high  # notEqualTo takes one point out of a range; who draws from it leaves that out
