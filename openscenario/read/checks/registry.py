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
    names = " or ".join(given)
    count = sum(value is not None for value in given.values())
    if count != 1:
        problem = "more than one" if count else "none"
        context.error("xml.choice", element.at, attribute, f"{problem} is given", allowed=f"exactly one of {names}")
