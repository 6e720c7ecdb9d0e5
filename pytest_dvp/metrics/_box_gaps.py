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
    return np.stack([each.T for each in _corners(boxes, others)], axis=-1)


def _corners(boxes: FloatArray, others: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same as x and y, each (4, n): what is least or greatest of four is found for all n at once."""
    half_x, half_y = 0.5 * others[:, 3] * _SIGNS[:, :1], 0.5 * others[:, 4] * _SIGNS[:, 1:]
    turn = others[:, 2] - boxes[:, 2]
    cos, sin = np.cos(turn), np.sin(turn)
    dx, dy = others[:, 0] - boxes[:, 0], others[:, 1] - boxes[:, 1]
    c, s = np.cos(boxes[:, 2]), np.sin(boxes[:, 2])
    x = (dx * c + dy * s) + cos * half_x - sin * half_y
    y = (dy * c - dx * s) + sin * half_x + cos * half_y
    return x, y


def overlap(boxes: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Which of n pairs of boxes touch or overlap, (n,): no normal of an edge separates them (SI units)."""
    return _reaches(boxes, _corners(boxes, others)) & _reaches(others, _corners(others, boxes))


def _reaches(boxes: FloatArray, corners: tuple[FloatArray, FloatArray]) -> NDArray[np.bool_]:
    """Which of n boxes have others, whose `corners` they see, neither all on one side nor all before or behind."""
    met = np.ones(len(boxes), dtype=bool)
    for place, half in zip(corners, (0.5 * boxes[:, 3], 0.5 * boxes[:, 4]), strict=True):
        met &= (place.min(axis=0) <= half) & (place.max(axis=0) >= -half)
    return met


def distances(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Least distance [m] between the boxes of n pairs, (n,); 0 where they touch or overlap.

    Between convex shapes apart from each other it is that of a corner of one from the other, so eight corners do.
    """
    least, met = np.full(len(boxes), np.inf), np.ones(len(boxes), dtype=bool)
    for first, second in ((boxes, others), (others, boxes)):
        corners = _corners(first, second)
        beyond_x = np.maximum(np.abs(corners[0]) - 0.5 * first[:, 3], 0.0)
        beyond_y = np.maximum(np.abs(corners[1]) - 0.5 * first[:, 4], 0.0)
        least = np.minimum(least, np.hypot(beyond_x, beyond_y).min(axis=0))
        met &= _reaches(first, corners)
    return np.where(met, 0.0, least)


def extents(boxes: FloatArray, others: FloatArray, axis: int) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinate [m], each (n,), that the part of an other box beside a box has along `axis`.

    axis 0: along the box, of the part in the strip that is as wide as the box; 1: across it, of the part in the strip
    as long as the box. NaN where no part of the other one is in the strip.
    """
    corners = _corners(boxes, others)
    along, across = corners[axis], corners[1 - axis]
    half = 0.5 * boxes[:, 4 - axis]
    found = [np.where(np.abs(across) <= half, along, np.nan)]
    step, aside = np.roll(along, -1, axis=0) - along, np.roll(across, -1, axis=0) - across
    for side in (-half, half):  # where an edge leaves the strip
        share = (side - across) / np.where(aside == 0.0, np.nan, aside)
        found.append(np.where((share >= 0.0) & (share <= 1.0), along + share * step, np.nan))
    points = np.concatenate(found)
    none = ~np.isfinite(points).any(axis=0)
    low = np.where(np.isnan(points), np.inf, points).min(axis=0)
    high = np.where(np.isnan(points), -np.inf, points).max(axis=0)
    return np.where(none, np.nan, low), np.where(none, np.nan, high)


def gaps(boxes: FloatArray, others: FloatArray, axis: int) -> FloatArray:
    """Free distance [m] along `axis` (see `extents`), (n,); 0 where they overlap, NaN where none is in the strip."""
    low, high = extents(boxes, others, axis)
    half = 0.5 * boxes[:, 3 + axis]
    return np.maximum(np.maximum(low - half, -half - high), 0.0)
