"""The units that an FMU declares for its inputs and outputs, as factors to the SI units of the log's columns."""

from __future__ import annotations

from typing import Any

from pytest_dvp.gap.compare.compared_model import CompareError
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.units import Unit, find_unit, units_of

_EXPONENTS = {"m": (1, 0), "rad": (0, 0), "-": (0, 0), "m/s": (1, -1), "rad/s": (0, -1), "m/s^2": (1, -2)}
"""Of metre and second in the SI units of the columns that a car is driven by and shows."""
_OTHERS = ("kg", "A", "K", "mol", "cd")  # base units of FMI that none of these has; radians count as 1 there


def declared_unit(variable: Any, description: Any, who: str, name: str | None = None) -> Unit:
    """The unit of an FMU's variable, by its own attribute or that of its type; SI where it declares none, or where no
    signal of ours has its name.

    `name` of the signal that it stands for, if that is not its own. `description` holds the FMU's definitions of units
    (FMI 2.0.4, 2.2.2; `displayUnit` changes no value). Raises CompareError for a unit that is none of the signal.
    """
    text = getattr(variable, "unit", None) or getattr(getattr(variable, "declaredType", None), "unit", None) or ""
    signal = SIGNALS.get(name or variable.name)
    if not text or signal is None:
        return Unit(signal.unit if signal is not None else "-")
    unit = find_unit(text)
    if unit is not None and unit.si == signal.unit:
        return unit
    defined = next((one.baseUnit for one in description.unitDefinitions or () if one.name == text), None)
    if (
        defined is not None
        and _EXPONENTS.get(signal.unit) == (defined.m, defined.s)
        and not any(getattr(defined, other) for other in _OTHERS)
    ):
        return Unit(signal.unit, float(defined.factor), float(defined.offset))
    allowed = ", ".join(units_of(signal.unit))
    raise CompareError(f"{who}: {variable.name} is declared in {text!r}; allowed: {allowed}")
