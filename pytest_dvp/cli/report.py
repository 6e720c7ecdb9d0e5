"""Judge a log again and write its report.html beside it."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.arguments import WrongArgument, add_json, add_settings, existing, settings_from

if TYPE_CHECKING:
    from pytest_dvp.log import Log


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("log", metavar="LOG", help="log.mcap, or a run folder that holds one")
    parser.add_argument("--out", metavar="FILE", help="where to write; default report.html beside the log")
    add_settings(parser, ("gates",))
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    settings = settings_from(arguments)
    named = Path(arguments.log)
    path = existing(str(named / "log.mcap" if named.is_dir() else named), "log")
    out = Path(arguments.out) if arguments.out else path.with_name("report.html")
    if not out.parent.is_dir():
        raise WrongArgument(f"--out {out}: no folder {out.parent}")
    from pytest_dvp.log import Log
    from pytest_dvp.results import write_report

    log = Log.load(path)
    result = _result(log, path.with_name("result.json"), settings.gates)
    write_report(out, log, result)
    if arguments.json:
        print(json.dumps({"report": str(out), "status": result["status"], "verdicts": result["verdicts"]}))
    else:
        print(f"dvp report: {result['status']}", file=sys.stderr)
        print(out)
    return 0 if result["status"] == "PASS" else 1


def _result(log: Log, stored: Path, gates: Path | None) -> dict[str, Any]:
    """The verdicts of the run as they were given, or new ones by `gates`; metrics with their courses from the log."""
    from pytest_dvp.gates import default_gates, judge, read_gates
    from pytest_dvp.results import measure, result_of

    chosen = read_gates(gates) if gates is not None else default_gates()
    result = result_of(log, judge(chosen, log), measure(log))
    if gates is None and stored.is_file():
        try:
            kept = json.loads(stored.read_text(encoding="utf-8"))
            result.update({key: kept[key] for key in ("status", "verdicts")})
        except (ValueError, KeyError, TypeError):
            raise WrongArgument(f"{stored}: no result of a run; judge again with --gates FILE") from None
    return result
