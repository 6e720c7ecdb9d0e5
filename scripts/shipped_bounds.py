"""Writes the bounds of clean drives into the gate files that ship, from the drives of scripts/shipped_drives.py.

    python -m scripts.shipped_bounds [--drives runs/shipped_gates/clean.jsonl]

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

# Known by requirements already, or of no log.
LEFT_OUT = (
    "collision", "road_departure", "goal_reached", "scenario_ended", "events_fired", "event_started", "tick_time",
    "red_light", "tet",
)  # fmt: skip
# Nearer to 0 is no fault: bounded above alone.
ERRORS = (
    "localization_error", "heading_error", "speed_error", "detection_error", "missed_objects", "false_tracks",
    "track_position_error", "track_speed_error", "track_size_error", "track_yaw_error", "identity_switches",
    "kind_error", "repeated_commands", "command_age", "steer_roughness", "accel_roughness", "lateral_rmse_path",
    "creep",
)  # fmt: skip
# Least distance between the clean drives and a bound: by unit what a log resolves, and some by themselves.
MARGIN = {
    "s": 0.1, "m": 0.02, "rad": 0.002, "rad/s": 0.005, "m/s": 0.02, "m/s^2": 0.05, "m/s^3": 0.1, "1/s": 0.02, "-": 0.02,
}  # fmt: skip
OWN_MARGIN = {
    "identity_switches": 1.5, "false_tracks": 0.5, "missed_objects": 0.3, "command_age": 0.01, "nees": 1.0,
    "localization_nees": 1.0,
}  # fmt: skip
SHARE = 0.02  # of the value, at least
WIDER = (
    2.0  # times as far from the median as the tail asks. Of bounds of two thirds of 610 drives, 17 of 704 tries with
)
# the others broke one as they were; 9 did so widened, all of four drives that took another course of events.


def bounds(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Bounds of one scenario's clean drives: "max" and "min" by metric, of those that each drive defines."""
    found: dict[str, dict[str, float]] = {"max": {}, "min": {}}
    for name in sorted(rows[0]["metrics"]):
        metric = name.split()[0]
        values = [row["metrics"].get(name) for row in rows]
        if metric in LEFT_OUT or metric.startswith(("replay_", "rss_")) or any(value is None for value in values):
            continue
        unit = find_metric(metric).unit
        size = max(abs(value) for value in values)
        margin = max(OWN_MARGIN.get(metric, MARGIN.get(unit, 0.02)), SHARE * size)
        middle = float(np.median(values))
        if metric != "detection_recall":
            found["max"][name] = _rounded(middle + WIDER * (upper_bound(values, RATE, margin) - middle), math.ceil)
        if metric not in ERRORS:
            low = middle + WIDER * (lower_bound(values, RATE, margin) - middle)
            if low > 0.0 or min(values) < 0.0:
                found["min"][name] = _rounded(low, math.floor)
    return found


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
    parser.add_argument("--drives", type=Path, default=STORE / "clean.jsonl")
    of: dict[str, list[Mapping[str, Any]]] = defaultdict(list)
    for row in stored(parser.parse_args().drives):
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
