"""Figures of tracks, computed once more (scripts/metric_sources.py): matches are the best of all permutations."""

from __future__ import annotations

import itertools
import math

import numpy as np

from pytest_dvp.logs.log import Log
from scripts.drawn_logs import EVERY, STEP
from scripts.sources_boxes import pose


def is_ahead(log: Log, k: int, x: float, y: float) -> bool:
    m, axis, _ = pose(log, k)
    p = (complex(x, y) - m) / axis - log.meta["ego"]["length"] / 2
    return 0.0 < p.real < 20.0 and abs(p.imag) < 4.0


def best_match(cost: list[list[float]]) -> dict[int, int]:
    """Row: column of the permutation with most matches within 3 m and then the least sum."""
    columns = len(cost[0]) if cost else 0
    best, choice = (0, 0.0), {}
    for pick in itertools.permutations([*range(columns), *[-1] * len(cost)], len(cost)):
        pairs = {i: j for i, j in enumerate(pick) if j >= 0 and cost[i][j] <= 3.0}
        score = (-len(pairs), sum(cost[i][j] for i, j in pairs.items()))
        if score < best:
            best, choice = score, pairs
    return choice


def judged(log: Log) -> tuple[list[tuple[str, int, int]], int]:
    """(name, row of its track, row of the detection or -1) of each road user ahead, and how many detections ahead
    belong to nobody."""
    table, names = log.detections, list(log.objects)
    found, ghosts = [], 0
    since: dict[str, float | None] = dict.fromkeys(names)
    for i, t in enumerate(log.objects[names[0]].t):
        rows = [j for j in range(len(table.t)) if abs(table.t[j] - t) < 1e-6]
        cost = [
            [math.dist((table.x[j], table.y[j]), (log.objects[n].x[i], log.objects[n].y[i])) for j in rows]
            for n in names
        ]
        pairs = best_match(cost)
        for a, name in enumerate(names):
            track = log.objects[name]
            if not is_ahead(log, i * EVERY, track.x[i], track.y[i]):
                since[name] = None
                continue
            since[name] = t if since[name] is None else since[name]
            if t - since[name] >= 1.0 - 1e-6:
                found.append((name, i, rows[pairs[a]] if a in pairs else -1))
        for b, j in enumerate(rows):
            if is_ahead(log, i * EVERY, table.x[j], table.y[j]) and all(of[b] > 3.0 for of in cost):
                ghosts += 1
    return found, ghosts


def track_figures(log: Log) -> dict[str, float | None]:
    """Every metric of tracks by its name; None: undefined."""
    every, ghosts = judged(log)
    table = log.detections
    hit = [(log.objects[name], i, j, name) for name, i, j in every if j >= 0]
    place = [math.dist((table.x[j], table.y[j]), (o.x[i], o.y[i])) for o, i, j, _ in hit]
    speed = [abs(complex(table.vx[j] - o.vx[i], table.vy[j] - o.vy[i])) for o, i, j, _ in hit]
    axes = [math.acos(min(abs(math.cos(table.yaw[j] - o.yaw[i])), 1.0)) for o, i, j, _ in hit if o.kind != "pedestrian"]
    size, late, fast, form = [], 0.0, 0.0, []
    for o, i, j, _ in hit:
        both = min(table.length[j], o.length) * min(table.width[j], o.width)
        size.append(1.0 - both / (table.length[j] * table.width[j] + o.length * o.width - both))
        v, e = complex(o.vx[i], o.vy[i]), complex(table.x[j] - o.x[i], table.y[j] - o.y[i])
        if abs(v) > 1.0:
            late, fast = late - (e * v.conjugate()).real, fast + abs(v) ** 2
        assert table.cov_xx is not None
        assert table.cov_xy is not None
        assert table.cov_yy is not None
        p = np.array([[table.cov_xx[j], table.cov_xy[j]], [table.cov_xy[j], table.cov_yy[j]]])
        form.append(float(np.array([e.real, e.imag]) @ np.linalg.solve(p, [e.real, e.imag])))
    assert table.track is not None
    switches, last = 0, dict[str, float]()
    for _, _, j, name in hit:
        switches += last.get(name, table.track[j]) != table.track[j]
        last[name] = float(table.track[j])

    def mean(values: list[float]) -> float | None:
        return sum(values) / len(values) if values else None

    def rms(values: list[float]) -> float | None:
        return math.sqrt(sum(v * v for v in values) / len(values)) if values else None

    return {
        "detection_recall": len(hit) / len(every) if every else None,
        "false_tracks": ghosts * STEP * EVERY,
        "track_position_error": mean(place), "track_speed_error": rms(speed), "track_yaw_error": rms(axes),
        "track_size_error": mean(size), "track_latency": late / fast if fast else None, "nees": mean(form),
        "identity_switches": float(switches) if hit else None,
        "kind_error": mean([float(table.kind[j] != o.kind) for o, _, j, _ in hit]),
    }  # fmt: skip
