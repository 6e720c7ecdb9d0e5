"""Drives many variants of a scenario, finds where the stack fails, and says how likely that is.

`dvp campaign SCENARIO --out DIR` samples or searches the declared ranges or distributions. Every drive is a row of
DIR/campaign.sqlite; after a kill, the same command goes on, and nothing is driven twice. `dvp campaign DIR` with
--status or --export reads a campaign.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.campaigns.campaign import KEEP
from pytest_dvp.campaigns.export import KINDS
from pytest_dvp.campaigns.plan import BOUNDARY, HYPOTHESIS, METHODS, RARE, RUNS
from pytest_dvp.campaigns.regression_set import CASES
from pytest_dvp.campaigns.sampling import SAMPLES
from pytest_dvp.campaigns.store import StoreError, is_campaign
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, settings_from
from pytest_dvp.cli.shared.named_scenarios import named_scenarios
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.worker_options import check_workers
from pytest_dvp.drive.option_sources import possible_folder
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown
from pytest_dvp.tuning.searchers import search_names

if TYPE_CHECKING:
    from pytest_dvp.campaigns.campaign import Crew
    from pytest_dvp.campaigns.store import Row, Store

PLACE = 105  # in `dvp --help`
READS_NO_LOG = True
READS_SCENARIOS = True

OPTIONS = (
    "seed", "ads", "model", "effects", "gates", "library", "reading", "ego", "set", "duration", "wall-limit",
    "tick-limit", "stack-process", "compute-delay", "after-collision",
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare scenarios, search method, number of drives, shards and what is exported."""
    parser.add_argument(
        "scenarios", nargs="+", metavar="X.xosc",
        help="scenario with constraint groups, or parameter distribution; or the folder of one campaign, to read it",
    )  # fmt: skip
    parser.add_argument("--out", metavar="DIR", help="folder of the campaign; an existing one is continued")
    parser.add_argument(
        "--method", metavar="NAME", default="sobol",
        help=f"how points are chosen: evenly ({', '.join(SAMPLES)}), or by a search for failures "
        f"({', '.join((*search_names(), HYPOTHESIS))}), or where passing ends ({BOUNDARY}), or {RARE}, which measures "
        "a small probability of failure; "
        "default: sobol",
    )  # fmt: skip
    parser.add_argument("--runs", type=int, metavar="N", default=RUNS, help=f"number of drives; default: {RUNS}")
    parser.add_argument("--jobs", type=int, metavar="N", help="number of processes; default: one for each core")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS",
        help="address of a `dask scheduler`, as tcp://host:8786, whose workers drive (extra cluster)",
    )  # fmt: skip
    parser.add_argument(
        "--keep-logs", metavar="WHICH", default=KEEP[0],
        help=f"logs that are kept: {', '.join(KEEP)}; default: those of failures and of the 5 nearest passes",
    )  # fmt: skip
    parser.add_argument("--status", action="store_true", help="print what a campaign found so far; drive nothing")
    parser.add_argument("--export", metavar="KIND", help=f"write the runs of a campaign: {', '.join(sorted(KINDS))}")
    parser.add_argument(
        "--cases", type=int, metavar="N", default=CASES,
        help=f"of --export regression: number of drives that stand for the campaign; default: {CASES}",
    )  # fmt: skip
    parser.add_argument(
        "--baseline", metavar="DIR",
        help="campaign of an earlier state: its variants are driven in place of new ones, and what fails now is told",
    )  # fmt: skip
    parser.add_argument(
        "--shard", metavar="I/N",
        help="drive only part I of N of an even sample, for CI jobs side by side; --merge puts them together",
    )  # fmt: skip
    parser.add_argument(
        "--merge", action="store_true", help="put the campaigns that are named together in --out; drive nothing"
    )
    parser.add_argument("--no-ini", action="store_true", help="ignore the dvp_ keys of the project's ini file")
    add_settings(parser, OPTIONS)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Drive, merge or read a campaign. Returns 1 if a driven variant failed, else 0.

    With a baseline, it returns 1 only if a variant fails that passed before.

    Raises SettingError for an unknown method, kind of export or kind of kept log.
    """
    if arguments.export is not None and arguments.export not in KINDS:
        raise SettingError(f"--export: {unknown('value', arguments.export, tuple(sorted(KINDS)))}")
    if arguments.cases < 1:
        raise SettingError(f"--cases is {arguments.cases}, expected a whole number >= 1")
    if arguments.method not in METHODS:
        raise SettingError(f"--method: {unknown('value', arguments.method, METHODS)}")
    if arguments.merge:
        return _merge(arguments)
    if arguments.status or arguments.export or (len(arguments.scenarios) == 1 and _names_campaign(arguments)):
        return _read(arguments)
    return _drive(arguments)


def _names_campaign(arguments: argparse.Namespace) -> bool:
    return arguments.out is None and is_campaign(Path(arguments.scenarios[0]))


def _read(arguments: argparse.Namespace) -> int:
    """Print or export what a campaign holds."""
    from pytest_dvp.campaigns.export import export
    from pytest_dvp.campaigns.store import Store
    from pytest_dvp.campaigns.summary import current_rows

    folder = Path(arguments.scenarios[0])
    if len(arguments.scenarios) > 1 or arguments.out is not None:
        raise WrongArgument("dvp campaign: --status and --export take the folder of one campaign and nothing else")
    try:
        with Store(folder) as store:
            if arguments.export:
                for file in export(current_rows(store), arguments.export, folder, arguments.cases):
                    print(file)
            elif arguments.baseline:
                return _compare(store, arguments)
            else:
                _say(store, arguments.json)
    except StoreError as error:
        raise WrongArgument(str(error)) from None
    return 0


def _drive(arguments: argparse.Namespace) -> int:
    from pytest_dvp.campaigns.drive_plan import check_first, drive_plan
    from pytest_dvp.campaigns.parameter_space import space_of
    from pytest_dvp.campaigns.plan import Plan, shard_of
    from pytest_dvp.campaigns.store import EXCLUDED, Store

    if arguments.out is None:
        raise WrongArgument("dvp campaign: --out DIR is missing: where the campaign is kept")
    check_workers(arguments)
    plan = Plan(arguments.method, arguments.runs, arguments.keep_logs, shard_of(arguments.shard)).checked()
    if arguments.shard is not None and arguments.baseline is not None:
        raise SettingError(f"--shard {arguments.shard}: the drives of a baseline have no parts")
    settings = settings_from(arguments, ini=OPTIONS)
    jobs = arguments.jobs or os.cpu_count() or 1
    if settings.stack_process is None and (jobs > 1 or arguments.scheduler is not None):
        # Each worker is a process of its own already: a stack that ends it ends its own drive and no other.
        settings = dataclasses.replace(settings, stack_process="off")
    spaces = [space_of(path, settings) for path in named_scenarios(arguments.scenarios)]
    check_first(spaces, settings)
    before = _baseline_rows(arguments)
    out = possible_folder(Path(arguments.out), "--out")
    try:
        store = Store(out, writes=True)
    except StoreError as error:
        raise WrongArgument(f"--out: {error}") from None
    with store, progress("dvp campaign", "driving") as tick, _crew(arguments.scheduler, jobs, tick) as crew:
        campaigns = drive_plan(
            spaces, settings, store, plan, crew, before=before, tick=tick,
            say=lambda text: print(f"dvp campaign: {text}", file=sys.stderr),
        )  # fmt: skip
        rows = [row for campaign in campaigns for row in store.rows([campaign.base])]
        if rows and all(row.verdict == EXCLUDED for row in rows):
            raise SettingError(
                f"nothing was driven: all {len(rows)} cases are outside the scenario's constraints; "
                f"the first: {rows[0].message}"
            )
        if before:
            return _compare(store, arguments)
        _say(store, arguments.json)
    if any(row.failed for row in rows):
        return 1
    if rows and not any(row.verdict == "PASS" for row in rows):  # a part of a small campaign may have no drive at all
        print("dvp campaign: not one drive decided anything", file=sys.stderr)
        return 1
    return 0


def _crew(scheduler: str | None, jobs: int, tick: Callable[[str], None]) -> AbstractContextManager[Crew]:
    """Who drives: processes of this machine, or the workers of a scheduler."""
    if scheduler is None:
        from pytest_dvp.campaigns.crew import LocalCrew
        from pytest_dvp.campaigns.one_drive import drive

        return LocalCrew(jobs, drive)
    from pytest_dvp.campaigns.cluster_crew import ClusterCrew

    tick(f"connecting to {scheduler}")
    return ClusterCrew(scheduler)


def _merge(arguments: argparse.Namespace) -> int:
    """Copy the rows of several campaigns, and the logs that they keep, into --out."""
    from pytest_dvp.campaigns.merge import merge
    from pytest_dvp.campaigns.store import Store

    if arguments.out is None:
        raise WrongArgument("dvp campaign --merge: --out DIR is missing: where they are put together")
    out = possible_folder(Path(arguments.out), "--out")
    try:
        with Store(out, writes=True) as store:
            merge([Path(text) for text in arguments.scenarios], store)
            _say(store, arguments.json)
            hint = f"the command of the parts without --shard, with --out {out}, drives nothing again and tells"
            print(f"dvp campaign: {hint} probability, coverage and map of the whole", file=sys.stderr)
    except StoreError as error:
        raise WrongArgument(str(error)) from None
    return 0


def _baseline_rows(arguments: argparse.Namespace) -> list[Row]:
    """The drives of the baseline that judge the stack; [] without one."""
    from pytest_dvp.campaigns.store import SHRINKING, Store
    from pytest_dvp.campaigns.summary import current_rows

    if arguments.baseline is None:
        return []
    if arguments.out is not None and Path(arguments.out).resolve() == Path(arguments.baseline).resolve():
        raise WrongArgument(f"--baseline {arguments.baseline} is --out: name another folder for the new drives")
    try:
        with Store(Path(arguments.baseline)) as store:
            found = [row for row in current_rows(store) if row.purpose != SHRINKING]
    except StoreError as error:
        raise WrongArgument(f"--baseline: {error}") from None
    if not found:
        raise WrongArgument(f"--baseline {arguments.baseline}: holds no drive to compare with")
    return found


def _compare(store: Store, arguments: argparse.Namespace) -> int:
    """Hold the campaign against the baseline; 1 if something that passed fails now, or nothing could be compared."""
    from pytest_dvp.campaigns.baseline import compared
    from pytest_dvp.campaigns.summary import current_rows

    found = compared(_baseline_rows(arguments), current_rows(store))
    if arguments.json:
        print(json.dumps(finite(found.as_dict()), ensure_ascii=False, allow_nan=False))
    else:
        print(found.text())
    if not found.pairs:
        print("dvp campaign: no drive of the baseline was driven again: nothing was compared", file=sys.stderr)
    return 1 if found.worse or not found.pairs else 0


def _say(store: Store, as_json: bool) -> None:
    from pytest_dvp.campaigns.summary import current_rows, summary, summary_text, told_of_each

    rows = current_rows(store)
    found: dict[str, Any] = summary(rows, len(store.rows()) - len(rows))
    found["probability"] = told_of_each(store, "probability")
    found["coverage"] = told_of_each(store, "coverage")
    if as_json:
        print(json.dumps(finite(found), ensure_ascii=False, allow_nan=False))
    else:
        print(summary_text(found))
