"""How much two drives of one car differ in what its stack decides:  python -m scripts.same_car [--first S] [--cars N]

A twin cannot be more like the car than the car is like itself. So the bounds of scenarios/stages.toml on what the stack
decides (line, pace, commands, worst moment) are held against pairs of drives of the car, in which no twin has a part.
For each such gate: the middle, and what the worst 1 % and the worst of all pairs had, on each scenario. Drives are kept
in runs/gate-power.
"""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path

import numpy as np

from pytest_dvp.drive.stage_comparison import gates_between
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.judging import judge_between
from scenarios import path as shipped
from scripts.gate_power import ROOT, SCENARIOS, Drives

DECIDED = ("mncc", "lag", "gain", "max_jerk", "max_ttc_inverse", "completion_time")


def main() -> int:
    """Returns the exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m scripts.same_car")
    parser.add_argument("--first", type=int, default=80_000, help="seed of the first drive")
    parser.add_argument("--cars", type=int, default=40, help="drives of the car on each scenario")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs" / "gate-power")
    asked = parser.parse_args()
    drives = Drives(asked.runs)
    print("| scenario | gate | middle | 1 % | worst | pairs |\n|---|---|---:|---:|---:|---:|")
    for scenario in SCENARIOS:
        gates = [g for g in gates_between(shipped(f"{scenario}.xosc"), None, shipped("stages.toml")) if decided(g)]
        logs = [drives.car(scenario, asked.first + k) for k in range(asked.cars)]
        found: dict[str, list[float]] = {}
        for one, other in itertools.permutations(logs, 2):
            for verdict in judge_between(gates, ("dt", "rw"), {"dt": one, "rw": other}):
                found.setdefault(verdict.name, []).append(np.nan if verdict.value is None else verdict.value)
        for name, values in found.items():
            worse = np.sort(
                values if name.startswith("mncc") else -np.abs(np.asarray(values) - name.startswith("gain"))
            )
            middle, rare, worst = (abs(float(np.nanquantile(worse, q))) for q in (0.5, 0.01, 0.0))
            print(f"| {scenario} | {name} | {middle:.4g} | {rare:.4g} | {worst:.4g} | {len(values)} |")
    return 0


def decided(gate: Gate) -> bool:
    """True if a gate between stages bounds what the stack decided."""
    return gate.between == ("dt", "rw") and gate.metric in DECIDED


if __name__ == "__main__":
    raise SystemExit(main())
