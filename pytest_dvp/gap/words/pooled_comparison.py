"""Several logs of one model as one answer in the shape of `compare --json`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from pytest_dvp.gap.compare.compare import Comparison, SignalScore


def pooled(comparisons: Mapping[str, Comparison]) -> dict[str, Any]:
    """One document for one or more comparisons by log name.

    One log: its own. Several: RMSE and chi^2/N over all samples, the other figures as means weighted by samples
    (coverage by time), `where` by share of the error of all logs (segments and places named with their log), and `logs`
    with each one's own document.
    """
    if len(comparisons) == 1:
        return next(iter(comparisons.values())).as_dict()
    everything = list(comparisons.values())
    names = list(dict.fromkeys(name for one in everything for name in one.signals))
    return {
        "alignment": {
            "lag": float(np.average([one.alignment.lag for one in everything], weights=[len(c.t) for c in everything])),
            "coverage": float(
                np.average(
                    [one.alignment.coverage for one in everything], weights=[c.t[-1] - c.t[0] for c in everything]
                )
            ),
        },
        "signals": {name: _signal(name, everything) for name in names},
        "where": _where(comparisons),
        "logs": [{"log": name, **one.as_dict()} for name, one in comparisons.items()],
    }


def _signal(name: str, comparisons: list[Comparison]) -> dict[str, Any]:
    parts = [(one.signals[name], _count(one, name)) for one in comparisons if name in one.signals]
    parts = [(score, count) for score, count in parts if count]
    result: dict[str, Any] = {}
    for field in dataclasses.fields(SignalScore):
        values = [(getattr(score, field.name), count) for score, count in parts]
        if field.name == "unit":
            result["unit"] = next((one.signals[name].unit for one in comparisons if name in one.signals), "")
            continue
        known = [(value, count) for value, count in values if value is not None and math.isfinite(value)]
        if not known:
            result[field.name] = None
            continue
        total = sum(count for _, count in known)
        power = 2.0 if field.name in ("rmse", "nrmse") else 1.0
        result[field.name] = (sum(value**power * count for value, count in known) / total) ** (1.0 / power)
    return result


def _where(comparisons: Mapping[str, Comparison]) -> list[dict[str, Any]]:
    energy: dict[str, float] = {}
    time: dict[str, float] = {}
    for one in comparisons.values():
        for channel, values in one.residuals.items():
            energy[channel] = energy.get(channel, 0.0) + float(np.nansum(values**2))
            time[channel] = time.get(channel, 0.0) + _count(one, channel)
    sums: dict[tuple[str, str], list[float]] = {}
    for log, one in comparisons.items():
        for entry in one.where:
            values = one.residuals[entry.channel]
            regime = entry.regime if entry.kind in ("regime", "speed") else f"{log} {entry.regime}"
            pair = sums.setdefault((entry.channel, regime), [0.0, 0.0])
            pair[0] += entry.share_of_error * float(np.nansum(values**2)) / max(energy[entry.channel], 1e-300)
            pair[1] += entry.share_of_time * _count(one, entry.channel) / max(time[entry.channel], 1.0)
    ordered = sorted(sums.items(), key=lambda item: (item[1][1] - item[1][0], item[0]))
    return [
        {"channel": channel, "regime": regime, "share_of_error": error, "share_of_time": share}
        for (channel, regime), (error, share) in ordered
    ]


def _count(one: Comparison, channel: str) -> int:
    return int(np.isfinite(one.residuals[channel]).sum())
