"""Every fault of the wire on three scenarios, stage rw against the surrogate: what became of each run, and of the next.

A cell is one run with the fault from 5 to 8 s, judged by the scenario's own gates (the clean run passes) and by one
that the clean run fails; after it a short clean run, whose bytes must be those of the first short clean run.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SCENARIOS = ("overtaking", "pedestrian_crossing", "urban")
NAMED: Mapping[str, str] = {
    "drop": "lost",
    "delay": "late",
    "duplicate": "repeated",
    "reorder": "out_of_order",
    "nan": "not_finite",
    "clock_ahead": "ahead",
    "clock_back": "stepped_back",
    "burst": "silent",
    "silence": "silent",
    "freeze": "frozen",
    "spike": "jump",
    "no_commands": "not_obeyed",
    "killed": "killed by SIGKILL",
    "stopped": "stopped (SIGSTOP)",
}
"""Fault -> the word that must stand in the report."""

SHORT = 2.0  # s, of the clean run after each
STRICT = "lateral_rmse_path"  # the gate that the clean run fails, at half of its value


def clean(scenario: str) -> dict[str, Any]:
    """Status and strict bound of the run without a fault, and the bytes of a short one."""
    result = _run(scenario)
    return {"status": result.status, "bound": 0.5 * float(result.metrics[STRICT]), "next": _short(scenario)}


def cell(scenario: str, fault: str, without: Mapping[str, Any]) -> dict[str, Any]:
    """What became of one fault: JSON values."""
    from pytest_dvp.drive.wire_log import wire_verdict
    from pytest_dvp.verdicts.gate_file import Gate
    from pytest_dvp.verdicts.judging import judge, overall

    result = _run(scenario, fault=fault)
    strict = [*judge([Gate(STRICT, max=without["bound"])], result.log)]
    troubled = wire_verdict(result.log)
    strict += [troubled] if troubled is not None else []
    said = " ".join(verdict.short for verdict in result.verdicts)
    return {
        "status": result.status,
        "strict": "ERROR" if result.error else overall(strict),
        "traceback": "Traceback" in (result.error or ""),
        "named": NAMED[fault] in said,
        "events": sorted({event.text.split(" ")[0] for event in result.log.events if event.kind == "wire"}),
        "next_same": _short(scenario) == without["next"],
        "processes": _children(),
    }


def matrix(kept: Callable[[str, Callable[[], Any]], Any]) -> dict[str, Any]:
    """All cells; `kept(name, measure)` may know a result from before."""
    out: dict[str, Any] = {}
    for scenario in SCENARIOS:
        without = kept(f"faults-{scenario}-clean", lambda scenario=scenario: clean(scenario))
        out[scenario] = {"clean": without["status"]}
        for fault in NAMED:
            out[scenario][fault] = kept(
                f"faults-{scenario}-{fault}",
                lambda scenario=scenario, fault=fault, without=without: cell(scenario, fault, without),
            )
            print(scenario, fault, out[scenario][fault], file=sys.stderr, flush=True)
    return out


def part(cells: Mapping[str, Any]) -> str:
    """The part of the page."""
    from vehicle.wire.faults import FAULTS

    every = [cells[scenario][fault] for scenario in SCENARIOS for fault in NAMED]
    lines = [
        "| fault, from 5 to 8 s | what happens | named as | " + " | ".join(f"`{s}`" for s in SCENARIOS) + " |",
        "|---|---|---|" + "--|" * len(SCENARIOS),
        "| none | | | " + " | ".join(cells[s]["clean"] for s in SCENARIOS) + " |",
    ]
    for fault, word in NAMED.items():
        row = " | ".join(cells[scenario][fault]["status"] for scenario in SCENARIOS)
        lines.append(f"| `{fault}` | {FAULTS[fault]} | {word.replace('_', ' ')} | {row} |")
    lines += [
        "",
        f"{len(every)} runs: {_count(every, 'traceback', True)} exceptions, {_count(every, 'named', True)} named as "
        f"they must be, {sum(one['status'] == 'PASS' for one in every)} passed. Judged by a gate that the clean run "
        f"fails: {sum(one['strict'] == 'PASS' for one in every)} passed. The clean run after each: "
        f"{_count(every, 'next_same', True)} times the same bytes as without a fault before it. Processes left: "
        f"{sum(one['processes'] for one in every)}.",
    ]
    return "\n".join(lines)


def missed(cells: Mapping[str, Any]) -> list[str]:
    """The cells that are not as they must be."""
    return [
        f"{scenario} {fault}: {one}"
        for scenario in SCENARIOS
        for fault in NAMED
        for one in [cells[scenario][fault]]
        if one["traceback"] or not one["named"] or not one["next_same"] or one["processes"]
        or "PASS" in (one["status"], one["strict"])
    ]  # fmt: skip


def _count(every: Sequence[Mapping[str, Any]], key: str, value: object) -> int:
    return sum(one[key] == value for one in every)


def _run(scenario: str, **options: Any) -> Any:
    from pytest_dvp.drive.run import run

    return run(ROOT / "scenarios" / f"{scenario}.xosc", stage="rw", **options)


def _short(scenario: str) -> str:
    with tempfile.TemporaryDirectory() as folder:
        result = _run(scenario, duration=SHORT, log_dir=Path(folder))
        return hashlib.sha256((result.folder / "log.mcap").read_bytes()).hexdigest()


def _children() -> int:
    """Processes that this one has started and that are still there."""
    count = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text(errors="replace").rpartition(")")[2].split()
        except OSError:
            continue
        count += int(fields[1]) == os.getpid()
    return count
