"""Actions whose parts exclude or need each other."""

from __future__ import annotations

from openscenario.model.actions import (
    LaneOffsetActionDynamics,
    LongitudinalDistanceAction,
    RelativeTargetSpeed,
    SpeedAction,
    SpeedProfileAction,
    TransitionDynamics,
)
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


@check(TransitionDynamics)
def takes_time(dynamics: TransitionDynamics, context: Context) -> None:
    """A shape needs time or way; without any it is the step that it does not say, and without a rate it never ends."""
    shape, dimension = dynamics.dynamics_shape, dynamics.dynamics_dimension
    if shape == "step":
        if dynamics.value != 0.0 and dimension != "rate":
            text = "a step takes no time and no way: the value counts for nothing"
            found = f"{dynamics.value:g}"
            context.warning("value.step_with_duration", dynamics.at, "@value", text, found=found, allowed="0")
    elif dynamics.value == 0.0:
        text = f"a {shape} transition of no {'duration' if dimension == 'time' else dimension} "
        text += "never ends" if dimension == "rate" else "is a step"
        hint = "" if dimension == "rate" else "dynamicsShape step says so"
        context.warning("value.no_transition", dynamics.at, "@value", text, found="0", allowed="> 0", hint=hint)


@check(LaneOffsetActionDynamics)
def moves_aside(dynamics: LaneOffsetActionDynamics, context: Context) -> None:
    """Warn of an offset by a shape that may have no lateral acceleration: it never ends."""
    if dynamics.max_lateral_acc == 0.0 and dynamics.dynamics_shape != "step":
        text = f"a {dynamics.dynamics_shape} transition without lateral acceleration never ends"
        context.warning("value.no_transition", dynamics.at, "@maxLateralAcc", text, found="0", allowed="> 0")


@check(SpeedProfileAction)
def may_change(action: SpeedProfileAction, context: Context) -> None:
    """A limit of 0 is legal, and what it limits never happens."""
    limits = action.dynamic_constraints
    if limits is None:
        return
    given = {
        "maxSpeed": limits.max_speed,
        "maxAcceleration": limits.max_acceleration,
        "maxDeceleration": limits.max_deceleration,
    }
    if action.following_mode == "follow":
        given |= {
            "maxAccelerationRate": limits.max_acceleration_rate,
            "maxDecelerationRate": limits.max_deceleration_rate,
        }
    for name, limit in given.items():
        if limit == 0.0:
            text = "a limit of 0: no speed that needs more is ever reached"
            context.warning("value.no_transition", limits.at, f"@{name}", text, found="0", allowed="> 0")


@check(SpeedAction)
def kept_at_a_rate(action: SpeedAction, context: Context) -> None:
    """Class RelativeTargetSpeed: continuous `may not be used together with Dynamics.time or Dynamics.distance`."""
    dynamics, target = action.speed_action_dynamics, action.speed_action_target
    continuous = isinstance(target, RelativeTargetSpeed) and target.continuous
    if continuous and dynamics.dynamics_shape != "step" and dynamics.dynamics_dimension != "rate":
        text = "a continuous target has no end: the value holds until the target is reached first"
        found = f"dynamicsDimension={dynamics.dynamics_dimension}"
        context.warning(
            "value.continuous_dimension", dynamics.at, "@dynamicsDimension", text, found=found, allowed="rate"
        )


@check(LongitudinalDistanceAction)
def one_gap(action: LongitudinalDistanceAction, context: Context) -> None:
    """Refuse an action that does not state one of a distance and a time gap, or states both."""
    exactly_one(action, context, "", distance=action.distance, timeGap=action.time_gap)


@check(AssignControllerAction)
def one_controller(action: AssignControllerAction, context: Context) -> None:
    """Refuse an action that does not name one controller, or names two."""
    exactly_one(action, context, "", ObjectController=action.object_controller, Controller=action.controller)


@check(ControllerAction)
def some_controller_part(action: ControllerAction, context: Context) -> None:
    """Refuse a ControllerAction that neither assigns nor overrides nor activates."""
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
    """Refuse an AppearanceAction without a light and an animation."""
    if not (action.light_state_action or action.animation_action):
        allowed = "LightStateAction, AnimationAction"
        context.error("xml.missing_element", action.at, "", "the action is empty", allowed=allowed)


@check(ParameterAction)
def of_the_parameter(action: ParameterAction, context: Context) -> None:
    """Keep what it does, to be checked against the type of its parameter once all are read."""
    value = action.action.value if isinstance(action.action, ParameterSetAction) else None
    context.typed_values.append(TypedValue("parameter", action.parameter_ref, value, action.action.at))


@check(VariableAction)
def of_the_variable(action: VariableAction, context: Context) -> None:
    """Keep what it does, to be checked against the type of its variable once all are read."""
    value = action.action.value if isinstance(action.action, VariableSetAction) else None
    context.typed_values.append(TypedValue("variable", action.variable_ref, value, action.action.at))
