"""Tracking: which measurement belongs to which track; tracks begin, coast through short occlusion, and end.

Constant-velocity Kalman filter along and across the line of sight: a camera sees the side better than the distance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ads.ekf import copy_row
from ads.perception.assignment import FORBIDDEN, assign
from ads.perception.fragments import gather_fragments, outside
from ads.perception.fusion import CAMERA, VEHICLE
from ads.perception.track import (
    AGE,
    AP,
    CP,
    HITS,
    LONG,
    SIZED,
    TW,
    TX,
    TY,
    TYAW,
    UNSEEN,
    VOTE_VEHICLE,
    VX,
    VY,
    WIDE,
    begin,
    correct_track,
    newly_seen,
    sight,
    track_kind,
    whole_box,
)  # fmt: skip
from machine_code import compiled
from vehicle.messages import FloatArray

MOST_TRACKS = 48  # chosen, not measured: it bounds the time of a tick
ACCELERATION = np.array([1.2, 1.8, 1.5, 0.8])  # m/s^2 per kind, process noise
COAST = np.array([1.5, 1.0, 1.0, 1.0])  # s unseen until a track is dropped
CONFIRM = 3  # hits
GATE = 9.2  # chi-square, 2 degrees of freedom, 99 %
LOOSE = 0.25  # m^2 added to a LiDAR object's variances in the gate: a partly seen car's middle is a guess
LOOSE_CAMERA = 0.5  # m^2
OTHER_KIND = 6.0  # added to the squared distance when kinds differ
RANGE_SIGMAS = 2.0  # of a camera's range within which two tracks in one direction are the same object
SAME = 0.2  # m; a track whose middle lies so near another's box is the same object


@compiled
def predict_tracks(tracks: FloatArray, n: int, dt: float) -> int:
    """Move the first `n` tracks of (m, TRACK) by `dt` [s] in place and drop those unseen too long.

    Returns how many are left.
    """
    left = 0
    for i in range(n):
        track = tracks[i]
        kind = track_kind(track)
        q = ACCELERATION[kind] ** 2
        track[TX] += track[VX] * dt
        track[TY] += track[VY] * dt
        for k in (AP, CP):
            track[k] += 2.0 * dt * track[k + 1] + dt * dt * track[k + 2] + q * dt**4 / 4.0
            track[k + 1] += dt * track[k + 2] + q * dt**3 / 2.0
            track[k + 2] += q * dt * dt
        track[UNSEEN] += dt
        track[AGE] += dt
        patience = COAST[kind] if track[HITS] >= CONFIRM else 0.25
        if track[UNSEEN] <= patience:
            if left != i:
                copy_row(tracks, i, tracks, left)
            left += 1
    return left


def update_tracks(
    tracks: FloatArray, n: int, rows: FloatArray, sensor: tuple[float, float, float], next_id: int
) -> tuple[int, int]:
    """Match measurements (m, MEASURE) to the first `n` tracks and update both; returns the number of tracks, next id.

    `sensor`: x, y [m] of the sensor in the map and the yaw [rad] that objects are assumed to have when in doubt.
    """
    used = np.zeros(len(rows), np.uint8)
    owner = gather_fragments(tracks, n, rows, used)
    pair = assign(match_costs(tracks, n, rows, sensor, used))
    left: int
    left, next_id = take_matches(tracks, n, rows, sensor, next_id, pair, owner, used)
    return left, next_id


@compiled
def match_costs(
    tracks: FloatArray, n: int, rows: FloatArray, sensor: tuple[float, float, float], used: NDArray[np.uint8]
) -> FloatArray:
    """Squared Mahalanobis distance [-] (n, m) of each measurement to each track; FORBIDDEN outside the gate."""
    m = len(rows)
    cost = np.full((n, m), FORBIDDEN)
    for i in range(n):
        track = tracks[i]
        kind = track_kind(track)
        for j in range(m):
            if used[j] == 1:
                continue
            row = rows[j]
            x, y, _, _, length, _ = whole_box(track, kind, row, sensor[0], sensor[1])
            if kind == VEHICLE and max(track[TW] - WIDE, track[SIZED] - LONG) > 0.0:  # much of it may show at once
                back = newly_seen(track, length, x, y)
                x, y = x - back * np.cos(track[TYAW]), y - back * np.sin(track[TYAW])
            c, s = sight(row[0] - sensor[0], row[1] - sensor[1])
            dx, dy = x - track[TX], y - track[TY]
            along, across = c * dx + s * dy, c * dy - s * dx
            loose = LOOSE_CAMERA if row[8] == CAMERA else LOOSE
            d = along * along / (track[AP] + row[7] + loose) + across * across / (track[CP] + row[9] + loose)
            if d > GATE:
                continue
            if row[5] >= 0.0 and int(row[5]) != kind and track[VOTE_VEHICLE + kind] > 3.0:
                d += OTHER_KIND
            cost[i, j] = d
    return cost


@compiled
def take_matches(
    tracks: FloatArray,
    n: int,
    rows: FloatArray,
    sensor: tuple[float, float, float],
    next_id: int,
    pair: NDArray[np.int64],
    owner: NDArray[np.int64],
    used: NDArray[np.uint8],
) -> tuple[int, int]:
    """Correct matched tracks, begin new ones, drop doubles; returns the number of tracks and the next id.

    `tracks` (k, TRACK) of which `n` count, `rows` (m, MEASURE), SI units; `pair` (n,): index of each track's row, -1
    for none; `owner` (m,): index of the track that a row is a piece of, -1 for none; `used` (m,) 1 for rows already
    taken.
    """
    for i in range(n):
        if pair[i] >= 0:
            used[pair[i]] = 1
            correct_track(tracks[i], rows[pair[i]], sensor[0], sensor[1])
    for j in range(len(rows)):
        if used[j] == 1 or n == MOST_TRACKS:
            continue
        if owner[j] >= 0 and pair[owner[j]] >= 0:  # a piece of what was seen anyway
            continue
        begin(tracks[n], rows[j], sensor, next_id)
        n += 1
        next_id += 1
    return without_doubles(tracks, n, sensor[0], sensor[1]), next_id


@compiled
def without_doubles(tracks: FloatArray, n: int, sensor_x: float, sensor_y: float) -> int:
    """Drop tracks whose middle lies in a vehicle track with more hits; returns how many are left.

    A camera alone knows the range badly: one of its tracks may lie as far before or behind as its range is unsure,
    seen from the sensor at (sensor_x, sensor_y) [m].
    """
    left = 0
    for i in range(n):
        double = False
        for j in range(n):
            if j != i and tracks[j, HITS] > tracks[i, HITS] and track_kind(tracks[j]) == VEHICLE:
                same = track_kind(tracks[i]) == VEHICLE or tracks[i, HITS] < CONFIRM
                x, y = tracks[i, TX], tracks[i, TY]
                if tracks[i, SIZED] == 0.0:
                    c, s = sight(x - sensor_x, y - sensor_y)
                    apart = c * (tracks[j, TX] - x) + s * (tracks[j, TY] - y)
                    unsure = RANGE_SIGMAS * np.sqrt(tracks[i, AP])
                    apart = min(max(apart, -unsure), unsure)
                    x, y = x + c * apart, y + s * apart
                along, across = outside(tracks[j], x, y)
                if same and max(along, across) < SAME:
                    double = True
        if not double:
            if left != i:
                copy_row(tracks, i, tracks, left)
            left += 1
    return left
