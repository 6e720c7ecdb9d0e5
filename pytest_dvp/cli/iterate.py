"""Closes reality gap and performance gap: drives on dt, pe and rw, finds what the twin lacks, tunes S and P; repeats.

A ledger keeps every iteration: parameters, effects, metrics, what changed and why. Held-out drives judge each change.
The iteration ends when nothing improves on them.
"""

from __future__ import annotations

import argparse
import json
import sys

from pytest_dvp.cli.shared.arguments import add_json, existing, new_file
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.worker_options import add_workers, check_workers, workers
from pytest_dvp.cli.tune import folder_of
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.paths import shown
from pytest_dvp.text.plain_json import finite

PLACE = 120  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the plan, the vehicle, the number of iterations, output folder, report and workers."""
    parser.add_argument(
        "plan", metavar="PLAN.toml", help="plan file: twin, scenarios to fit to, held-out scenarios, candidates"
    )
    parser.add_argument("--vehicle", metavar="NAME", help="car of pe and rw: surrogate or surrogate:HIDDEN.toml")
    parser.add_argument("--iterations", type=int, metavar="N", help="maximum number of iterations")
    parser.add_argument(
        "--tune-only", action="store_true", help="tune parameters only; do not search for missing effects"
    )
    add_workers(parser)
    parser.add_argument("--out", metavar="DIR", help="folder of the ledger; default: ROOTDIR/runs/tuning/PLAN")
    parser.add_argument("--report", metavar="FILE", help="file of the page; default: report.html in the folder")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Drive, extend the twin and tune, as the plan says, and write ledger and report. Returns 0.

    Raises SettingError for fewer than one iteration, and for a vehicle that cannot drive or may not drive unattended.
    """
    path = existing(arguments.plan, "plan")
    check_workers(arguments)
    if arguments.iterations is not None and arguments.iterations < 1:
        raise SettingError(f"--iterations is {arguments.iterations}, expected a whole number >= 1")
    report = None if arguments.report is None else new_file("--report", arguments.report, [path])
    from pytest_dvp.drive.stage_checks import check_stage
    from pytest_dvp.drive.stages import StageError
    from pytest_dvp.tuning.iterate import iterate
    from pytest_dvp.tuning.iteration_plan_file import read_plan
    from pytest_dvp.tuning.iteration_text import command_of, document, text
    from pytest_dvp.tuning.toml_reader import refuse_real_car
    from reports.whole_file import write_whole

    plan = read_plan(
        path,
        vehicle=arguments.vehicle,
        iterations=arguments.iterations,
        structure=False if arguments.tune_only else None,
    )
    try:
        refuse_real_car(plan.vehicle)
        check_stage("rw", plan.vehicle)
    except StageError as error:
        raise SettingError(f"--vehicle: {error}") from None
    out = folder_of(arguments.out, plan.name)
    with progress("dvp iterate", "iterating") as tick, workers(arguments, tick) as worked:
        found = iterate(plan, worked, out, tick)
    told = finite(document(found))
    write_whole(out / "result.json", json.dumps(told, ensure_ascii=False, indent=1).encode() + b"\n")
    report = out / "report.html" if report is None else report
    from pytest_dvp.tuning.iteration_page import iterate_page
    from reports.mcrpg import write_mcrpg_report

    write_mcrpg_report(report, iterate_page(told))
    print(f"dvp iterate: {worked.done} simulated, {worked.known} kept from before; {report}", file=sys.stderr)
    print(f"dvp iterate: the twin is {shown(found.state.model)}", file=sys.stderr)
    print(f"dvp iterate: next: {command_of(found)}", file=sys.stderr)
    if arguments.json:
        print(json.dumps(told, ensure_ascii=False, allow_nan=False))
    else:
        print(text(found))
    return 0
