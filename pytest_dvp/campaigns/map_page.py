"""The map of a campaign as plain data, for reports/campaign.py."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.failure_boundary import boundary_of
from pytest_dvp.campaigns.parameter_influence import OBJECTIVE, Influence, influence
from pytest_dvp.campaigns.reproducer import Reproducer
from pytest_dvp.campaigns.store import EXCLUDED, Row
from pytest_dvp.campaigns.summary import cluster_name, summary

PAGE = "map.html"
SHADED = 20  # cells of a plot in each direction that are shaded: 5 % of a range, as fine as the eye asks for
LISTED = 1000  # values of a list that are looked at for its place in a plot: beyond, neighbours look the same
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
        "boundary": _boundary(campaign, rows, names),
        "probability": probability,
        "tried": list(tried),
    }


def _boundary(campaign: Campaign, rows: Sequence[Row], names: Sequence[str]) -> dict[str, Any] | None:
    """For each pair of parameters, in the order of the plots, how likely a failure is where the others are nominal:
    SHADED rows of SHADED cells, the first row at the lowest values; none where the guess tells too little. And how
    often such a guess was right."""
    space = campaign.space
    found = boundary_of(space, [row for row in rows if row.verdict != EXCLUDED])
    if found is None:
        return None
    told = {"right": found.right, "rarer": found.rarer}
    if not found.tells:
        return {**told, "slices": []}
    index = {axis.name: k for k, axis in enumerate(space.axes)}
    slices = []
    for across, up in itertools.combinations(names, 2):
        at = np.tile(np.array(space.nominal_shares, dtype=float), (SHADED * SHADED, 1))
        at[:, index[across]] = np.tile(_cells(campaign, across), SHADED)
        at[:, index[up]] = np.repeat(_cells(campaign, up), SHADED)
        slices.append(found.fails(at).reshape(SHADED, SHADED).round(2).tolist())
    return {**told, "slices": slices}


def _cells(campaign: Campaign, name: str) -> list[float]:
    """Shares of an axis at the middles of SHADED equal steps of its plot; of a list that of the nearest value."""
    axis, ends = next(axis for axis in campaign.space.axes if axis.name == name), _axis(campaign, name)
    middles = [ends["low"] + (k + 0.5) / SHADED * (ends["high"] - ends["low"]) for k in range(SHADED)]
    if axis.count is None:
        return [axis.share_of({**axis.nominal, name: repr(value)}) for value in middles]
    picked = np.unique(np.round(np.linspace(0, axis.count - 1, min(axis.count, LISTED))))
    shares = np.array([axis.middle(int(k)) for k in picked])
    try:
        values = np.array([float(axis.at(share)[name]) for share in shares])
    except (KeyError, ValueError):  # words, and values that are set together, are drawn at their shares
        values = shares
    return [float(shares[np.argmin(np.abs(values - value))]) for value in middles]


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
