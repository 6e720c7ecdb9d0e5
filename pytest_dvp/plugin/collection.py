"""Scenario files as pytest items: `overtaking.xosc::dt`, `::pe-surrogate`, `::rw-surrogate`.

Of a distribution `::dt[07-EgoSpeed=70]`.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_dvp.campaigns.cases import choose
from pytest_dvp.drive.announced_cars import label
from pytest_dvp.drive.option import STAGES
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.plugin.fixtures import SHARED_KEY, Gate, GateFailed, Run
from pytest_dvp.plugin.item_notes import settings_of
from pytest_dvp.plugin.selection import asked_stage, explicit_arguments
from pytest_dvp.plugin.shadowed_packages import hidden_package
from pytest_dvp.text.errors import SettingError, is_users_mistake
from pytest_dvp.text.paths import shown
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from pytest_dvp.plugin.shared_runs import SharedRuns

DISTRIBUTION = "a parameter distribution"


class ScenarioFile(pytest.File):
    """A .xosc file; collects one item a stage or a case, nothing for a catalogue met in a folder."""

    def __init__(self, *, named: bool = False, **rest: Any) -> None:
        super().__init__(**rest)
        self.named = named
        self.left_out: list[str] = []  # what of a distribution does not run, in words

    def collect(self) -> Iterable[ScenarioItem]:
        """The items of a scenario: one a stage, then one for each pair of stages with a gate between them.

        A distribution gives one item a case; any other file without a storyboard gives none. Raises CollectError with
        the findings for a file with errors, for a file that the user names and that cannot run, and for a wrong option.
        """
        hidden = hidden_package()
        if hidden is not None:
            raise self.CollectError(hidden)
        from openscenario.findings import ScenarioError

        settings = settings_of(self.config)
        try:
            sight = classify_file(self.path, settings)
        except ScenarioError as error:
            raise self.CollectError("\n".join(str(finding) for finding in error.findings)) from None
        if sight.what != "scenario" and sight.what != DISTRIBUTION:
            if self.named:
                raise self.CollectError(f"{self.path}:{sight.line}: {sight.what}: it has no storyboard that could run")
            return []
        if settings.campaign:
            return self._campaign(settings, sight.line)
        if sight.what == DISTRIBUTION:
            return list(self._cases(settings, sight.line))
        try:
            check_name(self.config, settings)
        except SettingError as error:
            raise self.CollectError(str(error)) from None
        items = [*self._stages(settings, sight.line), *self._across(settings, sight.line)]
        self._check_ids([item.name for item in items])
        return items

    def _campaign(self, settings: RunSpec, line: int) -> list[ScenarioItem]:
        """One item that drives many variants; skipped where nothing varies, unless the user names the file."""
        from openscenario.findings import ScenarioError
        from pytest_dvp.plugin.campaign_item import NAME, campaign_of, nothing_varies

        try:
            reason = nothing_varies(self.path, settings)
        except ScenarioError as error:
            raise self.CollectError("\n".join(str(finding) for finding in error.findings)) from None
        except SettingError as error:
            raise self.CollectError(str(error)) from None
        if reason and self.named:
            raise self.CollectError(reason)
        item = ScenarioItem.from_parent(self, name=NAME, callobj=campaign_of(self.path))
        item.dvp_stage, item.dvp_line = "dt", line
        item.add_marker("dt")
        if reason:
            item.add_marker(pytest.mark.skip(reason=reason))
        self._check_ids([item.name])
        return [item]

    def _check_ids(self, names: Sequence[str]) -> None:
        """Raises CollectError for a node id of this file that is none of its items: pytest names none of them."""
        for argument in self.config.args:
            file, colons, name = argument.partition("::")
            if colons and name not in names and _same(self.config.invocation_params.dir / file, self.path):
                raise self.CollectError(f"{self.path.name}: {unknown('item', name, names)}")

    def _stages(self, settings: RunSpec, line: int) -> Iterator[ScenarioItem]:
        """One item a stage; those of a car wait until they are asked for."""
        for stage in STAGES:
            item = ScenarioItem.from_parent(self, name=label(stage, settings.vehicle), callobj=case(self.path, stage))
            item.dvp_stage, item.dvp_line = stage, line
            item.add_marker(stage)
            if stage != "dt" and not asked_stage(stage, self.config):
                item.add_marker(pytest.mark.skip(reason=f"drives a car of its own: ask for it with -m {stage}"))
            yield item

    def _across(self, settings: RunSpec, line: int) -> Iterator[ScenarioItem]:
        """One item for each pair of stages that a gate is between; the items of the stages then share their runs."""
        from pytest_dvp.drive.stage_comparison import gates_between, pair_name
        from pytest_dvp.verdicts.judging import GateError, pairs_of

        try:
            pairs = pairs_of(gates_between(self.path, settings.gates, settings.stage_gates))
        except GateError as error:
            if settings.stage_gates is not None and error.findings[0].file == shown(settings.stage_gates):
                raise self.CollectError("\n".join(str(finding) for finding in error.findings)) from None
            return  # the items of the stages say what is wrong with their gate file
        for pair in pairs:
            name = pair_name([label(stage, settings.vehicle) for stage in pair])
            item = ScenarioItem.from_parent(self, name=name, callobj=comparison(self.path, pair))
            item.dvp_stage, item.dvp_line, item.dvp_pair = name, line, pair
            cars = [stage for stage in pair if stage != "dt"]
            for stage in cars:
                item.add_marker(stage)
            unasked = [stage for stage in cars if not asked_stage(stage, self.config) and not settings.stage_logs]
            if unasked and not any(argument.endswith(f"::{name}") for argument in self.config.args):
                wanted = " or ".join(pair)
                one = label(unasked[0], settings.vehicle)
                why = f"drives a car of its own, as {one} does: ask for both, -m {shlex.quote(wanted)}"
                item.add_marker(pytest.mark.skip(reason=why))
            yield item

    def _cases(self, settings: RunSpec, line: int) -> Iterator[ScenarioItem]:
        """One item a case, on the digital twin alone: what is varied automatically never drives a real car."""
        from openscenario.findings import ScenarioError
        from openscenario.read import read_scenario

        try:
            chosen = choose(self.path, settings, "--dvp-cases", self.left_out.append)
        except ScenarioError as error:
            raise self.CollectError("\n".join(str(finding) for finding in error.findings)) from None
        except SettingError as error:
            raise self.CollectError(str(error)) from None
        looked_at = False
        for each in chosen:
            if not looked_at:  # a broken scenario shows at collection, once
                looked_at = True
                try:
                    read_scenario(
                        chosen.scenario, library=settings.library, rootdir=settings.rootdir, parameters=each.values
                    )
                except ScenarioError as error:
                    raise self.CollectError("\n".join(str(finding) for finding in error.findings)) from None
            options: dict[str, Any] = {"folder_name": chosen.folder_name(each)}
            if settings.gates is None and chosen.gates is not None:
                options["gates"] = chosen.gates
            drive = case(chosen.scenario, "dt", each.values, options)
            item = ScenarioItem.from_parent(self, name=f"dt[{each.name}]", callobj=drive)
            item.dvp_stage, item.dvp_line = "dt", line
            item.dvp_scenario, item.dvp_values, item.dvp_count = chosen.scenario, each.values, chosen.count
            item.add_marker("dt")
            yield item
        if not looked_at:
            raise self.CollectError(f"{self.path}: nothing to drive: {'; '.join(self.left_out)}")


class ScenarioItem(pytest.Function):
    """One scenario on one stage: a test function with real fixtures whose place is in the .xosc."""

    dvp_stage: str
    dvp_line: int
    dvp_scenario: Path | None = None  # what a case varies; None: the file itself is driven
    dvp_values: Mapping[str, str] | None = None
    dvp_count: int = 0  # cases in the file, chosen or not

    dvp_pair: tuple[str, str] | None = None  # the stages that it compares; None: it drives one

    dvp_refused: str | None = None  # why it must not run

    @property
    def dvp_shared(self) -> SharedRuns | None:
        """The runs it has in common with other items of its scenario; None if nothing is compared."""
        compared = any(isinstance(other, ScenarioItem) and other.dvp_pair for other in self.session.items)
        if self.dvp_values is not None or not compared:
            return None
        from pytest_dvp.plugin.shared_runs import SharedRuns

        return SharedRuns(shared_folder(self.config))

    def runtest(self) -> None:
        """Drive the scenario and judge it. Raises SettingError if the session's options do not fit this scenario."""
        if self.dvp_refused is not None:
            raise SettingError(self.dvp_refused)
        super().runtest()

    def reportinfo(self) -> tuple[os.PathLike[str] | str, int | None, str]:
        """The .xosc file, the line (from 0) of the item in it, and the name that pytest shows."""
        return self.path, self.dvp_line - 1, f"{self.path.name}::{self.name}"

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What pytest prints of a failure: the message alone for a gate or a user's mistake, else a traceback."""
        if not isinstance(excinfo.value, GateFailed) and not is_users_mistake(excinfo.value):
            return super().repr_failure(excinfo)
        # The message alone: it names file and line, and a traceback through our code helps nobody.
        report = excinfo.getrepr(style="value")
        crash = report.reprcrash
        if crash is not None:  # what the short summary shows, also from a worker
            crash.path, crash.lineno, crash.message = str(self.path), self.dvp_line, str(excinfo.value)
        return report


class FileKind:
    """What a first look at a file shows: "scenario" or what else it is, and the line of its storyboard or root."""

    def __init__(self, what: str, line: int) -> None:
        self.what = what
        self.line = line


def case(
    path: Path, stage: str, values: Mapping[str, str] | None = None, options: Mapping[str, Any] | None = None
) -> Callable[[Run, Gate], None]:
    """The test function of one scenario and stage; in a case of a distribution with the values of its parameters and
    further options of `run`."""

    def drive(run: Run, gate: Gate) -> None:
        __tracebackhide__ = True
        gate(run(path, stage=stage, parameters=dict(values or {}), **(options or {})))

    drive.__doc__ = f"{path.name} on stage {stage}"
    return drive


def comparison(path: Path, pair: tuple[str, str]) -> Callable[[Run, Gate], None]:
    """The test function that holds two stages of a scenario against each other."""

    def hold(run: Run, gate: Gate) -> None:
        __tracebackhide__ = True
        gate(run.across(path, pair))

    hold.__doc__ = f"{path.name}: gates between {' and '.join(pair)}"
    return hold


def shared_folder(config: pytest.Config) -> Path:
    """The folder of a session's shared runs; a worker of xdist was told it."""
    told = getattr(config, "workerinput", {}).get("dvp_shared")
    return Path(told) if told is not None else config.stash[SHARED_KEY]


def asked_for(path: Path, config: pytest.Config, settings: RunSpec) -> tuple[bool, bool]:
    """Whether a file is named on the command line, and whether a folder named there or by `dvp_scenarios` holds it."""
    folders = list(settings.scenarios)
    named = False
    if explicit_arguments(config):
        for argument in config.args:
            given = (config.invocation_params.dir / argument.split("::")[0]).absolute()
            named = named or _same(given, path)
            folders.append(given)
    real = path.resolve()
    return named, any(real.is_relative_to(folder.resolve()) for folder in folders)


def classify_file(path: Path, settings: RunSpec) -> FileKind:
    """Say whether a file is a scenario that could run; reads it whole, so that a broken one shows at collection.

    Raises ScenarioError for a file that is no scenario, catalogue or distribution.
    """
    from openscenario.read import read_scenario
    from openscenario.xml import read_xml

    root = read_xml(path).root
    child = {element.tag: element.line for element in root.children}
    for tag, what in (("Catalog", "a catalogue"), ("ParameterValueDistribution", DISTRIBUTION)):
        if tag in child:
            return FileKind(what, child[tag] or 1)
    scenario = read_scenario(path, library=settings.library, rootdir=settings.rootdir)
    return FileKind("scenario", scenario.storyboard.at.line or 1)


def check_parameters(items: Sequence[pytest.Item], settings: RunSpec) -> None:
    """Every `--dvp-set NAME=VALUE` must be declared by a collected scenario, deselected or not.

    Raises SettingError with the nearest declared name.
    """
    if not settings.set.scenario:
        return
    from openscenario.read import read_declarations

    declared = {declaration.name for path in _scenarios(items) for declaration in read_declarations(path)}
    for name in settings.set.scenario:
        if name not in declared:
            raise SettingError(f"--dvp-set: {unknown('parameter', name, declared)}")


def check_values(items: Sequence[pytest.Item], settings: RunSpec) -> None:
    """Every `--dvp-set NAME=VALUE` must be allowed by all scenarios that are to run and declare it.

    Raises SettingError with the allowed values, and the file if there are several.
    """
    if not settings.set.scenario:
        return
    from pytest_dvp.drive.parameter_checks import check_declared, declared_names

    paths = _scenarios(items)
    for path in paths:
        here = declared_names(path)
        try:
            check_declared(path, {n: v for n, v in settings.set.scenario.items() if n in here}, "--dvp-set")
        except SettingError as error:
            raise SettingError(f"{shown(path)}: {error}" if len(paths) > 1 else str(error)) from None


def _scenarios(items: Sequence[pytest.Item]) -> list[Path]:
    """The scenario files that items drive, each once."""
    return sorted({item.dvp_scenario or item.path for item in items if isinstance(item, ScenarioItem)})


def check_name(config: pytest.Config, settings: RunSpec) -> None:
    """Raises SettingError if a stage of a car is asked for and no vehicle has the name: items are called by it."""
    from pytest_dvp.drive.announced_cars import find_adapter
    from pytest_dvp.drive.stages import REPLAY, VEHICLES, StageError

    name = settings.vehicle.partition(":")[0]
    if name not in (*VEHICLES, REPLAY) and any(asked_stage(stage, config) for stage in STAGES if stage != "dt"):
        try:
            find_adapter(name)
        except StageError as error:
            raise SettingError(f"--dvp-vehicle: {error}") from None


def check_vehicle(config: pytest.Config, settings: RunSpec) -> None:
    """Raises SettingError if the car of a stage that is asked for hides a wrong file: before the twin drives."""
    from pytest_dvp.drive.stage_checks import check_hidden
    from pytest_dvp.drive.stages import StageError

    if any(asked_stage(stage, config) for stage in STAGES if stage != "dt"):
        try:
            check_hidden(settings.vehicle)
        except StageError as error:
            raise SettingError(f"--dvp-vehicle: {error}") from None


def refuse(items: Iterable[pytest.Item], why: str) -> None:
    """Let every scenario fail with one line instead of running."""
    for item in items:
        if isinstance(item, ScenarioItem):
            item.dvp_refused = why


REPEATING = {  # options of pytest and its plugins under which something automatic decides what runs, or how often
    "lf": "--lf",
    "failedfirst": "--ff",
    "stepwise": "--stepwise",
    "reruns": "--reruns",
    "count": "--count",
    "looponfail": "--looponfail",
    "numprocesses": "-n",
}


def refuse_repetition(items: Iterable[pytest.Item], config: pytest.Config) -> None:
    """Items that would drive a real car without a human having named just this drive fail with one line."""
    from pytest_dvp.drive.announced_cars import is_real

    vehicle = settings_of(config).vehicle
    real = [
        item
        for item in items
        if isinstance(item, ScenarioItem) and item.dvp_stage in STAGES and is_real(item.dvp_stage, vehicle)
    ]
    why = f"{len(real)} scenarios at once" if len(real) > 1 else ""
    for option, shown_as in REPEATING.items():
        value = getattr(config.option, option, None)
        if value not in (None, False, 0, "0", 1, "1") or (option != "numprocesses" and value is True):
            why = f"{shown_as} {value}" if not isinstance(value, bool) else shown_as
    if getattr(config, "workerinput", {}).get("workercount", 1) > 1:
        why = f"-n {config.workerinput['workercount']}"  # type: ignore[attr-defined]
    for item in real if why else ():
        item.dvp_refused = (
            f"{why} is refused: vehicle {vehicle!r} is real, and nothing automatic drives a real car; "
            f"name one scenario: pytest {item.path.name}::{item.name}"
        )


def header(items: Sequence[pytest.Item], settings: RunSpec) -> str:
    """The one line that says under which conditions scenarios run."""
    scenarios = [item for item in items if isinstance(item, ScenarioItem)]
    stages = [s for s in STAGES if any(item.dvp_stage == s or s in (item.dvp_pair or ()) for item in scenarios)]
    files = len({item.path for item in scenarios})
    words = [f"dvp: {files} scenario{'s' if files != 1 else ''}", *_case_words(scenarios), f"stage {', '.join(stages)}"]
    words += [
        f"vehicle {_vehicles(stages, settings)}",
        f"ADS {shown_name(settings.ads)}{_unasked(settings.origins.get('ads', '--ads'))}",
        f"seed {settings.seed}",
        f"model {', '.join(_models(scenarios, settings))}",
        *settings.set.words(),
    ]
    return ", ".join(words)


def _unasked(origin: str) -> str:
    """Where a setting stands that is not on the command line: ` (ini dvp_ads)`."""
    return "" if origin.startswith("--") else f" ({origin})"


def _models(scenarios: Sequence[ScenarioItem], settings: RunSpec) -> list[str]:
    """Files of the models that the twins are, or in the logs of earlier drives were, made from."""
    given = settings.model.name if settings.model else "tabby_evo.toml"
    earlier = _earlier_models(settings) if any(item.dvp_pair for item in scenarios) else {}
    names = [earlier.get(item.path.name, given) if "dt" in (item.dvp_pair or ()) else given for item in scenarios]
    return list(dict.fromkeys(names))


def _earlier_models(settings: RunSpec) -> dict[str, str]:
    """By scenario, what the log of its drive on the twin says of its model; the items say what is wrong with a log."""
    if not settings.stage_logs:
        return {}
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.log_error import LogError

    found: dict[str, str] = {}
    for path in settings.stage_logs:
        try:
            about = Log.load(path).meta
        except LogError:
            continue
        if about.get("stage") == "dt" and about.get("model"):
            found[str(about.get("scenario", ""))] = f"{about['model'].get('file', 'unknown')} of {path.name}"
    return found


def _vehicles(stages: Sequence[str], settings: RunSpec) -> str:
    names = ["twin"] if "dt" in stages else []
    return ", ".join([*names, settings.vehicle] if any(stage != "dt" for stage in stages) else names)


def _case_words(scenarios: Iterable[ScenarioItem]) -> Iterator[str]:
    chosen: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    for item in scenarios:
        if item.dvp_count:
            chosen[item.path] = chosen.get(item.path, 0) + 1
            counts[item.path] = item.dvp_count
    left_out = {item.path: item.parent.left_out for item in scenarios if isinstance(item.parent, ScenarioFile)}
    for path, count in counts.items():
        yield "; ".join([f"{chosen[path]} of {count} cases of {path.name}", *left_out.get(path, ())])


def shown_name(ads: str) -> str:
    """The ADS without the folder of its file."""
    file, colon, name = ads.rpartition(":")
    return f"{Path(file).name}:{name}" if colon and file.endswith(".py") else ads


def _same(first: Path, second: Path) -> bool:
    return first == second or (first.exists() and first.resolve() == second.resolve())
