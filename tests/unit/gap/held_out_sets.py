"""Sets of effects of which it is given what they leave of data held out."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from pytest_dvp.gap.diagnose.held_out import Fold

COUNT = 1000  # samples of the data fitted on, and of those held out


class HeldOutSets:
    """A search whose sets leave what `held` tells of held-out data (chi^2/N), by names in the order of the alphabet, 10
    where it tells nothing, and `level` of the data fitted on."""

    def __init__(self, held: dict[str, float], *, level: float = 4.0, excused: bool = False) -> None:
        self.held, self.level, self.count, self.said = held, level, COUNT, list[str]()
        self.settled: list[Any] = []
        self.target = SimpleNamespace(excused=excused, settle=self.settled.append)

    def trial(self, names: Sequence[str], values: Any = None, zoom: bool = False, like: Any = None) -> SimpleNamespace:
        left = self.held.get(" ".join(sorted(names)), 10.0)
        return SimpleNamespace(names=tuple(names), values={"held": left * COUNT}, chi2=self.level * COUNT)

    def pruned(self, trial: SimpleNamespace) -> SimpleNamespace:
        return trial

    def tick(self, text: str) -> None:
        self.said.append(text)


def judge() -> Fold:
    """Held-out data that tell what a set leaves of them."""
    of = SimpleNamespace(count=COUNT, whitened=lambda values: np.array([np.sqrt(values["held"])]))
    return Fold(None, of)  # type: ignore[arg-type]
