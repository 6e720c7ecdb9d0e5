"""Size and yaw of detected boxes against those of the objects they belong to."""

from __future__ import annotations

import numpy as np

from pytest_dvp.gap.perception.detection_pairs import Frames, Pairs
from pytest_dvp.logs.log_contents import FloatArray

KIND = "vehicle"  # whose sides are long enough for a LiDAR to tell its size and its axis
NEAR = 25.0  # m; farther away a tracker assumes the size that is usual
LEAST_OBJECTS = 3  # whose sizes differ by themselves: a scatter between objects needs three
LEAST_ROWS = 10  # boxes of one object
FINEST = np.array([0.02, 0.02, 0.01])  # standard deviations by object that no tracker is better than: -, -, rad


class Boxes:
    """What the boxes of cars nearby show: median (3,) over objects of length ratio, width ratio and turn [rad] to the
    left, and its standard deviation (3,); worth (2,): log-likelihood of size and of yaw.

    objects is 0 if the boxes tell nothing: no lengths, or of too few objects. Source of the deviation of a median:
    P. J. Huber, Robust Statistics (1981), section 1.2.
    """

    def __init__(self, f: Frames, p: Pairs, latency: float = 0.0) -> None:
        """latency [s]: age of the boxes, for an object that turns has turned on since."""
        self.objects, self.mean, self.spread, self.worth = 0, np.array([1.0, 1.0, 0.0]), np.zeros(3), np.zeros(2)
        every = [_of_object(f, p, j, name, latency) for j, name in enumerate(f.log.objects)]
        rows = np.array([row for row in every if row is not None])
        if len(rows) < LEAST_OBJECTS:
            return
        self.objects = len(rows)
        self.mean = np.median(rows, axis=0)
        scatter = np.maximum(1.4826 * np.median(np.abs(rows - self.mean), axis=0), FINEST)
        self.spread = np.sqrt(0.5 * np.pi / len(rows)) * scatter
        off = (self.mean - (1.0, 1.0, 0.0)) / self.spread
        self.worth = 0.5 * np.array([off[0] ** 2 + off[1] ** 2, off[2] ** 2])


def _of_object(f: Frames, p: Pairs, j: int, name: str, latency: float = 0.0) -> FloatArray | None:
    """Medians (3,) of one object's boxes; None if it is no car, or was not seen from nearby."""
    track, table = f.log.objects[name], f.log.detections
    seen = np.flatnonzero(p.seen[:, j] & (p.distance[:, j] <= NEAR))
    if track.kind != KIND or len(seen) < LEAST_ROWS or track.length <= 0.0 or track.width <= 0.0:
        return None
    row = p.row[seen, j]
    if not (table.length[row] > 0.0).all() or np.ptp(table.length[row]) + np.ptp(table.width[row]) == 0.0:
        return None  # a size that no measurement moves was not measured
    yaw = np.interp(f.t[seen] - latency, track.t, np.unwrap(track.yaw))
    turn = np.remainder(table.yaw[row] - yaw + 0.5 * np.pi, np.pi) - 0.5 * np.pi
    every = [table.length[row] / track.length, table.width[row] / track.width, turn]
    return np.array([np.median(values) for values in every])
