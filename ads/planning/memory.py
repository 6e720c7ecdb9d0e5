"""Memory of tracks: since when something stands, and whether it was ever seen moving."""

from __future__ import annotations

import math

from vehicle.messages import Detection

STANDING = 0.6  # m/s; faster is moving
DISPLACED = 2.0  # m from where it was seen, and more than the places are unsure; so far away, it has moved
SIGMAS = 6.0  # a filter that errs alike in every frame wanders farther than 3
SURER = 0.5  # of the variance; a place so much better known is the one to compare with
BY_CAMERA = 0.01  # of the range; a less sure place was seen by no LiDAR; chosen, a third of what the camera's has
PITCH = 0.008  # rad, unknown to the camera; a car that pulled away at 58 m, as measured, was placed 19 m too near
FORGET = 5.0  # s unseen
MOST = 64  # tracks, from which on those not seen for FORGET are deleted; chosen, not measured


class Known:
    """What is known of one track [s]."""

    __slots__ = ("moved", "pitch_error", "seen", "still_since", "variance", "x", "y")

    def __init__(self, t: float, x: float, y: float, variance: float, pitch_error: float) -> None:
        self.seen = t
        self.still_since = t
        self.x, self.y, self.variance, self.pitch_error = x, y, variance, pitch_error  # m, m, m^2, m
        self.moved = False


class TrackMemory:
    """Known tracks by their number, of a car whose camera is `camera_z` [m] above the ground."""

    def __init__(self, camera_z: float) -> None:
        self._known: dict[int, Known] = {}
        self._pitch_gain = PITCH / camera_z  # 1/m

    def note(self, t: float, x: float, y: float, detections: tuple[Detection, ...]) -> None:
        """Take over the detections of a tick at `t` [s], at which the car is at (x, y) [m]."""
        table = self._known
        for d in detections:
            distance = math.hypot(d.x - x, d.y - y)
            by_camera = d.position_variance > (BY_CAMERA * distance) ** 2
            pitch_error = self._pitch_gain * distance * distance if by_camera else 0.0
            known = table.get(d.track)
            if known is None:
                known = table[d.track] = Known(t, d.x, d.y, d.position_variance, pitch_error)
            known.seen = t
            if math.hypot(d.vx, d.vy) > STANDING:
                known.still_since = t
            if known.moved:
                continue
            unsure = SIGMAS * math.sqrt(known.variance + d.position_variance)
            unsure += math.hypot(known.pitch_error, pitch_error)
            if math.hypot(d.x - known.x, d.y - known.y) > DISPLACED + unsure:
                known.moved = True
            elif d.position_variance < SURER * known.variance:
                known.x, known.y, known.variance = d.x, d.y, d.position_variance
                known.pitch_error = pitch_error
        if len(table) > MOST:
            for track in [number for number, known in table.items() if t - known.seen > FORGET]:
                del table[track]

    def waits(self, t: float, track: int) -> None:
        """Take a track that waits for something at `t` [s] for one that moved until now."""
        known = self._known[track]
        known.moved, known.still_since = True, t

    def stood(self, t: float, track: int) -> float:
        """How long a track has stood [s]."""
        return t - self._known[track].still_since

    def moved(self, track: int) -> bool:
        """Whether a track was seen moving for sure."""
        return self._known[track].moved
