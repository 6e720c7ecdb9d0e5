"""Actions whose parts exclude or need each other."""

from __future__ import annotations

from openscenario.model.actions import LongitudinalDistanceAction, TransitionDynamics
from openscenario.model.controllers import AppearanceAction, AssignControllerAction, ControllerAction
from openscenario.model.global_actions import (
    ParameterAction,
    ParameterSetAction,
    VariableAction,
    VariableSetAction,
)
from openscenario.read.checks.registry import check, exactly_one
from openscenario.read.context import Context, TypedValue


@check(TransitionDynamics)
def not_backwards(dynamics: TransitionDynamics, context: Context) -> None:
    """Duration and distance are not negative; a negative rate is common in the wild and means its magnitude."""
    if dynamics.value >= 0.0:
        return
    found, allowed = f"{dynamics.value:g}", f">= 0 for dynamicsDimension={dynamics.dynamics_dimension}"
    if dynamics.dynamics_dimension == "rate":
        text = "a negative rate counts as its magnitude"
        context.warning("value.negative_rate", dynamics.at, "@value", text, found=found, allowed=allowed)
    else:
        text = f"negative {'duration' if dynamics.dynamics_dimension == 'time' else 'distance'}"
        context.error("value.out_of_range", dynamics.at, "@value", text, found=found, allowed=allowed)


@check(LongitudinalDistanceAction)
def one_gap(action: LongitudinalDistanceAction, context: Context) -> None:
    exactly_one(action, context, "", distance=action.distance, timeGap=action.time_gap)


@check(AssignControllerAction)
def one_controller(action: AssignControllerAction, context: Context) -> None:
    exactly_one(action, context, "", ObjectController=action.object_controller, Controller=action.controller)


@check(ControllerAction)
def some_controller_part(action: ControllerAction, context: Context) -> None:
    parts = (
        action.assign_controller_action,
        action.override_controller_value_action,
        action.activate_controller_action,
    )
    if not any(parts):
        allowed = "AssignControllerAction, OverrideControllerValueAction, ActivateControllerAction"
        context.error("xml.missing_element", action.at, "", "the action is empty", allowed=allowed)


@check(AppearanceAction)
def some_appearance(action: AppearanceAction, context: Context) -> None:
    if not (action.light_state_action or action.animation_action):
        allowed = "LightStateAction, AnimationAction"
        context.error("xml.missing_element", action.at, "", "the action is empty", allowed=allowed)


@check(ParameterAction)
def of_the_parameter(action: ParameterAction, context: Context) -> None:
    if isinstance(action.action, ParameterSetAction):
        value = TypedValue("parameter", action.parameter_ref, action.action.value, action.action.at)
        context.typed_values.append(value)


@check(VariableAction)
def of_the_variable(action: VariableAction, context: Context) -> None:
    if isinstance(action.action, VariableSetAction):
        context.typed_values.append(TypedValue("variable", action.variable_ref, action.action.value, action.action.at))
