"""LiDAR: crop, ground removal, clustering and oriented boxes by L-shape fit, all in the car's base frame.

Sources: L-shape by the closeness criterion of Zhang, Xu, Dong, Dolan, Efficient L-shape fitting for vehicle detection
using laser scanners, IEEE IV 2017, algorithm 3. Clusters are connected cells of a grid.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from machine_code import compiled
from vehicle.messages import FloatArray

CELL = 0.4  # m; returns in neighbouring cells belong together
FAR = 25.0  # m; beyond it one empty cell between two returns is forgiven
CLEARANCE = 0.15  # m above the ground plane; lower returns are ground
CEILING = 3.0  # m; higher returns are no obstacle
GROUND_BAND = 0.3  # m around the base plane in which ground is looked for
SLIVER = 0.25  # m across the line of sight
NEXT_DIRECTION = 0.02  # rad; directions closer than this are neighbours
GRAZING = 0.13  # m of step between neighbouring directions per m of range
LARGEST_STEP = 2.5  # m
SMALL = 0.9  # m; a cluster no larger has no orientation to fit
MOST_POINTS = 40  # of a cluster in the fit, evenly picked
CLOSENESS_FLOOR = 0.05  # m
MOST_BOXES = 64  # of one scan; chosen, not measured: it bounds the time of a tick
BOX = 7
"""Columns of a box: x, y [m], yaw [rad], length (along yaw), width [m], kind (index into messages.OBJECT_KINDS, or
-1 where the detector cannot tell), score."""


@compiled
def ground_plane(points: FloatArray) -> tuple[float, float, float]:
    """Least-squares plane z = c + a x + b y [m] through the returns near z = 0 of `points` (n, 3) [m].

    Zeros if there are fewer than 30 of them.
    """
    n = 0
    sx = sy = sz = sxx = syy = sxy = sxz = syz = 0.0
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if abs(z) > GROUND_BAND:
            continue
        n += 1
        sx, sy, sz = sx + x, sy + y, sz + z
        sxx, syy, sxy = sxx + x * x, syy + y * y, sxy + x * y
        sxz, syz = sxz + x * z, syz + y * z
    if n < 30:
        return 0.0, 0.0, 0.0
    mx, my, mz = sx / n, sy / n, sz / n
    vxx, vyy, vxy = sxx / n - mx * mx, syy / n - my * my, sxy / n - mx * my
    vxz, vyz = sxz / n - mx * mz, syz / n - my * mz
    det = vxx * vyy - vxy * vxy
    if vxx < 4.0 or vyy < 1.0 or det < 0.2 * vxx * vyy:
        return 0.0, 0.0, 0.0
    a, b = (vyy * vxz - vxy * vyz) / det, (vxx * vyz - vxy * vxz) / det
    c = mz - a * mx - b * my
    if abs(a) > 0.1 or abs(b) > 0.1 or abs(c) > 0.2:
        return 0.0, 0.0, 0.0
    return c, a, b


@compiled
def obstacle_points(scan: FloatArray, lidar_x: float, lidar_z: float, x_max: float, abs_y_max: float) -> FloatArray:
    """Returns (n, 3) of a scan in the base frame, inside the crop and above the ground.

    `scan` (m, 3) in the sensor frame; crop |x| <= x_max, |y| <= abs_y_max [m] seen from the sensor.
    """
    inside = np.empty((len(scan), 3))
    n = 0
    for i in range(len(scan)):
        if abs(scan[i, 0]) <= x_max and abs(scan[i, 1]) <= abs_y_max and math.isfinite(scan[i, 2]):
            inside[n, 0], inside[n, 1], inside[n, 2] = scan[i, 0] + lidar_x, scan[i, 1], scan[i, 2] + lidar_z
            n += 1
    inside = inside[:n]
    c, a, b = ground_plane(inside)
    k = 0
    for i in range(n):
        height = inside[i, 2] - (c + a * inside[i, 0] + b * inside[i, 1])
        if CLEARANCE < height < CEILING:
            inside[k, 0], inside[k, 1], inside[k, 2] = inside[i, 0], inside[i, 1], height
            k += 1
    return inside[:k]


@compiled
def root(parent: NDArray[np.int64], i: int) -> int:
    """Representative of the set of point `i`: an index into `parent` (n,) (union-find with path halving)."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@compiled
def extent(points: FloatArray, n: int) -> tuple[float, float, float, float]:
    """Least and largest x, least and largest y [m] of the first `n` of `points` (m, k), x and y first."""
    x_low = y_low = 1e300
    x_high = y_high = -1e300
    for i in range(n):
        x_low, x_high = min(x_low, points[i, 0]), max(x_high, points[i, 0])
        y_low, y_high = min(y_low, points[i, 1]), max(y_high, points[i, 1])
    return x_low, x_high, y_low, y_high


@compiled
def clusters(points: FloatArray) -> NDArray[np.int64]:
    """Label (n,) of each point (n, >= 2): the index of its cluster's first point."""
    n = len(points)
    parent = np.arange(n)
    if n == 0:
        return parent
    x_low, x_high, y_low, y_high = extent(points, n)
    x0, y0 = x_low - 3 * CELL, y_low - 3 * CELL
    nx = int((x_high - x0) / CELL) + 4
    ny = int((y_high - y0) / CELL) + 4
    first = np.full(nx * ny, -1, np.int64)
    cell = np.empty(n, np.int64)
    for i in range(n):
        c = int((points[i, 0] - x0) / CELL) * ny + int((points[i, 1] - y0) / CELL)
        cell[i] = c
        if first[c] < 0:
            first[c] = i
        else:
            parent[i] = first[c]
    for i in range(n):
        if first[cell[i]] != i:
            continue
        reach = 2 if points[i, 0] ** 2 + points[i, 1] ** 2 > FAR * FAR else 1
        for dx in range(-reach, reach + 1):
            for dy in range(-reach, reach + 1):
                j = first[cell[i] + dx * ny + dy]
                if j >= 0:
                    a, b = root(parent, i), root(parent, j)
                    if a != b:
                        parent[max(a, b)] = min(a, b)
    for i in range(n):
        parent[i] = root(parent, i)
    return parent


@compiled
def join_slivers(points: FloatArray, label: NDArray[np.int64], origin_x: float) -> None:
    """Give slivers the label of the nearest cluster in the next direction, in place.

    `points` (n, 3) [m], `label` (n,): the first point of each one's cluster. A side seen at a grazing angle returns
    points far apart along the line of sight, one direction each: clusters with hardly any width across the line of
    sight from the sensor at (origin_x, 0). A pedestrian is wider.
    """
    again = True
    while again:  # a chain of slivers grows by one link a round
        again = False
        for i in range(len(points)):
            if label[i] == i:
                owner = neighbour(points, label, i, origin_x)
                if owner >= 0:
                    again = True
                    a, b = min(owner, i), max(owner, i)
                    for j in range(len(points)):
                        if label[j] == b:
                            label[j] = a


@compiled
def neighbour(points: FloatArray, label: NDArray[np.int64], i: int, origin_x: float) -> int:
    """Label of the cluster next to cluster `i` that continues it, if that is a sliver; else -1.

    `points` (n, 3) [m], `label` (n,) as in join_slivers.
    """
    n = len(points)
    bearing = math.atan2(points[i, 1], points[i, 0] - origin_x)
    reach = math.hypot(points[i, 0] - origin_x, points[i, 1])
    c, s = math.cos(bearing), math.sin(bearing)
    low = high = 0.0
    for j in range(i, n):
        if label[j] == i:
            across = c * points[j, 1] - s * (points[j, 0] - origin_x)
            low, high = min(low, across), max(high, across)
            if high - low > SLIVER:
                return -1
    beside = max(NEXT_DIRECTION * reach, CELL)
    best, owner = min(GRAZING * reach, LARGEST_STEP), -1
    for j in range(n):
        if label[j] == i:
            continue
        across = c * points[j, 1] - s * (points[j, 0] - origin_x)
        if low - beside < across < high + beside:
            for k in range(i, n):
                if label[k] == i:
                    d = math.hypot(points[j, 0] - points[k, 0], points[j, 1] - points[k, 1])
                    if d < best:
                        best, owner = d, label[j]
    return owner


@compiled
def closeness(points: FloatArray, angle: float) -> float:
    """How well a rectangle at `angle` [rad] fits `points` (n, k), x and y first [m].

    The sum over points of 1 / distance to the nearer visible edge [1/m].
    """
    c, s = math.cos(angle), math.sin(angle)
    low1 = low2 = 1e300
    high1 = high2 = -1e300
    for i in range(len(points)):
        p, q = points[i, 0] * c + points[i, 1] * s, -points[i, 0] * s + points[i, 1] * c
        low1, high1, low2, high2 = min(low1, p), max(high1, p), min(low2, q), max(high2, q)
    near1 = far1 = near2 = far2 = 0.0
    for i in range(len(points)):
        p, q = points[i, 0] * c + points[i, 1] * s, -points[i, 0] * s + points[i, 1] * c
        near1, far1 = near1 + p - low1, far1 + high1 - p
        near2, far2 = near2 + q - low2, far2 + high2 - q
    total = 0.0
    for i in range(len(points)):
        p, q = points[i, 0] * c + points[i, 1] * s, -points[i, 0] * s + points[i, 1] * c
        d1 = p - low1 if near1 < far1 else high1 - p
        d2 = q - low2 if near2 < far2 else high2 - q
        total += 1.0 / max(min(d1, d2), CLOSENESS_FLOOR)
    return total


@compiled
def box_angle(points: FloatArray) -> float:
    """Angle [rad] in [0, pi/2) of the rectangle that fits `points` (n, k), n >= 2, x and y first, best; to 1 degree."""
    best, angle = -1.0, 0.0
    for k in range(18):
        value = closeness(points, math.radians(5.0 * k))
        if value > best:
            best, angle = value, math.radians(5.0 * k)
    coarse = angle
    for k in range(-4, 5):
        a = coarse + math.radians(1.0 * k)
        value = closeness(points, a)
        if value > best:
            best, angle = value, a
    return angle % (0.5 * math.pi)


@compiled
def lidar_boxes(scan: FloatArray, lidar_x: float, lidar_z: float, x_max: float, abs_y_max: float) -> FloatArray:
    """Boxes (k, BOX) in the base frame that a scan (n, 3) [m] in the sensor frame shows, at most MOST_BOXES.

    A box spans what was seen of the object, which may be one face of it only.
    """
    points = obstacle_points(scan, lidar_x, lidar_z, x_max, abs_y_max)
    label = clusters(points)
    join_slivers(points, label, lidar_x)
    n = len(points)
    boxes = np.zeros((MOST_BOXES, BOX))
    k = 0
    member = np.empty((n, 3))
    few = np.empty((MOST_POINTS, 3))
    for i in range(n):
        if label[i] != i or k == MOST_BOXES:
            continue
        m = 0
        for j in range(i, n):
            if label[j] == i:
                member[m, 0], member[m, 1], member[m, 2] = points[j, 0], points[j, 1], points[j, 2]
                m += 1
        if m < 2:
            continue
        x_low, x_high, y_low, y_high = extent(member, m)
        angle = 0.0
        if max(x_high - x_low, y_high - y_low) > SMALL and m > 3:
            take = min(m, MOST_POINTS)
            for j in range(take):
                few[j, 0], few[j, 1] = member[j * m // take, 0], member[j * m // take, 1]
            angle = box_angle(few[:take])
        c, s = math.cos(angle), math.sin(angle)
        low1 = low2 = 1e300
        high1 = high2 = -1e300
        for j in range(m):
            p, q = member[j, 0] * c + member[j, 1] * s, -member[j, 0] * s + member[j, 1] * c
            low1, high1, low2, high2 = min(low1, p), max(high1, p), min(low2, q), max(high2, q)
        p, q = 0.5 * (low1 + high1), 0.5 * (low2 + high2)
        boxes[k, 0], boxes[k, 1], boxes[k, 2] = p * c - q * s, p * s + q * c, angle
        boxes[k, 3], boxes[k, 4] = high1 - low1, high2 - low2
        boxes[k, 5], boxes[k, 6] = -1.0, min(0.5 + 0.05 * m, 0.9)
        k += 1
    return boxes[:k]
