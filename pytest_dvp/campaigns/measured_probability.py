"""The probability of failure of a scenario's drives, under the distributions that are declared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.failure_probability import Probability, clopper_pearson
from pytest_dvp.campaigns.rare_failures import rare_probability
from pytest_dvp.campaigns.store import EXCLUDED, Row
from pytest_dvp.logs.log_contents import FloatArray


def counted_probability(rows: Sequence[Row]) -> Probability:
    """Of independent draws within the scenario's constraints. Raises ValueError if there is none."""
    rows = [row for row in rows if row.verdict != EXCLUDED]
    failures = sum(_objective(row) < 0.0 for row in rows)
    return clopper_pearson(failures, sum(bool(np.isnan(_objective(row))) for row in rows), len(rows))


def measured_probability(campaign: Campaign, budget: int, seed: int) -> Probability:
    """Of a rare failure, with about `budget` drives."""

    def judge(points: FloatArray) -> FloatArray:
        """Objectives (n,) without unit of points (n, d) in shares of the axes."""
        rows = campaign.rows([tuple(float(share) for share in point) for point in points], "probability")
        return np.array([_objective(row) for row in rows])

    return rare_probability(judge, len(campaign.space.axes), budget, seed)


def _objective(row: Row) -> float:
    """NaN where a drive decides nothing: INCONCLUSIVE, or the run itself broke; it then widens the interval."""
    if row.verdict == EXCLUDED:  # a weighted draw that cannot happen: no failure of all draws
        return 1.0
    if row.verdict not in ("PASS", "FAIL"):
        return float("nan")
    if row.objective is None:
        return 1.0 if row.verdict == "PASS" else -1.0
    return row.objective
