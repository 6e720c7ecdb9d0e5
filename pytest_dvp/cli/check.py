"""Prints all findings in scenario, road, gate, model, log, study and plan files; runs nothing."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.doctor import add_log_options, log_options
from pytest_dvp.cli.effects import add_effects, effects_from
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, settings_from
from pytest_dvp.cli.shared.checkable_files import Kind, files_of, kind_of
from pytest_dvp.cli.shared.runnable_scenarios import runnable, said
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.near_path import looked_for
from pytest_dvp.text.paths import shown

if TYPE_CHECKING:
    from pytest_dvp.tuning.iteration_plan import Plan
    from pytest_dvp.tuning.study import Study
    from vehicle.model.effect import Effect

PLACE = 10  # in `dvp --help`

Findings = Iterable[dict[str, Any]]
OF_A_CHECK = ("library", "ego", "roads")
REFUSED = "scenario.refused"
_BY = "_by"  # key of the file whose check told a finding


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare files and folders to check, and the options by which a run would read them."""
    parser.add_argument(
        "paths", nargs="+", metavar="PATH", help=".xosc, .xodr, .gates.toml, .toml, .mcap or .csv file, or a folder"
    )
    add_settings(parser, OF_A_CHECK)
    add_log_options(parser)
    add_effects(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print what is wrong with the files, without running any. Returns 1 if a finding is an error, else 0."""
    settings = settings_from(arguments, ini=OF_A_CHECK)  # of which a run takes the same
    options = log_options(arguments)
    paths = _with_gates([path for text in arguments.paths for path in _files(text)], settings)
    effects = effects_from(arguments) if arguments.effects else {}
    found: list[dict[str, Any]] = []
    for path in paths:
        found.extend({**each, _BY: path} for each in _checker(path, effects, options)(path, settings))
    told = {str(each[_BY]) for each in found if each["severity"] == "error"}
    found = _once(found)
    rows = runnable(paths, found, settings)
    # what only the run itself refuses, and no reader of the file
    refused = [row for row in rows if not (row["runs"] or row["found"] or row["file"] in told)]
    found += [_error(REFUSED, row["file"], row["line"], row["why"]) for row in refused]
    notes = [note for path in paths if kind_of(path) == "scenario" for note in _without_effect(path, settings)]
    folders = any(Path(text).is_dir() for text in arguments.paths)
    rows = [{key: value for key, value in row.items() if key != "found"} for row in rows] if folders else []
    if arguments.json:
        print(
            json.dumps(
                {"findings": found, "notes": notes, **({"scenarios": rows} if folders else {})}, ensure_ascii=False
            )
        )
    else:
        for finding in found:
            place = finding["file"] if finding["line"] is None else f"{finding['file']}:{finding['line']}"
            used = f" (used by {', '.join(finding['used_by'])})" if "used_by" in finding else ""
            what = " ".join(filter(None, (finding["severity"], finding["code"], finding["element"])))
            print(f"{place}: {what}: {finding['message']}{used}")
        wrong = {finding["file"] for finding in found if finding["severity"] == "error"}
        for path in paths:
            if kind_of(path) == "scenario" and str(path) not in wrong:
                _say_cases(path, settings)
        for note in notes:
            print(f"{note['file']}:{note['line']}: note: {note['message']}", file=sys.stderr)
        for row in rows:
            print(said(row), file=sys.stderr)
        errors = sum(finding["severity"] == "error" for finding in found)
        print(f"{len(paths)} files, {errors} errors, {len(found) - errors} warnings", file=sys.stderr)
    return 1 if any(finding["severity"] == "error" for finding in found) else 0


def _once(found: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Each finding once: one of a catalogue that scenarios share, with those that use it (`used_by`)."""
    merged: dict[tuple[Any, ...], dict[str, Any]] = {}
    for each in found:
        file, by = Path(each["file"]), each[_BY]
        attribute = each["element"].rpartition("@")[2]  # the path to it depends on who read the file
        key = (file.resolve(), each["line"], each["code"], attribute, each["message"])
        one = merged.setdefault(key, {name: value for name, value in each.items() if name != _BY})
        if file.resolve() != by.resolve():
            one["file"] = shown(file)
            one["used_by"] = list(dict.fromkeys([*one.get("used_by", ()), str(by)]))
    return list(merged.values())


def _say_cases(path: Path, settings: RunSpec) -> None:
    """How many runs a distribution is: what its author wants to know, and no finding."""
    from pytest_dvp.campaigns.cases import is_distribution

    if is_distribution(path):
        from openscenario.read import read_cases

        cases = read_cases(path, library=settings.library, rootdir=settings.rootdir)
        print(f"{path}: {cases.count} cases of {cases.scenario}", file=sys.stderr)


def _without_effect(path: Path, settings: RunSpec) -> Findings:
    """What the scenario asks for and does not get: nothing is wrong with it, so it is no finding."""
    from openscenario.findings import ScenarioError
    from openscenario.no_effect import without_effect
    from openscenario.read import read_scenario

    try:
        scenario = read_scenario(path, library=settings.library, rootdir=settings.rootdir)
    except ScenarioError:
        return []  # it has findings, or is a catalogue or a distribution
    return [note.as_dict() for note in without_effect(scenario)]


def _files(text: str) -> list[Path]:
    path = Path(text)
    if not text.strip():
        raise WrongArgument("no name, expected a file or a folder")
    if path.is_dir():
        found = files_of(path)
        if not found:  # a wrong path must not look like a checked one
            raise WrongArgument(
                f"{text}: nothing to check here: no .xosc, .xodr, .gates.toml, vehicle model, study or log"
            )
        return found
    if not path.exists():
        raise WrongArgument(f"{text}: no such file{looked_for(path)}")
    return [path]


def _with_gates(paths: Sequence[Path], settings: RunSpec) -> list[Path]:
    """The files, each scenario with the gate file beside it: a run reads that too, and refuses what is wrong in it."""
    from pytest_dvp.verdicts.scenario_gates import gates_of

    named = {path.resolve() for path in paths}
    out: list[Path] = []
    for path in paths:
        out.append(path)
        is_scenario = kind_of(path) == "scenario"
        gates = gates_of(path, library=settings.library, rootdir=settings.rootdir) if is_scenario else None
        if gates is not None and gates.resolve() not in named:
            named.add(gates.resolve())
            out.append(Path(shown(gates)))
    return out


def _checker(
    path: Path, effects: Mapping[str, Effect], options: Mapping[str, Any]
) -> Callable[[Path, RunSpec], Findings]:
    kind = kind_of(path) or _named(path)
    if kind == "log":
        return partial(_log, options=options)
    return partial(_model, effects=effects) if kind == "model" else CHECKERS[kind]


def _named(path: Path) -> Kind:
    """What a user means by a file that says nothing of itself but its ending: a model, a log of any format, or else a
    scenario, whose reader says what is wrong with it."""
    from pytest_dvp.logs.formats.log_format import log_formats

    ending = path.suffix.lower()
    if ending == ".toml":
        return "model"
    return "log" if any(ending in each.endings for each in log_formats()) else "scenario"


def _scenario(path: Path, settings: RunSpec) -> Findings:
    from openscenario.read import check_scenario

    findings = check_scenario(path, library=settings.library, rootdir=settings.rootdir, strict=False)
    yield from (finding.as_dict() for finding in findings)
    if not any(finding.severity == "error" for finding in findings):
        yield from _ego(path, settings)


def _ego(path: Path, settings: RunSpec) -> Findings:
    """What a run would need and `dvp play` would not: the one vehicle that the driving stack drives."""
    from openscenario.findings import ScenarioError
    from openscenario.read import read_scenario
    from openscenario.xml import read_xml
    from pytest_dvp.drive.ego_task import find_ego

    root = read_xml(path).root
    entities = root.find("Entities")
    if entities is None:
        return  # a catalogue
    try:
        find_ego(read_scenario(path, library=settings.library, rootdir=settings.rootdir), settings.ego)
    except ScenarioError as error:
        hint = "" if settings.ego else "; dvp run needs it, dvp play does not: call the vehicle under test Ego"
        for finding in error.findings:
            yield finding.as_dict() | {
                "line": entities.line,
                "element": "OpenSCENARIO/Entities",
                "message": finding.message + hint,
            }


def _road(path: Path, settings: RunSpec) -> Findings:
    # Not load_network: what it compiles is for driving, and a check shall start at once.
    from openscenario.road.opendrive import examine_opendrive

    return [finding.as_dict() for finding in examine_opendrive(path, settings.roads)[1]]


def _gates(path: Path, settings: RunSpec) -> Findings:
    from pytest_dvp.verdicts.judging import check_gates
    from pytest_dvp.verdicts.scenario_gates import check_beside

    beside = check_beside(path, library=settings.library, rootdir=settings.rootdir)
    return [finding.as_dict() for finding in (*check_gates(path), *beside)]


def _model(path: Path, settings: RunSpec, effects: Mapping[str, Effect] | None = None) -> Findings:
    from vehicle.model.model_file import ModelError, read_model

    wrong = list(_one(path, "model.invalid", ModelError, lambda: read_model(path, extra=effects)))
    if wrong or not (text := read_model(path, extra=effects).drives_nothing):
        return wrong
    where = {"file": str(path), "line": None, "element": "[inputs]"}
    return [{"code": "model.drives_nothing", "severity": "warning", **where, "message": text}]


def _study(path: Path, settings: RunSpec, plan: bool = False) -> Findings:
    from openscenario.findings import ScenarioError
    from pytest_dvp.tuning.iteration_plan_file import read_plan
    from pytest_dvp.tuning.study_file import read_study
    from pytest_dvp.workers.errors import TuneError

    try:
        found = read_plan(path) if plan else read_study(path)
    except TuneError as error:
        return [_error("plan.invalid" if plan else "study.invalid", str(path), error.line, error.text)]
    except ScenarioError as error:  # of a scenario that it names
        return [finding.as_dict() for finding in error.findings]
    return _of_what_it_names(found, settings)


def _of_what_it_names(found: Study | Plan, settings: RunSpec) -> Findings:
    """What its run would refuse of the scenarios, logs and hidden effects that a study or plan names."""
    from pytest_dvp.drive.stage_checks import check_hidden
    from pytest_dvp.drive.stages import StageError
    from pytest_dvp.tuning.iteration_plan import Plan

    logs: tuple[Path, ...] = ()
    if isinstance(found, Plan):
        variants, on_car = (*found.variants, *found.held_out), True
    else:
        variants, logs, on_car = found.variants, found.logs, found.stage != "dt"
    asked = dataclasses.replace(settings, library=(*settings.library, *found.library))
    for row in runnable(dict.fromkeys(variant.scenario for variant in variants), (), asked):
        if not row["runs"]:
            yield _error(REFUSED, row["file"], row["line"], row["why"])
    for log in logs:
        yield from (finding for finding in _log(log, settings) if finding["severity"] == "error")
    if on_car:
        try:
            check_hidden(found.vehicle)
        except StageError as error:
            yield _error("vehicle.invalid", found.vehicle.partition(":")[2], None, str(error))


def _error(code: str, file: str, line: int | None, message: str) -> dict[str, Any]:
    return {"code": code, "severity": "error", "file": file, "line": line, "element": "", "message": message}


def _log(path: Path, settings: RunSpec, options: Mapping[str, Any] | None = None) -> Findings:
    from pytest_dvp.doctor import examine
    from pytest_dvp.logs.log_error import LogError
    from pytest_dvp.logs.read_log import read_log

    try:
        log = read_log(path, strict=False, **(options or {}))
    except LogError as error:
        if error.findings:
            return [finding.as_dict() for finding in error.findings]
        return _one(path, "log.invalid", LogError, lambda: read_log(path, **(options or {})))
    line = 3 if path.suffix.lower() in (".csv", ".tsv") else None  # of the second row: the first that has an interval
    return [finding.as_dict() for finding in examine(log, file=str(path), line=line)]


def _one(path: Path, code: str, kind: type[Exception], read: Callable[[], object]) -> Findings:
    """The single finding of a reader that stops at the first defect."""
    try:
        read()
    except kind as error:
        line = getattr(error, "line", None)
        element = str(getattr(error, "element", "") or getattr(error, "key", "") or "")
        message = str(error)
        for place in (f"{path}:{line}: ", f"{path}: ", f"{element}: "):  # which the finding says itself
            message = message.removeprefix(place)
        return [
            {
                "code": getattr(error, "code", code),
                "severity": "error",
                "file": str(path),
                "line": line,
                "element": element,
                "message": message,
            }
        ]
    return []


# What a user names himself is taken for this by its ending, whatever is in it.
CHECKERS: dict[Kind, Callable[[Path, RunSpec], Findings]] = {
    "scenario": _scenario,
    "road": _road,
    "gates": _gates,
    "model": _model,
    "study": _study,
    "plan": partial(_study, plan=True),
    "log": _log,
}
