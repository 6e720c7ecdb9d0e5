"""Conditions on simulation time, parameters, variables, storyboard states and traffic lights."""

from __future__ import annotations

from openscenario import model
from openscenario.criteria import criterion_of
from openscenario.storyboard.nodes import COMPLETE, RUNNING, STANDBY, find
from openscenario.storyboard.registry import Scope, condition
from openscenario.storyboard.signals import program_with
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.values import COMPARISONS, Values, compare

RESOLUTION = 1e-9  # s: a sum of steps meets a time in spite of rounding


@condition(model.SimulationTimeCondition)
def simulation_time(element: model.SimulationTimeCondition, entity: None, scope: Scope) -> Test:
    """Compares the time [s] since the storyboard began with a value."""
    board = scope.board
    rule, value = element.rule, element.value
    if rule == "greaterOrEqual":
        return lambda: board.time >= value - RESOLUTION
    if rule == "greaterThan":
        return lambda: board.time > value + RESOLUTION
    if rule == "lessThan":
        return lambda: board.time < value - RESOLUTION
    if rule == "lessOrEqual":
        return lambda: board.time <= value + RESOLUTION
    if rule == "equalTo":
        # a step rarely ends on the value: the step that passes it counts
        return lambda: board.time - board.dt < value - RESOLUTION <= board.time or abs(board.time - value) < RESOLUTION
    return lambda: abs(board.time - value) > RESOLUTION


@condition(model.ParameterCondition)
def parameter(element: model.ParameterCondition, entity: None, scope: Scope) -> Test:
    """Compares a parameter of the scenario with a value."""
    if element.parameter_ref not in scope.board.parameters and criterion_of(element.at):
        return lambda: False
    return _named(scope.board.parameters, element.parameter_ref, element.rule, element.value)


@condition(model.VariableCondition)
def variable(element: model.VariableCondition, entity: None, scope: Scope) -> Test:
    """Compares a variable with a value."""
    return _named(scope.board.variables, element.variable_ref, element.rule, element.value)


def _named(values: Values, name: str, rule: str, text: str) -> Test:
    if name not in values:
        raise Unsupported("not declared", name, ", ".join(values.names()))
    wanted = values.parse(name, text)
    return lambda: compare(rule, values.get(name), wanted)


@condition(model.StoryboardElementStateCondition)
def element_state(element: model.StoryboardElementStateCondition, entity: None, scope: Scope) -> Test:
    """States hold while they last; transitions in the step they happen in, or in the one after (seen once).

    Raises Unsupported if the storyboard has no such element.
    """
    board = scope.board
    node = find(board.root, element.storyboard_element_type, element.storyboard_element_ref, scope.node)
    if node is None:
        raise Unsupported(f"no {element.storyboard_element_type} of this name", element.storyboard_element_ref)
    wanted = element.state
    if wanted in (STANDBY, RUNNING, COMPLETE):
        return lambda: node.state == wanted
    seen = -1

    def happened() -> bool:
        nonlocal seen
        step, number = node.changes.get(wanted, (-2, -1))
        if number > seen and step >= board.steps - 1:
            seen = number
            return True
        return False

    return happened


@condition(model.TrafficSignalCondition)
def traffic_signal(element: model.TrafficSignalCondition, entity: None, scope: Scope) -> Test:
    """True while a traffic signal is in the state. The road may call it by its id or by its name."""
    world, name, state = scope.board.world, element.name, element.state
    return lambda: world.shows(name, state)


@condition(model.TrafficSignalControllerCondition)
def signal_phase(element: model.TrafficSignalControllerCondition, entity: None, scope: Scope) -> Test:
    """True while the program of a traffic signal controller is in the phase."""
    board = scope.board
    program = program_with(board.programs, element.traffic_signal_controller_ref, element.phase)

    def test() -> bool:
        phase = program.phase(board.time)
        return phase is not None and phase.name == element.phase

    return test


@condition(model.UserDefinedValueCondition)
def user_defined(element: model.UserDefinedValueCondition, entity: None, scope: Scope) -> Test:
    """Who runs the storyboard sets `board.world.values`; false until then. Numbers compare as numbers."""
    values, name, rule, wanted = scope.board.world.values, element.name, element.rule, element.value

    def test() -> bool:
        now = values.get(name)
        if now is None:
            return False
        try:
            return compare(rule, float(now), float(wanted))
        except ValueError:
            return compare(rule, now, wanted)

    return test


__all__ = ["COMPARISONS"]
