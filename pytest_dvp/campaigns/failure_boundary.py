"""Where passing ends and failing begins: a guess between the drives, with its doubt, and the drives that settle it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.parameter_space import Shares, Space
from pytest_dvp.campaigns.sampling import sobol
from pytest_dvp.campaigns.store import Row
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.tuning.searchers.gaussian_process import BATCH, CANDIDATES, chosen_length, predicted

EVEN = 0.3  # of the budget for the even sample that comes first: what it has no drive near is not refined
DOUBT = 1.96  # standard deviations by which a point may lie on the other side
CLIPPED = 1.0  # objectives beyond this say no more of where 0 is: as far as a bound that is not used at all
LEAST = 20  # judged drives, with at least LEAST_EACH of each kind, below which no boundary is told
LEAST_EACH = 3  # with one or two, leaving a drive out leaves nothing to guess from
MOST = 400  # drives that the guess rests on, those with the smallest objectives and the newest: it costs their cube
NEAR = 0.05  # share of a range: how far candidates lie from the drives that are nearest to the boundary
HALF = 0.5  # a guess of 80 drives of five parameters was wrong in 40 %, where 36 % failed: a picture of it misleads
FOLDS = 5  # of the cross-validation: each guess rests on four fifths of the drives


@dataclasses.dataclass(frozen=True)
class Boundary:
    """A Gaussian process of the objective over the shares of the axes.

    right  share 0 to 1 of the drives that were guessed on the right side from the others (cross-validation)
    rarer  share 0 to 0.5 of the drives that are of the rarer kind: as many are wrong if nothing is guessed
    """

    at: FloatArray
    objectives: FloatArray
    length: float
    right: float
    rarer: float

    @property
    def tells(self) -> bool:
        """Whether the guess is worth showing: it is wrong at most HALF as often as no guess at all."""
        return 1.0 - self.right <= HALF * self.rarer

    def fails(self, tried: FloatArray) -> FloatArray:
        """Probability (m,) [-] of a failure at shares (m, d) [-] of the axes, as far as the process is right."""
        mean, deviation = predicted(self.at, self.objectives, tried, self.length)
        return np.asarray(ndtr(-mean / np.maximum(deviation, 1e-9)))


def boundary_of(space: Space, rows: Sequence[Row]) -> Boundary | None:
    """The boundary that drives tell; None if they are too few, or hardly any failed or hardly any passed."""
    at, objectives = _judged(space, rows)
    if len(at) < LEAST or not LEAST_EACH <= int((objectives < 0.0).sum()) <= len(at) - LEAST_EACH:
        return None
    length = chosen_length(at, objectives)
    fold, right = np.arange(len(at)) % FOLDS, 0
    for k in range(FOLDS):
        mean, _ = predicted(at[fold != k], objectives[fold != k], at[fold == k], length)
        right += int(((mean < 0.0) == (objectives[fold == k] < 0.0)).sum())
    failed = float((objectives < 0.0).mean())
    return Boundary(at, objectives, length, right / len(at), min(failed, 1.0 - failed))


def refine_boundary(campaign: Campaign, budget: int, seed: int) -> list[Row]:
    """Drive `budget` points: an even sample, then those on whose side the drives so far are least sure.

    The same arguments ask for the same points, whatever the store holds. Sources: Bryan et al., Active learning for
    identifying function threshold boundaries, NIPS 2005 (the straddle); Ginsbourger et al., Kriging is well-suited to
    parallelize optimization, 2010 (a batch believes its own predictions).
    """
    size, rng = len(campaign.space.axes), np.random.default_rng(seed)
    first = min(max(2 * size + 2, round(EVEN * budget)), budget)
    rows = campaign.rows([campaign.space.nominal_shares, *sobol(size, first - 1, seed)], "sample")
    known = {row.key for row in rows}
    while len(known) < budget:
        at, objectives = _judged(campaign.space, rows)
        if len(at) < 2:
            picked = [tuple(map(float, row)) for row in rng.random((BATCH, size))]
        else:
            picked = _least_sure(at, objectives, rng, size)
        new = [row for row in campaign.rows(picked[: budget - len(known)], "search") if row.key not in known]
        if not new:
            break  # a space of few values is exhausted
        rows += new
        known |= {row.key for row in new}
    return rows


def _least_sure(at: FloatArray, objectives: FloatArray, rng: np.random.Generator, size: int) -> list[Shares]:
    length = chosen_length(at, objectives)
    near = at[np.argsort(np.abs(objectives), kind="stable")[:10]]
    picked: list[Shares] = []
    for _ in range(BATCH):
        local = near[rng.integers(len(near), size=CANDIDATES // 4)]
        local = np.clip(local + rng.normal(0.0, NEAR, local.shape), 0.0, 1.0)
        tried = np.vstack([rng.random((CANDIDATES - len(local), size)), local])
        mean, deviation = predicted(at, objectives, tried, length)
        k = int(np.argmax(DOUBT * deviation - np.abs(mean)))
        picked.append(tuple(float(share) for share in tried[k]))
        at, objectives = np.vstack([at, tried[k]]), np.append(objectives, mean[k])
    return picked


def _judged(space: Space, rows: Sequence[Row]) -> tuple[FloatArray, FloatArray]:
    """Shares (n, d) and clipped objectives (n,) of the drives that were judged, at most MOST."""
    judged = [(number, row, row.objective) for number, row in enumerate(rows) if row.objective is not None]
    if len(judged) > MOST:
        judged = sorted(judged, key=lambda each: (abs(each[2]), -each[0]))[:MOST]
    at = np.array([[axis.share_of(row.parameters) for axis in space.axes] for _, row, _ in judged], dtype=float)
    return at, np.clip(np.array([objective for _, _, objective in judged], dtype=float), -CLIPPED, CLIPPED)
