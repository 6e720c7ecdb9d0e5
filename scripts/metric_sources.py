"""Each metric beside an independent computation of its definition, on random logs: prints the table of docs/metrics.md.

    python -m scripts.metric_sources 10000 [--first 0]

The other computation shares nothing with the metrics but the log (sources_boxes, sources_lane, sources_tracks; filters
are those of scipy, and the rest are plain loops over rows). `peers()` are its functions by the name of the metric.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.signal import butter, filtfilt

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics import compute
from scripts import sources_boxes, sources_lane
from scripts.drawn_logs import EVERY, STEP, drawn_log
from scripts.sources_boxes import RSS
from scripts.sources_tracks import track_figures

BOXES = (
    "min_distance", "min_distance_longitudinal", "min_distance_lateral", "passing_clearance", "time_headway",
    "required_deceleration", "max_ttc_inverse", "tet", "pet", "rss_violation",
)  # fmt: skip
LANE = ("lane_time_outside", "red_light", "stop_line", "start_up_delay", "stop_error", "creep")
OPTIONS: dict[str, dict[str, Any]] = {
    "rss_violation": RSS, "input_age": {"sensor": "imu"}, "nis": {"sensor": "gnss"}, "pet": {"longest": 3.0}
}  # fmt: skip


def passed(values: FloatArray, cutoff: float) -> FloatArray:
    b, a = butter(2, cutoff, fs=1.0 / STEP)
    return np.asarray(filtfilt(b, a, values, padlen=min(len(values) - 1, math.ceil(6.0 / cutoff / STEP))))


def slope(values: FloatArray) -> FloatArray:
    """Central differences, one-sided at the ends."""
    inner = (values[2:] - values[:-2]) / (2 * STEP)
    return np.concatenate([[(values[1] - values[0]) / STEP], inner, [(values[-1] - values[-2]) / STEP]])


def lateral(log: Log) -> FloatArray:
    return passed(log["v"] * log["yaw_rate"] + slope(log["vy"]), 1.0)


def rough(log: Log, name: str) -> float:
    rate = slope(log[name])
    return math.sqrt(float(np.mean((rate - passed(rate, 1.0)) ** 2)))


def repeated_commands(log: Log) -> float | None:
    same = count = 0
    for k in range(EVERY, len(log.t), EVERY):
        if log["v"][k] > 0.5:
            count += 1
            same += log["steer_cmd"][k] == log["steer_cmd"][k - EVERY]
    return same / count if count else None


def estimate(log: Log, of: Callable[[int], float]) -> float:
    return math.sqrt(sum(of(k) ** 2 for k in range(0, len(log.t), EVERY)) / len(range(0, len(log.t), EVERY)))


def off(log: Log, k: int) -> float:
    return math.dist((log["x"][k], log["y"][k]), (log["ads.x"][k], log["ads.y"][k]))


def localization_nees(log: Log) -> float:
    ticks = range(0, len(log.t), EVERY)
    return sum((off(log, k) / log["ads.position_sigma"][k]) ** 2 for k in ticks) / len(ticks)


def turned(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


def peers() -> dict[str, Callable[[Log], float | None]]:
    """The independent computation of each metric, but those of `track_figures`."""
    own: dict[str, Callable[[Log], float | None]] = {name: getattr(sources_boxes, name) for name in BOXES}
    own |= {name: getattr(sources_lane, name) for name in LANE}
    own |= {"repeated_commands": repeated_commands, "localization_nees": localization_nees}
    return {
        **own,
        "max_jerk": lambda log: float(np.abs(slope(slope(passed(log["v"], 1.0)))).max()),
        "max_deceleration": lambda log: -float(slope(passed(log["v"], 1.0)).min()),
        "max_acceleration": lambda log: float(slope(passed(log["v"], 1.0)).max()),
        "max_lateral_acceleration": lambda log: float(np.abs(lateral(log)).max()),
        "max_lateral_jerk": lambda log: float(np.abs(slope(lateral(log))).max()),
        "max_steer_rate": lambda log: float(np.abs(slope(passed(log["steer"], 5.0))).max()),
        "max_yaw_rate": lambda log: max(abs(r) for r in log["yaw_rate"]),
        "steer_roughness": lambda log: rough(log, "steer_cmd"),
        "accel_roughness": lambda log: rough(log, "accel_cmd"),
        "speed_excess": lambda log: max(v - c for v, c in zip(log["v"], log["speed_limit"], strict=True) if c == c),
        "command_age": lambda log: max(log["command_age"].tolist()),
        "input_age": lambda log: max(log["ads.age_imu"].tolist()),
        "disordered_inputs": lambda log: max(log["ads.disordered"].tolist()),
        "nis": lambda log: sum(log["ads.nis_gnss"][::EVERY]) / len(log["ads.nis_gnss"][::EVERY]),
        "lane_width_error": lambda log: sum(
            abs(a - b) for a, b in zip(log["ads.lane_width"], log["lane_width"], strict=True)
        ) / len(log.t),
        "localization_error": lambda log: estimate(log, lambda k: off(log, k)),
        "heading_error": lambda log: estimate(log, lambda k: turned(log["ads.yaw"][k] - log["yaw"][k])),
        "speed_error": lambda log: estimate(log, lambda k: log["ads.v"][k] - log["v"][k]),
    }  # fmt: skip


def compared(seed: int) -> Iterator[tuple[str, float | None, float | None]]:
    """Of a random log: each metric, its value and that of its peer; None: undefined."""
    log = drawn_log(seed)
    expected = {name: peer(log) for name, peer in peers().items()} | track_figures(log)
    for name, value in expected.items():
        found = compute(name, log, **OPTIONS.get(name, {}))
        yield name, found.value if found.valid else None, value


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=int)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    both: dict[str, int] = {}
    worst: dict[str, tuple[float, int]] = {}
    unlike: dict[str, list[int]] = {}
    for seed in range(asked.first, asked.first + asked.cases):
        for name, value, expected in compared(seed):
            if (value is None) != (expected is None):
                unlike.setdefault(name, []).append(seed)
            elif value is not None and expected is not None:
                both[name] = both.get(name, 0) + 1
                worst[name] = max(worst.get(name, (0.0, seed)), (abs(value - expected), seed))
        print(f"\r{seed}", end="", file=sys.stderr)
    print("| metric | defined in | greatest difference | undefined for one alone |\n|---|---|---|---|")
    for name in sorted(both):
        print(
            f"| `{name}` | {both[name]} | {worst[name][0]:.2g} (seed {worst[name][1]}) | {unlike.get(name, [])[:5]} |"
        )


if __name__ == "__main__":
    main()
