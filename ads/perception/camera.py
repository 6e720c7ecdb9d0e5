"""Camera: boxes of the image to places on the ground, by the intrinsics and a flat ground plane."""

from __future__ import annotations

import math

import numpy as np

from vehicle.messages import OBJECT_KINDS, CameraFrame, FloatArray, VehicleDescription

SEEN = 7
"""Columns of a camera object: x, y of its nearest ground point [m], width [m], kind, score, sigma of the range
and across it [m]."""

EDGE = 2.0  # px; a box at the border of the image is cut off there
PIXEL_SIGMA = 1.5  # px, of a box's lower edge
EXTENT = (2.8, 0.5, 1.2, 1.0)  # m across the view, of each kind, when its side is out of sight
FARTHEST = 120.0  # m; beyond it a pixel is worth too much


def camera_objects(frame: CameraFrame, car: VehicleDescription) -> FloatArray:
    """Objects (k, SEEN) in the base frame, in SI units.

    Pinhole with the principal point in the middle of the image, looking along its mount's x axis, no pitch: a ground
    point at depth d appears f h / d below the middle. Not valid on crests and dips. A box cut off below is nearer than
    the nearest ground in sight; half way between is a guess. One cut off at a side is taken to be as wide as its kind
    is, from the edge in sight on: its middle in the image moves while the object stands.
    """
    rows = []
    f, h = car.camera_focal, car.camera_z
    c, s = math.cos(car.camera_yaw), math.sin(car.camera_yaw)
    middle_u, middle_v = 0.5 * car.camera_width, 0.5 * car.camera_height
    for box in frame.boxes:
        below = box.v_max - middle_v
        if below * FARTHEST < f * h:
            continue
        depth = f * h / below
        cut = box.v_max > car.camera_height - EDGE  # its lower end is out of sight, so it is nearer than that
        if cut:
            depth *= 0.75
        kind = OBJECT_KINDS.index(box.kind)
        left, right = (middle_u - box.u_min) / f * depth, (middle_u - box.u_max) / f * depth
        across = 0.0
        cut_left, cut_right = box.u_min < EDGE, box.u_max > car.camera_width - EDGE
        if cut_left != cut_right:
            hidden = max(EXTENT[kind] - (left - right), 0.0)
            left, right = (left + hidden, right) if cut_left else (left, right - hidden)
            across = 0.5 * EXTENT[kind]
        sigma = 0.25 * depth if cut else PIXEL_SIGMA * depth * depth / (f * h)
        y = 0.5 * (left + right)
        place = (car.camera_x + c * depth - s * y, car.camera_y + s * depth + c * y)
        rows.append((*place, left - right, float(kind), box.score, sigma, across))
    return np.array(rows, dtype=np.float64).reshape(-1, SEEN)
