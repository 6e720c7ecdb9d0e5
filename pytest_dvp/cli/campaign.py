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
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.campaigns.campaign import KEEP
from pytest_dvp.campaigns.export import KINDS
from pytest_dvp.campaigns.sampling import SAMPLES
from pytest_dvp.campaigns.store import StoreError, is_campaign
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, settings_from
from pytest_dvp.cli.shared.named_scenarios import named_scenarios
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.drive.option_sources import possible_folder
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown
from pytest_dvp.tuning.searchers import search_names

if TYPE_CHECKING:
    from pytest_dvp.campaigns.campaign import Campaign
    from pytest_dvp.campaigns.parameter_space import Space
    from pytest_dvp.campaigns.store import Row, Store
    from pytest_dvp.drive.run_spec import RunSpec

PLACE = 105  # in `dvp --help`
READS_NO_LOG = True
READS_SCENARIOS = True

RUNS = 200
"""Drives where no number is asked for: less than a minute on two cores with the reference stack."""
RARE = "rare"
METHODS = (*SAMPLES, *search_names(), RARE)
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
        f"({', '.join(search_names())}), or {RARE}, which measures a small probability of failure; default: sobol",
    )  # fmt: skip
    parser.add_argument("--runs", type=int, metavar="N", default=RUNS, help=f"number of drives; default: {RUNS}")
    parser.add_argument("--jobs", type=int, metavar="N", help="number of processes; default: one for each core")
    parser.add_argument(
        "--keep-logs", metavar="WHICH", default=KEEP[0],
        help=f"logs that are kept: {', '.join(KEEP)}; default: those of failures and of the 5 nearest passes",
    )  # fmt: skip
    parser.add_argument("--status", action="store_true", help="print what a campaign found so far; drive nothing")
    parser.add_argument("--export", metavar="KIND", help=f"write the runs of a campaign: {', '.join(sorted(KINDS))}")
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
    for option, value, known in (
        ("method", arguments.method, METHODS),
        ("keep-logs", arguments.keep_logs, KEEP),
        ("export", arguments.export, tuple(sorted(KINDS))),
    ):
        if value is not None and value not in known:
            raise SettingError(f"--{option}: {unknown('value', value, known)}")
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
                print(export(current_rows(store), arguments.export, folder))
            elif arguments.baseline:
                return _compare(store, arguments)
            else:
                _say(store, arguments.json)
    except StoreError as error:
        raise WrongArgument(str(error)) from None
    return 0


def _drive(arguments: argparse.Namespace) -> int:
    from pytest_dvp.campaigns.campaign import Campaign
    from pytest_dvp.campaigns.crew import Crew
    from pytest_dvp.campaigns.one_drive import drive
    from pytest_dvp.campaigns.parameter_space import space_of
    from pytest_dvp.campaigns.store import Store
    from pytest_dvp.campaigns.summary import CURRENT

    if arguments.out is None:
        raise WrongArgument("dvp campaign: --out DIR is missing: where the campaign is kept")
    for option in ("runs", "jobs"):
        value = getattr(arguments, option)
        if value is not None and value < 1:
            raise SettingError(f"--{option} is {value}, expected a whole number >= 1")
    _shard(arguments.shard)
    if arguments.shard is not None and (arguments.method not in SAMPLES or arguments.baseline is not None):
        raise SettingError(f"--shard {arguments.shard}: only an even sample has parts: {', '.join(SAMPLES)}")
    settings = settings_from(arguments, ini=OPTIONS)
    jobs = arguments.jobs or os.cpu_count() or 1
    if settings.stack_process is None and jobs > 1:
        # Each worker is a process of its own already: a stack that ends it ends its own drive and no other.
        settings = dataclasses.replace(settings, stack_process="off")
    named = named_scenarios(arguments.scenarios)
    spaces = [space_of(path, settings) for path in named]
    _check_first(spaces, settings)
    before = _baseline_rows(arguments)
    out = possible_folder(Path(arguments.out), "--out")
    try:
        store = Store(out, writes=True)
    except StoreError as error:
        raise WrongArgument(f"--out: {error}") from None
    with store, progress("dvp campaign", "driving") as tick, Crew(jobs, drive) as crew:
        campaigns = [Campaign(space, settings, store, crew, keep=arguments.keep_logs, tick=tick) for space in spaces]
        store.tell(CURRENT, [each.base for each in campaigns])
        for campaign in campaigns:
            if before:
                _again(campaign, before)
            else:
                _fill(campaign, arguments, settings.seed)
            print(f"dvp campaign: {campaign.space.file}: {campaign.progress.text()}", file=sys.stderr)
        _map(campaigns, Path(arguments.out))
        rows = [row for campaign in campaigns for row in store.rows([campaign.base])]
        if before:
            return _compare(store, arguments)
        _say(store, arguments.json)
    return 1 if any(row.failed for row in rows) else 0


def _shard(text: str | None) -> tuple[int, int]:
    """Which part of how many: (1, 1) without the option."""
    if text is None:
        return 1, 1
    words = text.split("/")
    if len(words) != 2 or not all(word.isascii() and word.isdigit() for word in words):
        raise SettingError(f"--shard: found {text!r}, expected I/N, as 2/4")
    part, parts = int(words[0]), int(words[1])
    if not 1 <= part <= parts:
        raise SettingError(f"--shard: found {text!r}, expected a part between 1 and {parts}")
    return part, parts


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
    except StoreError as error:
        raise WrongArgument(str(error)) from None
    return 0


def _check_first(spaces: list[Space], settings: RunSpec) -> None:
    """What is wrong with the scenario at its nominal values, with the gates or with the stack: told before a drive."""
    from openscenario.read import read_scenario
    from pytest_dvp.drive.chosen_stack import Ads
    from pytest_dvp.drive.parameter_checks import check_overrides
    from pytest_dvp.drive.stack_host import find_ads

    ads: Ads = find_ads(
        settings.ads, [settings.rootdir], process=settings.stack_process, tick_limit=settings.tick_limit
    )
    for space in spaces:
        read_scenario(space.scenario, library=settings.library, rootdir=settings.rootdir, parameters=space.nominal)
        check_overrides(space.scenario, settings.set, settings.origin("set"), ads=ads)


def _fill(campaign: Campaign, arguments: argparse.Namespace, seed: int) -> None:
    from pytest_dvp.campaigns.critical_search import search
    from pytest_dvp.campaigns.measured_probability import counted_probability, measured_probability
    from pytest_dvp.campaigns.sampling import sample

    campaign.progress.wanted = arguments.runs
    if arguments.method == RARE:
        found = measured_probability(campaign, arguments.runs, seed)
        campaign.store.tell(f"probability {campaign.base}", found.as_dict())
        return
    if arguments.method not in SAMPLES:
        search(campaign, arguments.method, arguments.runs, seed)
        return
    part, parts = _shard(arguments.shard)
    points = sample(arguments.method, campaign.space.axes, arguments.runs, seed)
    points = points[part - 1 :: parts]
    if not points:
        return  # more parts than drives
    campaign.progress.wanted = len(points)
    rows = campaign.rows(points, "sample")
    if arguments.method == "random":
        campaign.store.tell(f"probability {campaign.base}", counted_probability(rows).as_dict())


def _map(campaigns: Sequence[Campaign], folder: Path) -> None:
    """Shrink one failure of each kind, and write the map."""
    from pytest_dvp.campaigns.map_page import PAGE, map_page
    from pytest_dvp.campaigns.reproducer import reproducers
    from pytest_dvp.campaigns.summary import SHRINKING
    from reports.campaign import write_campaign_page

    pages = []
    for campaign in campaigns:
        rows = [row for row in campaign.store.rows([campaign.base]) if row.purpose != SHRINKING]
        found = reproducers(campaign, rows)
        for each in found:
            print(f"dvp campaign: {each.sentence()}\n  replay: {each.command}", file=sys.stderr)
        pages.append(map_page(campaign, rows, found, campaign.store.told(f"probability {campaign.base}")))
    write_campaign_page(folder / PAGE, pages)
    print(f"dvp campaign: map: {folder / PAGE}", file=sys.stderr)


def _baseline_rows(arguments: argparse.Namespace) -> list[Row]:
    """The drives of the baseline that judge the stack; [] without one."""
    from pytest_dvp.campaigns.store import Store
    from pytest_dvp.campaigns.summary import SHRINKING, current_rows

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


def _again(campaign: Campaign, before: Sequence[Row]) -> None:
    """Drive the variants of the baseline that are of this scenario."""
    names = {name for axis in campaign.space.axes for name in axis.nominal}
    here = [row for row in before if Path(row.scenario).name == campaign.space.scenario.name]
    values = [row.parameters for row in here if row.parameters.keys() == names]
    if not values:
        raise WrongArgument(f"--baseline: no drive of {campaign.space.scenario.name} with these parameters in it")
    campaign.progress.wanted = len(values)
    campaign.rows_of(values, "sample")


def _compare(store: Store, arguments: argparse.Namespace) -> int:
    """Hold the campaign against the baseline; 1 if something that passed fails now."""
    from pytest_dvp.campaigns.baseline import compared
    from pytest_dvp.campaigns.summary import current_rows

    found = compared(_baseline_rows(arguments), current_rows(store))
    if arguments.json:
        print(json.dumps(finite(found.as_dict()), ensure_ascii=False, allow_nan=False))
    else:
        print(found.text())
    return 1 if found.worse else 0


def _say(store: Store, as_json: bool) -> None:
    from pytest_dvp.campaigns.summary import current_rows, probabilities, summary, summary_text

    rows = current_rows(store)
    found: dict[str, Any] = summary(rows, len(store.rows()) - len(rows))
    found["probability"] = probabilities(store)
    if as_json:
        print(json.dumps(finite(found), ensure_ascii=False, allow_nan=False))
    else:
        print(summary_text(found))
