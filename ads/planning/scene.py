"""Objects seen from the path: where they are along and across it, and when the car would touch one."""

from __future__ import annotations

import math

import numpy as np

from ads.control.spline import project, sample
from machine_code import compiled
from vehicle.messages import Detection, FloatArray

PLACED = 6
"""Columns of a placed object: s_from, s_to, l_from, l_to [m], speed along and across the path [m/s]."""
OBJECT = 7
"""Columns of an object: centre x, y [m], yaw [rad], length, width [m], vx, vy [m/s]."""

REACH = 260  # path points to both sides in which objects are looked for
LANE_SPEED = 1.5  # m/s
LANE_DRIFT = 0.25  # of the speed along the path
STILL = 0.45  # m/s; slower counts as standing, a tracker's velocity is no better


def objects_of(detections: tuple[Detection, ...]) -> FloatArray:
    """Array (n, OBJECT) of detections in SI units; what moves slower than STILL stands still."""
    rows = np.empty((len(detections), OBJECT))
    for i, d in enumerate(detections):
        moving = d.vx * d.vx + d.vy * d.vy > STILL * STILL
        rows[i] = (d.x, d.y, d.yaw, d.length, d.width, d.vx if moving else 0.0, d.vy if moving else 0.0)
    return rows


@compiled
def place(path: FloatArray, index: int, objects: FloatArray) -> FloatArray:
    """Objects (n, OBJECT) in coordinates of a path near point `index`: (n, PLACED)."""
    out = np.empty((len(objects), PLACED))
    for i in range(len(objects)):
        o = objects[i]
        k, s, middle = project(path, o[0], o[1], index, REACH)
        _, _, heading, _, _ = sample(path, k, s)
        c, d = abs(math.cos(o[2] - heading)), abs(math.sin(o[2] - heading))
        along, across = 0.5 * (o[3] * c + o[4] * d), 0.5 * (o[3] * d + o[4] * c)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = s - along, s + along, middle - across, middle + across
        c, d = math.cos(heading), math.sin(heading)
        out[i, 4], out[i, 5] = o[5] * c + o[6] * d, o[6] * c - o[5] * d
    return out


@compiled
def boxes_touch(
    ax: float, ay: float, ayaw: float, al: float, aw: float, bx: float, by: float, byaw: float, bl: float, bw: float
) -> bool:
    """Whether two oriented boxes overlap: middle [m], yaw [rad], half length, half width [m] (separating axes)."""
    dx, dy = bx - ax, by - ay
    c, s = math.cos(byaw - ayaw), math.sin(byaw - ayaw)
    c, s = abs(c), abs(s)
    ca, sa = math.cos(ayaw), math.sin(ayaw)
    if abs(dx * ca + dy * sa) > al + bl * c + bw * s or abs(dy * ca - dx * sa) > aw + bl * s + bw * c:
        return False
    cb, sb = math.cos(byaw), math.sin(byaw)
    return abs(dx * cb + dy * sb) <= bl + al * c + aw * s and abs(dy * cb - dx * sb) <= bw + al * s + aw * c


@compiled
def keeps_lane(row: FloatArray) -> bool:
    """True if a placed object (PLACED,) drives along the path, with or against it: it will follow the road's bends.

    It has at least LANE_SPEED [m/s] along the path and little across it.
    """
    return bool(abs(row[4]) > LANE_SPEED and abs(row[5]) < LANE_DRIFT * abs(row[4]))


@compiled
def first_contact(
    path: FloatArray,
    reference: FloatArray,
    index: int,
    s: float,
    v: float,
    half_length: float,
    half_width: float,
    center_x: float,
    objects: FloatArray,
    placed: FloatArray,
    horizon: float,
) -> float:
    """Time [s] until the car, driving on along `path` at `v` [m/s], touches an object; inf if later than `horizon`.

    What drives along the road is taken to keep its place across the `reference` path, anything else moves straight on.
    The car's box: half sizes [m], its middle `center_x` ahead of the axle. `objects` (n, OBJECT), `placed` (n, PLACED).
    """
    step = 0.1
    n = len(objects)
    if n == 0:
        return math.inf
    reach = v * horizon + 2.0 * half_length + center_x
    near = np.empty(n, np.int64)
    m = 0
    x0, y0, _, _, _ = sample(path, index, s)
    for i in range(n):
        o = objects[i]
        size = 0.5 * math.hypot(o[3], o[4])
        if math.hypot(o[0] - x0, o[1] - y0) <= reach + size + math.hypot(o[5], o[6]) * horizon:
            near[m] = i
            m += 1
    for k in range(int(horizon / step) + 1):
        if m == 0:
            break
        t = k * step
        x, y, yaw, _, _ = sample(path, index, s + v * t)
        cx, cy = x + center_x * math.cos(yaw), y + center_x * math.sin(yaw)
        for j in range(m):
            o, row = objects[near[j]], placed[near[j]]
            bx, by, turn = o[0] + o[5] * t, o[1] + o[6] * t, 0.0
            if keeps_lane(row):
                along, across = 0.5 * (row[0] + row[1]), 0.5 * (row[2] + row[3])
                _, _, before, _, _ = sample(reference, index, along)
                px, py, after, _, _ = sample(reference, index, along + row[4] * t)
                across += row[5] * t
                bx, by, turn = px - across * math.sin(after), py + across * math.cos(after), after - before
            if boxes_touch(cx, cy, yaw, half_length, half_width, bx, by, o[2] + turn, 0.5 * o[3], 0.5 * o[4]):
                return t
    return math.inf
