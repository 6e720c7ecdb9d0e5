"""Writes the bounds of clean drives into the gate files that ship, from the drives of scripts/shipped_drives.py.

    python -m scripts.shipped_bounds [--drives FILE...]      # runs/shipped_gates/clean.jsonl

What is above the table [clean] of a file, the requirements, stays as it is. A bound is the same for the same drives.
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openscenario.read import read_declarations
from pytest_dvp.metrics import find_metric
from pytest_dvp.mutation.clean_bound import LEAST, lower_bound, upper_bound
from scripts.shipped_drives import FOLDER, STORE, names, stored

RATE = 1e-6  # false alarms of a bound in a drive; some 60 bounds a scenario: 6e-5 a drive, 0.2 in 3,000
HEAD = (
    "# Bounds that {n} clean drives of the reference stack keep on dt (docs/mutate.md), by scripts/shipped_bounds.py."
)

# Known by requirements already, or of no log; creep is undefined where by chance the ego does not stand for a second.
LEFT_OUT = (
    "collision", "road_departure", "goal_reached", "scenario_ended", "events_fired", "event_started", "tick_time",
    "red_light", "tet", "creep",
)  # fmt: skip
OF_A_SENSOR = ("input_age", "nis")  # bounded by sensor alone
# What depends on the course of events: who goes first, whether the ego brakes once more. A drive may take a course that
# none of some hundred before took, and no tail of theirs tells how far that lies: in 250 drives of junction the ego
# stayed 87 m away from the other one, and once 11 m. Only a requirement can bound such a metric.
OF_THE_COURSE = (
    "completion_time", "pet", "time_headway", "min_distance", "min_distance_lateral", "min_distance_longitudinal",
    "passing_clearance", "max_ttc_inverse", "required_deceleration", "max_deceleration", "max_acceleration", "max_jerk",
    "max_yaw_rate", "max_lateral_acceleration", "max_lateral_jerk", "max_steer_rate",
)  # fmt: skip
# What changes by a step: bounded above, at least at STEP times the median. A track that is lost and begins anew has a
# wrong speed for half a second, in 1 of 138 drives of urban; a vehicle that is passed later is passed on another line.
STEP = 2.0  # chosen; kept by 3,200 drives that it had not seen
BY_STEPS = ("identity_switches", "missed_objects", "track_speed_error", "lateral_rmse", "lane_time_outside")
# Nearer to 0 is no fault: bounded above alone.
ERRORS = (
    "localization_error", "heading_error", "speed_error", "detection_error", "missed_objects", "false_tracks",
    "track_position_error", "track_speed_error", "track_size_error", "track_yaw_error", "identity_switches",
    "kind_error", "repeated_commands", "command_age", "steer_roughness", "accel_roughness", "lateral_rmse_path",
    "disordered_inputs", "lane_width_error", "lateral_rmse", "lane_time_outside",
)  # fmt: skip
# Least distance between the clean drives and a bound: by unit what a log resolves, and some by themselves.
MARGIN = {
    "s": 0.1, "m": 0.02, "rad": 0.002, "rad/s": 0.005, "m/s": 0.02, "m/s^2": 0.05, "m/s^3": 0.1, "1/s": 0.02, "-": 0.02,
}  # fmt: skip
OWN_MARGIN = {
    "identity_switches": 1.5, "false_tracks": 0.5, "missed_objects": 0.3, "command_age": 0.01, "nees": 1.0,
    "localization_nees": 1.0, "input_age": 0.02, "disordered_inputs": 0.5,
    "track_yaw_error": 0.05,
}  # fmt: skip
SHARE = 0.02  # of the value, at least
# Upper bounds are at least these, from theory. nis: chi-square of 2 degrees (over 2) and of 1 at 1e-9 a measurement;
# localization_nees: of 2 at 1e-6 a drive, because the slow error of the fixes lasts as long as a drive.
AT_LEAST = {
    "nis sensor=gnss statistic=greatest": 20.7, "nis sensor=heading statistic=greatest": 37.3,
    "nis sensor=wheels statistic=greatest": 37.3, "localization_nees": 27.6,
}  # fmt: skip
WIDER = 1.5  # times as far from the median as the tail asks. With bounds of 27 of 40 drives, in eight splits of each
# scenario, no other metric than those OF_THE_COURSE and OF_THE_POSITION left 0.7 of that distance in the other 13.
OF_THE_POSITION = ("localization_error", "localization_nees", "lateral_rmse_path", "stop_error")
WIDER_POSITION = 2.0  # the slow error of the fixes is one draw a drive, and the same in each scenario with that seed


def bounds(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Bounds of one scenario's clean drives: "max" and "min" by metric, of those that each drive defines.

    A drive that does not have a metric at all is older than the metric, and says nothing of it.
    """
    found: dict[str, dict[str, float]] = {"max": {}, "min": {}}
    for name in sorted({name for row in rows for name in row["metrics"]}):
        metric = name.split()[0]
        values = [row["metrics"][name] for row in rows if name in row["metrics"]]
        if metric in LEFT_OUT + OF_THE_COURSE or metric.startswith(("replay_", "rss_")):
            continue
        if any(value is None for value in values):
            continue
        if name in OF_A_SENSOR:  # as a gate of the same file asked it
            continue
        low, high = _both(name, values)
        if metric != "detection_recall":
            found["max"][name] = _rounded(max(high, AT_LEAST.get(name, -math.inf)), math.ceil)
        if metric not in ERRORS and (low > 0.0 or min(values) < 0.0):
            found["min"][name] = _rounded(low, math.floor)
    return found


def _both(name: str, values: Sequence[float]) -> tuple[float, float]:
    """Lower and upper bound of the values of one metric."""
    metric, middle = name.split()[0], float(np.median(values))
    margin = OWN_MARGIN.get(metric, MARGIN.get(find_metric(metric).unit, 0.02))
    margin = max(margin, SHARE * max(abs(value) for value in values))
    wider = WIDER_POSITION if metric in OF_THE_POSITION else WIDER
    low = middle + wider * (lower_bound(values, RATE, margin) - middle)
    high = middle + wider * (upper_bound(values, RATE, margin) - middle)
    if metric in BY_STEPS:
        high = max(high, STEP * middle)
    return low, high


def _rounded(value: float, outwards: Any) -> float:
    """Three digits, away from the drives."""
    if value == 0.0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    return float(f"{outwards(value / step) * step:.6g}")


def table(scenario: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """The text of the table [clean]."""
    declared = read_declarations(FOLDER / f"{scenario}.xosc")
    values = ", ".join(f"{one.name} = {float(one.value):g}" for one in declared)
    lines = [
        HEAD.format(n=len(rows)),
        "[clean]",
        'only_if_logged = "ads.position_sigma"',
        f"parameters = {{ {values} }}",
    ]
    for side, found in bounds(rows).items():
        lines += ["", f"[clean.{side}]"]
        lines += [f'"{name}" = {bound:g}' if " " in name else f"{name} = {bound:g}" for name, bound in found.items()]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=Path, nargs="+", default=[STORE / "clean.jsonl"])
    of: dict[str, list[Mapping[str, Any]]] = defaultdict(list)
    for row in (row for file in parser.parse_args().drives for row in stored(file)):
        if not row["parameters"]:
            of[row["scenario"]].append(row)
    for scenario in names():
        if len(of[scenario]) < LEAST:
            print(f"{scenario}: {len(of[scenario])} clean drives, {LEAST} are needed")
            continue
        file = FOLDER / f"{scenario}.gates.toml"
        kept = file.read_text("utf-8").partition(HEAD.split("{")[0])[0].rstrip() + "\n\n"
        file.write_text(kept + table(scenario, of[scenario]), encoding="utf-8")
        print(f"{file.name}: bounds of {len(of[scenario])} drives")


if __name__ == "__main__":
    main()
