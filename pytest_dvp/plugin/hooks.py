"""Hooks of the pytest plugin; imports the standard library and pytest only, the rest inside the hook that needs it."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
import uuid
from collections.abc import Generator, Iterator
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_dvp.drive.option import LISTS, STAGES, Setting
from pytest_dvp.drive.option_sources import environment_lookup, from_sources, misspelt_variable, taken_for_root
from pytest_dvp.drive.run_spec import PLUGIN_SETTINGS, SETTINGS, SIMULATED, RunSpec
from pytest_dvp.gap.diagnosis_switch import diagnosis
from pytest_dvp.logs.budget import in_force
from pytest_dvp.logs.unfinished_run import FULL
from pytest_dvp.plugin import fixtures
from pytest_dvp.plugin.fixtures import gate, run  # noqa: F401  (pytest finds fixtures among a plugin's names)
from pytest_dvp.plugin.item_notes import ITEM_KEY, SETTINGS_KEY
from pytest_dvp.rooms.side_by_side import make_room
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.spelling import misspelt

if TYPE_CHECKING:
    from pytest_dvp.plugin.collection import ScenarioFile

ALL = SETTINGS + PLUGIN_SETTINGS
STAGE_MEANING = {
    "dt": "digital twin: car and world are simulated",
    "pe": "parallel execution: a real car among simulated road users",
    "rw": "real world: everything real, or a recorded log",
}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare each option of a run as `--dvp-NAME` and as an ini key."""
    group = parser.getgroup("dvp", "driving scenarios (pytest-dvp)")
    for setting in ALL:
        attributes: dict[str, Any] = {"dest": setting.ini, "default": None, "help": setting.help}
        if setting.kind == "flag":
            attributes["action"] = "store_true"
        else:
            attributes["metavar"] = setting.metavar
            if setting.kind in LISTS:
                attributes["action"] = "append"
        group.addoption(f"--dvp-{setting.name}", **attributes)
        kind = {"paths": "paths", "files": "paths", "logs": "paths", "assignments": "args"}.get(setting.kind, "string")
        parser.addini(setting.ini, setting.help, type=kind, default=None)  # type: ignore[arg-type]


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config, args: list[str]) -> None:
    """See the project's packages before a conftest.py or an option can load ours of the same name."""
    root, here = early_config.rootpath, early_config.invocation_params.dir
    asked = [(here / word.partition("::")[0]) for word in args if not word.startswith("-")]
    above = [folder for path in asked for folder in (path, *path.parents) if folder.is_relative_to(root)]
    make_room(dict.fromkeys(place for folder in [root, here, *above] for place in (folder, folder / "src")))


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers of the stages, and read the options once for the whole session."""
    for stage in STAGES:
        config.addinivalue_line("markers", f"{stage}: {STAGE_MEANING[stage]}")
    config.stash[SETTINGS_KEY] = _settings(config)
    budget = contextlib.ExitStack()
    budget.enter_context(in_force(config.stash[SETTINGS_KEY].budget))
    config.add_cleanup(budget.close)
    config.stash[fixtures.BROKEN_KEY] = []
    config.stash[fixtures.SHARED_KEY] = Path(tempfile.gettempdir()) / f"dvp-session-{os.getpid()}-{uuid.uuid4().hex}"


def pytest_unconfigure(config: pytest.Config) -> None:
    """Delete the folder in which the items of this session share their runs."""
    folder = config.stash.get(fixtures.SHARED_KEY, None)
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> ScenarioFile | None:
    """A collector for a .xosc file that is named or lies below a named folder; None for every other file."""
    if file_path.suffix.lower() != ".xosc":
        return None
    from pytest_dvp.plugin import collection

    settings = parent.config.stash[SETTINGS_KEY]
    named, inside = collection.asked_for(file_path, parent.config, settings)
    if not named and not inside:
        return None
    return collection.ScenarioFile.from_parent(parent, path=file_path, named=named)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Suit Hypothesis to long examples, and check the options against the collected scenarios.

    Raises UsageError for a parameter or a vehicle that fits none of them; in a worker of xdist the items fail instead.
    """
    if "hypothesis" in sys.modules:
        _suit_hypothesis(items)
    settings = config.stash[SETTINGS_KEY]
    if (settings.set.scenario or ":" in settings.vehicle) and any(_is_scenario(item) for item in items):
        from pytest_dvp.plugin import collection

        with _refusing(config, items):
            collection.check_parameters(items, settings)
            collection.check_vehicle(config, settings)


@contextlib.contextmanager
def _refusing(config: pytest.Config, items: list[pytest.Item]) -> Iterator[None]:
    """Make a wrong setting a UsageError; in a worker of xdist, which would take the session down, the items fail."""
    from pytest_dvp.plugin import collection

    try:
        yield
    except SettingError as error:
        if not hasattr(config, "workerinput"):
            raise pytest.UsageError(str(error)) from None
        collection.refuse(items, str(error))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """The runs folder holds results and failing variants: they are named one by one or not at all."""
    return True if collection_path == config.stash[SETTINGS_KEY].runs_folder else None


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Count the files that could not be collected, and which of them are scenarios."""
    report = yield
    if report.failed:
        collector.config.stash[fixtures.BROKEN_KEY].append(collector.path.suffix.lower() == ".xosc")
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_finish(session: pytest.Session) -> None:
    """A broken scenario is one error and the others still run; a broken test module interrupts as it always does.

    Raises UsageError for a value that a scenario which is to run does not allow; in a worker the items fail instead.
    """
    settings = session.config.stash[SETTINGS_KEY]
    if settings.set.scenario and any(_is_scenario(item) for item in session.items):
        from pytest_dvp.plugin import collection

        with _refusing(session.config, session.items):
            collection.check_values(session.items, settings)
    if settings.vehicle.partition(":")[0] not in SIMULATED and any(_is_scenario(item) for item in session.items):
        from pytest_dvp.plugin import collection

        collection.refuse_repetition(session.items, session.config)
    broken = session.config.stash[fixtures.BROKEN_KEY]
    if session.items and broken and all(broken):
        session.config.option.continue_on_collection_errors = True


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Let a failed gate be diagnosed while an item runs, unless the options forbid it."""
    with diagnosis(not item.config.stash[SETTINGS_KEY].no_diagnosis):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, object, object]:
    """A test with `@given` that drives ends with the smallest failure, or with a variant that decided nothing.

    Raises the Exception of `pytest.fail`, with one line, where there is nothing to search.
    """
    if "hypothesis" not in sys.modules or "run" not in pyfuncitem.fixturenames:
        return (yield)
    from pytest_dvp.plugin.given_examples import Searched, is_searched

    if not is_searched(pyfuncitem):
        return (yield)
    from pytest_dvp.campaigns.constraint_range import FuzzError

    try:
        with Searched(pyfuncitem).watched():
            return (yield)
    except FuzzError as error:  # one line about the test's own words, and dozens of Hypothesis above it
        raise pytest.fail.Exception(str(error), pytrace=False) from None


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Remember the item that runs now, so that each run is noted at the test that asked for it."""
    item.config.stash[ITEM_KEY] = item
    fixtures.forget_runs(item)


def pytest_report_collectionfinish(config: pytest.Config, items: list[pytest.Item]) -> list[str]:
    """One line that says what will drive; nothing for a session without scenarios."""
    if not any(_is_scenario(item) for item in items):
        return []
    from pytest_dvp.plugin import collection

    return [collection.header(items, config.stash[SETTINGS_KEY])]


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> Generator[None, object, object]:
    """A report of pytest's own (--junitxml) that a full disk does not take is a line; the exit code stays."""
    try:
        return (yield)
    except OSError as error:
        terminal = session.config.pluginmanager.get_plugin("terminalreporter")
        if error.errno not in FULL or terminal is None:
            raise
        file = error.filename or session.config.getoption("xmlpath", None) or "a file of the session"
        terminal.ensure_newline()
        terminal.write_line(f"{file}: cannot be written: {error.strerror}")
        return None


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """A worker of xdist sees all paths as if they were typed; only the controller knows which were.

    It also shares runs with the other workers.
    """
    node.workerinput["dvp_shared"] = str(node.config.stash[fixtures.SHARED_KEY])
    node.workerinput["dvp_explicit"] = node.config.args_source is pytest.Config.ArgsSource.ARGS


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Attach the results of an item's runs to its report, which crosses from a worker of xdist to the controller."""
    report = yield
    fixtures.attach(item, report)
    return report


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Print verdicts and comparisons of stages of all runs; on GitHub also annotations and the step summary."""
    # A worker of xdist has a terminal reporter as well, which nobody sees; the controller has the reports of all.
    if hasattr(config, "workerinput"):
        return
    _campaign_summary(terminalreporter)
    every = [report for group in terminalreporter.stats.values() for report in group]
    # Of a test that a plugin reran, the last time counts, as it does for pytest.
    reports = [one for one in every if getattr(one, "dvp", None) and one.outcome != "rerun"]
    if not reports:
        return
    from pytest_dvp.plugin import session_summary

    cases = session_summary.cases(reports)
    terminalreporter.write_sep("=", "dvp")
    for line in session_summary.lines(cases):
        terminalreporter.write_line(line)
    tables = session_summary.stage_tables(cases)
    if tables:
        terminalreporter.write_sep("=", "dvp stages")
        for line in tables:
            terminalreporter.write_line(line)
    if os.environ.get("GITHUB_ACTIONS"):
        for line in session_summary.github_annotations(cases):
            terminalreporter.write_line(line)
        step_summary = os.environ.get("GITHUB_STEP_SUMMARY")
        if step_summary:
            try:
                session_summary.append_table(Path(step_summary), cases)
            except OSError as error:  # the verdicts stand, whatever becomes of their table
                terminalreporter.write_line(f"GITHUB_STEP_SUMMARY {step_summary}: cannot be written: {error.strerror}")


def _campaign_summary(terminalreporter: Any) -> None:
    """Print a line of what each campaign found."""
    every = (report for group in terminalreporter.stats.values() for report in group)
    lines = [
        f"{report.nodeid}: {told}"
        for report in every
        if getattr(report, "when", None) == "call"
        for name, told in report.user_properties
        if name == "dvp_campaign"
    ]
    if lines:
        terminalreporter.write_sep("=", "dvp campaigns")
        for line in lines:
            terminalreporter.write_line(line)


def _suit_hypothesis(items: list[pytest.Item]) -> None:
    """Defaults of Hypothesis that do not suit tests whose examples are runs; what a test or a profile sets stays.

    The deadline of 200 ms is shorter than a run, and the phase "explain" runs ten times more examples than the search.
    """
    from hypothesis import Phase, settings

    default = settings.default
    for item in items:
        test: Any = getattr(item, "obj", None)
        if default is None or "run" not in getattr(item, "fixturenames", ()):
            continue
        if not getattr(test, "is_hypothesis_test", False):
            continue
        chosen = getattr(test, "_hypothesis_internal_use_settings", None) or default
        changed: dict[str, Any] = {}
        if chosen.deadline == timedelta(milliseconds=200):  # the default of Hypothesis itself
            changed["deadline"] = None
        if chosen.phases == default.phases:
            changed["phases"] = [phase for phase in default.phases if phase is not Phase.explain]
        function = getattr(test, "__func__", test)  # a method takes no attributes
        function._hypothesis_internal_use_settings = settings(chosen, **changed)


def _is_scenario(item: pytest.Item) -> bool:
    return hasattr(item, "dvp_stage")


def _settings(config: pytest.Config) -> RunSpec:
    """Command line before environment before ini file."""
    base = config.inipath.parent if config.inipath else config.rootpath
    here = config.invocation_params.dir
    chosen = config.option.rootdir or config.option.inifilename  # the user's own root
    named = config.args if config.args_source is pytest.Config.ArgsSource.ARGS else []
    asked = [here / argument.split("::")[0] for argument in named] or [here]
    words = [str(argument) for argument in config.invocation_params.args]
    misled = None if chosen else taken_for_root(words, here, asked, config.rootpath)
    if misled and not hasattr(config, "workerinput"):
        raise pytest.UsageError(misled)
    known = [setting.ini for setting in ALL]
    for wrong in (
        misspelt((name for name in _ini_names(config) if name.startswith("dvp_")), known),
        misspelt_variable(ALL),
    ):
        if wrong:
            raise pytest.UsageError(wrong)
    try:
        found = from_sources(
            ALL,
            [
                (lambda s: config.getoption(s.ini), lambda s: f"--dvp-{s.name}", here),
                (environment_lookup(), lambda s: f"environment {s.environment}", here),
                (lambda s: _ini(config, s), lambda s: f"ini {s.ini}", base),
            ],
            config.rootpath,
        )
        _check_runs_folder(found)
        if found.campaign or {"shard", "campaign_runs", "campaign_method"} & found.origins.keys():
            from pytest_dvp.plugin.campaign_item import check_options

            check_options(found)
        if found.set.P or found.set.S:
            from pytest_dvp.drive import parameter_checks
            from pytest_dvp.drive.stack_host import find_ads
            from pytest_dvp.drive.stack_parameters import check_parameters

            if found.set.P:
                ads = find_ads(found.ads, [config.rootpath], process=found.stack_process, tick_limit=found.tick_limit)
                check_parameters(ads, found.set.P, "--dvp-set")
            parameter_checks.check_simulator_parameters(found.set.S, "--dvp-set")
        return found
    except SettingError as error:
        raise pytest.UsageError(str(error)) from None
    except ImportError:  # what knows a parameter or a delay is in packages that a project's own may hide
        from pytest_dvp.plugin.shadowed_packages import hidden_package

        hidden = hidden_package()
        if hidden is None:
            raise
        raise pytest.UsageError(hidden) from None


def _check_runs_folder(settings: RunSpec) -> None:
    """Raises SettingError if the runs folder, which is not collected, holds a folder of scenarios."""
    runs = settings.runs_folder.resolve()
    for folder in settings.scenarios:
        if folder.resolve().is_relative_to(runs):
            place = f"{settings.origins.get('runs', 'runs folder')} {settings.runs_folder}"
            hidden = f"{settings.origin('scenarios')} {folder} is in it"
            raise SettingError(f"{place}: nothing in it is collected, and {hidden}; name another folder for the runs")


def _ini_names(config: pytest.Config) -> list[str]:
    # pytest 9 deprecates `inicfg`, and there is no public list of the keys a file sets.
    found = vars(config).get("_inicfg") or vars(config).get("inicfg") or {}
    return [str(name) for name in found]


def _ini(config: pytest.Config, setting: Setting) -> object:
    value = config.getini(setting.ini)
    return [str(part) for part in value] if isinstance(value, list) else value
