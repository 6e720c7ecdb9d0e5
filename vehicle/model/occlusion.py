"""How much of an object is behind others, as seen from the ego."""

from __future__ import annotations

import numpy as np

from vehicle.messages import FloatArray
from vehicle.model.perception_effects import Tracks

RAYS = 64  # over the angle that a box fills


def hidden_share(tracks: Tracks) -> FloatArray:
    """Share (n,) [-], 0 to 1, of the angle that each box fills which is behind boxes that are nearer at its stamp.

    Seen from the ego's reference point, from above: heights do not count. What is nearer has the nearer middle. A box
    around the reference point, or one without size, hides nothing. Resolution 1 / RAYS.
    """
    share = np.zeros(len(tracks.t))
    if not len(share):
        return share
    starts = np.flatnonzero(np.diff(tracks.t, prepend=-np.inf) > 0.0)
    middle, half = _angles(tracks)
    distance = tracks.distance()
    ray = (np.arange(RAYS) + 0.5) / RAYS * 2.0 - 1.0
    for begin, end in zip(starts, np.append(starts[1:], len(tracks.t)), strict=True):
        if end - begin < 2:
            continue
        rows = slice(begin, end)
        at = middle[rows, None] + half[rows, None] * ray  # (k, RAYS)
        off = np.abs(np.remainder(at[:, :, None] - middle[rows] + np.pi, 2.0 * np.pi) - np.pi)  # (k, RAYS, k)
        nearer = distance[None, rows] < distance[rows, None] - 1e-9
        share[rows] = ((off < half[rows]) & nearer[:, None, :]).any(axis=2).mean(axis=1)
    return share


def _angles(tracks: Tracks) -> tuple[FloatArray, FloatArray]:
    """Direction of each box's middle [rad] on the map, and half the angle [rad] that it fills; 0 from within it."""
    dx, dy = tracks.x - tracks.ego_x, tracks.y - tracks.ego_y
    middle = np.arctan2(dy, dx)
    c, s = np.cos(tracks.yaw), np.sin(tracks.yaw)
    low, high = np.zeros(len(middle)), np.zeros(len(middle))
    for a, b in ((0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)):
        ex, ey = a * tracks.length, b * tracks.width
        corner = np.arctan2(dy + s * ex + c * ey, dx + c * ex - s * ey)
        off = np.remainder(corner - middle + np.pi, 2.0 * np.pi) - np.pi
        low, high = np.minimum(low, off), np.maximum(high, off)
    along, across = np.abs(dx * c + dy * s), np.abs(dy * c - dx * s)
    outside = (along > 0.5 * tracks.length) | (across > 0.5 * tracks.width)
    return np.asarray(middle + 0.5 * (low + high)), np.where(outside, 0.5 * (high - low), 0.0)
