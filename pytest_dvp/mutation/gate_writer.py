"""Writes proposed gates to the gate file beside a scenario; what stands there stays as it is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pytest_dvp.mutation.mutate import Proposal
from pytest_dvp.verdicts.judging import default_gates, read_gates
from reports.whole_file import write_whole


def write_gates(proposals: Sequence[Proposal]) -> list[Path]:
    """Append the proposals, the tightest of each scenario, metric and side; the files written, in order."""
    files: dict[Path, list[str]] = {}
    for (scenario, metric), bounds in _tightest(proposals).items():
        file = Path(scenario).with_suffix(".gates.toml")
        lines = files.setdefault(file, [])
        rate = sum(p.false_alarm_rate for p in bounds)  # each side may be broken by itself
        why = f"# proposed by dvp mutate; false alarms: {rate:.2g} a run at most"
        lines += ["", f"[[gate]]                                    {why}", f'metric = "{metric}"', 'stages = ["dt"]']
        lines += [f"min = {p.min:.6g}" for p in bounds if p.min is not None]
        lines += [f"max = {p.max:.6g}" for p in bounds if p.max is not None]
    for file, lines in files.items():
        old = file.read_text("utf-8") if file.exists() else f"# Bounds of {_scenario(file)}.\n"
        if not file.exists() or not any(g.between is None and g.only_with is None for g in read_gates(file).gates):
            lines[:0] = _defaults()
        write_whole(file, (old.rstrip("\n") + "\n" + "\n".join(lines) + "\n").encode())
    return list(files)


def _scenario(file: Path) -> str:
    return f"{file.name.removesuffix('.gates.toml')}.xosc"


def _defaults() -> list[str]:
    """Lines of the gates that hold where a file has none of its own, for those that are added take their place."""
    lines = []
    for gate in default_gates().gates:
        lines += ["", "[[gate]]", f'metric = "{gate.metric}"']
        lines += [f"{side} = {bound:g}" for side, bound in (("min", gate.min), ("max", gate.max)) if bound is not None]
    return lines


def _tightest(proposals: Sequence[Proposal]) -> dict[tuple[str, str], list[Proposal]]:
    """By scenario and metric the least max and the greatest min."""
    found: dict[tuple[str, str], dict[str, Proposal]] = {}
    for p in proposals:
        sides = found.setdefault((p.scenario, p.metric), {})
        if p.max is not None and ("max" not in sides or p.max < (sides["max"].max or 0.0)):
            sides["max"] = p
        if p.min is not None and ("min" not in sides or p.min > (sides["min"].min or 0.0)):
            sides["min"] = p
    return {key: list(sides.values()) for key, sides in found.items()}
