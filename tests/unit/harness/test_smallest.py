"""The variant that is told: planted problems whose smallest answers are known, from wherever a search ended."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from hypothesis import Phase, find, settings

from pytest_dvp import Variant, scenario_variants
from pytest_dvp.plugin.smallest_failure import FURTHER, smallest

Write = Callable[..., Path]
Values = Mapping[str, float]
NOMINAL = {"ego_speed": 15.0, "gap": 20.0, "delay": 1.0}
RANGES = {"ego_speed": (5.0, 30.0), "gap": (2.0, 40.0), "delay": (0.0, 5.0)}


@pytest.fixture
def three(scenario: Write) -> Path:
    """A scenario with three parameters, on grids of 0.5, 0.5 and 0.1."""
    declared = "".join(
        f"""<ParameterDeclaration name="{name}" parameterType="double" value="{NOMINAL[name]}"><ConstraintGroup>
        <ValueConstraint rule="greaterOrEqual" value="{low}"/><ValueConstraint rule="lessOrEqual" value="{high}"/>
        </ConstraintGroup></ParameterDeclaration>"""
        for name, (low, high) in RANGES.items()
    )
    text = scenario().read_text()
    start, end = text.index("<ParameterDeclaration "), text.index("  </ParameterDeclarations>")
    return scenario((text[start:end], declared))


PROBLEMS: dict[str, tuple[Callable[[Values], bool], list[dict[str, float]]]] = {
    "one alone": (lambda v: v["ego_speed"] >= 19.0, [{"ego_speed": 19.0}]),
    "one alone, nearer with another": (
        lambda v: v["ego_speed"] >= 19.0 or (v["ego_speed"] >= 16.0 and v["gap"] <= 12.0),
        [{"ego_speed": 19.0}],
    ),
    "one alone, in a narrow band": (
        lambda v: 19.0 <= v["ego_speed"] <= 20.5 or (v["ego_speed"] >= 17.0 and v["delay"] >= 2.0),
        [{"ego_speed": 19.0}],
    ),
    "a sum, to which each can give all": (
        lambda v: (v["ego_speed"] - 15.0) / 15.0 + (20.0 - v["gap"]) / 18.0 >= 0.5,
        [{"ego_speed": 22.5}, {"gap": 11.0}],
    ),
    "two needed": (lambda v: v["ego_speed"] >= 18.0 and v["gap"] <= 12.0, [{"ego_speed": 18.0, "gap": 12.0}]),
    "two needed, three nearer": (
        lambda v: (
            (v["ego_speed"] >= 18.0 and v["gap"] <= 12.0)
            or (v["ego_speed"] >= 16.0 and v["gap"] <= 12.0 and v["delay"] >= 2.0)
        ),
        [{"ego_speed": 18.0, "gap": 12.0}],
    ),
    "three needed": (
        lambda v: v["ego_speed"] >= 18.0 and v["gap"] <= 12.0 and v["delay"] >= 2.0,
        [{"ego_speed": 18.0, "gap": 12.0, "delay": 2.0}],
    ),
}


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.nightly(by_day=6)
def test_no_parameter_of_what_is_told_can_go_back(three: Path, name: str, seed: int) -> None:
    bad, answers = PROBLEMS[name]
    driven: list[Variant] = []

    def fails(variant: Variant) -> bool:
        driven.append(variant)
        return bad({**NOMINAL, **variant.values})

    searched = settings(database=None, max_examples=300, deadline=None, phases=[Phase.generate, Phase.shrink])
    shrunk = find(scenario_variants(three), fails, settings=searched, random=random.Random(seed))
    driven.clear()
    told = smallest(shrunk, fails)
    assert dict(told.values) in answers
    assert fails(told)
    for changed in told.values:
        assert not fails(Variant(three, {n: v for n, v in told.values.items() if n != changed}))
    assert len(driven) < FURTHER


def test_a_search_that_ended_anywhere_is_brought_back(three: Path) -> None:
    """As with @settings(max_examples=...) too few to shrink, or a run of the time limit of Hypothesis."""
    bad = PROBLEMS["one alone"][0]
    anywhere = Variant(three, {"ego_speed": 27.0, "gap": 7.0, "delay": 3.3})
    assert smallest(anywhere, lambda v: bad({**NOMINAL, **v.values})).values == {"ego_speed": 27.0}


def test_values_stay_in_the_group_that_they_are_from(scenario: Write) -> None:
    """Two ranges of one number, and a word: neither is left on the way to a smaller variant."""
    groups = "".join(
        f"""<ConstraintGroup><ValueConstraint rule="greaterOrEqual" value="{low}"/>
        <ValueConstraint rule="lessOrEqual" value="{high}"/></ConstraintGroup>"""
        for low, high in ((2, 6), (50, 90))
    )
    path = scenario(
        (
            "</ParameterDeclarations>",
            f"""<ParameterDeclaration name="count" parameterType="integer" value="3">{groups}</ParameterDeclaration>
            <ParameterDeclaration name="weather" parameterType="string" value="dry">
            <ConstraintGroup><ValueConstraint rule="equalTo" value="dry"/></ConstraintGroup>
            <ConstraintGroup><ValueConstraint rule="equalTo" value="wet"/></ConstraintGroup>
            </ParameterDeclaration></ParameterDeclarations>""",
        )
    )
    driven: list[Variant] = []

    def fails(variant: Variant) -> bool:
        driven.append(variant)
        count = variant.values.get("count", 3)
        return count >= 70 or (count >= 55 and variant.values.get("weather") == "wet")

    assert smallest(Variant(path, {"count": 55, "weather": "wet"}), fails).values == {"count": 70}
    assert {type(v.values["count"]) for v in driven if "count" in v.values} == {int}
    assert all(50 <= v.values["count"] <= 90 for v in driven if "count" in v.values)


def test_what_the_constraints_exclude_is_not_driven(scenario: Write) -> None:
    """The ego cannot go back to 5 m/s alone: the other one, at 5.5 m/s, must not be faster."""
    other = """<ParameterDeclaration name="other" parameterType="double" value="3"><ConstraintGroup>
      <ValueConstraint rule="greaterOrEqual" value="1"/><ValueConstraint rule="lessOrEqual" value="6"/>
      <ValueConstraint rule="lessOrEqual" value="$ego_speed"/>
    </ConstraintGroup></ParameterDeclaration></ParameterDeclarations>"""
    path = scenario(("</ParameterDeclarations>", other))
    driven: list[Variant] = []

    def fails(variant: Variant) -> bool:
        driven.append(variant)
        return variant.values.get("other", 3.0) >= 5.5

    assert smallest(Variant(path, {"ego_speed": 6.0, "other": 5.5}), fails).values == {"ego_speed": 6.0, "other": 5.5}
    assert all(v.values.get("other", 3.0) <= v.values.get("ego_speed", 5.0) for v in driven)
