"""Memory of tracks: since when something stands, and whether it was ever seen moving."""

from __future__ import annotations

import math

from vehicle.messages import Detection

STANDING = 0.6  # m/s; faster is moving
SURE = 1.0  # m/s; fast enough to call it moving for good
SURE_AGE = 1.0  # s a track must be old for that: a young track's velocity is a guess
SURE_VARIANCE = 0.5  # m^2
FORGET = 5.0  # s unseen
MOST = 64


class Known:
    """What is known of one track [s]."""

    __slots__ = ("first", "moved", "seen", "still_since")

    def __init__(self, t: float) -> None:
        self.first = t
        self.seen = t
        self.still_since = t
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
                known = table[d.track] = Known(t)
            known.seen = t
            speed = math.hypot(d.vx, d.vy)
            if speed > STANDING:
                known.still_since = t
                if speed > SURE and t - known.first > SURE_AGE and d.position_variance < SURE_VARIANCE:
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
