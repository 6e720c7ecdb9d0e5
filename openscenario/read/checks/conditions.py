"""Conditions whose parts exclude each other, and what they refer to."""

from __future__ import annotations

from openscenario.model.conditions import StoryboardElementStateCondition, TimeToCollisionConditionTarget
from openscenario.read.checks.registry import check, exactly_one
from openscenario.read.context import Context


@check(TimeToCollisionConditionTarget)
def one_target(target: TimeToCollisionConditionTarget, context: Context) -> None:
    exactly_one(target, context, "", Position=target.position, EntityRef=target.entity_ref)


@check(StoryboardElementStateCondition)
def later(condition: StoryboardElementStateCondition, context: Context) -> None:
    """Its type is compared with the type of the element once all elements are known."""
    context.state_conditions.append(condition)
