"""The fixtures `run` and `gate`, and what a test's runs leave in its report.

Imports the standard library and pytest only; a session without scenarios loads nothing more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import pytest

from pytest_dvp.settings import Settings

if TYPE_CHECKING:
    from pytest_dvp.fuzz import Variant
    from pytest_dvp.run import RunResult

SETTINGS_KEY = pytest.StashKey[Settings]()
ITEM_KEY = pytest.StashKey[pytest.Item]()
RESULTS_KEY = pytest.StashKey[list["dict[str, Any]"]]()


class GateFailed(AssertionError):
    """A run whose verdict is not PASS. The first line says why in one sentence, the last how to replay it."""

    def __init__(self, message: str, result: Mapping[str, Any]) -> None:
        super().__init__(message)
        self.result = dict(result)


class Run(Protocol):
    """What the fixture `run` gives: a factory of finished runs."""

    def __call__(self, scenario: str | Path | Variant, **options: Any) -> RunResult: ...


class Gate(Protocol):
    """What the fixture `gate` gives: raises GateFailed unless every verdict of the run is PASS."""

    def __call__(self, result: RunResult, metrics: Sequence[str] | None = None) -> None: ...


# Session scope: the factory keeps nothing between calls, and so `@given` may use it without complaint.
@pytest.fixture(scope="session")
def run(request: pytest.FixtureRequest) -> Run:
    """Factory: `run("overtaking.xosc", parameters={...})` drives the scenario and returns its RunResult.

    A relative path starts at the test's own folder, else at the rootdir, else at a folder of `dvp_scenarios`. Takes
    every option of `pytest_dvp.run`; the session's `--dvp-*` settings are the defaults.
    """
    from pytest_dvp.session import Session

    return Session(request.config).run


@pytest.fixture(scope="session")
def gate(request: pytest.FixtureRequest) -> Gate:
    """Judge: `gate(result)` raises unless all verdicts are PASS; `metrics=[...]` looks at those gates only."""
    config = request.config

    def judge(result: RunResult, metrics: Sequence[str] | None = None) -> None:
        __tracebackhide__ = True
        from pytest_dvp.summary import failure

        plain = result.as_dict()
        message = failure(plain, metrics)
        if message is not None:
            note(current_item(config), plain)
            raise GateFailed(message, plain)

    return judge


def settings_of(config: pytest.Config) -> Settings:
    """The session's settings, as the plugin read them."""
    return config.stash[SETTINGS_KEY]


def current_item(config: pytest.Config) -> pytest.Item:
    """The test that runs now."""
    return config.stash[ITEM_KEY]


def note(node: pytest.Item, result: Mapping[str, Any]) -> None:
    """Remember a run of this test; only the last one of a scenario and stage counts (Hypothesis runs many)."""
    results = node.stash.setdefault(RESULTS_KEY, [])
    results[:] = [r for r in results if (r["scenario"], r["stage"]) != (result["scenario"], result["stage"])]
    results.append(dict(result))


def attach(item: pytest.Item, call: pytest.CallInfo[None], report: pytest.TestReport) -> None:
    """Put the numbers of a test's runs into its report: scalars for JUnit, the verdicts for the summary."""
    results = item.stash.get(RESULTS_KEY, [])
    if report.when != "call" or not results:
        return
    report.dvp = results  # type: ignore[attr-defined]
    prefix = len(results) > 1
    for result in results:
        head = f"{Path(result['scenario']).stem}." if prefix else ""
        numbers = [("verdict", result["status"]), ("seed", result["seed"]), ("stage", result["stage"])]
        numbers += [(name, value) for name, value in sorted(result["metrics"].items()) if value is not None]
        item.user_properties.extend((head + name, value) for name, value in numbers)
    report.user_properties[:] = item.user_properties
    failed = call.excinfo.value if call.excinfo is not None else None
    if isinstance(failed, GateFailed) and not hasattr(item, "dvp_stage") and report.longrepr is not None:
        # Hypothesis adds its own lines below the message, and what to do next must come last.
        report.longrepr.addsection("replay", failed.result["replay"])  # type: ignore[union-attr]
