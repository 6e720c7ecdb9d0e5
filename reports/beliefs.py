"""What the stack believed against what was true, over time: rows of the timeline made from the series of metrics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.figures import BLUE, GREEN, PURPLE, Figure, curve, numbers, thin


class ChartRow(NamedTuple):
    """A further row of the timeline: y axis, title, height [px], what is drawn on it."""

    axis: str
    title: str
    height: float
    traces: list[Figure]


def belief_rows(
    metrics: Mapping[str, Mapping[str, Any]], columns: Mapping[str, NDArray[np.float64]]
) -> tuple[ChartRow, ...]:
    """Driven against planned path, estimated against true position and heading, detections against true road users.

    Each from the series of its metric (`lateral_rmse_path`, `localization_error`, `detection_error` [m],
    `heading_error` [rad]); a metric without one gives no row. The standard deviation that the stack itself states
    (`ads.position_sigma`) stands beside its error.

    Columns (n,) by name, in the units of the log.
    """
    rows = []
    off = _series(metrics, "lateral_rmse_path")
    if off is not None:
        trace = curve(off["t"], off["value"], "left of the planned path", "y7", colour=BLUE, unit="m")
        rows.append(ChartRow("y7", "driven −<br>planned [m]", 78.0, [trace]))
    pose = _series(metrics, "localization_error")
    if pose is not None:
        traces = [curve(pose["t"], pose["value"], "estimated − true position", "y8", colour=BLUE, unit="m")]
        if "ads.position_sigma" in columns and np.isfinite(columns["ads.position_sigma"]).any():
            sigma = columns["ads.position_sigma"]
            words = "1 σ that the ADS states"
            stated = curve(columns["t"], sigma, words, "y8", colour=GREEN, dash="dot", unit="m", legend=words)
            traces.insert(0, stated)
        rows.append(ChartRow("y8", "estimated −<br>true [m]", 78.0, traces))
    heading = _series(metrics, "heading_error")
    if heading is not None:
        degrees = np.degrees(np.asarray(heading["value"], dtype=np.float64))
        trace = curve(heading["t"], degrees, "estimated − true heading", "y10", colour=BLUE, unit="deg")
        rows.append(ChartRow("y10", "heading −<br>true [deg]", 78.0, [trace]))
    seen = _series(metrics, "detection_error")
    if seen is not None:
        t, error = thin(seen["t"], seen["value"])
        points = {
            "type": "scatter", "mode": "markers", "name": "detected − true", "x": numbers(t, 3), "y": numbers(error),
            "xaxis": "x", "yaxis": "y9", "showlegend": False, "marker": {"size": 3.5, "color": PURPLE},
            "hovertemplate": "detected − true %{y:.2f} m<extra></extra>",
        }  # fmt: skip
        rows.append(ChartRow("y9", "detected −<br>true [m]", 78.0, [points]))
    return tuple(rows)


def _series(metrics: Mapping[str, Mapping[str, Any]], name: str) -> Mapping[str, Any] | None:
    series = (metrics.get(name) or {}).get("series")
    return series if series and len(series["t"]) else None
