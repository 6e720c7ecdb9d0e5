"""A track: one object with its motion, size and kind, as a row of numbers; and how a measurement's box bears on it.

A measurement's box is what was seen of the object; its middle is moved away from the sensor until the box has the
track's size: the near face of a car is not its middle.
"""

from __future__ import annotations

import math

import numpy as np

from ads.perception.fusion import CAMERA, PEDESTRIAN, TYPICAL, VEHICLE, kind_by_size
from ads.transforms import wrap_angle
from machine_code import compiled
from vehicle.messages import FloatArray

TRACK = 23  # columns, as named below
(ID, TX, TY, VX, VY, AP, AV, AA, CP, CV, CC, TYAW, TL, TW, VOTE_VEHICLE, VOTE_PEDESTRIAN, VOTE_BICYCLE, VOTE_MISC,
 HITS, UNSEEN, AGE, SCORE, SIZED) = range(TRACK)  # fmt: skip
"""Columns: id, position, velocity, covariance along the line of sight (position, both, velocity) and across it, yaw,
length, width, votes per kind, hits, time unseen [s], age [s], score, longest side ever seen [m]."""

FIRST_SPEED = np.array([12.0, 1.7, 4.0, 1.0])  # m/s per kind, sigma of a new track's velocity
MEASURED = 0.01  # m, least side of a box that the LiDAR has seen; 0 is a camera's word
CAMERA_BIAS = 0.03  # of the range; pitch and calibration err alike in every frame, so that no number of frames helps
FACE = 0.25  # of an object's extent; who shows no more of it shows one face
BESIDE = 0.5  # m from a face's plane to the sensor, at least, to know on which side it is
WIDE = 2.2  # m; no car is so wide, a truck is
LONG = 6.0  # m; no car is so long
SIDE = 2.8  # m; no car is wider, not even seen askew, so a longer face is a side
LENGTH_SIGMA = 0.5  # m, chosen: the length of cars about the typical one, from 3.5 m (segment A) to 5.1 m (segment F)


@compiled
def track_kind(track: FloatArray) -> int:
    """Kind with the most votes in `track` (TRACK,), an index into messages.OBJECT_KINDS."""
    best = 0
    for k in range(1, 4):
        if track[VOTE_VEHICLE + k] > track[VOTE_VEHICLE + best]:
            best = k
    return best


@compiled
def sight(dx: float, dy: float) -> tuple[float, float]:
    """Unit vector of the line of sight from the sensor to something dx, dy [m] away."""
    d = max(math.hypot(dx, dy), 1e-6)
    return dx / d, dy / d


@compiled
def correct_axis(track: FloatArray, k: int, innovation: float, variance: float) -> tuple[float, float]:
    """Correction of position [m] and velocity [m/s] of `track` (TRACK,) along one axis, whose covariance shrinks.

    `k`: the column at which the covariance of that axis starts; `innovation` [m], `variance` [m^2].
    """
    total = track[k] + variance
    gain, gain_v = track[k] / total, track[k + 1] / total
    track[k + 2] -= gain_v * track[k + 1]
    track[k + 1] *= 1.0 - gain
    track[k] *= 1.0 - gain
    return gain * innovation, gain_v * innovation


@compiled
def settle_box(row: FloatArray, kind: int, yaw_hint: float, known_length: float, known_width: float) -> tuple[
    float, float, float, float, float
]:  # fmt: skip
    """Yaw [rad], visible length and width [m] of a measured box `row` (MEASURE,), and the size [m] to assume.

    Its length axis is chosen by its sides, or else by `yaw_hint` [rad].
    """
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


@compiled
def middle(
    row: FloatArray, yaw: float, seen: float, whole: float, sensor_x: float, sensor_y: float, long: bool
) -> tuple[float, float]:
    """Shift [m] of the middle of a box `row` (MEASURE,) along `yaw` when it grows from `seen` to `whole` [m].

    It grows away from the sensor. The far end of a `long` one may hide how near the sensor is to its side.
    """
    ux, uy = math.cos(yaw), math.sin(yaw)
    dx, dy = row[0] - sensor_x, row[1] - sensor_y
    away = dx * ux + dy * uy
    share = away / max(math.hypot(dx, dy), 0.1)
    one_face = seen < FACE * whole and abs(away) > 0.5 * seen + BESIDE
    if abs(share) < 0.3 and not (long and one_face):  # looked at squarely: it may be hidden on either side
        return 0.0, 0.0
    shift = math.copysign(0.5 * max(whole - seen, 0.0), share)
    return shift * ux, shift * uy


@compiled
def assumed_size(track: FloatArray, kind: int) -> tuple[float, float]:
    """Length and width [m] of a track (TRACK,): what was seen of it, at least what is typical of its kind."""
    return max(track[SIZED], TYPICAL[kind, 0]), max(track[TW], TYPICAL[kind, 1])


@compiled
def whole_box(
    track: FloatArray, kind: int, row: FloatArray, sensor_x: float, sensor_y: float
) -> tuple[float, float, float, float, float, float]:
    """Middle x, y [m] and yaw [rad] of the object of which a measurement shows a part; length seen, length, width [m].

    `track` (TRACK,), `row` (MEASURE,). What a camera reports is whole already.
    """
    if row[8] == CAMERA:
        return row[0], row[1], track[TYAW], 0.0, track[TL], track[TW]
    length, width = assumed_size(track, kind)
    yaw, seen_l, seen_w, whole_l, whole_w = settle_box(row, kind, track[TYAW], length, width)
    if kind == PEDESTRIAN:
        return row[0], row[1], yaw, 0.0, whole_l, whole_w
    long = whole_l > LONG
    ax, ay = middle(row, yaw, seen_l, whole_l, sensor_x, sensor_y, long)
    bx, by = middle(row, yaw + 0.5 * math.pi, seen_w, whole_w, sensor_x, sensor_y, long)
    return row[0] + ax + bx, row[1] + ay + by, yaw, max(seen_l, MEASURED), whole_l, whole_w


@compiled
def vote(track: FloatArray, row: FloatArray) -> None:
    """Count in `track` (TRACK,) what a measurement `row` (MEASURE,) says of its kind.

    A kind is an index into messages.OBJECT_KINDS. A camera's word weighs more than a cluster's size.
    """
    for k in range(4):
        track[VOTE_VEHICLE + k] *= 0.95
    if row[5] >= 0.0:
        track[VOTE_VEHICLE + int(row[5])] += row[6]
    else:
        track[VOTE_VEHICLE + kind_by_size(row[3], row[4])] += 0.15


@compiled
def surely_moving(track: FloatArray) -> bool:
    """True if a track (TRACK,) is faster [m/s] than its velocity is uncertain: its motion tells where it points."""
    speed = math.hypot(track[VX], track[VY])
    return bool(speed > 1.5 and speed > 3.0 * math.sqrt(max(track[AA], track[CC])))


@compiled
def axis_unknown(track: FloatArray) -> bool:
    """True if neither a side of a track (TRACK,), longer than SIDE [m], nor its motion has shown where it points."""
    return not (track[SIZED] > SIDE or track_kind(track) == PEDESTRIAN or surely_moving(track))


@compiled
def unknown_middle(track: FloatArray) -> float:
    """Variance [m^2] of the middle along a track (TRACK,), of a vehicle of which only the short face was seen."""
    if track[SIZED] > SIDE or track_kind(track) != VEHICLE:
        return 0.0
    return (0.5 * LENGTH_SIGMA) ** 2


@compiled
def depth(track: FloatArray, c: float, s: float) -> float:
    """Half the extent [m] of a track's box in the direction (c, s)."""
    along = abs(c * math.cos(track[TYAW]) + s * math.sin(track[TYAW]))
    return float(0.5 * (track[TL] * along + track[TW] * math.sqrt(max(1.0 - along * along, 0.0))))


@compiled
def turn_track(track: FloatArray, heading: float, sensor_x: float, sensor_y: float) -> None:
    """Turn a track by quarter turns to the axis nearest to `heading` [rad], the way traffic goes there.

    The face towards the sensor at (sensor_x, sensor_y) [m] stays where it was seen.
    """
    quarter = 0.5 * math.pi
    if track[SIZED] == 0.0:  # a camera's word: nothing measured yet
        track[TYAW] = wrap_angle(heading)
        return
    turns = math.floor(wrap_angle(heading - track[TYAW]) / quarter + 0.5)
    if turns == 0:
        return
    c, s = sight(track[TX] - sensor_x, track[TY] - sensor_y)
    before = depth(track, c, s)
    track[TYAW] = wrap_angle(track[TYAW] + quarter * turns)
    shift = depth(track, c, s) - before
    track[TX] += shift * c
    track[TY] += shift * s


@compiled
def begin(track: FloatArray, row: FloatArray, sensor: tuple[float, float, float], number: int) -> None:
    """Fill a new track (TRACK,) from a measurement `row` (MEASURE,), in SI units; `sensor` as update_tracks has it."""
    for k in range(TRACK):
        track[k] = 0.0
    vote(track, row)
    kind = track_kind(track)
    track[ID], track[TYAW], track[TL], track[TW] = number, sensor[2], TYPICAL[kind, 0], TYPICAL[kind, 1]
    x, y, yaw, seen, length, width = whole_box(track, kind, row, sensor[0], sensor[1])
    track[TX], track[TY], track[TYAW], track[SIZED], track[TL], track[TW] = x, y, yaw, seen, length, width
    track[AP], track[CP] = row[7], row[9]
    track[AA] = track[CC] = FIRST_SPEED[kind] ** 2
    track[HITS], track[SCORE] = 1.0, row[6]


@compiled
def newly_seen(track: FloatArray, length: float, x: float, y: float) -> float:
    """By how much [m] a track's middle moves along it as it is seen to be `length` [m] long, its middle at (x, y) [m].

    The end that was seen stays: at most half of what is new. It is no motion. Of a car that is little: 0.
    """
    if max(length, track[SIZED]) <= LONG and track[TW] <= WIDE:
        return 0.0
    more = 0.5 * max(length - track[TL], 0.0)
    along = math.cos(track[TYAW]) * (x - track[TX]) + math.sin(track[TYAW]) * (y - track[TY])
    return min(max(along, -more), more)


@compiled
def correct_track(track: FloatArray, row: FloatArray, sensor_x: float, sensor_y: float) -> None:
    """Take a measurement `row` (MEASURE,) into a track (TRACK,): kind, size, yaw, position and velocity, in SI units.

    sensor_x, sensor_y [m]: where the sensor was in the map.
    """
    vote(track, row)
    kind = track_kind(track)
    x, y, yaw, seen, length, width = whole_box(track, kind, row, sensor_x, sensor_y)
    if row[8] != CAMERA:
        if kind != PEDESTRIAN:
            still = track[VX] ** 2 + track[VY] ** 2 < 1.0
            trust = max(0.05, 1.0 / track[HITS]) if still else 0.25
            track[TYAW] += trust * wrap_angle(yaw - track[TYAW])
        track[SIZED] = max(track[SIZED], seen)
        shift = newly_seen(track, length, x, y)
        track[TX] += shift * math.cos(track[TYAW])
        track[TY] += shift * math.sin(track[TYAW])
        track[TL] = length
        track[TW] += 0.1 * max(width - track[TW], 0.0)
    c, s = sight(row[0] - sensor_x, row[1] - sensor_y)
    ex, ey = x - track[TX], y - track[TY]
    p, v = correct_axis(track, AP, c * ex + s * ey, row[7])
    q, w = correct_axis(track, CP, c * ey - s * ex, row[9])
    if row[8] == CAMERA:
        track[AP] = max(track[AP], CAMERA_BIAS**2 * ((row[0] - sensor_x) ** 2 + (row[1] - sensor_y) ** 2))
    track[TX] += c * p - s * q
    track[TY] += s * p + c * q
    track[VX] += c * v - s * w
    track[VY] += s * v + c * w
    track[HITS] += 1.0
    track[UNSEEN] = 0.0
    track[SCORE] += 0.3 * (row[6] - track[SCORE])
    if surely_moving(track):
        course = math.atan2(track[VY], track[VX])
        if math.cos(course - track[TYAW]) < 0.0:  # turned round at once: on the way it would lie across the road, and
            track[TYAW] += math.pi  # stay so where the motion, first told by a camera's ranges, proves to be none
        track[TYAW] = wrap_angle(track[TYAW] + 0.3 * wrap_angle(course - track[TYAW]))
