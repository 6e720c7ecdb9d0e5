"""The rules by which a condition compares: what is nearer than a millionth is equal, and what is infinite is itself."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.values import COMPARISONS, ROUNDING

RULES = ("equalTo", "notEqualTo", "greaterThan", "lessThan", "greaterOrEqual", "lessOrEqual")


@pytest.mark.parametrize(
    ("found", "true"),
    [
        (0.0, {"equalTo", "greaterOrEqual", "lessOrEqual"}),
        (0.9e-6, {"equalTo", "greaterOrEqual", "lessOrEqual"}),
        (-0.9e-6, {"equalTo", "greaterOrEqual", "lessOrEqual"}),
        (1.1e-6, {"notEqualTo", "greaterThan", "greaterOrEqual"}),
        (-1.1e-6, {"notEqualTo", "lessThan", "lessOrEqual"}),
        (3.0, {"notEqualTo", "greaterThan", "greaterOrEqual"}),
        (-3.0, {"notEqualTo", "lessThan", "lessOrEqual"}),
        (math.inf, {"notEqualTo", "greaterThan", "greaterOrEqual"}),
        (-math.inf, {"notEqualTo", "lessThan", "lessOrEqual"}),
    ],
)
def test_a_number_compared_with_another_one(found: float, true: set[str]) -> None:
    assert {rule for rule in RULES if COMPARISONS[rule](found, 0.0)} == true
    if math.isfinite(found):
        assert {rule for rule in RULES if COMPARISONS[rule](8.0 + found, 8.0)} == true


@pytest.mark.parametrize("found", [-ROUNDING, ROUNDING, math.nan, math.inf, 0.0])
@pytest.mark.parametrize("value", [0.0, math.inf])
def test_what_is_not_equal_is_unequal_also_just_at_the_bound(found: float, value: float) -> None:
    assert COMPARISONS["equalTo"](found, value) is not COMPARISONS["notEqualTo"](found, value)
    assert COMPARISONS["equalTo"](found, value) is (found == value)


def test_infinities_are_equal_to_themselves() -> None:
    for endless in (math.inf, -math.inf):
        assert COMPARISONS["equalTo"](endless, endless)
        assert not COMPARISONS["notEqualTo"](endless, endless)
