"""RunData: what the report of a run is drawn from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray


class RunData(TypedDict):
    """Plain data, for `reports` knows no log.

    columns     equally long arrays by name: `t` [s], `x`, `y` [m], `yaw` [rad], `v` [m/s], ... NaN = not measured
    objects     true boxes: name, kind, length, width [m] and arrays t [s], x, y (box centre [m]), yaw [rad]
    detections  table of detected boxes: arrays t, kind, x, y, yaw, length, width
    paths       (t [s], points (n, 2) [m]) of the planned path whenever it changed
    events      mappings with t [s], kind, element, text, file, line
    road        mappings with kind ("edge", "lane", "centre", "crosswalk") and points (n, 2) [m]
    meta        conditions of the run, JSON-able
    """

    columns: Mapping[str, NDArray[np.float64]]
    objects: Sequence[Mapping[str, Any]]
    detections: Mapping[str, Any]
    paths: Sequence[tuple[float, NDArray[np.float64]]]
    events: Sequence[Mapping[str, Any]]
    road: Sequence[Mapping[str, Any]]
    meta: Mapping[str, Any]
