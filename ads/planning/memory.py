"""Memory of tracks: since when something stands, and whether it was ever seen moving."""

from __future__ import annotations

import math

from vehicle.messages import Detection

STANDING = 0.6  # m/s; faster is moving
DISPLACED = 2.0  # m from where it was first surely seen; so far away, it has moved
SURE = 0.3  # m^2; a place less sure says nothing about motion
FORGET = 5.0  # s unseen
MOST = 64


class Known:
    """What is known of one track [s]."""

    __slots__ = ("moved", "seen", "still_since", "variance", "x", "y")

    def __init__(self, t: float, x: float, y: float, variance: float) -> None:
        self.seen = t
        self.still_since = t
        self.x, self.y, self.variance = x, y, variance
        self.moved = False


class TrackMemory:
    """Known tracks by their number."""

    def __init__(self) -> None:
        self._known: dict[int, Known] = {}

    def note(self, t: float, detections: tuple[Detection, ...]) -> None:
        """Take over the detections of a tick at `t` [s]."""
        table = self._known
        for d in detections:
            known = table.get(d.track)
            if known is None:
                known = table[d.track] = Known(t, d.x, d.y, d.position_variance)
            known.seen = t
            if math.hypot(d.vx, d.vy) > STANDING:
                known.still_since = t
            if known.moved or d.position_variance > SURE:
                continue
            if known.variance > SURE:
                known.x, known.y, known.variance = d.x, d.y, d.position_variance
            elif math.hypot(d.x - known.x, d.y - known.y) > DISPLACED:
                known.moved = True
        if len(table) > MOST:
            for track in [number for number, known in table.items() if t - known.seen > FORGET]:
                del table[track]

    def stood(self, t: float, track: int) -> float:
        """How long a track has stood [s]."""
        return t - self._known[track].still_since

    def moved(self, track: int) -> bool:
        """Whether a track was seen moving for sure."""
        return self._known[track].moved
