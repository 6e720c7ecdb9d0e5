"""Compiled view of a pinhole camera: where boxes appear and how much of each is hidden."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray

NEAR = 0.3  # m, what is closer is not imaged
ACROSS, DOWN = 7, 5  # sample points on each box for occlusion


@compiled
def _entry(box: Any, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float) -> float:
    """Ray parameter where the ray o + t d enters an upright box, infinite if it misses."""
    px, py, pz = ox - box[0], oy - box[1], oz - box[2]
    beside = dx * py - dy * px
    if 4.0 * beside * beside > (box[4] * box[4] + box[5] * box[5]) * (dx * dx + dy * dy):
        return np.inf  # passes the box's circumscribed circle
    c, s = math.cos(box[3]), math.sin(box[3])
    near, far = 0.0, np.inf
    for axis in range(3):
        if axis == 0:
            o, d = c * px + s * py, c * dx + s * dy
        elif axis == 1:
            o, d = -s * px + c * py, -s * dx + c * dy
        else:
            o, d = pz, dz
        half = 0.5 * box[4 + axis]
        if d != 0.0:
            t1, t2 = (-half - o) / d, (half - o) / d
            near, far = max(near, min(t1, t2)), min(far, max(t1, t2))
        elif abs(o) > half:
            return np.inf
    return near if near <= far else np.inf


@compiled
def _image_box(
    box: Any, px: float, py: float, pz: float, c: float, s: float, focal: float, cu: float, cv: float, out: Any
) -> bool:
    """Image rectangle of a box's corners, before clipping; False if a corner is not in front of the camera."""
    cb, sb = math.cos(box[3]), math.sin(box[3])
    out[0], out[1], out[2], out[3] = np.inf, np.inf, -np.inf, -np.inf
    for corner in range(8):
        ex = 0.5 * box[4] if corner & 1 else -0.5 * box[4]
        ey = 0.5 * box[5] if corner & 2 else -0.5 * box[5]
        ez = 0.5 * box[6] if corner & 4 else -0.5 * box[6]
        wx, wy, wz = box[0] + cb * ex - sb * ey - px, box[1] + sb * ex + cb * ey - py, box[2] + ez - pz
        ahead, left = c * wx + s * wy, -s * wx + c * wy
        if ahead < NEAR:
            return False
        u, v = cu - focal * left / ahead, cv - focal * wz / ahead
        out[0], out[1] = min(out[0], u), min(out[1], v)
        out[2], out[3] = max(out[2], u), max(out[3], v)
    return True


@compiled
def view(
    boxes: FloatArray,
    px: float,
    py: float,
    pz: float,
    yaw: float,
    focal: float,
    width: float,
    height: float,
    reach: float,
    out: FloatArray,
) -> int:
    """Boxes as a camera at (px, py, pz) [m], looking along `yaw` [rad], images them; returns how many.

    `boxes` (n, 9) as in Surroundings; `focal`, `width`, `height` in px, principal point in the middle; nothing beyond
    `reach` [m]. Rows of `out` (n, 6): index of the box, u_min, v_min, u_max, v_max [px] clipped to the image, share
    that is visible (0..1: not hidden by nearer boxes and inside the image).
    """
    c, s = math.cos(yaw), math.sin(yaw)
    count = 0
    rect = np.empty(4)
    for i in range(boxes.shape[0]):
        if math.hypot(boxes[i, 0] - px, boxes[i, 1] - py) > reach:
            continue
        if not _image_box(boxes[i], px, py, pz, c, s, focal, 0.5 * width, 0.5 * height, rect):
            continue
        if rect[2] <= 0.0 or rect[0] >= width or rect[3] <= 0.0 or rect[1] >= height:
            continue
        hits = seen = 0
        for a in range(ACROSS):
            for d in range(DOWN):
                u = rect[0] + (a + 0.5) / ACROSS * (rect[2] - rect[0])
                v = rect[1] + (d + 0.5) / DOWN * (rect[3] - rect[1])
                left, up = (0.5 * width - u) / focal, (0.5 * height - v) / focal
                rx, ry = c - s * left, s + c * left
                own = _entry(boxes[i], px, py, pz, rx, ry, up)
                if own == np.inf:
                    continue
                hits += 1
                if u < 0.0 or u > width or v < 0.0 or v > height:
                    continue
                free = True
                for j in range(boxes.shape[0]):
                    if j != i and _entry(boxes[j], px, py, pz, rx, ry, up) < own:
                        free = False
                        break
                if free:
                    seen += 1
        if seen == 0:
            continue
        row = out[count]
        row[0] = i
        row[1], row[2] = max(rect[0], 0.0), max(rect[1], 0.0)
        row[3], row[4] = min(rect[2], width), min(rect[3], height)
        row[5] = seen / hits
        count += 1
    return count
