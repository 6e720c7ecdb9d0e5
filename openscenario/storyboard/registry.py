"""How actions and conditions are found: a decorated factory in any module of `actions` or `conditions`.

A new one is one function in one file:

    @action(model.SpeedAction)
    def speed(element: model.SpeedAction, entity: Entity | None, board: Board) -> Runner: ...

    @condition(model.SpeedCondition)
    def speed(element: model.SpeedCondition, entity: Entity | None, scope: Scope) -> Test: ...

A factory may raise `Unsupported` for an option it cannot do; the storyboard turns it into a finding before anything
runs.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

from openscenario.storyboard.board import Board
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.nodes import Node
from openscenario.storyboard.runner import Runner
from openscenario.storyboard.unsupported import Unsupported

Factory = TypeVar("Factory", bound=Callable[..., Any])


class Scope(NamedTuple):
    """Where a condition stands: the storyboard, and the element whose trigger it belongs to."""

    board: Board
    node: Node


def entity_called(name: str, board: Board, element: object = None) -> Entity:
    """The entity that an action, condition or position (`element`, if it is not the whole of it) refers to.

    Raises:
        Unsupported: there is none of that name.
    """
    if name not in board.entities:
        raise Unsupported("no entity of this name", name, ", ".join(board.entities), element)
    return board.entities[name]


def action(kind: type) -> Callable[[Factory], Factory]:
    """Mark a factory as the one for model actions of `kind`."""
    return _mark("__runs_action__", kind)


def condition(kind: type) -> Callable[[Factory], Factory]:
    """Mark a factory as the one for model conditions of `kind`."""
    return _mark("__tests_condition__", kind)


def _mark(attribute: str, kind: type) -> Callable[[Factory], Factory]:
    def mark(factory: Factory) -> Factory:
        setattr(factory, attribute, (*getattr(factory, attribute, ()), kind))
        return factory

    return mark


@functools.cache
def action_factories() -> Mapping[type, Callable[..., Runner]]:
    """Model class -> factory, of all modules in `openscenario.storyboard.actions`."""
    from openscenario.storyboard import actions

    return _collect(actions, "__runs_action__")


@functools.cache
def condition_factories() -> Mapping[type, Callable[..., Callable[[], bool]]]:
    """Model class -> factory, of all modules in `openscenario.storyboard.conditions`."""
    from openscenario.storyboard import conditions

    return _collect(conditions, "__tests_condition__")


def _collect(package: ModuleType, attribute: str) -> dict[type, Callable[..., Any]]:
    found: dict[type, Callable[..., Any]] = {}
    for entry in sorted(pkgutil.iter_modules(package.__path__), key=lambda each: each.name):
        module = importlib.import_module(f"{package.__name__}.{entry.name}")
        for factory in vars(module).values():
            for kind in getattr(factory, attribute, ()):
                found[kind] = factory
    return found
