"""Which checks an element undergoes once it is read."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeAlias

from openscenario.model.kinds import Element
from openscenario.read.context import Context

Check: TypeAlias = Callable[[Any, Context], None]

CHECKS: Final[dict[type[Element], list[Check]]] = {}


def check(*classes: type[Element]) -> Callable[[Check], Check]:
    """Registers a function `(element, context) -> None` that notes what is wrong with elements of the classes."""

    def register(function: Check) -> Check:
        for cls in classes:
            CHECKS.setdefault(cls, []).append(function)
        return function

    return register


def exactly_one(element: Element, context: Context, attribute: str, **given: object) -> None:
    """Notes an error, at the element or its `@attribute`, unless exactly one of the values is set."""
    if all(value is None for value in given.values()):
        allowed = f"exactly one of {' or '.join(given)}"
        context.error("xml.choice", element.at, attribute, "none is given", allowed=allowed)
    at_most_one(element, context, attribute, "exactly one", **given)


def at_most_one(
    element: Element, context: Context, attribute: str, allowed: str = "at most one", **given: object
) -> None:
    """Notes an error, at the element or its `@attribute`, if more than one of the values is set."""
    if sum(value is not None for value in given.values()) > 1:
        allowed = f"{allowed} of {' or '.join(given)}"
        context.error("xml.choice", element.at, attribute, "more than one is given", allowed=allowed)
