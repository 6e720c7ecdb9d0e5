"""A campaign as a pytest item, `overtaking.xosc::campaign`: `--dvp-campaign` drives many variants of each file."""

from __future__ import annotations

import dataclasses
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.plugin.fixtures import GateFailed
from pytest_dvp.plugin.item_notes import settings_of
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.paths import shown, told_apart

if TYPE_CHECKING:
    from pytest_dvp.campaigns.plan import Plan

NAME = "campaign"
TOLD = "dvp_campaign"
"""Property of a report, one line: what the campaign found."""
_PREFIX = "--dvp-campaign-"  # of the options in messages
EVERY = 5.0  # s between lines of progress, which pass pytest's capture


def campaign_of(path: Path) -> Callable[[pytest.FixtureRequest], None]:
    """The test function that drives the campaign of a scenario or distribution."""

    def drive(request: pytest.FixtureRequest) -> None:
        __tracebackhide__ = True
        _drive(path, settings_of(request.config), request)

    drive.__doc__ = f"many variants of {path.name} on stage dt"
    return drive


def check_options(settings: RunSpec) -> None:
    """Raises SettingError for a wrong value, and for an option that was typed, or is in the environment, and would do
    nothing: without `--dvp-campaign` those of a campaign, with it `--dvp-cases`. A line of an ini file is of every
    session, and may wait for those that it concerns.
    """
    plan = _plan(settings)
    (plan if settings.campaign else dataclasses.replace(plan, shard=(1, 1))).checked(_PREFIX)
    without_effect = {"cases": "chooses among cases that are driven one by one: leave out --dvp-campaign"}
    if not settings.campaign:
        without_effect = {
            "shard": "divides a campaign: add --dvp-campaign",
            "campaign_runs": "is the size of a campaign: add --dvp-campaign",
            "campaign_method": "chooses the drives of a campaign: add --dvp-campaign",
        }
    for key, why in without_effect.items():
        if settings.origins.get(key, "ini").startswith(("--", "environment")):
            raise SettingError(f"{settings.origin(key)} {why}")


def nothing_varies(path: Path, settings: RunSpec) -> str:
    """Why a file can have no campaign; "" if it can. Raises ScenarioError and SettingError for what is wrong."""
    from pytest_dvp.campaigns.constraint_range import FuzzError
    from pytest_dvp.campaigns.parameter_space import space_of

    try:
        space_of(path, settings)
    except FuzzError as error:
        return str(error)
    return ""


def _drive(path: Path, settings: RunSpec, request: pytest.FixtureRequest) -> None:
    from pytest_dvp.campaigns.crew import LocalCrew
    from pytest_dvp.campaigns.drive_plan import check_first, drive_plan
    from pytest_dvp.campaigns.one_drive import drive
    from pytest_dvp.campaigns.parameter_space import space_of
    from pytest_dvp.campaigns.store import SHRINKING, Store

    __tracebackhide__ = True
    plan = _plan(settings).checked(_PREFIX)
    part, parts = plan.shard
    every = [item.path for item in request.session.items if item.name == NAME]
    name = told_apart(path, every, settings.rootdir)
    folder = settings.runs_folder / f"campaign-{name}{'' if parts == 1 else f'-{part}-of-{parts}'}"
    # In a worker of xdist the other cores have work already.
    jobs = 1 if hasattr(request.config, "workerinput") else os.cpu_count() or 1
    if settings.stack_process is None and jobs > 1:
        settings = dataclasses.replace(settings, stack_process="off")
    space = space_of(path, settings)
    check_first([space], settings)
    said: list[str] = []
    with Store(folder, writes=True) as store, LocalCrew(jobs, drive) as crew:
        campaigns = drive_plan([space], settings, store, plan, crew, tick=_progress(request), say=said.append)
        rows = [row for row in store.rows([campaigns[0].base]) if row.purpose != SHRINKING]
    failed = sum(row.failed for row in rows)
    passed = sum(row.verdict == "PASS" for row in rows)
    line = f"{len(rows)} drives: {failed} failed, {passed} passed; map: {shown(folder / 'map.html')}"
    request.node.user_properties.append((TOLD, line))
    if failed or (rows and not passed):  # a part of a small campaign may have no drive at all
        why = "" if failed else ": not one drive decided anything"
        raise GateFailed("\n".join([f"{path.name}: {line}{why}", *said]), {})


def _plan(settings: RunSpec) -> Plan:
    """What the options ask for. Raises SettingError for a wrong part; `checked` looks at the rest."""
    from pytest_dvp.campaigns.plan import Plan, shard_of

    shard = shard_of(settings.shard, settings.origin("shard"))
    return Plan(settings.campaign_method, settings.campaign_runs, shard=shard)


def _progress(request: pytest.FixtureRequest) -> Callable[[str], None]:
    """Tells what is driven now on stderr, past the capture of pytest, every few seconds."""
    capture = request.config.pluginmanager.getplugin("capturemanager")
    last = time.monotonic()

    def tell(text: str) -> None:
        nonlocal last
        if time.monotonic() - last < EVERY or capture is None:
            return
        last = time.monotonic()
        with capture.global_and_fixture_disabled():
            print(f"\n{request.node.name}: {text}", file=sys.stderr, flush=True)

    return tell
