"""Hypothesis as a way to choose drives: it draws shares of the axes, and `target` leads it to small objectives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.parameter_space import Axis
from pytest_dvp.campaigns.store import Row

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


def search_by_hypothesis(campaign: Campaign, budget: int, seed: int) -> list[Row]:
    """Drive up to `budget` points that Hypothesis chooses, one after the other; the rows in the order asked for.

    It asks for fewer where the space has fewer values. Nothing is remembered between calls: the same seed asks for the
    same points. A vacuous drive, and one that measured nothing, is no aim.

    Source: Loescher and Sagonas, Targeted property-based testing, ISSTA 2017; `hypothesis.target`.
    """
    import hypothesis
    from hypothesis import HealthCheck, Phase
    from hypothesis import strategies as st

    shares = [_share(axis) for axis in campaign.space.axes]
    found: dict[str, Row] = {}

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=budget, database=None, deadline=None, phases=(Phase.generate, Phase.target),
        suppress_health_check=list(HealthCheck), print_blob=False,
    )  # fmt: skip
    @hypothesis.given(st.tuples(*shares))
    def driven(point: tuple[float, ...]) -> None:
        if len(found) >= budget:
            return
        row = campaign.rows([point], "search")[0]
        found[row.key] = row
        if row.objective is not None and not row.vacuous:
            hypothesis.target(-row.objective)

    driven()
    return list(found.values())


def _share(axis: Axis) -> SearchStrategy[float]:
    """A share of an axis: anywhere on a continuous one, the middle of a value on one of `count` values."""
    from hypothesis import strategies as st

    if axis.count is None:
        return st.floats(0.0, 1.0)
    return st.integers(0, axis.count - 1).map(axis.middle)
