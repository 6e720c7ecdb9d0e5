"""Distances, times and RSS of pairs of boxes, computed once more (scripts/metric_sources.py).

Boxes are complex numbers, strips are clipped polygons, a time to collision is the overlap of shadows on four axes.
"""

from __future__ import annotations

import cmath
import functools
import math
from collections.abc import Iterator

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import ObjectTrack
from scripts.drawn_logs import EVERY, STEP

RSS = {
    "response_time": 0.5, "max_acceleration": 2.0, "max_braking": 8.0, "min_braking": 4.0,
    "lateral_acceleration": 0.5, "lateral_braking": 1.0, "lateral_margin": 0.2,
}  # fmt: skip
SIGNS = (1 + 1j, -1 + 1j, -1 - 1j, 1 - 1j)


def places(track: ObjectTrack) -> Iterator[tuple[int, int]]:
    """Rows of a track and of the log at the same time."""
    return ((i, i * EVERY) for i in range(len(track.t)))


@functools.lru_cache(maxsize=1)
def poses(log: Log) -> list[tuple[complex, complex, complex]]:
    """Of each row: middle of the ego's box, direction of its x axis, velocity of its middle, as complex numbers."""
    ahead, found = log.meta["ego"]["center_x"], []
    for x, y, yaw, vx, vy, rate in zip(
        *(log[n].tolist() for n in ("x", "y", "yaw", "vx", "vy", "yaw_rate")), strict=True
    ):
        axis = cmath.exp(1j * yaw)
        found.append((complex(x, y) + ahead * axis, axis, complex(vx, vy + ahead * rate) * axis))
    return found


def pose(log: Log, k: int) -> tuple[complex, complex, complex]:
    """That of row k."""
    return poses(log)[k]


def other(track: ObjectTrack, i: int) -> tuple[complex, complex, complex]:
    return complex(track.x[i], track.y[i]), cmath.exp(1j * track.yaw[i]), complex(track.vx[i], track.vy[i])


def ring(middle: complex, axis: complex, size: tuple[float, float]) -> list[complex]:
    return [middle + axis * complex(s.real * size[0] / 2, s.imag * size[1] / 2) for s in SIGNS]


def size_of(log: Log) -> tuple[float, float]:
    return log.meta["ego"]["length"], log.meta["ego"]["width"]


def shadows(a: list[complex], b: list[complex], axis: complex) -> tuple[float, float, float, float]:
    one, two = [(p * axis.conjugate()).real for p in a], [(p * axis.conjugate()).real for p in b]
    return min(one), max(one), min(two), max(two)


def apart(a: list[complex], b: list[complex], axes: tuple[complex, ...]) -> float:
    """Distance of two rings: 0 if no axis separates them, else the least of each corner from each edge."""
    for axis in axes:
        low, high, low2, high2 = shadows(a, b, axis)
        if low > high2 or low2 > high:
            break
    else:
        return 0.0
    least = math.inf
    for points, edges in ((a, b), (b, a)):
        for p in points:
            for q, r in zip(edges, edges[1:] + edges[:1], strict=True):
                share = ((p - q) * (r - q).conjugate()).real / abs(r - q) ** 2
                least = min(least, abs(p - q - min(max(share, 0.0), 1.0) * (r - q)))
    return least


def clipped(polygon: list[complex], half: float) -> list[complex]:
    """The part of a polygon with |imaginary part| <= half (Sutherland and Hodgman)."""
    for sign in (1.0, -1.0):
        kept: list[complex] = []
        for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            a, b = half - sign * p.imag, half - sign * q.imag
            if a >= 0.0:
                kept.append(p)
            if (a > 0.0 > b) or (a < 0.0 < b):
                kept.append(p + a / (a - b) * (q - p))
        polygon = kept
        if not polygon:
            break
    return polygon


@functools.lru_cache(maxsize=1)
def strips(log: Log) -> list[tuple[complex, complex, complex, complex, list[complex], list[complex]]]:
    """Of each pair: ego's speed, the other's, both along the ego's axes, its middle, and what of it is in the strip as
    wide as the ego and, turned by a quarter, as long as it."""
    (length, width), found = size_of(log), []
    for track in log.objects.values():
        for i, k in places(track):
            m, axis, v = pose(log, k)
            om, oaxis, ov = other(track, i)
            seen = [(p - m) / axis for p in ring(om, oaxis, (track.length, track.width))]
            found.append((
                v / axis, ov / axis, (om - m) / axis, complex(length, width),
                clipped(seen, width / 2), clipped([-1j * p for p in seen], length / 2),
            ))  # fmt: skip
    return found


def gap(part: list[complex], whole: float) -> float:
    low, high = min(p.real for p in part), max(p.real for p in part)
    return max(low - whole / 2, -whole / 2 - high, 0.0)


def least(values: list[float]) -> float | None:
    return min(values, default=None)


def min_distance(log: Log) -> float | None:
    found = []
    for track in log.objects.values():
        for i, k in places(track):
            (m, axis, _), (om, oaxis, _) = pose(log, k), other(track, i)
            a, b = ring(m, axis, size_of(log)), ring(om, oaxis, (track.length, track.width))
            found.append(apart(a, b, (axis, 1j * axis, oaxis, 1j * oaxis)))
    return least(found)


def min_distance_longitudinal(log: Log) -> float | None:
    return least([gap(along, size.real) for _, _, _, size, along, _ in strips(log) if along])


def min_distance_lateral(log: Log) -> float | None:
    return least([gap(across, size.imag) for _, _, _, size, _, across in strips(log) if across])


def passing_clearance(log: Log) -> float | None:
    return least(
        [gap(across, s.imag) for v, ov, _, s, _, across in strips(log) if across and abs(v.real - ov.real) > 1.0]
    )


def ahead(log: Log) -> Iterator[tuple[float, float, float]]:
    """Gap, speed of the ego, closing speed, of what is straight ahead."""
    for v, ov, m, size, along, _ in strips(log):
        if along and m.real > 0.0:
            yield max(min(p.real for p in along) - size.real / 2, 0.0), v.real, v.real - ov.real


def time_headway(log: Log) -> float | None:
    return least([g / v for g, v, _ in ahead(log) if v > 0.5])


def required_deceleration(log: Log) -> float | None:
    return max((max(c, 0.0) ** 2 / (2.0 * max(g, 0.1)) for g, _, c in ahead(log)), default=None)


@functools.lru_cache(maxsize=1)
def ttcs(log: Log) -> list[list[float]]:
    """Of each track and row: from when to when the shadows on all four axes overlap."""
    found = []
    for track in log.objects.values():
        of_track = []
        for i, k in places(track):
            (m, axis, v), (om, oaxis, ov) = pose(log, k), other(track, i)
            a, b = ring(m, axis, size_of(log)), ring(om, oaxis, (track.length, track.width))
            begin, end = 0.0, math.inf
            for line in (axis, 1j * axis, oaxis, 1j * oaxis):
                low, high, low2, high2 = shadows(a, b, line)
                speed = ((ov - v) * line.conjugate()).real
                if speed == 0.0:
                    begin, end = (begin, end) if low2 <= high and high2 >= low else (math.inf, 0.0)
                else:
                    first, last = sorted(((low - high2) / speed, (high - low2) / speed))
                    begin, end = max(begin, first), min(end, last)
            of_track.append(begin if begin <= end else math.inf)
        found.append(of_track)
    return found


def max_ttc_inverse(log: Log) -> float | None:
    return max(1.0 / max(t, 0.01) for of_track in ttcs(log) for t in of_track)


def tet(log: Log) -> float | None:
    counts = [(sum(t < 2.0 for t in of_track[:-1]), of_track[-1] < 2.0) for of_track in ttcs(log)]
    return sum(STEP * EVERY * max(count, last) for count, last in counts)


def pet(log: Log) -> float | None:
    """All pairs of instants, by shadows on the four axes."""
    found = []
    for track in log.objects.values():
        mine = [pose(log, k) for _, k in places(track)]
        its = [other(track, i) for i in range(len(track.t))]
        gap_ = np.array([[abs(i - j) * STEP * EVERY for j in range(len(its))] for i in range(len(mine))])
        between = np.array([o[0] for o in its])[None, :] - np.array([p[0] for p in mine])[:, None]
        a, b = np.array([p[1] for p in mine])[:, None], np.array([o[1] for o in its])[None, :]
        met = np.ones(gap_.shape, dtype=bool)
        for line in (a, 1j * a, b, 1j * b):
            reach = sum(
                length / 2 * abs((of * np.conj(line)).real) + width / 2 * abs((1j * of * np.conj(line)).real)
                for of, (length, width) in ((a, size_of(log)), (b, (track.length, track.width)))
            )
            met &= np.abs((between * np.conj(line)).real) <= reach
        found += gap_[met & (gap_ <= 3.0)].tolist()
    return least(found)


def rss_violation(log: Log) -> float | None:
    """Definitions 1, 2 and 6 of the paper, one pair at a time; the last row of a track counts where no other does."""
    r, up, hard, soft, aup, brake, mu = RSS.values()
    total = 0.0
    length, width = size_of(log)
    for track in log.objects.values():
        count = 0
        for i, k in places(track):
            (m, axis, v), (om, oaxis, ov) = pose(log, k), other(track, i)
            seen = [(p - m) / axis for p in ring(om, oaxis, (track.length, track.width))]
            low, high = min(p.real for p in seen), max(p.real for p in seen)
            bottom, top = min(p.imag for p in seen), max(p.imag for p in seen)
            along = max(low - length / 2, -length / 2 - high, 0.0)
            beside = max(bottom - width / 2, -width / 2 - top, 0.0)
            v, ov = v / axis, ov / axis
            rear, front = (v.real, ov.real) if low + high >= 0.0 else (ov.real, v.real)
            rear, front = (0.0 if abs(u) < 1e-6 else u for u in (rear, front))
            if rear < 0.0 and front < 0.0:
                rear, front = -front, -rear
            way = rear * r + up * r * r / 2 + max(rear + r * up, 0.0) ** 2 / (2 * soft)
            if front < 0.0:
                need = way - front * r + up * r * r / 2 + (-front + r * up) ** 2 / (2 * soft)
            else:
                need = way - front**2 / (2 * hard)
            side = 1.0 if bottom + top >= 0.0 else -1.0
            p, q = side * v.imag, side * ov.imag
            pr, qr = p + r * aup, q - r * aup
            ways = [(u + w) / 2 * r + w * abs(w) / (2 * brake) for u, w in ((p, pr), (q, qr))]
            if along < max(need, 0.0) and beside < mu + max(ways[0] - ways[1], 0.0):
                count += i < len(track.t) - 1 or not count
        total += STEP * EVERY * count
    return total
