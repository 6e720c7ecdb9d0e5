"""Logs of one scenario on several stages: the table that holds them side by side, and the gates between them.

The first log of a stage counts. Without gates the exit code is 0, with gates 0 only if all of them pass.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from pytest_dvp.cli.arguments import WrongArgument, add_json, add_settings, settings_from
from pytest_dvp.plain_json import finite
from pytest_dvp.settings import STAGES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("logs", nargs="+", metavar="LOG", help="log.mcap or run folder of one stage each")
    parser.add_argument("--before", metavar="LOG", help="what the first stage is compared with: the iteration before")
    parser.add_argument("--out", metavar="FILE", help="write a page with table and figures")
    add_settings(parser, ("gates",))
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    from pytest_dvp.across import Driven, hold, left_out, pairs_driven, read_between
    from pytest_dvp.cli.run import across_text
    from pytest_dvp.log import Log
    from pytest_dvp.stage_table import stage_table

    settings = settings_from(arguments)
    out = None if arguments.out is None else Path(arguments.out)
    if out is not None and not out.absolute().parent.is_dir():
        raise WrongArgument(f"--out {out}: no folder {out.parent}")
    gates = () if settings.gates is None else read_between(settings.gates)
    drives: dict[str, Driven] = {}
    for text in arguments.logs:
        if not Path(text).exists():
            raise WrongArgument(f"{text}: no such log")
        log = Log.load(text)
        stage = str(log.meta.get("stage", "")).split("-")[0]
        if stage in drives:
            print(f"dvp stages: {text} left out: {drives[stage].place} is of stage {stage} as well", file=sys.stderr)
        drives.setdefault(stage, Driven(log, Path(text)))
    first = next(iter(drives.values())).log.meta
    before = None if arguments.before is None else Log.load(arguments.before)
    about = {
        "scenario": str(first.get("scenario", "")),
        "line": 1,
        "seed": int(first.get("seed") or 0),
        "ads": str(first.get("ads", "")),
        "replay": " ".join(["dvp stages", *arguments.logs, *_options(settings.gates, arguments.before)]),
    }
    pairs = pairs_driven(gates, list(drives))
    missing = {stage: f"none of the logs is of stage {stage}" for stage in STAGES if stage not in drives}
    held = hold(drives, gates, pairs, about, missing=missing, notes=left_out(gates, pairs, list(drives)))
    if before is not None:
        import dataclasses

        logs = {drive.label: drive.log for drive in drives.values()}
        table = stage_table(logs, (f"{before.meta.get('stage', '')} before", before))
        held = dataclasses.replace(held, table=table)
    if out is not None:
        from reports.stages import write_stages_report

        write_stages_report(out, held.as_dict(), {drive.label: drive.log.columns for drive in drives.values()})
        print(f"dvp stages: page in {out}", file=sys.stderr)
    if arguments.json:
        print(json.dumps(finite(held.as_dict()), ensure_ascii=False))
    else:
        print(across_text(held))
    return 0 if held.status == "PASS" or not gates else 1


def _options(gates: Path | None, before: str | None) -> list[str]:
    """What a reader must add to see the same comparison again."""
    from pytest_dvp.paths import shown

    return [
        *(() if gates is None else ("--gates", str(shown(gates)))),
        *(() if before is None else ("--before", str(before))),
    ]
