"""How much of the objective each parameter decides alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.campaigns.parameter_space import Space
from pytest_dvp.campaigns.store import Row

LEAST = 40  # drives below which nothing is told: bins of fewer than 5 drives show noise
EVEN = "sample"  # purpose of the drives that are spread evenly; those of a search lie where it looked


def influence(space: Space, rows: Sequence[Row]) -> dict[str, float] | None:
    """Share of the variance of the objective that each parameter explains alone, 0 to 1; None below LEAST drives.

    First-order Sobol indices from given data: variance of the mean over bins of one parameter, less what the noise in
    the bins adds to it. Only drives that were sampled evenly count, and the parameters of a campaign are independent,
    which the indices need. Source: Plischke, Borgonovo, Smith, Global sensitivity measures from given data, European
    Journal of Operational Research 226 (2013).
    """
    even = [row for row in rows if row.purpose == EVEN and row.objective is not None]
    values = np.array([row.objective for row in even], dtype=float)
    if len(even) < LEAST or not values.std() > 0.0:
        return None
    bins = max(4, min(12, round(len(even) ** 0.5 / 2)))
    found = {}
    for axis in space.axes:
        shares = np.array([axis.share_of(row.parameters) for row in even])
        which = np.minimum((np.argsort(np.argsort(shares, kind="stable")) * bins) // len(even), bins - 1)
        groups = [values[which == k] for k in range(bins)]
        means = np.array([group.mean() for group in groups])
        noise = float(np.mean([group.var(ddof=1) / len(group) for group in groups]))
        found[axis.name] = float(np.clip((means.var() - noise) / values.var(), 0.0, 1.0))
    return found
