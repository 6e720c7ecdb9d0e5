"""Fragments: pieces of one vehicle that the LiDAR's clusters show apart are joined again by its track."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ads.perception.fusion import CAMERA, VEHICLE
from ads.perception.track import AP, CP, SIDE, TL, TW, TX, TY, TYAW, track_kind
from machine_code import compiled
from vehicle.messages import FloatArray

AROUND = 0.4  # m around a track's box in which a piece may lie
LARGEST_AROUND = 0.8  # m, with the track's uncertainty
LONGER = 1.0  # m more at each end
GROWTH = 1.5  # m by which a joint box may be longer than the track


@compiled
def outside(track: FloatArray, x: float, y: float) -> tuple[float, float]:
    """How far a point [m] lies outside the box of a track (TRACK,), along and across it [m]; 0 inside."""
    c, s = math.cos(track[TYAW]), math.sin(track[TYAW])
    dx, dy = x - track[TX], y - track[TY]
    along, across = abs(c * dx + s * dy), abs(c * dy - s * dx)
    return max(along - 0.5 * track[TL], 0.0), max(across - 0.5 * track[TW], 0.0)


@compiled
def owner_of(tracks: FloatArray, n: int, row: FloatArray) -> int:
    """Row of the vehicle among the first `n` tracks (m, TRACK) that a LiDAR box fits best as a piece of it; -1 if none.

    `row` (MEASURE,), SI units; a camera's object and a box of another kind belong to none.
    """
    best, owner = 1e300, -1
    if row[8] == CAMERA or (row[5] >= 0.0 and int(row[5]) != VEHICLE):
        return owner
    for i in range(n):
        track = tracks[i]
        if track_kind(track) != VEHICLE:
            continue
        around = min(AROUND + math.sqrt(max(track[AP], track[CP])), LARGEST_AROUND)
        along, across = outside(track, row[0], row[1])
        if along > around + LONGER or across > around:
            continue
        misfit = along + 3.0 * across + 0.1 * math.hypot(row[0] - track[TX], row[1] - track[TY])
        if misfit < best:
            best, owner = misfit, i
    return owner


@compiled
def gather_fragments(tracks: FloatArray, n: int, rows: FloatArray, used: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Join LiDAR boxes that lie in one vehicle track: a side seen at a grazing angle falls into pieces.

    The joint box replaces the first piece in `rows` (m, MEASURE), the others are marked in `used` (m,). Pieces that
    together would be too large for one vehicle stay apart. Returns the track (m,) that each row lies in, -1 for none.
    """
    m = len(rows)
    owner = np.full(m, -1, np.int64)
    for j in range(m):
        owner[j] = owner_of(tracks, n, rows[j])
    for i in range(n):
        count, first = 0, -1
        for j in range(m):
            if owner[j] == i:
                count += 1
                first = j if first < 0 else first
        if count < 2:
            continue
        yaw = tracks[i, TYAW]
        c, s = math.cos(yaw), math.sin(yaw)
        low1 = low2 = 1e300
        high1 = high2 = -1e300
        for j in range(m):
            if owner[j] != i:
                continue
            row = rows[j]
            cr, sr = math.cos(row[2]), math.sin(row[2])
            for corner in range(4):
                a = 0.5 * row[3] * (1.0 if corner & 1 else -1.0)
                b = 0.5 * row[4] * (1.0 if corner & 2 else -1.0)
                x, y = row[0] + cr * a - sr * b, row[1] + sr * a + cr * b
                p, q = c * x + s * y, c * y - s * x
                low1, high1, low2, high2 = min(low1, p), max(high1, p), min(low2, q), max(high2, q)
        if high1 - low1 > tracks[i, TL] + GROWTH or high2 - low2 > SIDE:
            continue
        for j in range(first + 1, m):
            if owner[j] == i:
                used[j] = 1
                for k in (5, 6, 8):  # the best word on kind, score and source
                    rows[first, k] = max(rows[first, k], rows[j, k])
        p, q = 0.5 * (low1 + high1), 0.5 * (low2 + high2)
        rows[first, 0], rows[first, 1], rows[first, 2] = c * p - s * q, s * p + c * q, yaw
        rows[first, 3], rows[first, 4] = high1 - low1, high2 - low2
    return owner
