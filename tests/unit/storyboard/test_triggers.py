"""Edges and delays (ASAM OpenSCENARIO XML 1.3, "Condition edges", "Condition delay")."""

from __future__ import annotations

import pytest

from openscenario import model
from openscenario.storyboard.triggers import ConditionState, TriggerState


def outputs(values: str, edge: str, delay: float = 0.0, dt: float = 1.0) -> str:
    """What a condition says in each step, given what it tests ("1" true, "0" false)."""
    feed = iter(values)
    condition = model.Condition(
        name="c",
        delay=delay,
        condition_edge=edge,  # type: ignore[arg-type]
        condition=model.SimulationTimeCondition(rule="greaterThan", value=0.0),
    )
    state = ConditionState(condition, lambda: next(feed) == "1")
    return "".join("1" if state.evaluate(i * dt) else "0" for i in range(len(values)))


@pytest.mark.parametrize(
    ("edge", "expected"),
    [
        ("none", "0110110"),
        ("rising", "0100100"),
        ("falling", "0001001"),
        ("risingOrFalling", "0101101"),
    ],
)
def test_edges(edge: str, expected: str) -> None:
    assert outputs("0110110", edge) == expected


def test_the_first_evaluation_sees_no_edge() -> None:
    assert outputs("1101", "rising") == "0001"


def test_a_delay_shifts_the_answer() -> None:
    assert outputs("01000000", "rising", delay=3.0) == "00001000"


def test_a_delayed_condition_without_edge_ends_delayed_too() -> None:
    assert outputs("01100000", "none", delay=2.0) == "00011000"


def test_before_the_delay_is_over_it_is_false() -> None:
    assert outputs("1111", "none", delay=2.0) == "0011"


def test_a_group_needs_all_and_a_trigger_one() -> None:
    def state(value: bool) -> ConditionState:
        condition = model.Condition(
            name="c",
            delay=0.0,
            condition_edge="none",
            condition=model.SimulationTimeCondition(rule="greaterThan", value=0.0),
        )
        return ConditionState(condition, lambda: value)

    assert not TriggerState(((state(True), state(False)),)).evaluate(0.0)
    assert TriggerState(((state(False),), (state(True),))).evaluate(0.0)
    assert not TriggerState(()).evaluate(0.0)
