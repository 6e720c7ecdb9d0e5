"""What `dvp mutate` says on the terminal."""

from __future__ import annotations

from pathlib import Path

from pytest_dvp.mutation.mutate import Judged, Mutation


def mutation_lines(found: Mutation) -> list[str]:
    """The kill matrix, the escapers from the worst on with the gates that would catch them, and faults that no scenario
    excites."""
    changed = [one for one in found.judged if one.changed]
    killed = [one for one in changed if one.killed_by]
    habits = sum(one.by_habit for one in killed)
    alone = f", {habits} of them by bounds of clean drives alone" if habits else ""
    lines = [
        f"{len(killed)} of {len(changed)} faults that change a drive are noticed by a gate{alone}; "
        f"{len(found.judged) - len(changed)} of {len(found.judged)} change nothing "
        f"({len(found.scenarios)} scenarios, {found.clean} clean seeds each)",
        "",
        *_matrix(found),
    ]
    escaped = sorted((one for one in changed if one.escaped), key=lambda one: -one.far)
    if escaped:
        lines += ["", "escaped, the farthest from normal first:"]
        lines += [f"  {one.fault.name}: {_escape(one)}" for one in escaped]
    idle = [one for one in found.judged if not one.changed]
    if idle:
        lines += ["", "no scenario excites:"]
        whys = [found.why_idle(one.fault) for one in idle]
        lines += [f"  {one.fault.name}" + (f" ({why})" if why else "") for one, why in zip(idle, whys, strict=True)]
    if found.unsound:
        lines += ["", "gates that do not pass without any fault, and so notice nothing:"]
        lines += [f"  {gate}: {count} of {found.clean} clean drives" for gate, count in found.unsound.items()]
    return lines


def _matrix(found: Mutation) -> list[str]:
    """One line a fault, one column a scenario: x a gate fails, . the drive is another one, blank nothing changes."""
    names = [Path(scenario).stem for scenario in found.scenarios]
    width = max(len(one.fault.name) for one in found.judged)
    head = [f"{'':{width}}  {chr(ord('A') + k % 26)} = {name}" for k, name in enumerate(names)]
    letters = " ".join(chr(ord("A") + k % 26) for k in range(len(names)))
    rows = [f"{'fault':{width}}  {letters}  noticed by"]
    for one in found.judged:
        by = {text.partition(": ")[0] for text in one.killed_by}
        marks = " ".join("x" if name in by else " " for name in names)
        gates = sorted({text.partition(": ")[2] for text in one.killed_by})
        told = "; ".join(gates[:2]) + (f" and {len(gates) - 2} more" if len(gates) > 2 else "")
        rows.append(f"{one.fault.name:{width}}  {marks}  {told or ('ESCAPED' if one.escaped else '-')}")
    return [*head, *rows]


def _escape(one: Judged) -> str:
    if one.proposed is None:
        return "changes which metrics are defined; no bound can be proposed"
    p = one.proposed
    bound = f"max = {p.max:.4g}" if p.max is not None else f"min = {p.min:.4g}"
    rate = f"{p.false_alarm_rate:.2g}"
    kind = "; a habit of the clean drives, no requirement" if p.habit else ""
    return f"{Path(p.scenario).stem} would need {p.metric} {bound} (false alarms: {rate} a run at most{kind})"
