"""A knob: one parameter of P or S that is tuned, with its candidate values and what is physically plausible for it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

Point: TypeAlias = Mapping[str, float]
"""A value for each knob, by its name."""

DIGITS = 6  # significant digits of a value: what a person can type again, and what is hashed


@dataclasses.dataclass(frozen=True, slots=True)
class Knob:
    """One parameter that is tuned.

    name       "P.LQR_q11", "S.EGO_mass"
    unit       of its values
    values     candidates, rising
    low, high  range within which searchers of continuous values look: that of the candidates
    plausible  range that the car's data sheet or physics allows (low, high); None: not stated
    whole      takes whole numbers only, also between its candidates
    logarithmic  searched by its logarithm: candidates that span more than a factor of 30, all > 0
    """

    name: str
    unit: str
    values: tuple[float, ...]
    plausible: tuple[float, float] | None = None
    whole: bool = False

    @property
    def low(self) -> float:
        """Least value, in `unit`."""
        return self.values[0]

    @property
    def high(self) -> float:
        """Greatest value, in `unit`."""
        return self.values[-1]

    @property
    def logarithmic(self) -> bool:
        """Whether the range is searched by its logarithm: it spans more than a factor of 30."""
        return self.low > 0.0 and self.high / self.low > 30.0

    def at(self, share: float) -> float:
        """Value at a share 0..1 of the range; beyond it, its end."""
        share = min(max(share, 0.0), 1.0)
        if self.logarithmic:
            value = self.low * (self.high / self.low) ** share
        else:
            value = self.low + (self.high - self.low) * share
        return float(round(value)) if self.whole else rounded(value)

    def share(self, value: float) -> float:
        """Where in the range a value lies, 0..1."""
        if self.high == self.low:
            return 0.5
        if self.logarithmic:
            found = math.log(max(value, 1e-300) / self.low) / math.log(self.high / self.low)
        else:
            found = (value - self.low) / (self.high - self.low)
        return min(max(found, 0.0), 1.0)


def rounded(value: float) -> float:
    """The value to as many digits as a person would type."""
    return float(f"{value:.{DIGITS}g}")


def typed(value: float) -> str:
    """The shortest text that is exactly this number again: `30`, `4.5`, `0.0005`."""
    short = f"{value:g}"
    return short if float(short) == value else repr(float(value))


def split(point: Point) -> tuple[dict[str, float], dict[str, float]]:
    """The values of P and those of S, by their names there."""
    found: dict[str, dict[str, float]] = {"P": {}, "S": {}}
    for name, value in point.items():
        group, _, rest = name.partition(".")
        found[group][rest] = value
    return found["P"], found["S"]


def changed(before: Point, after: Point) -> dict[str, tuple[float, float]]:
    """Knobs that moved: name -> (before, after)."""
    return {name: (before[name], after[name]) for name in after if before.get(name) != after[name]}


def described(point: Point, names: Sequence[str] | None = None) -> str:
    """`P.LQR_q11=30, S.EGO_mass=730`."""
    return ", ".join(f"{name}={point[name]:g}" for name in (names if names is not None else point))
