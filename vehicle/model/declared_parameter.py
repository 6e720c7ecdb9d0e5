"""A declared parameter: what may be set from outside, with unit, range and meaning."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from vehicle.model.errors import ModelError


@dataclass(frozen=True, slots=True)
class Declaration:
    """One parameter: name, unit, allowed range (both ends included unless `positive`), default and meaning."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    default: float | None = None
    positive: bool = False

    def check(self, value: float) -> float:
        """`value` if allowed. Raises ModelError naming what was found and what is allowed."""
        good = isfinite(value) and self.low <= value <= self.high and not (self.positive and value <= 0.0)
        if not good:
            low = f"more than {self.low:g}" if self.positive and self.low == 0.0 else f"{self.low:g}"
            raise ModelError(
                "value not allowed", key=self.name, found=f"{value:g}", allowed=f"{low} to {self.high:g} {self.unit}"
            )
        return value
