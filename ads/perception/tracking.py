"""Tracking: objects with identity, velocity and size; coasts through short occlusion.

Constant-velocity Kalman filter along and across the line of sight: a camera sees the side better than the distance.
A measurement's box is what was seen of the object; its middle is moved away from the sensor until the box has the
track's size: the near face of a car is not its middle.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ads.perception.assignment import FORBIDDEN, assign
from ads.perception.fusion import CAMERA, PEDESTRIAN, TYPICAL, VEHICLE, kind_by_size
from ads.transforms import wrap_angle
from vehicle.messages import FloatArray

TRACK = 23
(ID, TX, TY, VX, VY, AP, AV, AA, CP, CV, CC, TYAW, TL, TW, VOTE_VEHICLE, VOTE_PEDESTRIAN, VOTE_BICYCLE, VOTE_MISC,
 HITS, UNSEEN, AGE, SCORE, SIZED) = range(TRACK)  # fmt: skip
"""Columns: id, position, velocity, covariance along the line of sight (position, both, velocity) and across it, yaw,
length, width, votes per kind, hits, time unseen [s], age [s], score, longest side ever seen [m]."""

MOST_TRACKS = 48
ACCELERATION = np.array([1.2, 1.2, 1.2, 0.8])  # m/s^2 per kind, process noise
COAST = np.array([1.5, 1.0, 1.0, 1.0])  # s unseen until a track is dropped
CONFIRM = 3  # hits
FIRST_SPEED = np.array([5.0, 1.7, 4.0, 1.0])  # m/s per kind, sigma of a new track's velocity
LONGER = 1.0  # m beyond a track's end where a piece may still be of it
SIDE = 2.8  # m; no car is wider, not even seen askew, so a longer face is a side
GATE = 9.2  # chi-square, 2 degrees of freedom, 99 %


@njit(cache=True, error_model="numpy")
def track_kind(track: FloatArray) -> int:
    """Index into messages.OBJECT_KINDS with the most votes."""
    best = 0
    for k in range(1, 4):
        if track[VOTE_VEHICLE + k] > track[VOTE_VEHICLE + best]:
            best = k
    return best


@njit(cache=True, error_model="numpy")
def settle_box(row: FloatArray, kind: int, yaw_hint: float, known_length: float, known_width: float) -> tuple[
    float, float, float, float, float
]:  # fmt: skip
    """Yaw, visible length and width of a measured box with its length axis chosen, and the size to assume."""
    yaw, length, width = row[2], row[3], row[4]
    if kind == PEDESTRIAN:
        return yaw_hint, length, width, max(0.5, min(length, 1.0)), max(0.5, min(width, 1.0))
    turn = False
    if max(length, width) > SIDE:
        turn = width > length
    else:
        turn = abs(math.sin(yaw - yaw_hint)) > math.sqrt(0.5)
    if turn:
        yaw, length, width = yaw + 0.5 * math.pi, width, length
    if math.cos(yaw - yaw_hint) < 0.0:
        yaw += math.pi
    return wrap_angle(yaw), length, width, max(length, known_length), max(width, known_width)


@njit(cache=True, error_model="numpy")
def middle(
    row: FloatArray, yaw: float, seen: float, whole: float, sensor_x: float, sensor_y: float
) -> tuple[float, float]:
    """Shift [m] of the box's middle along `yaw` when it grows from `seen` to `whole` [m], away from the sensor."""
    ux, uy = math.cos(yaw), math.sin(yaw)
    dx, dy = row[0] - sensor_x, row[1] - sensor_y
    share = (dx * ux + dy * uy) / max(math.hypot(dx, dy), 0.1)
    if abs(share) < 0.3:  # looked at squarely: it may be hidden on either side
        return 0.0, 0.0
    shift = math.copysign(0.5 * max(whole - seen, 0.0), share)
    return shift * ux, shift * uy


@njit(cache=True, error_model="numpy")
def predict_tracks(tracks: FloatArray, n: int, dt: float) -> int:
    """Move the first `n` tracks by `dt` [s] in place, drop those unseen too long; returns how many are left."""
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
                tracks[left] = track
            left += 1
    return left


@njit(cache=True, error_model="numpy")
def sight(dx: float, dy: float) -> tuple[float, float]:
    """Unit vector of the line of sight from the sensor to something dx, dy [m] away."""
    d = max(math.hypot(dx, dy), 1e-6)
    return dx / d, dy / d


@njit(cache=True, error_model="numpy")
def correct_axis(track: FloatArray, k: int, innovation: float, variance: float) -> tuple[float, float]:
    """Correction of position [m] and velocity [m/s] along one axis, whose covariance starts at column `k`."""
    total = track[k] + variance
    gain, gain_v = track[k] / total, track[k + 1] / total
    track[k + 2] -= gain_v * track[k + 1]
    track[k + 1] *= 1.0 - gain
    track[k] *= 1.0 - gain
    return gain * innovation, gain_v * innovation


@njit(cache=True, error_model="numpy")
def update_tracks(
    tracks: FloatArray, n: int, rows: FloatArray, sensor: tuple[float, float, float], next_id: int
) -> tuple[int, int]:
    """Match measurements (m, MEASURE) to the first `n` tracks and update both; returns the number of tracks, next id.

    `sensor`: x, y [m] of the sensor in the map and the yaw [rad] that objects are assumed to have when in doubt.
    """
    m = len(rows)
    used = np.zeros(m, np.uint8)
    owner = gather_fragments(tracks, n, rows, used)
    cost = np.full((n, m), FORBIDDEN)
    for i in range(n):
        track = tracks[i]
        kind = track_kind(track)
        for j in range(m):
            if used[j] == 1:
                continue
            row = rows[j]
            camera = row[8] == CAMERA
            dx, dy = row[0] - track[TX], row[1] - track[TY]
            # the middle of a partly seen car may be off by half its length
            loose = 1.0 if kind != VEHICLE else 4.0
            loose = 0.5 if camera else 0.25 * loose
            c, s = sight(row[0] - sensor[0], row[1] - sensor[1])
            along, across = c * dx + s * dy, c * dy - s * dx
            d = along * along / (track[AP] + row[7] + loose) + across * across / (track[CP] + row[9] + loose)
            if d > GATE:
                continue
            if row[5] >= 0.0 and int(row[5]) != kind and track[VOTE_VEHICLE + kind] > 3.0:
                d += 6.0
            cost[i, j] = d
    pair = assign(cost)
    for i in range(n):
        j = pair[i]
        if j < 0:
            continue
        used[j] = 1
        track, row = tracks[i], rows[j]
        vote(track, row)
        kind = track_kind(track)
        x, y = row[0], row[1]
        if row[8] != CAMERA:
            length, width = assumed_size(track, kind)
            yaw, seen_l, seen_w, whole_l, whole_w = settle_box(row, kind, track[TYAW], length, width)
            if kind != PEDESTRIAN:
                ax, ay = middle(row, yaw, seen_l, whole_l, sensor[0], sensor[1])
                bx, by = middle(row, yaw + 0.5 * math.pi, seen_w, whole_w, sensor[0], sensor[1])
                x, y = x + ax + bx, y + ay + by
                still = track[VX] ** 2 + track[VY] ** 2 < 1.0
                trust = max(0.05, 1.0 / track[HITS]) if still else 0.25
                track[TYAW] += trust * wrap_angle(yaw - track[TYAW])
            track[SIZED] = max(track[SIZED], seen_l)
            track[TL] = whole_l
            track[TW] += 0.1 * (whole_w - track[TW]) if whole_w > track[TW] else 0.0
        c, s = sight(row[0] - sensor[0], row[1] - sensor[1])
        ex, ey = x - track[TX], y - track[TY]
        p, v = correct_axis(track, AP, c * ex + s * ey, row[7])
        q, w = correct_axis(track, CP, c * ey - s * ex, row[9])
        track[TX] += c * p - s * q
        track[TY] += s * p + c * q
        track[VX] += c * v - s * w
        track[VY] += s * v + c * w
        track[HITS] += 1.0
        track[UNSEEN] = 0.0
        track[SCORE] += 0.3 * (row[6] - track[SCORE])
        speed = math.hypot(track[VX], track[VY])
        if speed > 1.5 and speed > 3.0 * math.sqrt(max(track[AA], track[CC])):
            track[TYAW] += 0.3 * wrap_angle(math.atan2(track[VY], track[VX]) - track[TYAW])
    for j in range(m):
        if used[j] == 1 or owner[j] >= 0 or n == MOST_TRACKS:
            continue
        begin(tracks[n], rows[j], sensor, next_id)
        n += 1
        next_id += 1
    return without_doubles(tracks, n), next_id


@njit(cache=True, error_model="numpy")
def inside(track: FloatArray, x: float, y: float, longer: float, wider: float) -> bool:
    """Whether a point [m] lies in a track's box grown at each end and side [m]."""
    c, s = math.cos(track[TYAW]), math.sin(track[TYAW])
    dx, dy = x - track[TX], y - track[TY]
    along, across = abs(c * dx + s * dy), abs(c * dy - s * dx)
    return bool(along < 0.5 * track[TL] + longer and across < 0.5 * track[TW] + wider)


@njit(cache=True, error_model="numpy")
def gather_fragments(tracks: FloatArray, n: int, rows: FloatArray, used: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Join LiDAR boxes that lie in one vehicle track: a side seen at a grazing angle falls into pieces.

    The joint box replaces the first piece in `rows`, the others are marked in `used`. Returns the track (m,) that each
    row lies in, -1 for none.
    """
    m = len(rows)
    owner = np.full(m, -1, np.int64)
    for j in range(m):
        row = rows[j]
        if row[8] == CAMERA or (row[5] >= 0.0 and int(row[5]) != VEHICLE):
            continue
        most = 0.0
        for i in range(n):
            margin = 0.4 + 2.0 * math.sqrt(max(tracks[i, AP], tracks[i, CP]))
            if track_kind(tracks[i]) != VEHICLE or tracks[i, HITS] <= most:
                continue
            if inside(tracks[i], row[0], row[1], LONGER + margin, margin):
                owner[j], most = i, tracks[i, HITS]
    for i in range(n):
        count, first = 0, -1
        for j in range(m):
            if owner[j] == i:
                count += 1
                first = j if first < 0 else first
        if count < 2:
            continue
        c, s = math.cos(tracks[i, TYAW]), math.sin(tracks[i, TYAW])
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
            if j != first:
                used[j] = 1
                rows[first, 5], rows[first, 8] = max(rows[first, 5], row[5]), max(rows[first, 8], row[8])
                rows[first, 6] = max(rows[first, 6], row[6])
        p, q = 0.5 * (low1 + high1), 0.5 * (low2 + high2)
        rows[first, 0], rows[first, 1], rows[first, 2] = c * p - s * q, s * p + c * q, tracks[i, TYAW]
        rows[first, 3], rows[first, 4] = high1 - low1, high2 - low2
    return owner


@njit(cache=True, error_model="numpy")
def without_doubles(tracks: FloatArray, n: int) -> int:
    """Drop tracks whose middle lies in a vehicle track with more hits; returns how many are left."""
    left = 0
    for i in range(n):
        double = False
        for j in range(n):
            if j != i and tracks[j, HITS] > tracks[i, HITS] and track_kind(tracks[j]) == VEHICLE:
                same = track_kind(tracks[i]) == VEHICLE or tracks[i, HITS] < CONFIRM
                if same and inside(tracks[j], tracks[i, TX], tracks[i, TY], 0.2, 0.2):
                    double = True
        if not double:
            if left != i:
                tracks[left] = tracks[i]
            left += 1
    return left


@njit(cache=True, error_model="numpy")
def turn_track(track: FloatArray, heading: float) -> None:
    """Turn a new track by quarter turns to the axis nearest to `heading` [rad], the way traffic goes there."""
    if track[SIZED] > SIDE or track_kind(track) == PEDESTRIAN:
        return
    quarter = 0.5 * math.pi
    if track[SIZED] == 0.0:  # a camera's word: nothing measured yet
        track[TYAW] = heading
    else:
        track[TYAW] += quarter * math.floor(wrap_angle(heading - track[TYAW]) / quarter + 0.5)
    track[TYAW] = wrap_angle(track[TYAW])


@njit(cache=True, error_model="numpy")
def vote(track: FloatArray, row: FloatArray) -> None:
    """Count what a measurement says of a track's kind; a camera's word weighs more than a cluster's size."""
    for k in range(4):
        track[VOTE_VEHICLE + k] *= 0.95
    if row[5] >= 0.0:
        track[VOTE_VEHICLE + int(row[5])] += row[6]
    else:
        track[VOTE_VEHICLE + kind_by_size(row[3], row[4])] += 0.15


@njit(cache=True, error_model="numpy")
def assumed_size(track: FloatArray, kind: int) -> tuple[float, float]:
    """Length and width [m] of a track: what was seen of it, at least what is typical of its kind."""
    return max(track[SIZED], TYPICAL[kind, 0]), max(track[TW], TYPICAL[kind, 1])


@njit(cache=True, error_model="numpy")
def begin(track: FloatArray, row: FloatArray, sensor: tuple[float, float, float], number: int) -> None:
    """Fill a new track from a measurement."""
    track[:] = 0.0
    vote(track, row)
    kind = track_kind(track)
    length, width = TYPICAL[kind, 0], TYPICAL[kind, 1]
    track[ID], track[TX], track[TY], track[TYAW] = number, row[0], row[1], sensor[2]
    if row[8] != CAMERA:
        yaw, seen_l, seen_w, whole_l, whole_w = settle_box(row, kind, sensor[2], length, width)
        if kind != PEDESTRIAN:
            ax, ay = middle(row, yaw, seen_l, whole_l, sensor[0], sensor[1])
            bx, by = middle(row, yaw + 0.5 * math.pi, seen_w, whole_w, sensor[0], sensor[1])
            track[TX], track[TY] = row[0] + ax + bx, row[1] + ay + by
            track[TYAW] = yaw
        track[SIZED] = seen_l
        length, width = whole_l, whole_w
    track[TL], track[TW] = length, width
    track[AP], track[CP] = row[7], row[9]
    track[AA] = track[CC] = FIRST_SPEED[kind] ** 2
    track[HITS], track[SCORE] = 1.0, row[6]
