"""What goes wrong with real logs, done to a clean one: `dirty(columns, "jitter", seed)`.

Each kind is one function columns -> columns; the clean columns stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tests.truth.effects import FloatArray

Columns = dict[str, FloatArray]
Kind = Callable[[Columns, np.random.Generator], Columns]
KINDS: dict[str, Kind] = {}
CLOCK_OFFSET = 0.2  # s
JITTER = 0.05  # of the period
GNSS_EVERY = 10  # rows: 5 Hz in a 50 Hz log
QUANTA = {"v": 0.1, "yaw_rate": 0.01, "ax": 0.05, "ay": 0.05, "x": 0.01, "y": 0.01, "yaw": 0.005}


def kind(function: Kind) -> Kind:
    KINDS[function.__name__] = function
    return function


def dirty(columns: Columns, name: str, seed: int = 0) -> Columns:
    """The columns with one thing wrong; rows may be more or fewer. Raises ValueError on an unknown kind."""
    if name not in KINDS:
        raise ValueError(f"no kind of dirt called {name!r}; known: {', '.join(KINDS)}")
    copies = {c: np.array(values) for c, values in columns.items()}
    return KINDS[name](copies, np.random.default_rng([seed, 5]))


@kind
def jitter(log: Columns, rng: np.random.Generator) -> Columns:
    """Stamps scatter by 5 % of the period, in order."""
    period = float(np.median(np.diff(log["t"])))
    log["t"] += np.clip(rng.normal(0.0, JITTER * period, len(log["t"])), -0.4 * period, 0.4 * period)
    return log


@kind
def mixed_rates(log: Columns, rng: np.random.Generator) -> Columns:
    """Position and heading at 5 Hz, nothing between."""
    for name in ("x", "y", "yaw"):
        lost = np.arange(len(log["t"])) % GNSS_EVERY != 0
        log[name][lost] = math.nan
    return log


@kind
def quantised(log: Columns, rng: np.random.Generator) -> Columns:
    """Coarse steps of the transmission."""
    for name, quantum in QUANTA.items():
        log[name] = np.round(log[name] / quantum) * quantum
    return log


@kind
def gnss_jumps(log: Columns, rng: np.random.Generator) -> Columns:
    """Position jumps by about a metre, five times, and stays."""
    for row in rng.integers(len(log["t"]) // 10, len(log["t"]), 5):
        log["x"][row:] += rng.choice([-1.0, 1.0])
        log["y"][row:] += rng.choice([-1.0, 1.0])
    return log


@kind
def dropouts(log: Columns, rng: np.random.Generator) -> Columns:
    """Position is lost for two seconds, three times."""
    for row in rng.integers(0, len(log["t"]) - 100, 3):
        for name in ("x", "y", "yaw"):
            log[name][row : row + 100] = math.nan
    return log


@kind
def gap(log: Columns, rng: np.random.Generator) -> Columns:
    """Three seconds of rows are missing."""
    begin = int(rng.integers(len(log["t"]) // 4, len(log["t"]) // 2))
    keep = np.ones(len(log["t"]), dtype=bool)
    keep[begin : begin + 150] = False
    return {name: values[keep] for name, values in log.items()}


@kind
def duplicated_stamps(log: Columns, rng: np.random.Generator) -> Columns:
    """Some rows carry the stamp of the row before."""
    rows = rng.choice(np.arange(1, len(log["t"])), 20, replace=False)
    log["t"][rows] = log["t"][rows - 1]
    return log


@kind
def reversed_stamps(log: Columns, rng: np.random.Generator) -> Columns:
    """A block of rows came in the wrong order."""
    begin = int(rng.integers(0, len(log["t"]) - 50))
    log["t"][begin : begin + 50] = log["t"][begin : begin + 50][::-1]
    return log


@kind
def concatenated(log: Columns, rng: np.random.Generator) -> Columns:
    """Two runs in one file: stamps go on, the car jumps back."""
    period = float(np.median(np.diff(log["t"])))
    joined = {name: np.concatenate([values, values]) for name, values in log.items()}
    joined["t"][len(log["t"]) :] += log["t"][-1] + period - log["t"][0]
    return joined


@kind
def degrees_as_radians(log: Columns, rng: np.random.Generator) -> Columns:
    """The steering is logged in degrees under a header that says rad."""
    log["steer_cmd"] = np.degrees(log["steer_cmd"])
    return log


@kind
def kmh_as_mps(log: Columns, rng: np.random.Generator) -> Columns:
    """The speed is logged in km/h under a header that says m/s."""
    log["v"] = 3.6 * log["v"]
    return log


@kind
def sign_flip(log: Columns, rng: np.random.Generator) -> Columns:
    """The yaw rate is positive to the right."""
    log["yaw_rate"] = -log["yaw_rate"]
    return log


@kind
def axis_swap(log: Columns, rng: np.random.Generator) -> Columns:
    """The accelerometer's axes are exchanged."""
    log["ax"], log["ay"] = log["ay"], log["ax"]
    return log


@kind
def clock_offset(log: Columns, rng: np.random.Generator) -> Columns:
    """Everything measured is stamped 0.2 s late; commands are not."""
    late = round(CLOCK_OFFSET / float(np.median(np.diff(log["t"]))))
    for name in set(log) - {"t", "accel_cmd", "speed_cmd", "steer_cmd"}:
        log[name] = np.concatenate([np.full(late, log[name][0]), log[name][:-late]])
    return log


@kind
def saturated(log: Columns, rng: np.random.Generator) -> Columns:
    """The gyro ends at half of what the car does."""
    most = 0.5 * float(np.nanmax(np.abs(log["yaw_rate"])))
    log["yaw_rate"] = np.clip(log["yaw_rate"], -most, most)
    return log


@kind
def dead(log: Columns, rng: np.random.Generator) -> Columns:
    """The lateral accelerometer shows one number from the second quarter on."""
    log["ay"][len(log["ay"]) // 4 :] = log["ay"][len(log["ay"]) // 4]
    return log


@kind
def steering_report_is_the_command(log: Columns, rng: np.random.Generator) -> Columns:
    """A column `steer` that looks like a measurement and is the command."""
    log["steer"] = log["steer_cmd"].copy()
    return log
