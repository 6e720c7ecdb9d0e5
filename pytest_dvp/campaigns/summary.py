"""What a campaign found so far, as plain data and as text."""

from __future__ import annotations

import collections
from collections.abc import Sequence
from typing import Any

from pytest_dvp.campaigns.failure_probability import Probability
from pytest_dvp.campaigns.space_coverage import Coverage, Gap
from pytest_dvp.campaigns.store import EXCLUDED, SHRINKING, Row, Store

SHOWN = 5  # failures and nearest passes that the text lists
CURRENT = "current"
"""Name under which a store tells which base keys belong to the last command; rows of older code have others."""


def current_rows(store: Store) -> list[Row]:
    """The drives of the settings that the campaign was last driven with; all, if that is not known."""
    bases = store.told(CURRENT)
    return store.rows(bases) if isinstance(bases, list) and bases else store.rows()


def told_of_each(store: Store, what: str) -> dict[str, dict[str, Any]]:
    """What was found last by scenario, of those for which it was: the "probability" of failure, the "coverage"."""
    found = {}
    for base in store.told(CURRENT) or ():
        rows, plain = store.rows([base]), store.told(f"{what} {base}")
        if plain is not None and rows:
            found[rows[0].scenario] = plain
    return found


def summary(rows: Sequence[Row], older: int = 0) -> dict[str, Any]:
    """Counts by verdict, failures by gate, the worst drives, and the CPU time; `older`: rows of other settings."""
    every, rows = rows, [row for row in rows if row.purpose != SHRINKING and row.verdict != EXCLUDED]
    excluded = sum(row.verdict == EXCLUDED and row.purpose != SHRINKING for row in every)
    shrinking = len(every) - len(rows) - excluded
    verdicts = collections.Counter(row.verdict for row in rows)
    gates = collections.Counter(cluster_name(row) for row in rows if row.failed)
    ranked = sorted((row for row in rows if row.objective is not None), key=lambda row: (row.objective, row.key))
    cpu = sum(row.cpu for row in every)
    return {
        "runs": len(rows),
        "excluded": excluded,
        "shrinking": shrinking,
        "older": older,
        "verdicts": dict(sorted(verdicts.items())),
        "vacuous": sum(row.vacuous for row in rows),
        "failures": dict(sorted(gates.items())),
        "worst": [
            {"key": row.key, "verdict": row.verdict, "objective": row.objective, "gate": row.gate,
             "object": row.object, "parameters": row.parameters, "log": row.log, "message": row.message}
            for row in ranked[:SHOWN]
        ],
        "cpu": cpu,
        "runs_a_cpu_minute": 60.0 * len(every) / cpu if cpu > 0.0 else None,
    }  # fmt: skip


def cluster_name(row: Row) -> str:
    """What happened in a failure: the gate, and with whom."""
    return f"{row.gate}, {row.object}" if row.object else row.gate


def summary_text(found: dict[str, Any]) -> str:
    """The summary for a terminal."""
    counts = ", ".join(f"{count} {verdict}" for verdict, count in found["verdicts"].items()) or "nothing driven"
    lines = [f"{found['runs']} runs: {counts}"]
    if found["excluded"]:
        lines.append(f"  {found['excluded']} more were not driven: their values are outside the scenario's constraints")
    if found["vacuous"]:
        lines.append(f"  {found['vacuous']} of them vacuous: an event never fired, so they show nothing")
    lines += [f"  {count} failed by {name}" for name, count in found["failures"].items()]
    if found["worst"]:
        lines.append("  nearest to a failure, or beyond it (objective < 0):")
    for each in found["worst"]:
        values = ", ".join(f"{name}={value}" for name, value in each["parameters"].items())
        lines.append(f"    {each['objective']:8.3f}  {each['verdict']:<5} {each['gate']}  {values}")
    for scenario, plain in found.get("probability", {}).items():
        lines.append(f"  {scenario}: {Probability(**plain).text()}")
    for scenario, plain in found.get("coverage", {}).items():
        told = Coverage(**{**plain, "gaps": tuple(Gap(**gap) for gap in plain["gaps"])})
        lines += [f"  {scenario}: {sentence}" for sentence in told.sentences()]
    if found.get("probability"):
        lines.append("  (under the declared distributions; the error of the twin itself is not in it)")
    if found["runs_a_cpu_minute"] is not None:
        lines.append(f"  {found['cpu']:.0f} s of CPU time, {found['runs_a_cpu_minute']:.0f} runs a CPU minute")
    if found["shrinking"]:
        lines.append(f"  {found['shrinking']} more runs shrank the failures")
    if found["older"]:
        lines.append(f"  and {found['older']} runs of other settings, files or code, which are not counted here")
    return "\n".join(lines)
