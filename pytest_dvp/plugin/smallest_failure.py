"""The smallest variant that still fails.

Hypothesis prefers a smaller value of the first parameter to fewer changed parameters: where 18 fails with a second one
changed and 19 fails alone, it ends with the two.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from pytest_dvp.campaigns.variant import Value, Variant
from pytest_dvp.plugin.scenario_strategy import course, is_allowed

FURTHER = 60
"""Most runs spent on variants in which one parameter goes back and another one further away: two changed parameters
take at most 2 * (PARTS + 2) of them, and three or more stop here. `test_smallest.py` counts them."""

NEAR, PARTS = 4, 16
"""Longest way between two values that are tried: 4 steps of the grid, in a long range a 16th of the way to its end. A
shorter band of values that fail may be passed over."""


def smallest(variant: Variant, fails: Callable[[Variant], bool]) -> Variant:
    """A variant that fails and in which no changed parameter can go back to its nominal value and still fail.

    fails: whether a variant fails; the given one does. A parameter also goes back where another one, further from its
    own nominal value, fails without it; that value is then the nearest one found by halving. At most `FURTHER` runs
    are spent on that, and as many as it takes on the rest. What the scenario's constraints exclude is not driven.
    """
    left = [FURTHER]

    def is_smaller(one: Variant) -> bool:
        return is_allowed(one) and fails(one)

    while True:
        fewer = _without_one(variant, is_smaller)
        if fewer is None and len(variant.values) > 1:
            fewer = _by_another(variant, is_smaller, left)
        if fewer is None:
            return variant
        variant = fewer


def _without_one(variant: Variant, fails: Callable[[Variant], bool]) -> Variant | None:
    return next((one for name in variant.values if fails(one := _without(variant, name))), None)


def _by_another(variant: Variant, fails: Callable[[Variant], bool], left: list[int]) -> Variant | None:
    """One parameter less, with another one further away."""
    for dropped in variant.values:
        rest = _without(variant, dropped)
        for name, value in rest.values.items():
            found = _further(rest, name, value, fails, left)
            if found is not None:
                return found
    return None


def _further(
    rest: Variant, name: str, value: Value, fails: Callable[[Variant], bool], left: list[int]
) -> Variant | None:
    """`rest`, which does not fail, with one parameter so far from nominal that it does; None if that is not found."""
    ahead = course(rest.scenario, name, value)
    if ahead is None:
        return None

    def at(index: int) -> Variant:
        return dataclasses.replace(rest, values={**rest.values, name: ahead[index]})

    passing, reach, longest = -1, 1, max(NEAR, len(ahead) // PARTS)  # indices of values; -1 is `value` itself
    while passing < len(ahead) - 1:
        index = min(passing + reach, len(ahead) - 1)
        if left[0] <= 0:
            return None
        left[0] -= 1
        if fails(at(index)):
            break
        passing, reach = index, min(2 * reach, longest)
    else:
        return None
    failing = index
    while failing - passing > 1:
        middle = (failing + passing) // 2
        if fails(at(middle)):
            failing = middle
        else:
            passing = middle
    return at(failing)


def _without(variant: Variant, name: str) -> Variant:
    return dataclasses.replace(variant, values={n: v for n, v in variant.values.items() if n != name})
