"""A variant of a scenario; apart from the strategies, so that a run does not load Hypothesis."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

Value: TypeAlias = float | int | str | bool


@dataclasses.dataclass(frozen=True)
class Variant:
    """A scenario with some of its declared parameters changed; `values` holds only those that are not nominal.

    varied  names of all that a strategy varies, also of those that are nominal in this variant
    """

    scenario: Path
    values: Mapping[str, Value]
    varied: tuple[str, ...] = dataclasses.field(default=(), compare=False)

    def __repr__(self) -> str:
        changed = "".join(f", {name}={value!r}" for name, value in self.values.items())
        return f"Variant({self.scenario.name}{changed})"
