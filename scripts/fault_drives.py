"""Drives faults made after the gates stood (scripts/fresh_faults.py), and tells which of them no gate noticed.

    python -m scripts.fault_drives drive SEED [--count 120] [--drives 100]     # goes on after an interruption
    python -m scripts.fault_drives tell SEED

`--kinds second` drives those of scripts/fresh_kinds.py. SEED is the first 8 hex digits of the commit that froze the
gates. A fault is put into the reference stack and driven through the scenarios, in an order of its own, until a gate
that ships does not pass. It changed a drive if a metric leaves the range of the clean drives, as `dvp mutate` has it.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import random
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.drive.stack_host import find_ads
from pytest_dvp.mutation.fault import Fault
from pytest_dvp.mutation.faulty_stack import behind
from pytest_dvp.mutation.mutate import OF_THE_CLOCK, Envelope, proposed_gate
from pytest_dvp.mutation.source_mutants import mutant_named, planted
from scripts import fresh_faults, fresh_kinds
from scripts.shipped_drives import STORE, driven, go_on, names, stored

KINDS = {"first": fresh_faults.generated, "second": fresh_kinds.generated, "source": fresh_faults.of_the_source}
DRIVE_SEED = 0  # one of the clean seeds, so that a fault without effect drives exactly as that one
CLEAN = 20  # seeds, as `dvp mutate` takes them


@contextlib.contextmanager
def faulty(fault: Fault) -> Iterator[Any]:
    """What `ads=` takes for the reference stack with the fault."""
    if fault.where == "source":
        with planted(mutant_named(fault.name)):
            yield None
    else:
        yield behind(find_ads(None), fault)


def drive(seed: str, k: int, scenario: str, told: str, fault: Fault) -> dict[str, Any]:
    """One drive of a fault, as the store keeps it; a stack that breaks is a gate that did not pass."""
    try:
        with faulty(fault) as ads:
            row = driven(scenario, DRIVE_SEED, ads=ads)
    except Exception as error:
        row = {"scenario": scenario, "seed": DRIVE_SEED, "parameters": {}, "status": "ERROR", "metrics": {}}
        row["failed"] = [f"run: {type(error).__name__}"]
    return {**row, "draw": seed, "fault": k, "where": fault.where, "told": told}


def store_of(seed: str, kinds: str) -> Path:
    """Where the drives of a draw are kept."""
    return STORE / (f"faults_{seed}.jsonl" if kinds == "first" else f"faults_{seed}_{kinds}.jsonl")


def drive_all(seed: str, kinds: str, count: int, most: int) -> None:
    """Drive what the store does not hold yet, at most `most` drives."""
    store = store_of(seed, kinds)
    rows = list(stored(store))
    done = {(row["fault"], row["scenario"]) for row in rows}
    killed = {row["fault"] for row in rows if row["failed"]}
    for k, (told, fault) in enumerate(KINDS[kinds](seed, count)):
        order = names()
        random.Random(f"{seed} {k}").shuffle(order)
        for scenario in order:
            if k in killed or most <= 0:
                break
            if (k, scenario) in done:
                continue
            row = drive(seed, k, scenario, told, fault)
            go_on(store, [(k, scenario)], lambda row: (row["fault"], row["scenario"]), lambda *_, row=row: row)
            most -= 1
            print(f"{k} {fault.where}: {told}: {scenario}: {row['failed'][:2] or 'passed'}", file=sys.stderr)
            if row["failed"]:
                killed.add(k)


def envelopes() -> dict[str, dict[str, Envelope]]:
    """By scenario and metric the range of the first CLEAN clean drives; None: not every one of them has it."""
    of: dict[str, list[dict[str, Any]]] = {}
    for row in stored(STORE / "clean.jsonl"):
        if not row["parameters"]:
            of.setdefault(row["scenario"], []).append(row["metrics"])
    found: dict[str, dict[str, Envelope]] = {}
    for scenario, every in of.items():
        first = every[:CLEAN]
        found[scenario] = {}
        for metric in first[0].keys() - OF_THE_CLOCK:
            values = [float(row[metric]) for row in first if row.get(metric) is not None]
            if len(values) == len(first):
                found[scenario][metric] = Envelope(min(values), max(values), len(values))
    return found


def far(row: dict[str, Any], ranges: dict[str, Envelope]) -> tuple[float, str]:
    """By how much, in widths of its range, and which metric left its range farthest; a lost one is infinitely far."""
    away = [
        (float("inf") if row["metrics"].get(metric) is None else envelope.beyond(row["metrics"][metric]), metric)
        for metric, envelope in ranges.items()
    ]
    return max(away, default=(0.0, ""))


def caught(row: dict[str, Any], scenario: str, metric: str) -> dict[str, Any]:
    """The gate that `dvp mutate` proposes for an escaper, and how many further clean drives break it, of how many."""
    rows = [*stored(STORE / "clean.jsonl"), *stored(STORE / "fresh.jsonl")]
    clean = [r["metrics"] for r in rows if r["scenario"] == scenario and not r["parameters"]]
    first, further = [[m[metric] for m in some if m.get(metric) is not None] for some in (clean[:CLEAN], clean[CLEAN:])]
    envelope, value = Envelope(min(first), max(first), len(first)), row["metrics"][metric]
    gate = proposed_gate(scenario, metric, value, envelope)
    assert gate is not None, f"clean drives of {scenario} break the default gate of {metric}"
    low, high = (-math.inf if gate.min is None else gate.min), (math.inf if gate.max is None else gate.max)
    broken = sum(not low <= one <= high for one in further)
    return {"gate": f"{metric} {low:.4g} to {high:.4g}", "kills": not low <= value <= high,
            "clean": f"{broken} of {len(further)}"}  # fmt: skip


def tell(seed: str, without: Sequence[str] = (), kinds: str = "first") -> list[dict[str, Any]]:
    """One row a fault: family, description, whether it was noticed and where, and how far it went from clean drives.

    without: metrics that do not tell whether a fault changed a drive; that it was noticed, each gate tells.
    """
    ranges = {
        scenario: {name: one for name, one in found.items() if name.split()[0] not in without}
        for scenario, found in envelopes().items()
    }
    of: dict[int, list[dict[str, Any]]] = {}
    for row in stored(store_of(seed, kinds)):
        of.setdefault(row["fault"], []).append(row)
    told = []
    for k, rows in sorted(of.items()):
        by = next((row for row in rows if row["failed"]), None)
        worst = max((*far(row, ranges[row["scenario"]]), row["scenario"]) for row in rows)
        escaped = by is None and 0.0 < worst[0] < math.inf
        proposed = (
            caught(next(row for row in rows if row["scenario"] == worst[2]), worst[2], worst[1]) if escaped else {}
        )
        told_by = [gate for row in rows for gate in row["failed"] if re.split(r"[ (]", gate)[0] not in without]
        told.append(
            {"fault": k, "where": rows[0]["where"], "told": rows[0]["told"], "drives": len(rows),
             "noticed": by is not None, "by": f"{by['scenario']}: {by['failed'][0]}" if by else "",
             "changed": bool(told_by) or worst[0] > 0.0, "worst": f"{worst[2]}: {worst[1]} {worst[0]:.3g}",
             "proposed": proposed}
        )  # fmt: skip
    return told


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["drive", "tell"])
    parser.add_argument("seed")
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--drives", type=int, default=10**9, help="at most so many in this call")
    parser.add_argument("--kinds", choices=sorted(KINDS), default="first")
    parser.add_argument("--without", nargs="+", default=(), help="metrics that do not tell whether a drive changed")
    asked = parser.parse_args()
    if asked.what == "drive":
        drive_all(asked.seed, asked.kinds, asked.count, asked.drives)
        return
    rows = tell(asked.seed, asked.without, asked.kinds)
    for row in rows:
        if row["changed"] and not row["noticed"]:
            print(f"escaped: {row['fault']} {row['where']}: {row['told']}: farthest {row['worst']}")
            print(f"    proposed: {row['proposed']}")
    for family in ("observation", "command", "map", "time", "source", ""):
        some = [row for row in rows if row["where"].startswith(family)]
        changed = [row for row in some if row["changed"]]
        noticed = sum(row["noticed"] for row in changed)
        print(f"{family or 'all'}: {noticed} of {len(changed)} that changed, of {len(some)}")


if __name__ == "__main__":
    main()
