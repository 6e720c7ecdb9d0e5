"""Late fusion: LiDAR boxes and camera objects paired into measurements in the map frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ads.perception.assignment import FORBIDDEN, assign
from machine_code import compiled
from vehicle.messages import FloatArray

MEASURE = 10
"""Columns of a measurement: x, y [m], yaw [rad], length, width [m], kind (-1 unknown), score, variance along
the line of sight [m^2], source, variance across it [m^2]."""

LIDAR, CAMERA, BOTH = 1.0, 2.0, 3.0
LIDAR_VARIANCE = 0.03  # m^2, per axis
CAMERA_ACROSS = 0.06  # m^2
ACROSS = 0.5  # m between the edges of a pair across the line of sight, at most
LONGEST_VEHICLE = 18.75  # m, of a road train by directive 96/53/EC
VEHICLE, PEDESTRIAN, BICYCLE, MISC = 0, 1, 2, 3  # as in messages.OBJECT_KINDS
TYPICAL = np.array([[4.0, 1.75], [0.5, 0.5], [1.8, 0.6], [1.0, 1.0]])  # m, length and width of each kind


@compiled
def kind_by_size(length: float, width: float) -> int:
    """What a LiDAR cluster without a camera object probably is."""
    longest = max(length, width)
    if longest < 1.0:
        return PEDESTRIAN
    return VEHICLE if longest < LONGEST_VEHICLE else MISC


def fuse(
    boxes: FloatArray,
    pose: tuple[float, float, float],
    seen: FloatArray,
    camera_pose: tuple[float, float, float],
    min_dist: float,
) -> FloatArray:
    """Measurements (k, MEASURE) in the map from LiDAR boxes (n, BOX) and camera objects (m, SEEN).

    `pose`, `camera_pose`: the car (x, y [m], yaw [rad]) when each was taken. A pair is one object if it is closer than
    `min_dist` [m], where along the line of sight the camera's range sigma is allowed for, and if they meet across it.
    """
    out, rays, cost = pair_costs(boxes, pose, seen, camera_pose, min_dist)
    measured: FloatArray = take_pairs(out, rays, seen, camera_pose[2], assign(cost))
    return measured


@compiled
def pair_costs(
    boxes: FloatArray,
    pose: tuple[float, float, float],
    seen: FloatArray,
    camera_pose: tuple[float, float, float],
    min_dist: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Three arrays to pair boxes (n, BOX) with camera objects (m, SEEN), all in SI units.

    LiDAR boxes in the map, with room for the camera's (n + m, MEASURE); where each camera object is and its line of
    sight (m, 4); cost of each pair (n, m).
    """
    n, m = len(boxes), len(seen)
    out = np.zeros((n + m, MEASURE))
    c, s = math.cos(pose[2]), math.sin(pose[2])
    cc, cs = math.cos(camera_pose[2]), math.sin(camera_pose[2])
    for i in range(n):
        out[i, 0] = pose[0] + c * boxes[i, 0] - s * boxes[i, 1]
        out[i, 1] = pose[1] + s * boxes[i, 0] + c * boxes[i, 1]
        out[i, 2] = pose[2] + boxes[i, 2]
        out[i, 3], out[i, 4], out[i, 5] = boxes[i, 3], boxes[i, 4], boxes[i, 5]
        out[i, 6], out[i, 7], out[i, 8] = boxes[i, 6], LIDAR_VARIANCE, LIDAR
        out[i, 9] = LIDAR_VARIANCE
    cost = np.full((n, m), FORBIDDEN)
    rays = np.empty((m, 4))
    for j in range(m):
        kind = int(seen[j, 3])
        distance = max(math.hypot(seen[j, 0], seen[j, 1]), 0.1)
        deeper = 1.0 + 0.5 * TYPICAL[kind, 0] / distance  # from the nearest point to the middle
        x, y = seen[j, 0] * deeper, seen[j, 1] * deeper
        rays[j, 0] = camera_pose[0] + cc * x - cs * y
        rays[j, 1] = camera_pose[1] + cs * x + cc * y
        rays[j, 2] = math.cos(math.atan2(y, x) + camera_pose[2])
        rays[j, 3] = math.sin(math.atan2(y, x) + camera_pose[2])
        for i in range(n):
            dx, dy = out[i, 0] - rays[j, 0], out[i, 1] - rays[j, 1]
            along, across = dx * rays[j, 2] + dy * rays[j, 3], dy * rays[j, 2] - dx * rays[j, 3]
            d = math.hypot(along / (1.0 + seen[j, 5]), across)
            widest = ACROSS + 0.5 * (seen[j, 2] + max(boxes[i, 3], boxes[i, 4]))
            if d <= min_dist and abs(across) <= widest:
                cost[i, j] = d
    return out, rays, cost


@compiled
def take_pairs(
    out: FloatArray, rays: FloatArray, seen: FloatArray, camera_yaw: float, pair: NDArray[np.int64]
) -> FloatArray:
    """Measurements (k, MEASURE), SI units, once it is known which box goes with which camera object.

    `pair` (n,) from `assign`: the camera object of each box, -1 for none.
    """
    n, m = len(pair), len(seen)
    taken = np.zeros(m, np.uint8)
    for i in range(n):
        j = pair[i]
        if j >= 0:
            taken[j] = 1
            out[i, 5], out[i, 6], out[i, 8] = seen[j, 3], max(out[i, 6], seen[j, 4]), BOTH
    k = n
    for j in range(m):
        if taken[j] == 1:
            continue
        kind = int(seen[j, 3])
        out[k, 0], out[k, 1], out[k, 2] = rays[j, 0], rays[j, 1], camera_yaw
        out[k, 3], out[k, 4], out[k, 5] = TYPICAL[kind, 0], TYPICAL[kind, 1], kind
        out[k, 6], out[k, 7], out[k, 8] = seen[j, 4], 0.1 + seen[j, 5] ** 2, CAMERA
        out[k, 9] = CAMERA_ACROSS + seen[j, 6] ** 2
        k += 1
    return out[:k]
