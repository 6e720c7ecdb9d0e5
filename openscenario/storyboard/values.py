"""Parameters and variables at run time: named values of a declared type."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Final

Value = bool | int | float | str

ROUNDING: Final = 1e-6  # values nearer than this are equal: a speed that went up in steps meets its target

COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "equalTo": lambda found, value: found == value or abs(found - value) < ROUNDING,
    "notEqualTo": lambda found, value: found != value and not abs(found - value) < ROUNDING,
    "greaterThan": lambda found, value: found > value + ROUNDING,
    "lessThan": lambda found, value: found < value - ROUNDING,
    "greaterOrEqual": lambda found, value: found > value - ROUNDING,
    "lessOrEqual": lambda found, value: found < value + ROUNDING,
}
"""The standard's rules as functions of (value found, value of the condition), both finite or not."""

WHOLE = ("integer", "int", "unsignedInt", "unsignedShort")


def typed(kind: str, text: str) -> Value:
    """The value that `text` spells for a declared type; the text itself where it spells none."""
    try:
        if kind == "boolean":
            return text.strip().lower() in ("true", "1")
        if kind in WHOLE:
            return int(float(text))
        if kind == "double":
            return float(text)
    except ValueError:
        return text
    return text


def compare(rule: str, left: Value, right: Value) -> bool:
    """`left rule right`: numbers as numbers (a boolean counts 0 or 1), everything else as text."""
    if isinstance(left, str) or isinstance(right, str):
        order = (str(left) > str(right)) - (str(left) < str(right))
        return COMPARISONS[rule](order, 0)
    return COMPARISONS[rule](left, right)


class Values:
    """Name -> value, with the declared types."""

    __slots__ = ("_kinds", "_values")

    def __init__(self, declarations: Iterable[tuple[str, str, str]]) -> None:
        self._kinds: dict[str, str] = {}
        self._values: dict[str, Value] = {}
        for name, kind, text in declarations:
            self._kinds[name] = kind
            self._values[name] = typed(kind, text)

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def names(self) -> tuple[str, ...]:
        """The names of all that are declared."""
        return tuple(self._values)

    def get(self, name: str) -> Value:
        """The present value, in its declared type; the text itself where that type cannot hold it."""
        return self._values[name]

    def parse(self, name: str, text: str) -> Value:
        """`text` as a value of the type of `name`."""
        return typed(self._kinds[name], text)

    def set(self, name: str, text: str) -> None:
        """Give a declared name the value that `text` spells in its type."""
        self._values[name] = self.parse(name, text)

    def add(self, name: str, amount: float) -> None:
        """Add to the value of a declared name; a text stays as it is, a whole number stays whole."""
        self._calculate(name, lambda value: value + amount)

    def multiply(self, name: str, factor: float) -> None:
        """Multiply the value of a declared name; a text stays as it is, a whole number stays whole."""
        self._calculate(name, lambda value: value * factor)

    def _calculate(self, name: str, change: Callable[[float], float]) -> None:
        value = self._values[name]
        if isinstance(value, str):
            return
        result = change(float(value))
        self._values[name] = int(result + math.copysign(ROUNDING, result)) if self._kinds[name] in WHOLE else result
