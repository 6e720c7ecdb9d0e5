"""The outcome of an iteration: for the terminal, and as a document."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.tuning.result_bounds import Bound, bounds

if TYPE_CHECKING:
    from pytest_dvp.tuning.iterate import Iterated


def document(found: Iterated) -> dict[str, Any]:
    """The document of `dvp iterate --json`."""
    return {
        "plan": found.plan.name,
        "vehicle": _vehicle(found.plan.vehicle),
        "structure": found.plan.structure,
        "ads": None if found.plan.ads is None else Path(found.plan.ads).name,
        "preset": found.plan.preset,
        "ended": found.ended,
        "model": f"{found.state.model.parent.name}/{found.state.model.name}",
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
    entries = [entry.as_dict() for entry in found.entries]
    lines += [f"ended: {found.ended}", "", *table(bounds(found.first, found.last)), ""]
    return "\n".join([*lines, headline(entries, structure=found.plan.structure)])


def headline(ledger: Sequence[Mapping[str, Any]], *, structure: bool) -> str:
    """What the twin lacked, and how far it is from the car now; `ledger`: entries as in the document."""
    taken = [word for e in ledger if "twin" in e["accepted"] for word in e["structure"].get("taken", ())]
    before, after = (entry["held_out"]["chi2_per_n"] for entry in (ledger[0], ledger[-1]))
    what = f"Twin extended: {'; '.join(taken)}." if taken else "No effect was added to the twin."
    error = f"chi^2/N of held-out drives {_number(before)} -> {_number(after)}"
    if after is not None and after <= 1.0:
        return f"{what} It is the car to within the noise of its sensors ({error})."
    more = "" if structure else "; nothing was looked for that it lacks (--tune-only)"
    return f"{what} {error}, where 1 would be the noise of the sensors{more}."


def command_of(found: Iterated) -> str:
    """The command that drives the first held-out variant on the twin with the stack, as both are at the end; not behind
    the guard, which no command line puts before a twin."""
    from pytest_dvp.tuning.iteration_plan import drives
    from pytest_dvp.tuning.repeat_commands import command

    (drive, *_) = drives(found.plan, found.state, found.plan.held_out[:1], found.plan.last_seeds[:1], Path(), ("dt",))
    return command(dataclasses.replace(drive.job, gated=False))


def table(rows: list[Bound]) -> list[str]:
    """The bounds for a terminal; what was measured nowhere is one line at the end."""
    head = f"{'':<41}{'stages':<8}{'first':>10} {'last':>10} {'+-':>10} {'worst':>10}  bound"
    lines = [
        "on held-out drives, before the first iteration and after the last; +-: half the 95 % interval",
        head,
    ]
    unknown: dict[str, list[str]] = {}
    for row in rows:
        if row.value is None:
            unknown.setdefault(row.what, []).append(row.where)
            continue
        mark = "ok" if row.holds else "open" if row.undecided else "MISS"
        numbers = " ".join(f"{_number(v):>10}" for v in (row.first, row.value, row.half_width, row.worst))
        lines.append(f"{mark:<5}{row.what:<36}{row.where:<8}{numbers}  {row.bound}")
    if unknown:
        told = "; ".join(f"{what} ({', '.join(where)})" for what, where in unknown.items())
        lines.append(f"none could be measured of: {told}")
    return [*lines, count([row.as_dict() for row in rows])]


def count(rows: Sequence[Mapping[str, Any]]) -> str:
    """`53 of 61 bounds hold; open: 6 need more repeats (last_seeds); none: 1 could not be measured`."""
    held, unknown = sum(row["holds"] for row in rows), sum(row["value"] is None for row in rows)
    text = f"{held} of {len(rows)} bounds hold"
    if undecided := sum(row["undecided"] for row in rows):
        text += f"; open: {undecided} need more repeats (last_seeds)"
    return text + (f"; none: {unknown} could not be measured" if unknown else "")


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.5f}" if 0.9 < abs(value) < 1.0 else f"{value:.4g}"


def _vehicle(text: str) -> str:
    """`surrogate nominal`: no folder of this machine."""
    kind, colon, hidden = text.partition(":")
    return f"{kind} {Path(hidden).stem}" if colon else kind
