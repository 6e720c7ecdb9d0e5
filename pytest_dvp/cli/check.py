"""All findings of scenario, road, gate, model and log files; runs nothing."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from pytest_dvp.cli.arguments import WrongArgument, add_json, add_settings, settings_from
from pytest_dvp.settings import Settings

Findings = Iterable[dict[str, Any]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", metavar="PATH", help=".xosc, .xodr, .gates.toml, .toml, .mcap, or a folder")
    add_settings(parser, ("library",))
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    settings = settings_from(arguments)
    paths = [path for text in arguments.paths for path in _files(text)]
    found: list[dict[str, Any]] = []
    for path in paths:
        found.extend(_checker(path)(path, settings))
    if arguments.json:
        print(json.dumps({"findings": found}, ensure_ascii=False))
    else:
        for finding in found:
            place = finding["file"] if finding["line"] is None else f"{finding['file']}:{finding['line']}"
            print(f"{place}: {finding['severity']} {finding['code']} {finding['element']}: {finding['message']}")
        errors = sum(finding["severity"] == "error" for finding in found)
        print(f"{len(paths)} files, {errors} errors, {len(found) - errors} warnings", file=sys.stderr)
    return 1 if any(finding["severity"] == "error" for finding in found) else 0


def _files(text: str) -> list[Path]:
    path = Path(text)
    if path.is_dir():
        return sorted(file for file in path.rglob("*") if file.is_file() and _kind(file) in CHECKERS)
    if not path.exists():
        raise WrongArgument(f"{text}: no such file")
    return [path]


def _kind(path: Path) -> str:
    return ".gates.toml" if path.name.endswith(".gates.toml") else path.suffix.lower()


def _checker(path: Path) -> Callable[[Path, Settings], Findings]:
    # Whatever is none of the known kinds was named by a user as a scenario: its reader says what is wrong with it.
    return CHECKERS.get(_kind(path), _scenario)


def _scenario(path: Path, settings: Settings) -> Findings:
    from openscenario.read import check_scenario

    return [finding.as_dict() for finding in check_scenario(path, library=settings.library, rootdir=settings.rootdir)]


def _road(path: Path, settings: Settings) -> Findings:
    # Not load_network: what it compiles is for driving, and a check shall start at once.
    from openscenario.road.opendrive import examine_opendrive

    return [finding.as_dict() for finding in examine_opendrive(path)[1]]


def _gates(path: Path, settings: Settings) -> Findings:
    from pytest_dvp.gates import check_gates

    return [finding.as_dict() for finding in check_gates(path)]


def _model(path: Path, settings: Settings) -> Findings:
    from vehicle.model.model_file import ModelError, read_model

    return _one(path, "model.invalid", ModelError, lambda: read_model(path))


def _log(path: Path, settings: Settings) -> Findings:
    from pytest_dvp.log import Log, LogError

    return _one(path, "log.invalid", LogError, lambda: Log.load(path))


def _one(path: Path, code: str, kind: type[Exception], read: Callable[[], object]) -> Findings:
    """The single finding of a reader that stops at the first defect."""
    try:
        read()
    except kind as error:
        return [
            {
                "code": getattr(error, "code", code),
                "severity": "error",
                "file": str(path),
                "line": getattr(error, "line", None),
                "element": str(getattr(error, "element", "") or getattr(error, "key", "") or ""),
                "message": str(error),
            }
        ]
    return []


CHECKERS: dict[str, Callable[[Path, Settings], Findings]] = {
    ".xosc": _scenario,
    ".xodr": _road,
    ".gates.toml": _gates,
    ".toml": _model,
    ".mcap": _log,
}
