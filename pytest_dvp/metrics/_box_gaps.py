"""Distances between pairs of oriented boxes, from bumper to bumper: whole, along the first box, and across it.

A box is a row of x, y [m] of its middle, yaw [rad], length, width [m]; further columns are not looked at.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import FloatArray

_SIGNS = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])


def corners_seen_by(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Corners of n others (n,) in turn order as array (n, 4, 2) [m], in the frames of n boxes: x along, y left."""
    half = 0.5 * others[:, None, 3:5] * _SIGNS
    turn = others[:, 2] - boxes[:, 2]
    cos, sin = np.cos(turn)[:, None], np.sin(turn)[:, None]
    dx, dy = others[:, 0] - boxes[:, 0], others[:, 1] - boxes[:, 1]
    c, s = np.cos(boxes[:, 2]), np.sin(boxes[:, 2])
    x = (dx * c + dy * s)[:, None] + cos * half[..., 0] - sin * half[..., 1]
    y = (dy * c - dx * s)[:, None] + sin * half[..., 0] + cos * half[..., 1]
    return np.stack((x, y), axis=-1)


def overlap(boxes: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Which of n pairs of boxes touch or overlap, (n,): no normal of an edge separates them (SI units)."""
    met = np.ones(len(boxes), dtype=bool)
    for first, second in ((boxes, others), (others, boxes)):
        corners, half = corners_seen_by(first, second), 0.5 * first[:, None, 3:5]
        met &= ((corners.min(axis=1) <= half[:, 0]) & (corners.max(axis=1) >= -half[:, 0])).all(axis=1)
    return met


def distances(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Least distance [m] between the boxes of n pairs, (n,); 0 where they touch or overlap.

    Between convex shapes apart from each other it is that of a corner of one from the other, so eight corners do.
    """
    least = np.full(len(boxes), np.inf)
    for first, second in ((boxes, others), (others, boxes)):
        beyond = np.maximum(np.abs(corners_seen_by(first, second)) - 0.5 * first[:, None, 3:5], 0.0)
        least = np.minimum(least, np.hypot(beyond[..., 0], beyond[..., 1]).min(axis=1))
    return np.where(overlap(boxes, others), 0.0, least)


def extents(boxes: FloatArray, others: FloatArray, axis: int) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinate [m], each (n,), that the part of an other box beside a box has along `axis`.

    axis 0: along the box, of the part in the strip that is as wide as the box; 1: across it, of the part in the strip
    as long as the box. NaN where no part of the other one is in the strip.
    """
    corners = corners_seen_by(boxes, others)
    along, across = corners[..., axis], corners[..., 1 - axis]
    half = 0.5 * boxes[:, 4 - axis]
    found = [np.where(np.abs(across) <= half[:, None], along, np.nan)]
    step, aside = np.roll(along, -1, axis=1) - along, np.roll(across, -1, axis=1) - across
    for side in (-half, half):  # where an edge leaves the strip
        share = (side[:, None] - across) / np.where(aside == 0.0, np.nan, aside)
        found.append(np.where((share >= 0.0) & (share <= 1.0), along + share * step, np.nan))
    points = np.concatenate(found, axis=1)
    none = ~np.isfinite(points).any(axis=1)
    low = np.where(np.isnan(points), np.inf, points).min(axis=1)
    high = np.where(np.isnan(points), -np.inf, points).max(axis=1)
    return np.where(none, np.nan, low), np.where(none, np.nan, high)


def gaps(boxes: FloatArray, others: FloatArray, axis: int) -> FloatArray:
    """Free distance [m] along `axis` (see `extents`), (n,); 0 where they overlap, NaN where none is in the strip."""
    low, high = extents(boxes, others, axis)
    half = 0.5 * boxes[:, 3 + axis]
    return np.maximum(np.maximum(low - half, -half - high), 0.0)
