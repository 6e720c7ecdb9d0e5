"""What a scenario needs for a fault to matter, and whether a drive met it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytest_dvp.logs.log import Log

BEND = "a bend, or a junction"
OTHERS = "a road user in its way"
PEDESTRIAN = "a pedestrian"
STOP = "a stop at an obstacle or the goal"
LIGHT = "a traffic light that it meets at red"
CROSSWALK = "a crosswalk on its way"
PASSED = "something to pass"
GOAL = "a goal"
ROUTE = "a route"
SPEED = "a set speed"

TURNED = 0.35  # rad, chosen: 20 degrees of heading, more than a lane change takes
DROVE, STOOD = 1.0, 0.1  # m/s, chosen: faster than a car that creeps, and slower than the noise of a speed
NEAR = 5.0  # m, chosen: a crosswalk whose middle is nearer to the path than this lies across it
DEFINED_BY = {OTHERS: "missed_objects", LIGHT: "stop_line", PASSED: "passing_clearance", GOAL: "goal_reached"}
"""Metrics that a drive has only if it met that."""


def met(log: Log, metrics: Mapping[str, float | None]) -> list[str]:
    """The needs that a drive met, from its log and its metrics (None: undefined)."""
    found = [need for need, metric in DEFINED_BY.items() if metrics.get(metric) is not None]
    task = log.meta.get("task") or {}
    v = np.abs(log["v"])
    fast = np.flatnonzero(v > DROVE)
    also = {
        BEND: np.ptp(np.unwrap(log["yaw"])) > TURNED,
        PEDESTRIAN: any(track.kind == "pedestrian" for track in log.objects.values()),
        STOP: len(fast) > 0 and bool((v[fast[0] :] < STOOD).any()),
        CROSSWALK: any(_is_near(log, each["points"]) for each in log.road if each["kind"] == "crosswalk"),
        ROUTE: bool(task.get("route")),
        SPEED: task.get("set_speed") is not None,
    }
    return [*found, *(need for need, there in also.items() if there)]


def _is_near(log: Log, outline: object) -> bool:
    """Whether the middle of an outline (k, 2) lies beside the path that was driven."""
    x, y = np.asarray(outline, dtype=np.float64).mean(axis=0)
    return bool(np.hypot(log["x"] - x, log["y"] - y).min() < NEAR)
