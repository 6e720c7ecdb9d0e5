"""The outcome of an iteration: for the terminal, and as a document."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pytest_dvp.tuning.bounds import Bound, bounds
from pytest_dvp.tuning.iterate import Iterated


def document(found: Iterated) -> dict[str, Any]:
    """The document of `dvp iterate --json`."""
    return {
        "plan": found.plan.name,
        "vehicle": _vehicle(found.plan.vehicle),
        "structure": found.plan.structure,
        "ads": None if found.plan.ads is None else Path(found.plan.ads).name,
        "ended": found.ended,
        "model": found.state.model.name,
        "P": {stage: dict(values) for stage, values in found.state.P.items()},
        "ledger": [entry.as_dict() for entry in found.entries],
        "held_out": {"first": found.first.as_dict(), "last": found.last.as_dict()},
        "repeatability": {name: figure.as_dict() for name, figure in found.repeatability.items()},
        "bounds": [bound.as_dict() for bound in bounds(found.first, found.last)],
    }


def text(found: Iterated) -> str:
    """What happened, iteration by iteration, and the table of bounds."""
    lines = []
    for entry in found.entries:
        accepted = entry.accepted or "nothing"
        lines.append(f"iteration {entry.number}: {accepted}")
        lines += [f"  {change}" for change in entry.changes]
    lines += [f"ended: {found.ended}", "", *table(bounds(found.first, found.last))]
    return "\n".join(lines)


def table(rows: list[Bound]) -> list[str]:
    """The bounds for a terminal."""
    head = f"{'':<4}{'':<34}{'stages':<8}{'first':>10}{'last':>10}{'+-':>10}{'worst':>10}  bound"
    lines = [head]
    for row in rows:
        mark = "ok" if row.holds else "none" if row.value is None else "MISS"
        numbers = "".join(f"{_number(v):>10}" for v in (row.first, row.value, row.half_width, row.worst))
        lines.append(f"{mark:<5}{row.what:<33}{row.where:<8}{numbers}  {row.bound}")
    held, unknown = sum(row.holds for row in rows), sum(row.value is None for row in rows)
    more = f"; none: {unknown} could not be measured" if unknown else ""
    return [*lines, f"{held} of {len(rows)} rows hold{more}"]


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.5f}" if 0.9 < abs(value) < 1.0 else f"{value:.4g}"


def _vehicle(text: str) -> str:
    """`surrogate nominal`: no folder of this machine."""
    kind, colon, hidden = text.partition(":")
    return f"{kind} {Path(hidden).stem}" if colon else kind
