"""Waypoints: points at fixed spacing along the middle of the route's lanes, made into a dense reference path."""

from __future__ import annotations

import math

import numpy as np

from ads.control.spline import spline_path
from ads.planning.route import Leg, Map
from machine_code import compiled
from vehicle.messages import FloatArray

SPACING = 2.0  # m between waypoints
STEP = 0.5  # m between path points
BEHIND = 15.0  # m of path before the start
BEYOND = 30.0  # m of path after the end of the route
JUMP = 0.3  # m sideways between neighbours: a lane change, not a bend


@compiled
def thin(line: FloatArray, spacing: float, blend: float) -> FloatArray:
    """Waypoints (k, 2) at `spacing` [m] from a line (n, >= 3) of x, y, heading.

    Where the line jumps sideways (a lane change of the route) the points within `blend` [m] are left out on both
    sides, so that the spline changes lanes smoothly.
    """
    n = len(line)
    keep = np.ones(n, np.uint8)
    along = np.zeros(n)
    for i in range(1, n):
        dx, dy = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
        along[i] = along[i - 1] + math.hypot(dx, dy)
    for i in range(1, n):
        dx, dy = line[i, 0] - line[i - 1, 0], line[i, 1] - line[i - 1, 1]
        side = abs(-dx * math.sin(line[i - 1, 2]) + dy * math.cos(line[i - 1, 2]))
        if side > JUMP and side > 0.5 * abs(dx * math.cos(line[i - 1, 2]) + dy * math.sin(line[i - 1, 2])):
            j = i - 1
            while j > 0 and along[i] - along[j] < blend:
                keep[j] = 0
                j -= 1
            j = i
            while j < n - 1 and along[j] - along[i] < blend:
                keep[j] = 0
                j += 1
    points = np.zeros((n, 2))
    k = 0
    last = -1e9
    for i in range(n):
        if keep[i] == 1 and (along[i] - last >= spacing - 1e-9 or (i == n - 1 and along[i] - last > 0.25 * spacing)):
            points[k, 0], points[k, 1] = line[i, 0], line[i, 1]
            k += 1
            last = along[i]
    return points[:k].copy()


def straight_path(x: float, y: float, yaw: float, length: float) -> FloatArray:
    """A straight reference path (n, COLUMNS) of a spline of `length` [m] from BEHIND metres before a pose."""
    c, s = math.cos(yaw), math.sin(yaw)
    along = np.array([-BEHIND, 0.5 * (length - BEHIND), length])
    path: FloatArray = spline_path(np.column_stack((x + c * along, y + s * along)), STEP)
    return path


def reference_path(network: Map, legs: tuple[Leg, ...], speed: float) -> FloatArray:
    """Dense path (n, COLUMNS) of a spline along the middle of `legs`, with straight run-in and run-out.

    `speed` [m/s] sets how long a lane change takes: 2 s to each side of the change, at least 8 m.
    """
    line = network.centreline(legs, SPACING / 4.0)
    points = thin(np.ascontiguousarray(line[:, :3]), SPACING, max(8.0, 2.0 * speed))
    if len(points) < 2:
        return straight_path(float(line[0, 0]), float(line[0, 1]), float(line[0, 2]), BEYOND)
    before, after = np.arange(-BEHIND, -0.5 * SPACING, SPACING), np.arange(SPACING, BEYOND, SPACING)
    head, tail = float(line[0, 2]), float(line[-1, 2])
    run_in = points[0] + np.outer(before, (math.cos(head), math.sin(head)))
    run_out = points[-1] + np.outer(after, (math.cos(tail), math.sin(tail)))
    path: FloatArray = spline_path(np.ascontiguousarray(np.vstack((run_in, points, run_out))), STEP)
    return path
