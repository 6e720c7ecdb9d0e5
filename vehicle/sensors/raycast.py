"""Compiled ray casting of a scanning LiDAR against upright oriented boxes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray


@compiled
def _cast_box(
    depth: Any, box: Any, px: float, py: float, pz: float, yaw: float, first: float, pitch: float, rays: Any, tilts: Any
) -> None:
    """Shorten the horizontal distances in `depth` (azimuths, layers) by one box."""
    count = rays.shape[0]
    dx, dy = box[0] - px, box[1] - py
    half_l, half_w = 0.5 * box[4], 0.5 * box[5]
    low, high = box[2] - 0.5 * box[6] - pz, box[2] + 0.5 * box[6] - pz
    cb, sb = math.cos(box[3] - yaw), math.sin(box[3] - yaw)
    cy, sy = math.cos(yaw), math.sin(yaw)
    mx, my = cy * dx + sy * dy, -sy * dx + cy * dy  # box centre in the sensor frame
    # Sensor in the box frame
    ox, oy = -(cb * mx + sb * my), sb * mx - cb * my
    turn = 2.0 * math.pi / pitch  # azimuths of a full turn, those outside the field of view among them
    if abs(turn - round(turn)) < 1e-6:
        turn = float(round(turn))
    offset, span, laps = 0.0, count - 1.0, 0
    if abs(ox) > half_l or abs(oy) > half_w:
        middle = math.atan2(my, mx)
        least, most = 0.0, 0.0
        for corner in range(4):
            ex = half_l if corner & 1 else -half_l
            ey = half_w if corner & 2 else -half_w
            side = math.atan2(my + sb * ex + cb * ey, mx + cb * ex - sb * ey) - middle
            if side > math.pi:
                side -= 2.0 * math.pi
            elif side < -math.pi:
                side += 2.0 * math.pi
            least, most = min(least, side), max(most, side)
        offset, span, laps = (middle + least - first) / pitch, (most - least) / pitch, 1
    for lap in range(-laps, laps + 1):
        whole = math.floor(lap * turn)
        start = offset + (lap * turn - whole)
        begin, last = whole + math.ceil(start), whole + math.floor(start + span)
        for index in range(max(begin, 0), min(last, count - 1) + 1):
            rx, ry = rays[index, 0], rays[index, 1]
            bx, by = cb * rx + sb * ry, -sb * rx + cb * ry  # ray direction in the box frame
            near, far = 0.0, np.inf
            if bx != 0.0:
                t1, t2 = (-half_l - ox) / bx, (half_l - ox) / bx
                near, far = max(near, min(t1, t2)), min(far, max(t1, t2))
            elif abs(ox) > half_l:
                continue
            if by != 0.0:
                t1, t2 = (-half_w - oy) / by, (half_w - oy) / by
                near, far = max(near, min(t1, t2)), min(far, max(t1, t2))
            elif abs(oy) > half_w:
                continue
            if near > far:
                continue
            for layer in range(tilts.shape[0]):
                tilt = tilts[layer]
                t_in, t_out = near, far
                if tilt != 0.0:
                    t1, t2 = low / tilt, high / tilt
                    t_in, t_out = max(t_in, min(t1, t2)), min(t_out, max(t1, t2))
                elif low > 0.0 or high < 0.0:
                    continue
                if 0.0 < t_in <= t_out and t_in < depth[index, layer]:
                    depth[index, layer] = t_in


@compiled
def scan(
    boxes: FloatArray,
    px: float,
    py: float,
    pz: float,
    yaw: float,
    height: float,
    first: float,
    pitch: float,
    rays: FloatArray,
    tilts: FloatArray,
    reach: float,
    nearest: float,
    ground: bool,
    depth: FloatArray,
) -> int:
    """Cast all rays from a sensor at (px, py, pz) [m] with `yaw` [rad]; returns the number of returns.

    `boxes` (n, 9) as in Surroundings; `height` [m] of the sensor above flat ground; azimuths `first` + i `pitch` [rad]
    with their unit vectors `rays` (a, 2); `tilts` (l,) rise over run of each layer; returns between `nearest` and
    `reach` [m] count. `depth` (a, l) receives horizontal distances [m], infinite where nothing came back.
    """
    for layer in range(tilts.shape[0]):
        tilt = tilts[layer]
        start = -height / tilt if ground and tilt < 0.0 else np.inf
        for index in range(rays.shape[0]):
            depth[index, layer] = start
    for i in range(boxes.shape[0]):
        dx, dy = boxes[i, 0] - px, boxes[i, 1] - py
        if math.hypot(dx, dy) - 0.5 * math.hypot(boxes[i, 4], boxes[i, 5]) <= reach:
            _cast_box(depth, boxes[i], px, py, pz, yaw, first, pitch, rays, tilts)
    count = 0
    for layer in range(tilts.shape[0]):
        stretch = math.sqrt(1.0 + tilts[layer] ** 2)
        for index in range(rays.shape[0]):
            distance = depth[index, layer] * stretch
            if nearest <= distance <= reach:
                count += 1
            else:
                depth[index, layer] = np.inf
    return count


@compiled
def to_points(depth: FloatArray, rays: FloatArray, tilts: FloatArray, noise: FloatArray, sigma: float) -> FloatArray:
    """Points (n, 3) [m] in the sensor frame from `depth`, with range noise `sigma` [m] from `noise` (n,)."""
    points = np.empty((noise.shape[0], 3))
    n = 0
    for index in range(rays.shape[0]):
        for layer in range(tilts.shape[0]):
            distance = depth[index, layer]
            if distance < np.inf:
                distance += sigma * noise[n] / math.sqrt(1.0 + tilts[layer] ** 2)
                points[n, 0] = distance * rays[index, 0]
                points[n, 1] = distance * rays[index, 1]
                points[n, 2] = distance * tilts[layer]
                n += 1
    return points
