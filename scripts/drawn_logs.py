"""Short random logs, for comparing metrics with their independent sources (scripts/metric_sources.py).

The ego drives a smooth random way past a traffic light along a straight lane, among up to three others; the stack's
detections, estimates and commands are the truth with noise, misses, ghosts, repetitions and swaps.
"""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, LogEvent, ObjectTrack

STEP, EVERY = 0.01, 5  # s of a row; rows of a tick
LASTS = 2.0, 4.0  # s: what is ahead counts after 1 s
KINDS = ("vehicle", "bicycle", "pedestrian")
STATES = ("red", "green", "amber", "red;amber", "on;off;off", "off;off;on", "on;on;off")


def drawn_log(seed: int) -> Log:
    """The log of a seed, the same each time; SI units."""
    rng = np.random.default_rng([seed, 23])
    t = np.arange(round(rng.uniform(*LASTS) / STEP)) * STEP
    n, ticks = len(t), slice(None, None, EVERY)
    v = np.maximum(rng.uniform(0.0, 8.0) + _smooth(rng, t, 2.0), 0.0)
    if rng.random() < 0.4:  # comes to rest, and may set off again
        v *= np.clip(1.0 - (t - rng.uniform(0.0, 1.5)) * rng.uniform(0.5, 3.0), 0.0, 1.0)
        v += np.where(t > rng.uniform(*LASTS), 2.0, 0.0) * (rng.random() < 0.5)
    rate = _smooth(rng, t, 0.15)
    yaw = rng.uniform(-0.2, 0.2) + np.cumsum(rate) * STEP
    turn = rng.uniform(-np.pi, np.pi)  # of the lane in the map
    x, y = np.cumsum(v * np.cos(yaw)) * STEP, rng.uniform(-1.0, 1.0) + np.cumsum(v * np.sin(yaw)) * STEP
    ego = {"length": rng.uniform(2.0, 6.0), "width": rng.uniform(1.0, 2.5), "height": 1.5, "center_x": 1.2}
    columns = {
        "t": t, **_turned(x, y, yaw, turn), "v": v, "vx": v, "vy": 0.1 * rate, "yaw_rate": rate,
        "steer": _smooth(rng, t, 0.1), "lane_width": np.full(n, rng.uniform(2.5, 4.5)),
        "speed_limit": np.where(t < 1.0, np.nan, rng.uniform(1.0, 12.0)),
    }  # fmt: skip
    held = np.repeat(np.arange(0, n, EVERY), EVERY)[:n]
    for name, size in (("steer_cmd", 0.1), ("accel_cmd", 2.0), ("command_age", 0.02), ("ads.age_imu", 0.1)):
        asked = np.round(_smooth(rng, t, size) + rng.normal(0.0, 0.05 * size, n), 3)
        columns[name] = asked[held]
    for name in ("x", "y", "yaw", "v"):
        columns[f"ads.{name}"] = (columns[name] + rng.normal(0.0, 0.1, n))[held]
    columns["ads.position_sigma"] = rng.uniform(0.05, 0.3, n)[held]
    columns["ads.nis_gnss"] = rng.chisquare(2, n)[held] / 2.0
    columns["ads.lane_width"] = (columns["lane_width"] + rng.normal(0.0, 0.3, n))[held]
    columns["ads.disordered"] = np.cumsum(rng.random(n) < 0.02)[held].astype(float)
    tracks = {f"other{k}": _other(rng, t[ticks], x[ticks], y[ticks], turn) for k in range(rng.integers(1, 4))}
    line = np.array([[-50.0, 0.0], [rng.uniform(0.0, 30.0), 0.0]])
    reference = np.column_stack(_rotated(line[:, 0], line[:, 1], turn))
    at = rng.uniform(0.0, 20.0)
    px, py = _rotated(np.array([at]), np.array([0.0]), turn)
    lines = [{"signal": "7", "x": float(px[0]), "y": float(py[0]), "heading": turn, "width": 3.5}]
    changes = np.sort(rng.uniform(0.0, LASTS[1], 3))
    phases = [
        LogEvent(0.0 if k == 0 else float(s), "signal", "7", str(rng.choice(STATES))) for k, s in enumerate(changes)
    ]
    meta = {"ego": ego, "stage": "dt", "stop_lines": lines, "task": {"goal": {"road": "1"}}}
    return Log(columns, tracks, _seen(rng, tracks), [], reference, [], phases, meta)


def _smooth(rng: np.random.Generator, t: FloatArray, size: float) -> FloatArray:
    """A sum of four sinusoids of 0.1 to 3 Hz, (n,)."""
    total = np.zeros(len(t))
    for frequency, phase in zip(rng.uniform(0.1, 3.0, 4), rng.uniform(0.0, 2.0 * np.pi, 4), strict=True):
        total += size / 2.0 * rng.random() * np.sin(2.0 * np.pi * frequency * t + phase)
    return total


def _rotated(x: FloatArray, y: FloatArray, turn: float) -> tuple[FloatArray, FloatArray]:
    return np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y


def _turned(x: FloatArray, y: FloatArray, yaw: FloatArray, turn: float) -> dict[str, FloatArray]:
    x, y = _rotated(x, y, turn)
    return {"x": x, "y": y, "yaw": yaw + turn}


def _other(rng: np.random.Generator, t: FloatArray, x: FloatArray, y: FloatArray, turn: float) -> ObjectTrack:
    """One that drives straight and crosses the ego's way, or goes with it."""
    k = int(rng.integers(0, len(t)))
    course = rng.choice([0.0, np.pi, rng.uniform(-np.pi, np.pi)])
    speed = rng.choice([0.0, rng.uniform(0.0, 8.0)])
    vx, vy = speed * np.cos(course), speed * np.sin(course)
    ox = x[k] + rng.uniform(-10.0, 25.0) + vx * (t - t[k])
    oy = y[k] + rng.uniform(-7.0, 7.0) + vy * (t - t[k])
    ox, oy = _rotated(ox, oy, turn)
    vx, vy = _rotated(np.full(len(t), vx), np.full(len(t), vy), turn)
    yaw = np.full(len(t), course + turn + rng.normal(0.0, 0.1))
    size = float(rng.uniform(0.4, 6.0)), float(rng.uniform(0.4, 2.5))
    return ObjectTrack(str(rng.choice(KINDS)), *size, 1.5, t, ox, oy, np.zeros(len(t)), yaw, vx, vy)


def _seen(rng: np.random.Generator, tracks: dict[str, ObjectTrack]) -> DetectionTable:
    """The truth with noise, some of it missed, with doubles and ghosts; numbers of tracks are swapped now and then."""
    rows: list[tuple[float, str, FloatArray]] = []
    for k, track in enumerate(tracks.values()):
        for i, t in enumerate(track.t):
            for _ in range(int(rng.choice([0, 1, 1, 1, 1, 2]))):
                truth = np.array(
                    [track.x[i], track.y[i], track.yaw[i], track.length, track.width, track.vx[i], track.vy[i]]
                )
                told = truth + rng.normal(0.0, 0.4, 7) * np.array([1.0, 1.0, 0.5, 0.2, 0.2, 1.0, 1.0])
                told[3:5] = np.maximum(told[3:5], 0.1)
                kind = track.kind if rng.random() < 0.9 else "misc"
                number = float(k if rng.random() < 0.95 else rng.integers(0, 5))
                xx, yy = rng.uniform(0.05, 0.5, 2)
                cov = (xx, rng.uniform(-0.9, 0.9) * np.sqrt(xx * yy), yy)
                rows.append((t, kind, np.array([*told, number, *cov])))
            if rng.random() < 0.05:
                ghost = np.array([*rng.uniform(-15.0, 15.0, 2), 0.0, 2.0, 1.0, 0.0, 0.0, 9.0, 0.1, 0.0, 0.1])
                ghost[:2] += track.x[i], track.y[i]
                rows.append((t, "vehicle", ghost))
    rows.sort(key=lambda row: row[0])
    values = np.array([row[2] for row in rows]).reshape(-1, 11)
    return DetectionTable(np.array([row[0] for row in rows]), tuple(row[1] for row in rows), *values.T)
