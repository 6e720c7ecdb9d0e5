"""Camera: boxes of the image to places on the ground, by the intrinsics and a flat ground plane."""

from __future__ import annotations

import numpy as np

from vehicle.messages import OBJECT_KINDS, CameraFrame, FloatArray, VehicleDescription

SEEN = 6
"""Columns of a camera object: x, y of its nearest ground point [m], width [m], kind, score, range sigma [m]."""

EDGE = 2.0  # px; a box at the border of the image is cut off there
PIXEL_SIGMA = 1.5  # px, of a box's lower edge
FARTHEST = 120.0  # m; beyond it a pixel is worth too much


def camera_objects(frame: CameraFrame, car: VehicleDescription) -> FloatArray:
    """Objects (k, SEEN) in the base frame.

    Pinhole with the principal point in the middle of the image, looking along x, no pitch: a ground point at depth d
    appears f h / d below the middle. Not valid on crests and dips. A box cut off
    below is nearer than the nearest ground in sight; half way between is a guess.
    """
    rows = []
    f, h = car.camera_focal, car.camera_z
    middle_u, middle_v = 0.5 * car.camera_width, 0.5 * car.camera_height
    for box in frame.boxes:
        below = box.v_max - middle_v
        if below * FARTHEST < f * h:
            continue
        depth = f * h / below
        cut = box.v_max > car.camera_height - EDGE  # its lower end is out of sight, so it is nearer than that
        if cut:
            depth *= 0.75
        y = -(0.5 * (box.u_min + box.u_max) - middle_u) / f * depth
        width = (box.u_max - box.u_min) / f * depth
        sigma = 0.25 * depth if cut else PIXEL_SIGMA * depth * depth / (f * h)
        rows.append((car.camera_x + depth, y, width, float(OBJECT_KINDS.index(box.kind)), box.score, sigma))
    return np.array(rows, dtype=np.float64).reshape(-1, SEEN)
