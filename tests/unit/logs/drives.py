"""A car driven on paper: logs with known motion, and the defects that logs come with. Independent of the product."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pytest_dvp.logs.log import Log

Columns = dict[str, np.ndarray]

UNITS = {
    "t": "s", "x": "m", "y": "m", "yaw": "rad", "v": "m/s", "yaw_rate": "rad/s", "ax": "m/s^2", "ay": "m/s^2",
    "steer": "rad", "steer_cmd": "rad", "accel_cmd": "m/s^2",
}  # fmt: skip
WHEELBASE = 2.7
SUBSTEPS = 10


def drive(
    seconds: float = 60.0,
    rate: float = 50.0,
    seed: int = 1,
    noise: float = 1.0,
    heading: float = 0.4,
    steer_delay: float = 0.0,
) -> Columns:
    """Starts, curves of both directions, brakes to a stop and goes on: kinematic bicycle by its rear axle.

    The steering follows its command with a lag of 0.1 s (after `steer_delay` [s]), the drive with one of 0.2 s:
    true physics, no defect.
    """
    rng = np.random.default_rng(seed)
    n = int(seconds * rate)
    dt = 1.0 / rate
    t = np.arange(n) * dt
    accel = np.select(
        [t % 30 < 6, t % 30 < 16, t % 30 < 19, t % 30 < 24, t % 30 < 27], [1.8, 0.3 * np.sin(t), -2.5, 1.2, -3.0], 0.0
    )
    command = 0.08 * np.sin(0.9 * t + 0.3 * np.sin(0.13 * t)) + 0.06 * np.sign(np.sin(0.21 * t + seed))
    state = {name: np.zeros(n) for name in ("x", "y", "yaw", "v", "a", "d")}
    x = y = v = a = d = 0.0
    yaw = heading
    for i in range(n):
        for name, value in zip(state, (x, y, yaw, v, a, d), strict=True):
            state[name][i] = value
        h = dt / SUBSTEPS
        for _ in range(SUBSTEPS):
            a += (accel[i] - a) * h / 0.2
            d += (command[max(i - round(steer_delay * rate), 0)] - d) * h / 0.1
            if v <= 0.0 and a < 0.0:
                v = 0.0
            else:
                v = max(v + a * h, 0.0)
            yaw += v * math.tan(d) / WHEELBASE * h
            x, y = x + v * math.cos(yaw) * h, y + v * math.sin(yaw) * h
    standing = (state["v"] == 0.0) & (state["a"] < 0.0)
    turn = state["v"] * np.tan(state["d"]) / WHEELBASE
    columns = {
        "t": t, "x": state["x"], "y": state["y"], "yaw": state["yaw"], "v": state["v"], "yaw_rate": turn,
        "ax": np.where(standing, 0.0, state["a"]), "ay": state["v"] * turn, "steer": state["d"],
        "steer_cmd": command, "accel_cmd": accel,
    }  # fmt: skip
    sigma = {"x": 0.02, "y": 0.02, "yaw": 0.003, "v": 0.03, "yaw_rate": 0.005, "ax": 0.08, "ay": 0.08, "steer": 0.0005}
    return {n: c + noise * sigma.get(n, 0.0) * rng.normal(size=len(t)) for n, c in columns.items()}


def later(columns: Columns, names: tuple[str, ...], seconds: float) -> Columns:
    """The named channels as a sensor with a clock `seconds` off would record them."""
    t = columns["t"]
    return {n: np.interp(t - seconds, t, c) if n in names else c for n, c in columns.items()}


def scaled(columns: Columns, factor: float, *names: str) -> Columns:
    return {n: c * factor if n in names else c for n, c in columns.items()}


def swapped(columns: Columns, a: str, b: str) -> Columns:
    return {n: columns[b] if n == a else columns[a] if n == b else c for n, c in columns.items()}


def jittered(columns: Columns, share: float, seed: int = 3) -> Columns:
    """Stamps whose intervals scatter by `share` (standard deviation); the values belong to the true times."""
    steps = np.diff(columns["t"])
    scatter = np.random.default_rng(seed).normal(size=len(steps)) * share
    return {**columns, "t": np.concatenate([[0.0], np.cumsum(steps * np.maximum(1.0 + scatter, 0.1))])}


def rows(columns: Columns, index: np.ndarray) -> Columns:
    return {n: c[index] for n, c in columns.items()}


def without(columns: Columns, *names: str) -> Columns:
    return {n: c for n, c in columns.items() if n not in names}


def two_runs(columns: Columns, other: Columns) -> Columns:
    """A second run behind the first, its clock going on."""
    step = columns["t"][1] - columns["t"][0]
    shift = columns["t"][-1] + step - other["t"][0]
    return {n: np.concatenate([c, other[n] + (shift if n == "t" else 0.0)]) for n, c in columns.items()}


def write_csv(path: Path, columns: Columns, header: Callable[[str], str] | None = None) -> Path:
    named = header or (lambda name: f"{name} [{UNITS.get(name, '-')}]")
    lines = [",".join(named(n) for n in columns)]
    lines += [
        ",".join(f"{v:.9g}" if np.isfinite(v) else "" for v in row) for row in zip(*columns.values(), strict=True)
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def log_of(columns: Columns) -> Log:
    return Log(columns={n: np.ascontiguousarray(c, dtype=float) for n, c in columns.items()})
