"""Compares logs of a scenario on several stages: prints a table, and judges the gates between stages.

Logs of several scenarios are compared scenario by scenario. The first log of a stage counts. The exit code is 0
without gates; with gates it is 0 only if all of them pass.
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, new_file, settings_from
from pytest_dvp.drive.option import STAGES
from pytest_dvp.text.plain_json import finite

if TYPE_CHECKING:
    from pytest_dvp.drive.stage_comparison import StageComparison, StageDrive
    from pytest_dvp.verdicts.judging import Gate

PLACE = 40  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare logs, gate file and report."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="log.mcap or run folder of one stage")
    parser.add_argument(
        "--before", metavar="LOG", help="log of the previous iteration, with which the first stage is compared"
    )
    parser.add_argument("--out", metavar="FILE", help="write a page with a table and figures")
    add_settings(parser, ("gates",))
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the table of stages. Returns 1 if a gate between stages does not pass, else 0.

    Raises WrongArgument for logs of several scenarios with an option that fits only one.
    """
    from pytest_dvp.cli.run import across_text
    from pytest_dvp.drive.stage_comparison import StageDrive, read_between
    from pytest_dvp.logs.log import Log

    settings = settings_from(arguments)
    logs = [Path(text) for text in (*arguments.logs, *([] if arguments.before is None else [arguments.before]))]
    read = [*logs, *(log / "log.mcap" for log in logs), *([] if settings.gates is None else [settings.gates])]
    out = None if arguments.out is None else new_file("--out", arguments.out, read)
    gates = () if settings.gates is None else read_between(settings.gates)
    groups = _by_scenario(arguments.logs)
    if len(groups) > 1 and (out is not None or arguments.before is not None):
        option = "--out" if out is not None else "--before"
        names = ", ".join(groups)
        raise WrongArgument(f"{option}: of one scenario at a time; these logs are of {names}")
    before = None if arguments.before is None else StageDrive(Log.load(arguments.before), Path(arguments.before))
    options = _options(settings.gates, arguments.before)
    compared = [_held(drives, gates, before, options) for drives in groups.values()]
    if out is not None:
        from reports.stages import write_stages_report

        (drives,) = groups.values()
        there = [drive for drive in drives.values() if drive.label in compared[0].logs]
        write_stages_report(out, compared[0].as_dict(), {drive.label: drive.log.columns for drive in there})
        print(f"dvp stages: page in {out}", file=sys.stderr)
    if arguments.json:
        documents = [finite(held.as_dict()) for held in compared]
        print(json.dumps(documents if len(documents) > 1 else documents[0], ensure_ascii=False))
    else:
        print("\n\n".join(across_text(held) for held in compared))
    return 0 if not gates or all(held.status == "PASS" for held in compared) else 1


def _by_scenario(names: Sequence[str]) -> dict[str, dict[str, StageDrive]]:
    """The drives by scenario and stage. Those of which there are no two stages of one scenario are one group: that
    they are not compared is for the verdicts to say."""
    from pytest_dvp.drive.stage_comparison import StageDrive
    from pytest_dvp.logs.log import Log

    groups: dict[str, dict[str, StageDrive]] = {}
    for text in names:
        if not Path(text).exists():
            raise WrongArgument(f"{text}: no such log")
        log = Log.load(text)
        stage = str(log.meta.get("stage", "")).split("-")[0]
        drives = groups.setdefault(str(log.meta.get("scenario", "")), {})
        if stage in drives:
            _say_left_out(text, f"{drives[stage].place} is of stage {stage} as well")
        drives.setdefault(stage, StageDrive(log, Path(text)))
    whole = {scenario: drives for scenario, drives in groups.items() if len(drives) > 1}
    if whole:
        for scenario, drives in groups.items():
            for drive in drives.values() if scenario not in whole else ():
                _say_left_out(str(drive.place), f"no other stage of {scenario or 'its scenario'} is among the logs")
        return whole
    together: dict[str, StageDrive] = {}
    for drives in groups.values():
        for stage, drive in drives.items():
            if stage in together:
                _say_left_out(str(drive.place), f"{together[stage].place} is of stage {stage} as well")
            together.setdefault(stage, drive)
    return {next(iter(groups)): together}


def _say_left_out(log: str, why: str) -> None:
    print(f"dvp stages: {log} left out: {why}", file=sys.stderr)


def _held(
    drives: Mapping[str, StageDrive], gates: Sequence[Gate], before: StageDrive | None, options: Sequence[str]
) -> StageComparison:
    from pytest_dvp.drive.stage_comparison import compare_stages, left_out, pairs_driven

    first = next(iter(drives.values())).log.meta
    about = {
        "scenario": str(first.get("scenario", "")),
        "line": 1,
        "seed": int(first.get("seed") or 0),
        "ads": str(first.get("ads", "")),
        "replay": shlex.join(["dvp", "stages", *(str(drive.place) for drive in drives.values()), *options]),
    }
    pairs = pairs_driven(gates, list(drives))
    missing = {stage: f"none of the logs is of stage {stage}" for stage in STAGES if stage not in drives}
    notes = left_out(gates, pairs, list(drives))
    return compare_stages(drives, gates, pairs, about, missing=missing, notes=notes, before=before)


def _options(gates: Path | None, before: str | None) -> list[str]:
    """What a reader must add to see the same comparison again."""
    from pytest_dvp.text.paths import shown

    return [
        *(() if gates is None else ("--gates", str(shown(gates)))),
        *(() if before is None else ("--before", str(before))),
    ]
