"""Conditions whose parts exclude each other, and what they refer to."""

from __future__ import annotations

from openscenario.model.conditions import (
    ParameterCondition,
    SimulationTimeCondition,
    StoryboardElementStateCondition,
    TimeToCollisionConditionTarget,
    VariableCondition,
)
from openscenario.read.checks.registry import check, exactly_one
from openscenario.read.context import Context, TypedValue


@check(TimeToCollisionConditionTarget)
def one_target(target: TimeToCollisionConditionTarget, context: Context) -> None:
    """Refuse a target that is not one of a position and an entity, or is both."""
    exactly_one(target, context, "", Position=target.position, EntityRef=target.entity_ref)


@check(StoryboardElementStateCondition)
def later(condition: StoryboardElementStateCondition, context: Context) -> None:
    """Its type is compared with the type of the element once all elements are known."""
    context.state_conditions.append(condition)


@check(SimulationTimeCondition)
def begins_at_zero(condition: SimulationTimeCondition, context: Context) -> None:
    """A negative time is legal and never what was meant: time begins at 0."""
    if condition.value >= 0.0:
        return
    always = condition.rule in ("greaterThan", "greaterOrEqual", "notEqualTo")
    text = f"simulation time begins at 0, so this is {'true from the start' if always else 'never true'}"
    context.warning(
        "value.negative_time", condition.at, "@value", text, found=f"{condition.value:g}", allowed="0 s or more"
    )


@check(ParameterCondition)
def of_the_parameter(condition: ParameterCondition, context: Context) -> None:
    """A value of another type would never compare equal."""
    context.typed_values.append(TypedValue("parameter", condition.parameter_ref, condition.value, condition.at))


@check(VariableCondition)
def of_the_variable(condition: VariableCondition, context: Context) -> None:
    """Keep the compared value, to be checked against the type of its variable once all are read."""
    context.typed_values.append(TypedValue("variable", condition.variable_ref, condition.value, condition.at))
