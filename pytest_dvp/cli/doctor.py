"""Finds what is wrong with a log, and which effects it could reveal."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.effects import add_effects, effects_from
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing
from pytest_dvp.cli.shared.command_columns import assumed, missing

if TYPE_CHECKING:
    from openscenario.findings import Finding
    from pytest_dvp.doctor import Excitation
    from pytest_dvp.logs.log import Log
    from vehicle.model.effect import Effect

PLACE = 130  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare logs, how they are mapped, the model and own effects."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="log, or a part of it as LOG@START:STOP (seconds)")
    add_log_options(parser)
    parser.add_argument("--model", metavar="FILE", help="vehicle model, whose inputs decide which effects could show")
    add_effects(parser)
    add_json(parser)


def add_log_options(parser: argparse.ArgumentParser) -> None:
    """How a foreign log is to be read: shared by the commands that take one."""
    parser.add_argument("--map", metavar="FILE", help="mapping of fields to signals (TOML; `dvp map LOG` proposes one)")
    parser.add_argument("--msg", action="append", default=[], metavar="DIR", help="folder of .msg files (ROS types)")


def log_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Keyword arguments of read_log. Raises WrongArgument for a file or folder that is not there."""
    mapping = Path(arguments.map) if arguments.map else None
    if mapping is not None and not mapping.is_file():
        raise WrongArgument(f"--map {mapping}: no such file")
    return {"mapping": mapping, "msg_dirs": message_folders(arguments)}


def read_files(arguments: argparse.Namespace, logs: Iterable[str]) -> list[Path]:
    """Every file that a command reads logs with, and those of a folder: what its output must not write over."""
    from pytest_dvp.logs.log_part import parse_argument

    paths = [parse_argument(text).path for text in logs]
    within = [file for path in paths if path.is_dir() for file in path.iterdir()]
    options = [*([arguments.map] if arguments.map else []), *arguments.effects]
    return [*paths, *within, *map(Path, options)]


def message_folders(arguments: argparse.Namespace) -> list[Path]:
    """Folders of --msg. Raises WrongArgument for one that is not there."""
    folders = [Path(text) for text in arguments.msg]
    for folder in folders:
        if not folder.is_dir():
            raise WrongArgument(f"--msg {folder}: no such folder")
    return folders


def existing_log(text: str, *, parts: bool = True) -> str:
    """A log argument whose file is there and of a kind that is read; parts: it may be LOG@START:STOP.

    Raises WrongArgument.
    """
    from pytest_dvp.logs.log_error import LogError
    from pytest_dvp.logs.log_part import parse_argument
    from pytest_dvp.logs.read_log import kind_of

    if not text.strip():
        raise WrongArgument("no name, expected a log")
    try:
        kind_of(parse_argument(text).path if parts else Path(text))
    except LogError as error:
        raise WrongArgument(str(error)) from None
    return text


def execute(arguments: argparse.Namespace) -> int:
    """Print what is wrong with each log. Returns 1 if a finding is an error, else 0."""
    options = log_options(arguments)
    names = [existing_log(text) for text in arguments.logs]
    effects = effects_from(arguments) if arguments.effects else {}
    model = _model(arguments.model, effects)
    told = [_told(name, options, model, effects) for name in names]
    if arguments.json:
        print(json.dumps({"logs": [entry for entry, _, _ in told]}, ensure_ascii=False))
    else:
        for entry, findings, shown in told:
            _print(entry, findings, shown)
    return 1 if any(f.severity == "error" for _, findings, _ in told for f in findings) else 0


def _model(text: str | None, effects: Mapping[str, Effect]) -> Any:
    if text is None:
        return None
    existing(text, "model")
    from vehicle.model.model_file import read_model

    model = read_model(Path(text), extra=effects)
    if said := assumed(model, Path(text).name):
        print(f"dvp doctor: {said}", file=sys.stderr)
    return model


def _told(
    name: str, options: dict[str, Any], model: Any, effects: Mapping[str, Effect]
) -> tuple[dict[str, Any], tuple[Finding, ...], Excitation | None]:
    from openscenario.findings import Finding
    from pytest_dvp.doctor import examine, excitation
    from pytest_dvp.logs.log_error import LogError
    from pytest_dvp.logs.read_log import read_log

    try:
        log = read_log(name, strict=False, **options)
    except LogError as error:
        findings = error.findings or (Finding(error.code, "error", name, None, "", text=str(error)),)
        return {"log": name, "findings": [f.as_dict() for f in findings]}, tuple(findings), None
    findings = examine(log, file=name)
    shown = excitation(log, model, effects)
    imported = dict(log.meta.get("import", {}))
    unknown = imported.get("unknown", [])  # a column that is kept beside the signals was not recognised as one
    imported["recognised"] = [name for name in imported.get("recognised", []) if name not in unknown]
    drives = [column for column in (model.inputs.columns if model is not None else ()) if column in log.columns]
    imported["unknown"] = [column for column in unknown if column not in drives]
    entry = {
        "log": name,
        "rows": len(log.t),
        "duration": log.duration,
        "columns": list(log.columns),
        "rates": _rates(log),
        **{key: imported.get(key, []) for key in ("converted", "aliased", "unknown", "recognised", "unmapped")},
        "inputs": drives,
        "missing_inputs": missing(model, log) if model is not None else [],
        "findings": [finding.as_dict() for finding in findings],
        "excitation": shown.as_dict(),
    }
    return entry, findings, shown


def _rates(log: Log) -> dict[str, float]:
    """Samples a second [Hz] of the columns that are slower than the rows."""
    import numpy as np

    counts = {name: int(np.count_nonzero(np.isfinite(values))) for name, values in log.columns.items()}
    slower = {name: count for name, count in counts.items() if 1 < count < 0.8 * len(log.t)}
    return {name: round((count - 1) / log.duration, 3) for name, count in slower.items()} if log.duration else {}


_SAID = (
    ("converted", "converted"), ("aliased", "renamed"), ("recognised", "recognised by name and unit"),
    ("unknown", "kept, not known"), ("unmapped", "not mapped, left out"),
)  # fmt: skip


def _print(entry: dict[str, Any], findings: tuple[Finding, ...], shown: Excitation | None) -> None:
    from openscenario.findings import listed

    if shown is not None:
        rate = (entry["rows"] - 1) / entry["duration"] if entry["duration"] else 0.0
        print(f"{entry['log']}: {entry['rows']} rows, {entry['duration']:.2f} s, {rate:.4g} Hz")
        if entry["rates"]:
            print("  mixed rates: " + ", ".join(f"{name} {hz:.4g} Hz" for name, hz in entry["rates"].items()))
        if entry["missing_inputs"]:
            print(f"  cannot drive the model: has no {' and no '.join(entry['missing_inputs'])}")
        if entry["inputs"] and not entry["missing_inputs"]:
            print(f"  drives the model: {', '.join(entry['inputs'])}")
        for key, what in _SAID:
            if entry[key]:
                print(f"  {what}: {listed(entry[key], 20)}")
    else:
        print(f"{entry['log']}: cannot be read")
    for finding in findings:
        place = f"line {finding.line}" if finding.line is not None else ""
        what = " ".join(filter(None, (finding.severity, finding.code, place, finding.element)))
        print(f"  {what}: {finding.message}")
    if not findings:
        print("  nothing wrong found")
    if shown is not None:
        print("  driven: " + ", ".join(f"{f.name} {f.value:.3g} {f.unit}".removesuffix(" -") for f in shown.facts))
        print("  could show: " + (", ".join(shown.within_reach) or "no effect"))
        for title, group in (("could show only if large", shown.hardly), ("could not show", shown.out_of_reach)):
            reasons: dict[str, list[str]] = {}
            for effect, reason in group.items():
                reasons.setdefault(reason, []).append(effect)
            if reasons:
                print(f"  {title}:")
            for reason, effects in reasons.items():
                print(f"    {', '.join(effects)}: {reason}")
    errors = sum(finding.severity == "error" for finding in findings)
    print(f"{entry['log']}: {errors} errors, {len(findings) - errors} warnings", file=sys.stderr)
