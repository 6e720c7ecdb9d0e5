"""The range of a number that a constraint group of a parameter declaration bounds."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from openscenario.model.declarations import ParameterDeclaration, ValueConstraint, ValueConstraintGroup

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
