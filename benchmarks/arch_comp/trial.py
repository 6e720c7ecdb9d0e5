"""One search on one problem: after how many simulations it falsifies the requirement."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from benchmarks.arch_comp.problems import Model, Problem
from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.critical_search import search
from pytest_dvp.campaigns.parameter_space import Axis, Shares, Space, Values
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row
from pytest_dvp.tuning.searchers.search import make_searcher
from pytest_dvp.tuning.tuned_parameter import Knob

METHODS = ("random", "gaussian_process", "cross_entropy", "descent", "bandit", "cma", "tpe")


class Falsified(Exception):
    """A simulation broke the requirement: the search is over."""


@dataclasses.dataclass(frozen=True)
class Trial:
    """A search: simulations until the requirement broke, None if it held; the least robustness; seconds of CPU."""

    problem: str
    method: str
    seed: int
    found: int | None
    least: float
    cpu: float


class Ground:
    """Stands where a campaign stands for a search: it simulates points until one breaks the requirement."""

    def __init__(self, problem: Problem, budget: int) -> None:
        self.space = Space(Path(problem.name), Path(problem.name), None, _axes(problem.model))
        self.driven, self.least = 0, math.inf
        self._problem, self._budget = problem, budget

    def key(self, values: Values) -> str:
        """What tells one simulation from another."""
        return " ".join(values.values())

    def rows(self, points: Sequence[Shares], purpose: str) -> list[Row]:
        """A row a point, one after the other. Raises Falsified."""
        return [self._row(point, purpose) for point in points]

    def robustness(self, at: Shares) -> float:
        """Of one simulation. Raises Falsified if it is below 0, and at the end of the budget."""
        if self.driven >= self._budget:
            raise Falsified
        self.driven += 1
        values = np.array([float(value) for value in self.space.values(at).values()])
        robustness = self._problem.robustness(values)
        self.least = min(self.least, robustness)
        if robustness < 0.0:
            raise Falsified
        return robustness

    def _row(self, at: Shares, purpose: str) -> Row:
        objective, values = self.robustness(at), self.space.values(at)
        name, margins = self._problem.name, {self._problem.name: objective}
        key = self.key(values)
        return Row(key, name, values, 0, "PASS", margins, {}, False, 0.0, "", "", "", purpose, objective, name, "", "")


def tried(problem: Problem, method: str, seed: int, budget: int = 300, *, alone: bool = False) -> Trial:
    """Search until the requirement breaks or the budget is spent.

    `alone`: the searcher asks and is told, and nothing else; otherwise it works as in `dvp campaign --method`, with the
    even sample before it and the descents between its rounds.
    """
    begin = time.process_time()
    ground = Ground(problem, budget)
    try:
        if method == "random":
            for at in sample("random", ground.space.axes, budget, seed):
                ground.robustness(at)
        elif alone:
            _ask(ground, method, seed)
        else:
            search(cast("Campaign", ground), method, budget, seed)
    except Falsified:
        pass
    found = ground.driven if ground.least < 0.0 else None
    return Trial(problem.name, method, seed, found, ground.least, time.process_time() - begin)


def _ask(ground: Ground, method: str, seed: int) -> None:
    """Asks and tells; begins again at a random point where the searcher has nothing left to try. Raises Falsified."""
    size = len(ground.space.axes)
    knobs = [Knob(str(k), "", (0.0, 1.0)) for k in range(size)]
    rng = np.random.default_rng(seed)
    start = [0.5] * size
    while True:
        searcher = make_searcher(method, knobs, dict(zip(map(str, range(size)), start, strict=True)), seed)
        while points := searcher.ask():
            searcher.tell(points, [ground.robustness(tuple(point.values())) for point in points])
        start, seed = [float(share) for share in rng.random(size)], seed + 1000


def _axes(model: Model) -> tuple[Axis, ...]:
    return tuple(
        _axis(f"{what}{k + 1}", highest)
        for what, highest in zip(("throttle", "brake"), model.highest, strict=True)
        for k in range(model.pieces)
    )


def _axis(name: str, highest: float) -> Axis:
    def at(share: float) -> Values:
        return {name: f"{share * highest:.6g}"}

    return Axis(name, at, at(0.5), None)
