"""A search for critical drives: it finds a failure, turns away from it, and looks for the next one."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.parameter_space import Shares
from pytest_dvp.campaigns.sampling import sobol
from pytest_dvp.campaigns.store import Row
from pytest_dvp.tuning.searchers.search import Learner, make_searcher
from pytest_dvp.tuning.tuned_parameter import Knob, Point

LOCAL = "descent"  # every second round starts from the worst pass so far and stays near it
REACH = 0.12
"""Distance between two points, as the root mean square over the axes in shares of the ranges, within which a failure is
the same find as an earlier one. Two points drawn at random are 0.41 apart: within the reach lies 0.4 % of a cube of 5
dimensions."""
FINDS = 2  # failures with which a round has found its place: where it starts, and that it was no single point
EVEN = 0.2  # share of the budget for the even sample that shows where to begin; at least two drives for each axis
STALE = 6  # batches in a row that bring no lower score, after which a round ends
DULL = 1.0  # score of a drive that measured nothing: as far from failing as a bound that is not used at all


def search(campaign: Campaign, name: str, budget: int, seed: int) -> list[Row]:
    """Drive `budget` points: an even sample, then rounds of the searcher `name` and of local descents, by turns.

    A round minimises the objective. Failures of earlier rounds push it elsewhere; a vacuous drive scores DULL. The same
    arguments ask for the same points, whatever the store holds and however many processes drive.

    Raises TuneError if the searcher needs a package that is not installed.
    """
    return _Search(campaign, budget, seed).rows(name)


class _Search:
    def __init__(self, campaign: Campaign, budget: int, seed: int) -> None:
        self._campaign, self._budget, self._seed = campaign, budget, seed
        self._size = len(campaign.space.axes)
        self._knobs = [Knob(str(k), "", (0.0, 1.0)) for k in range(self._size)]
        self._known: dict[str, tuple[Shares, Row]] = {}
        self._behind: list[Shares] = []  # failures of earlier rounds
        self._ended: list[Shares] = []  # where rounds ended without a failure: none begins there, but one may lie near

    def rows(self, name: str) -> list[Row]:
        """All drives, in the order asked for."""
        make_searcher(name, self._knobs, self._point((0.5,) * self._size), self._seed)  # what is missing shows now
        first = min(max(2 * self._size, round(EVEN * self._budget)), self._budget)
        self._drive([self._campaign.space.nominal_shares, *sobol(self._size, first - 1, self._seed)])
        number = idle = 0
        while len(self._known) < self._budget and idle < STALE:
            before = len(self._known)
            self._round(name if number % 2 == 0 else LOCAL, self._seed + number)
            number += 1
            idle = idle + 1 if len(self._known) == before else 0  # a space of few values is exhausted
        return [row for _, row in self._known.values()]

    def _round(self, name: str, seed: int) -> None:
        start = self._start()
        searcher = make_searcher(name, self._knobs, self._point(start), seed)
        if isinstance(searcher, Learner):
            known = list(self._known.values())
            searcher.learn([self._point(at) for at, _ in known], [self._score(at, row) for at, row in known])
        finds: list[Shares] = []
        best, stale, lowest = math.inf, 0, start
        while stale < STALE and len(finds) < FINDS and (points := searcher.ask()):
            shares = [tuple(point[knob.name] for knob in self._knobs) for point in points]
            rows = self._drive(shares)
            if len(rows) < len(points):
                break  # the budget is spent
            scores = [self._score(at, row) for at, row in zip(shares, rows, strict=True)]
            finds += [at for at, row, s in zip(shares, rows, scores, strict=True) if row.failed and s < 0.0]
            k = min(range(len(scores)), key=lambda i: (scores[i], i))
            stale = 0 if scores[k] < best else stale + 1
            if scores[k] < best:
                best, lowest = scores[k], shares[k]
            searcher.tell(points, scores)
        self._behind += finds
        self._ended += [] if finds else [lowest]

    def _drive(self, shares: Sequence[Shares]) -> list[Row]:
        """The rows as far as the budget reaches; points that are known cost nothing."""
        keys = [self._campaign.key(self._campaign.space.values(at)) for at in shares]
        fresh: dict[str, Shares] = {}
        for key, at in zip(keys, shares, strict=True):
            if key not in self._known and len(self._known) + len(fresh) < self._budget:
                fresh.setdefault(key, at)
        for (key, at), row in zip(fresh.items(), self._campaign.rows(list(fresh.values()), "search"), strict=True):
            self._known[key] = (at, row)
        return [self._known[key][1] for key in keys if key in self._known]

    def _score(self, at: Shares, row: Row, ended: Sequence[Shares] = ()) -> float:
        """The objective; near what lies behind a failure is no find, and a pass is worth less."""
        if row.objective is None:
            return DULL
        near = max((1.0 - apart(at, other) / REACH for other in (*self._behind, *ended)), default=0.0)
        return row.objective if near <= 0.0 else max(row.objective, 0.0) + near

    def _start(self) -> Shares:
        """The worst drive that does not lie near a failure, nor where a round has ended."""
        known = enumerate(self._known.values())
        tried = [(self._score(at, row, self._ended), number, at) for number, (at, row) in known]
        return min(tried)[2]

    def _point(self, shares: Shares) -> Point:
        return {knob.name: share for knob, share in zip(self._knobs, shares, strict=True)}


def apart(one: Shares, other: Shares) -> float:
    """Root mean square over the axes of the difference of two points in shares of the ranges: 0 to 1."""
    return math.sqrt(sum((a - b) ** 2 for a, b in zip(one, other, strict=True)) / len(one))
