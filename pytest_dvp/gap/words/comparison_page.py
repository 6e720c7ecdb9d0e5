"""What the report page of a comparison shows, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from openscenario.findings import Finding
from pytest_dvp.gap.compare.compare import Comparison
from pytest_dvp.gap.compare.regimes import LATERAL, LONGITUDINAL, REGIMES, ribbon, speed_bins
from pytest_dvp.gap.words.comparison import covered, headline, not_judged, skipped, slid
from pytest_dvp.logs.log_contents import FloatArray

SMOOTHED = 0.5  # s over which the error along the path is averaged


def page_of(
    name: str, comparison: Comparison, findings: Sequence[Finding] = (), mapping: Sequence[Mapping[str, str]] = ()
) -> dict[str, Any]:
    """Input of `reports.compare.write_compare_report` for one log. findings: the doctor's warnings about it; mapping: a
    row for each signal that a mapping file names (`mapping_rows`)."""
    along, across = _track_errors(comparison)
    return {
        "log": name,
        "model": comparison.model,
        "headline": headline(comparison),
        "covered": covered(comparison),
        "alignment": {"lag": comparison.alignment.lag, "coverage": comparison.alignment.coverage},
        "signals": {
            key: {**score.as_dict(), "noise": comparison.noise[key]} for key, score in comparison.signals.items()
        },
        "where": [{**where.as_dict(), "kind": where.kind} for where in comparison.where],
        "skipped": skipped(comparison.not_compared),
        "not_judged": not_judged(comparison),
        "unjudged": slid(comparison),
        "mapping": mapping,
        "warnings": [f"{finding.code} {finding.element}: {finding.message}" for finding in findings],
        "t": comparison.t,
        "measured": comparison.measured,
        "modelled": comparison.modelled,
        "residuals": {**comparison.residuals, **({"along": along, "across": across} if along is not None else {})},
        "ribbons": {
            "along": ribbon(comparison.regimes, LONGITUDINAL, comparison.t),
            "turns": ribbon(comparison.regimes, LATERAL, comparison.t),
        },
        "groups": _groups(comparison),
        "segments": comparison.t[comparison.segments.starts],
        "position": comparison.position,
        "error": _error(comparison),
    }  # fmt: skip


def _groups(comparison: Comparison) -> dict[str, dict[str, float | None]]:
    """RMS error in units of the noise, by group and channel; None without samples."""
    masks = {name: comparison.regimes[name] for name in REGIMES} | speed_bins(comparison.speed)
    table: dict[str, dict[str, float | None]] = {}
    for group, mask in masks.items():
        row: dict[str, float | None] = {}
        for channel, values in comparison.residuals.items():
            picked = values[mask]
            picked = picked[np.isfinite(picked)]
            row[channel] = float(np.sqrt(np.mean(picked**2)) / comparison.noise[channel]) if len(picked) else None
        if any(value is not None for value in row.values()):
            table[group] = row
    return table


def _error(comparison: Comparison) -> FloatArray:
    """RMS over the channels of residual/noise (n,), averaged over half a second."""
    stack = np.array([(comparison.residuals[name] / comparison.noise[name]) ** 2 for name in comparison.signals])
    known = np.isfinite(stack)
    power = np.where(known, stack, 0.0).sum(axis=0)
    count = known.sum(axis=0).astype(np.float64)
    step = float(np.median(np.diff(comparison.t)))
    half = max(1, round(0.5 * SMOOTHED / step))
    i = np.arange(len(power))
    low, high = np.maximum(i - half, 0), np.minimum(i + half + 1, len(power))
    total, many = np.concatenate([[0.0], np.cumsum(power)]), np.concatenate([[0.0], np.cumsum(count)])
    samples = many[high] - many[low]
    return np.asarray(np.where(samples > 0.0, np.sqrt((total[high] - total[low]) / np.maximum(samples, 1.0)), np.nan))


def _track_errors(comparison: Comparison) -> tuple[FloatArray | None, FloatArray | None]:
    """Position error [m] along and across the measured heading."""
    rest = comparison.residuals
    if "x" not in rest or "y" not in rest or "yaw" not in comparison.measured:
        return None, None
    c, s = np.cos(comparison.measured["yaw"]), np.sin(comparison.measured["yaw"])
    return c * rest["x"] + s * rest["y"], c * rest["y"] - s * rest["x"]
