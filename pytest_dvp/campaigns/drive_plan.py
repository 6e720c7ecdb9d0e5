"""Drives a plan over the spaces of its scenarios into one store, and writes the map of what it found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pytest_dvp.campaigns.campaign import Campaign, Crew
from pytest_dvp.campaigns.parameter_space import Space
from pytest_dvp.campaigns.plan import BOUNDARY, HYPOTHESIS, RARE, Plan
from pytest_dvp.campaigns.sampling import SAMPLES, sample
from pytest_dvp.campaigns.store import EXCLUDED, SHRINKING, Row, Store
from pytest_dvp.campaigns.summary import CURRENT
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.paths import told_apart

Tell = Callable[[str], None]


def drive_plan(
    spaces: Sequence[Space], settings: RunSpec, store: Store, plan: Plan, crew: Crew, *,
    before: Sequence[Row] = (), tick: Tell = lambda text: None, say: Tell = lambda text: None,
) -> list[Campaign]:  # fmt: skip
    """Drive what the plan asks for of each space, shrink one failure of each kind, and write map.html beside the store.

    before  drives of a baseline: their variants are driven in place of those of the plan
    tick    is told of progress; say: of what was found, a line each

    Raises SettingError where no drive of the baseline fits a scenario, and what a drive raises about a user's file.
    """
    campaigns = [Campaign(space, settings, store, crew, keep=plan.keep, tick=tick) for space in spaces]
    store.tell(CURRENT, [each.base for each in campaigns])
    for campaign in campaigns:
        if before:
            _again(campaign, before)
        else:
            _fill(campaign, plan, settings.seed)
        say(f"{campaign.space.file}: {campaign.progress.text()}")
    _map(campaigns, store.folder, say)
    return campaigns


def check_first(spaces: Sequence[Space], settings: RunSpec) -> None:
    """Read the scenario at its nominal values, the gates and the stack, so that what is wrong shows before a drive.

    Raises ScenarioError, GateError, AdsError, ParameterError.
    """
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


def _fill(campaign: Campaign, plan: Plan, seed: int) -> None:
    from pytest_dvp.campaigns.measured_probability import counted_probability, measured_probability

    campaign.progress.wanted = plan.runs
    if plan.method == RARE:
        found = measured_probability(campaign, plan.runs, seed)
        campaign.store.tell(f"probability {campaign.base}", found.as_dict())
        return
    if plan.method == HYPOTHESIS:
        from pytest_dvp.campaigns.hypothesis_search import search_by_hypothesis

        search_by_hypothesis(campaign, plan.runs, seed)
        return
    if plan.method == BOUNDARY:
        from pytest_dvp.campaigns.failure_boundary import refine_boundary

        refine_boundary(campaign, plan.runs, seed)
        return
    if plan.method not in SAMPLES:
        from pytest_dvp.campaigns.critical_search import search

        search(campaign, plan.method, plan.runs, seed)
        return
    part, parts = plan.shard
    points = sample(plan.method, campaign.space.axes, plan.runs, seed)[part - 1 :: parts]
    if not points:
        return  # more parts than drives
    campaign.progress.wanted = len(points)
    rows = campaign.rows(points, "sample")
    if plan.method == "random" and any(row.verdict != EXCLUDED for row in rows):
        campaign.store.tell(f"probability {campaign.base}", counted_probability(rows).as_dict())


def _again(campaign: Campaign, before: Sequence[Row]) -> None:
    """Drive the variants of the baseline that are of this scenario."""
    from pytest_dvp.text.errors import SettingError

    names = {name for axis in campaign.space.axes for name in axis.nominal}
    here = [row for row in before if Path(row.scenario).name == campaign.space.scenario.name]
    values = [row.parameters for row in here if row.parameters.keys() == names]
    if not values:
        raise SettingError(f"--baseline: no drive of {campaign.space.scenario.name} with these parameters in it")
    seeds, seed = sorted({row.seed for row in here}), campaign.settings.seed
    if seeds != [seed]:
        told = ", ".join(map(str, seeds))
        raise SettingError(
            f"--baseline: driven with seed {told}, this campaign with {seed}; allowed: --seed {seeds[0]}"
        )
    campaign.progress.wanted = len(values)
    campaign.rows_of(values, "sample")


def _map(campaigns: Sequence[Campaign], folder: Path, say: Tell) -> None:
    """Shrink one failure of each kind, and write the map."""
    from pytest_dvp.campaigns.map_page import PAGE, map_page
    from pytest_dvp.campaigns.reproducer import reproducers
    from pytest_dvp.campaigns.space_coverage import coverage
    from reports.campaign import write_campaign_page

    files = [campaign.space.file for campaign in campaigns]
    pages = []
    for campaign in campaigns:
        rows = [row for row in campaign.store.rows([campaign.base]) if row.purpose != SHRINKING]
        tried = coverage(campaign.space, rows)
        campaign.store.tell(f"coverage {campaign.base}", None if tried is None else tried.as_dict())
        name = told_apart(campaign.space.file, files, campaign.settings.rootdir)
        found = reproducers(campaign, rows, name)
        for each in found:
            say(f"{each.sentence()}\n  replay: {each.command}")
        probability = campaign.store.told(f"probability {campaign.base}")
        pages.append(map_page(campaign, rows, found, probability, () if tried is None else tried.sentences()))
    write_campaign_page(folder / PAGE, pages)
    say(f"map: {folder / PAGE}")
