"""ParameterAction and VariableAction: set, add, multiply."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.values import Values

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.ParameterAction)
def parameter(element: model.ParameterAction, entity: None, board: Board) -> Runner:
    """Set a parameter of the scenario, or calculate with it."""
    return _change(board.parameters, element.parameter_ref, element.action)


@action(model.VariableAction)
def variable(element: model.VariableAction, entity: None, board: Board) -> Runner:
    """Set a variable, or calculate with it."""
    return _change(board.variables, element.variable_ref, element.action)


def _change(values: Values, name: str, change: object) -> Runner:
    if name not in values:
        raise Unsupported("not declared", name, ", ".join(values.names()))
    if isinstance(change, model.ParameterSetAction | model.VariableSetAction):
        text = change.value
        return Instant(lambda: values.set(name, text))
    assert isinstance(change, model.ParameterModifyAction | model.VariableModifyAction)
    rule = change.rule
    if isinstance(rule, model.ParameterAddValueRule | model.VariableAddValueRule):
        return Instant(lambda: values.add(name, rule.value))
    return Instant(lambda: values.multiply(name, rule.value))
