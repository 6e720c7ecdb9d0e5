"""Memory of tracks: since when something stands, and whether it was ever seen moving."""

from __future__ import annotations

import math

from vehicle.messages import Detection

STANDING = 0.6  # m/s; faster is moving
DISPLACED = 2.0  # m from where it was seen, and more than the places are unsure; so far away, it has moved
SIGMAS = 6.0  # a filter that errs alike in every frame wanders farther than 3
SURER = 0.5  # of the variance; a place so much better known is the one to compare with
FORGET = 5.0  # s unseen
MOST = 64  # tracks, from which on those not seen for FORGET are deleted; chosen, not measured


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
            if known.moved:
                continue
            unsure = SIGMAS * math.sqrt(known.variance + d.position_variance)
            if math.hypot(d.x - known.x, d.y - known.y) > DISPLACED + unsure:
                known.moved = True
            elif d.position_variance < SURER * known.variance:
                known.x, known.y, known.variance = d.x, d.y, d.position_variance
        if len(table) > MOST:
            for track in [number for number, known in table.items() if t - known.seen > FORGET]:
                del table[track]

    def stood(self, t: float, track: int) -> float:
        """How long a track has stood [s]."""
        return t - self._known[track].still_since

    def moved(self, track: int) -> bool:
        """Whether a track was seen moving for sure."""
        return self._known[track].moved
