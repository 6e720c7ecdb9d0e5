"""CMA-ES over the continuous ranges of the knobs (extra `tune`)."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from pytest_dvp.tuning.tuned_parameter import Knob, Point

SPREAD = 0.2  # of the range, first standard deviation


class CmaEs:
    """Covariance matrix adaptation in the unit cube of the knobs' ranges; a batch is one generation.

    Source: N. Hansen, The CMA Evolution Strategy: A Tutorial, arXiv:1604.00772; package `cma`.
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it cannot draw
            cma: Any = importlib.import_module("cma")  # it has no hints
        self.knobs, self._start = tuple(knobs), dict(start)
        self._first = True
        options = {"seed": seed + 1, "bounds": [0.0, 1.0], "verbose": -9, "verb_log": 0, "verb_disp": 0}
        # one knob: cma asks for two dimensions at least, the second is idle
        self._idle = max(0, 2 - len(self.knobs))
        x0 = [knob.share(start[knob.name]) for knob in self.knobs] + [0.5] * self._idle
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._strategy = cma.CMAEvolutionStrategy(x0, SPREAD, options)
        self._asked: list[np.ndarray] = []

    def ask(self) -> list[Point]:
        """The start alone first, then one generation a batch; empty when the strategy has ended."""
        if self._first:
            return [dict(self._start)]
        if self._strategy.stop():
            return []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._asked = list(self._strategy.ask())
        return [{k.name: k.at(float(share)) for k, share in zip(self.knobs, x, strict=False)} for x in self._asked]

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better; those of a generation that the budget cut are not used."""
        if self._first:
            self._first = False
            return
        if len(scores) < len(self._asked):
            return  # the budget cut the generation; nothing is asked after it
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._strategy.tell(self._asked, list(scores))


def make(knobs: Sequence[Knob], start: Point, seed: int) -> CmaEs:
    """The search from `start` on. Raises ModuleNotFoundError without the package."""
    return CmaEs(knobs, start, seed)
