"""Figures of the faults seeded into the stack (`tests/faults`): what gates catch, and false alarms of clean drives.

`python -m scripts.ads_figures_faults` prints them; 1,000 clean drives take some minutes.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "faults"))
from mutation import Fault, failed, faults, seeded

SCENARIOS = ("overtaking", "pedestrian_crossing", "urban", "follow", "traffic_light", "junction")
CLEAN_SEEDS = 1000
SEED = 7
Figure = dict[str, Any]


@cache
def caught() -> dict[str, tuple[str, ...]]:
    """Gates that failed, by the name of the fault."""
    found = {}
    for fault in faults():
        with seeded(fault):
            found[fault.name] = tuple(dict.fromkeys(verdict.metric for verdict in failed(fault.scenario, SEED)))
    return found


def figures(clean_seeds: int = CLEAN_SEEDS) -> list[Figure]:
    """Share of the faults that are caught, and false alarms in clean drives, the scenarios in turn."""
    gates = caught()
    share = sum(bool(found) for found in gates.values()) / len(gates)
    alarms = sum(bool(failed(SCENARIOS[seed % len(SCENARIOS)], seed)) for seed in range(clean_seeds))
    return [
        {
            "name": f"seeded faults that make a gate fail, of {len(gates)}",
            "found": f"{100 * share:.1f} %",
            "goal": ">= 95 %",
            "met": share >= 0.95,
        },
        {
            "name": f"drives without a fault that fail a gate, of {clean_seeds:,} seeds",
            "found": str(alarms),
            "goal": "0",
            "met": alarms == 0,
        },
    ]


def table() -> list[tuple[Fault, tuple[str, ...]]]:
    """Every fault with the gates that failed."""
    gates = caught()
    return [(fault, gates[fault.name]) for fault in faults()]


if __name__ == "__main__":
    for figure in figures():
        print(f"{'met   ' if figure['met'] else 'MISSED'} {figure['name']}: {figure['found']} ({figure['goal']})")
