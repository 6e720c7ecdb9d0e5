"""Which scenario files of a folder run, and why the others do not: the last lines of `dvp check FOLDER`."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.cli.shared.checkable_files import kind_of
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.paths import shown

FEW = 20
"""Files up to which nothing is compiled for a check: a file takes some 0.06 s instead of 0.02 s then, and nobody waits
for a compiler, which takes a minute after an installation. Measured on 381 scenarios; both give the same answers."""

LOOKED_AT = 50  # cases of a distribution among which one is sought that its constraints allow; 0.2 s. Half of those of
# R157's cut-in are excluded


def runnable(paths: Iterable[Path], found: Sequence[Mapping[str, Any]], settings: RunSpec) -> list[dict[str, Any]]:
    """A row for each scenario and distribution: file, runs, why ("" if it runs), line of what is wrong (None where
    that is in another file, which `why` then names), found (whether a finding says so already). No catalogues.

    Other than the findings this begins the run itself, so an element that only the storyboard refuses shows, and a road
    or a goal that nobody can drive to. That loads what drives on the road, in a process of its own.
    """
    from pytest_dvp.verdicts.scenario_gates import gates_of

    files = [path for path in paths if kind_of(path) == "scenario" and not is_catalogue(path)]
    wrong: dict[str, list[Mapping[str, Any]]] = {str(path): [] for path in files}
    errors_of: dict[Path, list[Mapping[str, Any]]] = {}
    for each in found:
        if each["severity"] == "error":
            errors_of.setdefault(Path(each["file"]).resolve(), []).append(each)
    for path in files:
        wrong[str(path)] += errors_of.get(path.resolve(), ())
        gates = gates_of(path, library=settings.library, rootdir=settings.rootdir)
        if gates is not None:  # a run reads it as well
            wrong[str(path)] += errors_of.get(gates.resolve(), ())
    refused = _ask([file for file, errors in wrong.items() if not errors], settings)
    rows = []
    for file, errors in wrong.items():
        first = errors[0] if errors else None
        why, line = refused[file][:2] if first is None else _why(file, first["file"], first["line"], first["message"])
        more = f" (and {len(errors) - 1} more errors)" if len(errors) > 1 else ""
        rows.append({"file": file, "runs": not why, "why": why + more, "line": line, "found": first is not None})
    return rows


def _ask(files: Sequence[str], settings: RunSpec) -> dict[str, tuple[str, int | None]]:
    """Why each file is refused, and where; "" and None if it runs."""
    if not files:
        return {}
    question = _question(files, settings)
    from vehicle.child_process import own_module, own_path

    words, there = own_module("pytest_dvp.cli.shared.runnable_scenarios"), {**os.environ, **own_path()}
    if len(files) <= FEW:
        there["NUMBA_DISABLE_JIT"] = "1"
    child = subprocess.run(words, input=json.dumps(question), capture_output=True, text=True, check=False, env=there)
    if child.returncode:
        last = (child.stderr.strip().splitlines() or [f"exit code {child.returncode}"])[-1]
        return dict.fromkeys(files, (f"it cannot be told: {last}", None))
    return {file: (why, line) for file, (why, line) in json.loads(child.stdout).items()}


def _question(files: Sequence[str], settings: RunSpec) -> dict[str, Any]:
    """What the child of `_ask` is told."""
    return {
        "files": files,
        "library": [str(folder) for folder in settings.library],
        "rootdir": str(settings.rootdir),
        "ego": settings.ego,
        "roads": settings.roads,
    }


def said(row: Mapping[str, Any]) -> str:
    """`a.xosc: runs`, or `a.xosc:12: refused: the scenario names no road network`."""
    place = row["file"] if row["line"] is None else f"{row['file']}:{row['line']}"
    return f"{place}: runs" if row["runs"] else f"{place}: refused: {row['why']}"


def is_catalogue(path: Path) -> bool:
    """Whether a file is a catalogue; False for one that cannot be read: its reader says why."""
    from openscenario.findings import ScenarioError
    from openscenario.xml import read_xml

    try:
        return read_xml(path).root.find("Catalog") is not None
    except ScenarioError:
        return False


def _refusal(path: Path, settings: RunSpec) -> tuple[str, int | None]:
    """Why `dvp run` would refuse a file that has no error finding, and the line; empty if it would not."""
    from openscenario.findings import ScenarioError
    from openscenario.read import read_cases, read_scenario
    from pytest_dvp.campaigns.cases import excluded_by, is_distribution
    from pytest_dvp.drive.ego_task import find_ego
    from pytest_dvp.drive.preparation import begin, network_of
    from pytest_dvp.verdicts.judging import GateError, default_gates, read_gates
    from pytest_dvp.verdicts.scenario_gates import gates_of

    values: Mapping[str, str] = {}
    driven = path
    try:
        if is_distribution(path):
            cases = read_cases(path, library=settings.library, rootdir=settings.rootdir)
            driven = cases.scenario or path
            some = (cases[k] for k in cases.sample(min(LOOKED_AT, cases.count), settings.seed))
            values = next((each for each in some if not excluded_by(driven, each)), cases[0])
        scenario = read_scenario(driven, library=settings.library, rootdir=settings.rootdir, parameters=values)
        network = network_of(scenario, settings.roads)
        ego = find_ego(scenario, settings.ego).name
        beside = gates_of(path, library=settings.library, rootdir=settings.rootdir)
        begin(scenario, network, default_gates() if beside is None else read_gates(beside), ego, settings)
    except (ScenarioError, GateError) as error:
        first = error.findings[0]
        return _why(str(path), first.file, first.line, first.message)
    return "", None


def _why(file: str, place: str, line: int | None, message: str) -> tuple[str, int | None]:
    """The reason and the line of `file`; a line of another file stands with that file, in the reason."""
    if Path(place).resolve() == Path(file).resolve():
        return message, line
    where = shown(Path(place))
    return f"{where if line is None else f'{where}:{line}'}: {message}", None


def _answers(question: Mapping[str, Any]) -> dict[str, tuple[str, int | None]]:
    """Why each file of a question is refused, and where."""
    settings = dataclasses.replace(
        RunSpec(),
        library=tuple(Path(folder) for folder in question["library"]),
        rootdir=Path(question["rootdir"]),
        ego=question["ego"],
        roads=question["roads"],
    )
    return {file: _refusal(Path(file), settings) for file in question["files"]}


if __name__ == "__main__":  # the child of `_ask`
    json.dump(_answers(json.load(sys.stdin)), sys.stdout)
