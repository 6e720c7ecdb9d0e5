"""The map of a campaign as plain data, for reports/campaign.py."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.parameter_influence import OBJECTIVE, Influence, influence
from pytest_dvp.campaigns.reproducer import Reproducer
from pytest_dvp.campaigns.store import EXCLUDED, Row
from pytest_dvp.campaigns.summary import cluster_name, summary

PAGE = "map.html"
MOST = 3000  # drives that are drawn: all failures, and the newest of the others


def map_page(
    campaign: Campaign, rows: Sequence[Row], found: Sequence[Reproducer], probability: dict[str, Any] | None,
    tried: Sequence[str] = (),
) -> dict[str, Any]:  # fmt: skip
    """What `reports.campaign.write_campaign_page` takes, for one scenario. `tried`: sentences on the coverage."""
    told = influence(campaign.space, rows)
    names = [axis.name for axis in campaign.space.axes]
    if told is not None:
        names.sort(key=lambda name: -told.shares[OBJECTIVE][name][0])
    failed = [row for row in rows if row.failed]
    shown = [
        *[row for row in rows if not row.failed and row.verdict != EXCLUDED][-max(MOST - len(failed), 0) :],
        *failed[:MOST],
    ]
    return {
        "scenario": str(campaign.space.file),
        "summary": summary(rows),
        "influence": None if told is None else _influence(told, names),
        "axes": [_axis(campaign, name) for name in names],
        "points": [
            {
                "values": [_number(campaign, name, row) for name in names],
                "verdict": row.verdict,
                "cluster": cluster_name(row) if row.failed else "",
                "objective": row.objective,
                "label": ", ".join(f"{n}={v}" for n, v in row.parameters.items()) + f": {row.message}",
            }
            for row in shown
        ],
        "clusters": [each.as_dict() for each in found],
        "probability": probability,
        "tried": list(tried),
    }


def _influence(told: Influence, names: Sequence[str]) -> dict[str, Any]:
    """A row for each parameter, a column for each result: share and its standard error."""
    return {
        "dependent": told.dependent,
        "drives": told.drives,
        "results": list(told.shares),
        "rows": [{"name": name, "cells": [shares[name] for shares in told.shares.values()]} for name in names],
    }


def _axis(campaign: Campaign, name: str) -> dict[str, Any]:
    """Name, ends and nominal place of an axis: its value, or the share of a list of words."""
    axis = next(axis for axis in campaign.space.axes if axis.name == name)
    low, high = axis.at(1e-4), axis.at(1.0 - 1e-4)
    try:
        ends = [float(low[name]), float(high[name])]
        nominal = float(axis.nominal[name])
    except (KeyError, ValueError):
        ends, nominal = [0.0, 1.0], axis.share_of(axis.nominal)
    return {"name": name, "low": min(*ends, nominal), "high": max(*ends, nominal), "nominal": nominal}


def _number(campaign: Campaign, name: str, row: Row) -> float:
    try:
        return float(row.parameters[name])
    except (KeyError, ValueError):
        return next(axis for axis in campaign.space.axes if axis.name == name).share_of(row.parameters)
