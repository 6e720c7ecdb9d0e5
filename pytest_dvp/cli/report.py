"""Writes the report.html of a log again, and its result.json if it has one; judges it again with --gates.

Without --gates, the verdicts are those that its run gave. A log without a result.json has none: it is judged by the
default gates, and the answer says so. A run that broke off, a dry run and one with faults on the wire pass by no gates.
Among runs that share the library that draws, the report shares it, too. Elsewhere, with another name (`--out`) or with
`--single-file`, it is one file that needs no other.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, existing, new_file, settings_from
from pytest_dvp.text.paths import shown

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log

PLACE = 60  # in `dvp --help`
BY_DEFAULT = "judged by the default gates: there was no result.json beside the log, and no --gates FILE"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the log or run folder, the gates and the report."""
    parser.add_argument("log", metavar="LOG", help="log.mcap, or a run folder that contains one")
    parser.add_argument("--out", metavar="FILE", help="file of the report; default: report.html next to the log")
    parser.add_argument(
        "--gates",
        metavar="FILE",
        help="gate file; default: the verdicts of the run in result.json, without that file the default gates",
    )
    add_settings(parser, ("single-file",))
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Judge a log again and write its report. Returns 0 if the verdict is PASS, else 1.

    Raises WrongArgument if there is no such log.
    """
    settings = settings_from(arguments)
    named = Path(arguments.log)
    path = named / "log.mcap" if named.is_dir() else existing(str(named), "log")
    stored = path.with_name("result.json")
    out = path.with_name("report.html")
    if arguments.out is not None:
        read = [path, stored, *([] if settings.gates is None else [settings.gates])]
        out = new_file("--out", arguments.out, read)
    from pytest_dvp.drive.run_folder import report_library, write_report, write_result
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.log_error import LogError

    try:
        log = Log.load(path)
    except LogError as error:
        if path.is_file():
            raise
        raise WrongArgument(str(error)) from None
    result = _result(log, stored, settings.gates)
    beside = out.absolute().parent == path.absolute().parent
    if beside and (named.is_dir() or stored.is_file()):
        write_result(stored, result)
    with report_library(out.parent, single_file=settings.single_file or arguments.out is not None) as library:
        write_report(out, log, result, library=library)
    if arguments.json:
        print(json.dumps({"report": str(out), "status": result["status"], "verdicts": result["verdicts"]}))
    else:
        by = f", {BY_DEFAULT}" if BY_DEFAULT in result.get("notes", ()) else ""
        print(f"dvp report: {result['status']}{by}", file=sys.stderr)
        print(out)
    return 0 if result["status"] == "PASS" else 1


def _result(log: Log, stored: Path, gates: Path | None) -> dict[str, Any]:
    """The verdicts of the run as they were given, or new ones by `gates`; metrics with their courses from the log."""
    from pytest_dvp.drive.run_folder import measure, result_of
    from pytest_dvp.drive.run_verdicts import broke_off, spoilt
    from pytest_dvp.verdicts.harmless_side import NOTE, harmless_notes
    from pytest_dvp.verdicts.judging import default_gates, judge, never_fired, read_gates, unjudged

    kept = _kept(stored) if stored.is_file() else {}
    log = dataclasses.replace(log, tick_time=kept.get("tick_time") or None)
    bounds = read_gates(gates) if gates is not None else default_gates()
    verdicts = [*spoilt(log), *judge(bounds, log)]  # a dry run or one over a faulty wire passes by no gates
    if not kept:
        verdicts = [*broke_off(log), *verdicts]
    result = {**kept, **result_of(log, verdicts, measure(log))}
    if gates is None and kept:
        result.update({key: kept[key] for key in ("status", "scenario", "verdicts")})
        return result
    doubts = [note for note in kept.get("notes", ()) if not note.startswith(("not judged:", NOTE, BY_DEFAULT))]
    result["never_fired"] = list(never_fired(bounds, log))
    by_default = [BY_DEFAULT] if gates is None else []
    result["notes"] = [*by_default, *unjudged(verdicts, log), *harmless_notes(bounds.gates), *doubts]
    broken = [verdict for verdict in kept.get("verdicts", ()) if kept.get("error") and not verdict["metric"]]
    if broken:  # a run that broke off stays one, whatever its gates say
        result["verdicts"], result["status"] = [*broken[:1], *result["verdicts"]], "ERROR"
    if str(kept.get("replay", "")).startswith("dvp run ") and gates is not None:
        result["replay"] = _with_gates(kept["replay"], shown(gates))
    result["scenario"] = kept.get("scenario", result["scenario"])
    return result


def _kept(stored: Path) -> dict[str, Any]:
    from pytest_dvp.drive.result_file import ResultFileError, read_result

    try:
        return read_result(stored)
    except ResultFileError as error:
        raise WrongArgument(f"{error}; judge the log without it: delete it and name --gates FILE") from None


def _with_gates(replay: str, gates: str) -> str:
    try:
        words = shlex.split(replay)
    except ValueError:  # edited by hand
        return replay
    if "--gates" in words:
        at = words.index("--gates")
        del words[at : at + 2]
    return shlex.join([*words, "--gates", gates])
