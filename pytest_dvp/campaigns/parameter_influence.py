"""How much of each margin every parameter decides, from the evenly spread drives of a campaign."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from pytest_dvp.campaigns.parameter_space import Space
from pytest_dvp.campaigns.store import EXCLUDED, Row
from pytest_dvp.campaigns.variance_shares import first_order, shapley, with_error

LEAST = 40  # drives below which nothing is told: bins of fewer than 5 drives show noise
LEAST_DEPENDENT = 100  # and for Shapley effects, which compare drives with their 20 nearest
EVEN = "sample"  # purpose of the drives that are spread evenly; those of a search lie where it looked
JUDGED = 0.95  # share of the drives that must have been measured: what is left out makes the others dependent, too
SHOWN = 5  # gates beside the objective, those that failed most or came nearest
OBJECTIVE = "the tightest gate"


@dataclasses.dataclass(frozen=True)
class Influence:
    """Shares of the variance, by result and parameter: (share, its standard error).

    dependent  why the parameters depend on each other, and the shares are Shapley effects; "" if they do not, and the
               shares are what each parameter explains alone
    shares     {"the tightest gate" or a gate: {parameter: (share, error)}}
    drives     how many were looked at
    """

    dependent: str
    shares: Mapping[str, Mapping[str, tuple[float, float]]]
    drives: int


def influence(space: Space, rows: Sequence[Row]) -> Influence | None:
    """Of the objective and of the margins that failed most; None below LEAST evenly spread drives, or if none varies.

    Parameters of a campaign are drawn independently. Where a constraint of the scenario excludes some draws, those
    that are left depend on each other, and a share that each explains alone says too much.
    """
    even = [row for row in rows if row.purpose == EVEN]
    driven = [row for row in even if row.verdict != EXCLUDED]
    judged = [row for row in driven if row.objective is not None]
    if len(judged) < LEAST:
        return None
    dependent = ""
    excluded = [row for row in even if row.verdict == EXCLUDED]
    if excluded:
        dependent = (
            f"{len(excluded)} of {len(even)} draws are outside the scenario's constraints: {excluded[0].message}"
        )
    elif len(judged) < JUDGED * len(driven):
        dependent = f"{len(driven) - len(judged)} of {len(driven)} drives measured nothing"
    if dependent and len(judged) < LEAST_DEPENDENT:
        return None
    x = np.array([[axis.share_of(row.parameters) for axis in space.axes] for row in judged])
    results = _results(judged)
    if OBJECTIVE not in results:
        return None
    found, error = with_error(shapley if dependent else first_order, x, np.array(list(results.values())).T)
    shares = {
        name: {axis.name: (float(found[k, r]), float(error[k, r])) for k, axis in enumerate(space.axes)}
        for r, name in enumerate(results)
    }
    return Influence(dependent, shares, len(judged))


def _results(rows: Sequence[Row]) -> dict[str, list[float]]:
    """What varies of the objective, and of the margins that were measured in all these drives, the nearest first."""
    found = {OBJECTIVE: [float(row.objective) for row in rows if row.objective is not None]}
    margins: dict[str, list[float]] = {}
    for name in rows[0].margins:
        values = [row.margins.get(name) for row in rows]
        if all(value is not None for value in values):
            margins[name] = [float(value) for value in values if value is not None]
    failed = {name: sum(row.failed and row.gate == name for row in rows) for name in margins}
    nearest = sorted(margins, key=lambda name: (-failed[name], min(margins[name]), name))
    found |= {name: margins[name] for name in nearest[:SHOWN]}
    return {name: values for name, values in found.items() if np.std(values) > 1e-12 * np.abs(values).max()}
