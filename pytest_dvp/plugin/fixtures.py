"""The fixtures `run` and `gate`, and what a test's runs leave in its report.

Imports the standard library and pytest only; a session without scenarios loads nothing more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, Unpack

import pytest

from pytest_dvp.plugin.item_notes import RESULTS_KEY, VARIANT_KEY, current_item, settings_of
from pytest_dvp.plugin.run_summary import RunSummary, metrics_of
from pytest_dvp.text.errors import SettingError

if TYPE_CHECKING:
    from pytest_dvp.campaigns.variant import Variant
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.drive.run_options import RunOptions
    from pytest_dvp.drive.stage_comparison import StageComparison

BROKEN_KEY = pytest.StashKey[list[bool]]()  # a collection error each: whether a scenario file is to blame
SHARED_KEY = pytest.StashKey[Path]()  # folder of the runs that several items of a session need
TOLD_KEY = pytest.StashKey[
    dict[tuple[str, str], tuple[int, dict[str, Any]]]
]()  # steps of a run when told, and what was
PROPERTIES_KEY = pytest.StashKey[list[tuple[str, object]]]()  # those of JUnit that are of a test's runs


class GateFailed(AssertionError):
    """A run whose verdict is not PASS. The first line says why in one sentence, the last how to replay it."""

    def __init__(self, message: str, result: Mapping[str, Any]) -> None:
        super().__init__(message)
        self.result = dict(result)


class Undecided(GateFailed):
    """A run whose verdict is INCONCLUSIVE: nothing failed, and it proves nothing."""


class Run(Protocol):
    """What the fixture `run` gives: a factory of finished runs."""

    def __call__(self, scenario: str | Path | Variant, **options: Unpack[RunOptions]) -> RunResult: ...

    def across(self, scenario: str | Path, pair: tuple[str, str]) -> StageComparison:
        """Compare a scenario on two stages of "dt", "pe" and "rw", by the gates between them.

        What the session has not driven yet is driven now, unless it needs a real car.
        """


class Gate(Protocol):
    """What the fixture `gate` gives: raises GateFailed unless every verdict of the run is PASS."""

    def __call__(
        self,
        result: RunResult | StageComparison,
        metrics: Sequence[str] | None = None,
        optional_events: Sequence[str] = (),
    ) -> None: ...


# Session scope: the factory keeps nothing between calls, and so `@given` may use it without complaint.
@pytest.fixture(scope="session")
def run(request: pytest.FixtureRequest) -> Run:
    """Factory: `run("overtaking.xosc", parameters={...})` drives the scenario and returns its RunResult.

    A relative path starts at the test's own folder, else at the rootdir, else at a folder of `dvp_scenarios`. Takes
    every option of `pytest_dvp.run`; the session's `--dvp-*` settings are the defaults.
    """
    from pytest_dvp.plugin.shadowed_packages import hidden_package

    hidden = hidden_package()
    if hidden is not None:
        pytest.fail(hidden, pytrace=False)
    from pytest_dvp.plugin.session import Session

    return Session(request.config)


@pytest.fixture(scope="session")
def gate(request: pytest.FixtureRequest) -> Gate:
    """Judge: `gate(result)` raises unless all verdicts are PASS; `metrics=[...]` looks at those gates only.

    Whatever metrics are asked, a run in which an event of the storyboard never fired is INCONCLUSIVE. The exceptions
    are the events of `optional_events=[...]` and those that the gate file lets be; an unknown name is a SettingError.
    """
    config = request.config

    def judge(
        result: RunResult | StageComparison, metrics: Sequence[str] | None = None, optional_events: Sequence[str] = ()
    ) -> None:
        __tracebackhide__ = True
        from pytest_dvp.verdicts.result_text import failure, on_condition, undecided
        from pytest_dvp.verdicts.silent_events import check_optional, without_optional

        given = result.as_dict()
        if isinstance(metrics, str):
            raise SettingError(f"metrics: found {metrics!r}, expected a list of names: metrics=[{metrics!r}]")
        check_optional(optional_events, given.get("events", ()))
        plain = without_optional(given, optional_events)
        message = failure(plain, metrics)
        _ask(current_item(config), given, metrics, optional_events, passed=message is None)
        if message is not None:
            names = [] if metrics is None else metrics_of(metrics, plain["verdicts"])
            plain["replay"] = on_condition(plain["replay"], names, optional_events)
            plain["explanation"] = _explanation(result, plain["verdicts"], metrics)
            kind = Undecided if undecided(plain, metrics) else GateFailed
            raise kind(failure(plain, metrics) or message, plain)

    return judge


def _explanation(
    result: RunResult | StageComparison, verdicts: Sequence[Mapping[str, Any]], metrics: Sequence[str] | None
) -> list[str]:
    """What the model of a failed gate lacks: only then, as it costs seconds, and not for each run of a search."""
    from pytest_dvp.verdicts.model_gate import METRICS

    chosen = [v for v in verdicts if metrics is None or v["metric"] in metrics or v["gate"] in metrics]
    if not any(v["status"] == "FAIL" and v["metric"] in METRICS.values() for v in chosen) or result.folder is None:
        return []
    from pytest_dvp.drive.stage_comparison import StageComparison

    if isinstance(result, StageComparison):  # two logs: its gates are not on a model file
        return []
    from pytest_dvp.gap.diagnosis_switch import diagnosis_wanted
    from pytest_dvp.text.paths import shown

    if not diagnosis_wanted():
        return []
    from pytest_dvp.verdicts.gate_explanation import gate_explanation

    return gate_explanation(result.log, chosen, shown(result.folder / "log.mcap"))


def _ask(
    node: pytest.Item,
    result: Mapping[str, Any],
    metrics: Sequence[str] | None,
    optional: Sequence[str],
    *,
    passed: bool,
) -> None:
    """Remember which gates of a run the test asked for; the run that fails it is the one to tell of."""
    known, key = node.stash.setdefault(RESULTS_KEY, {}), (result["scenario"], result["stage"])
    noted = known.get(key)
    if noted is None:
        noted = known[key] = RunSummary(dict(result))
    if not passed:
        noted.last = dict(result)
    noted.add_request(metrics, optional, passed=passed)


def attach(item: pytest.Item, report: pytest.TestReport) -> None:
    """Put the numbers of a test's runs into its report: scalars for JUnit, the verdicts for the summary.

    The report of the call holds all of them, or that of the setup where no call follows. That of the teardown holds
    what a fixture has driven or judged after the call.
    """
    if report.when == "setup" and report.passed:
        return
    told = item.stash.setdefault(TOLD_KEY, {})
    expected = hasattr(report, "wasxfail") and not report.passed  # one that passes all the same has it, too
    changed = []
    for key, noted in item.stash.get(RESULTS_KEY, {}).items():
        if report.when == "teardown" and key in told and told[key][0] == noted.steps:
            continue
        result = noted.reported_run(failed=report.failed or expected)
        changed.append(result if not expected else {**result, "expected": True})
        told[key] = noted.steps, changed[-1]
    if report.failed and not hasattr(item, "dvp_stage") and (changed or report.when != "teardown"):
        _say_how_to_replay(item, report, changed)
    if not changed:
        return
    every = [result for _, result in told.values()]
    for result, called in zip(every, _names(every), strict=True):
        result["called"] = called
    report.dvp = changed  # type: ignore[attr-defined]
    _put_properties(item, every)
    report.user_properties[:] = item.user_properties


def forget_runs(item: pytest.Item) -> None:
    """Begin a test anew: what it drove before, when something ran it a first time, is no part of this time."""
    _put_properties(item, ())
    keys: tuple[pytest.StashKey[Any], ...] = (RESULTS_KEY, VARIANT_KEY, TOLD_KEY)
    for key in keys:
        if key in item.stash:
            del item.stash[key]


def _put_properties(item: pytest.Item, results: Sequence[Mapping[str, Any]]) -> None:
    """The properties of a test's runs, in place of those that were put there before."""
    before = item.stash.get(PROPERTIES_KEY, [])
    kept = [each for each in item.user_properties if each not in before]
    found: list[tuple[str, object]] = []
    for result in results:
        head = f"{result['called']}." if len(results) > 1 else ""
        found += [(head + name, value) for name, value in properties(result)]
    item.stash[PROPERTIES_KEY] = found
    item.user_properties[:] = [*kept, *found]


def _names(results: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the runs of a test are called: the scenario's name, with the stage or the whole path where that tells them
    apart."""
    stems = [Path(result["scenario"]).stem for result in results]
    staged = [f"{stem} {result['stage']}" for stem, result in zip(stems, results, strict=True)]
    for names in (stems, staged):
        if len(set(names)) == len(names):
            return names
    return [f"{result['scenario']} {result['stage']}" for result in results]


def properties(result: Mapping[str, Any]) -> list[tuple[str, object]]:
    """What JUnit holds of a run: verdict, conditions, all metrics, and unit, bound and margin of each gate's."""
    found: list[tuple[str, object]] = [
        (name, result.get(name)) for name in ("verdict", "seed", "stage", "ads", "ended")
    ]
    found[0] = ("verdict", result["status"])
    found += [(f"set.{name}", value) for name, value in sorted(result.get("set", {}).items())]
    found += [("compute_delay", result.get("compute_delay"))]
    found += [(f"tick_time.{name}", value) for name, value in result.get("tick_time", {}).items()]
    from pytest_dvp.verdicts.result_text import page_of

    if result.get("findings"):
        from pytest_dvp.drive.run_findings import said

        found += [(f"finding.{f['code']}.{f['field']}", said(f)) for f in result["findings"]]
    found += sorted(result["metrics"].items())
    seen: dict[str, int] = {}
    for verdict in result["verdicts"]:
        name = verdict.get("name") or verdict["metric"] or verdict["gate"] or "gate"
        seen[name] = seen.get(name, 0) + 1
        again = f"-{seen[name]}" if seen[name] > 1 else ""  # the second bound on one metric, with other options
        found += [(f"{name}{again}.{key}", verdict.get(key)) for key in ("status", "value", "unit", "bound", "margin")]
        found += [(f"{name}{again}.requirement", verdict.get("requirement") or None)]
    if search := result.get("search"):
        found += [("variants", search["variants"])]
        found += [(f"never_fired.{name}", count) for name, count in search["never_fired"].items()]
    found += [("report", page_of(result)), ("replay", result.get("replay"))]
    return [(name, value) for name, value in found if value is not None]


def _say_how_to_replay(item: pytest.Item, report: pytest.TestReport, results: Sequence[Mapping[str, Any]]) -> None:
    """End a failure with a command; Hypothesis and notes add lines below the message, so it is a section of its own."""
    variant, options = item.stash.get(VARIANT_KEY, (None, {}))
    if variant is not None:
        from pytest_dvp.plugin.scenario_strategy import keep, kept_name
        from pytest_dvp.verdicts.result_text import condition_of

        name = kept_name(item.name, item.nodeid, (other.name for other in item.session.items))
        replay = keep(variant, options, settings_of(item.config).runs_folder, name)
        if results and replay.startswith("dvp run "):  # of a gate(..., metrics=[...], optional_events=[...])
            replay += condition_of(results[-1]["replay"])
    elif results:
        replay = results[-1]["replay"]
    else:
        return
    add = getattr(report.longrepr, "addsection", None)
    if add is not None:
        add("replay", replay)
