"""Writes proposed gates to the gate file beside a scenario; what stands there stays as it is."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Sequence
from pathlib import Path

from openscenario.read import read_declarations
from pytest_dvp.mutation.mutate import Proposal
from pytest_dvp.verdicts.judging import default_gates, read_gates
from reports.whole_file import write_whole


def write_gates(proposals: Sequence[Proposal]) -> list[Path]:
    """Append the proposals, the tightest of each scenario, metric and side; the files written, in order.

    A habit is written as a bound of clean drives, which were driven with the scenario's own parameters."""
    files: dict[Path, list[str]] = {}
    for (scenario, metric, habit), bounds in _tightest(proposals).items():
        file = Path(scenario).with_suffix(".gates.toml")
        lines = files.setdefault(file, [])
        rate = sum(p.false_alarm_rate for p in bounds)  # each side may be broken by itself
        why = f"# proposed by dvp mutate; false alarms: {rate:.2g} a run at most"
        lines += ["", f"[[gate]]                                    {why}", f'metric = "{metric}"', 'stages = ["dt"]']
        lines += [f"clean = {_parameters(Path(scenario))}"] if habit else []
        lines += [f"min = {p.min:.6g}" for p in bounds if p.min is not None]
        lines += [f"max = {p.max:.6g}" for p in bounds if p.max is not None]
    for file, lines in files.items():
        old = file.read_text("utf-8") if file.exists() else f"# Bounds of {_scenario(file)}.\n"
        if not file.exists() or not any(g.between is None and g.only_with is None for g in read_gates(file).gates):
            lines[:0] = _defaults()
        write_whole(file, (old.rstrip("\n") + "\n" + "\n".join(lines) + "\n").encode())
    return list(files)


def _parameters(scenario: Path) -> str:
    """The parameters of a scenario that are numbers, with the values that it declares, as a table of TOML."""
    values = {}
    for one in read_declarations(scenario):
        with contextlib.suppress(ValueError):
            values[one.name] = float(one.value)
    told = [f"{json.dumps(name)} = {value:.9g}" for name, value in values.items() if math.isfinite(value)]
    return f"{{ {', '.join(told)} }}" if told else "{}"


def _scenario(file: Path) -> str:
    return f"{file.name.removesuffix('.gates.toml')}.xosc"


def _defaults() -> list[str]:
    """Lines of the gates that hold where a file has none of its own, for those that are added take their place."""
    lines = []
    for gate in default_gates().gates:
        lines += ["", "[[gate]]", f'metric = "{gate.metric}"']
        lines += [f"{side} = {bound:g}" for side, bound in (("min", gate.min), ("max", gate.max)) if bound is not None]
    return lines


def _tightest(proposals: Sequence[Proposal]) -> dict[tuple[str, str, bool], list[Proposal]]:
    """By scenario, metric and whether it is a habit the least max and the greatest min."""
    found: dict[tuple[str, str, bool], dict[str, Proposal]] = {}
    for p in proposals:
        sides = found.setdefault((p.scenario, p.metric, p.habit), {})
        if p.max is not None and ("max" not in sides or p.max < (sides["max"].max or 0.0)):
            sides["max"] = p
        if p.min is not None and ("min" not in sides or p.min > (sides["min"].min or 0.0)):
            sides["min"] = p
    return {key: list(sides.values()) for key, sides in found.items()}
