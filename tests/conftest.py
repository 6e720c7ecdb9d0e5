"""Fixtures that all tests share."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.cli.shared import runnable_scenarios
from pytest_dvp.drive.run_spec import RunSpec

pytest_plugins = ["pytester"]

SKIP_LINES = 10  # of the summary: more than that nobody reads; chosen
_RARE = "rarer reasons, which -rs tells for a single file"
ROOT = Path(__file__).resolve().parents[1]
ASK = runnable_scenarios._ask


def pytest_configure(config: pytest.Config) -> None:
    """Declares the mark of tests that weigh much and guard what a lighter one guards nearly as well."""
    gc.disable()  # until all is collected: nothing that is imported or collected becomes garbage
    config.addinivalue_line(
        "markers",
        "nightly(by_day=0): runs in `make nightly` alone (DVP_NIGHTLY is set there); of a test with many parameters "
        "every `by_day`-th one runs by day, too",
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skips what is marked `nightly` by day."""
    if "DVP_NIGHTLY" in os.environ:
        return
    seen: dict[str, int] = {}
    for item in items:
        mark = item.get_closest_marker("nightly")
        if mark is None:
            continue
        by_day, test = mark.kwargs.get("by_day", 0), item.nodeid.partition("[")[0]
        seen[test] = seen.get(test, -1) + 1
        if not by_day or seen[test] % by_day:
            item.add_marker(pytest.mark.skip(reason="driven by make nightly"))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """All tests in a browser stay with one worker, as if they stood in one file: it starts one browser for them."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class WithOneBrowser(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return "tests/browser" if nodeid.startswith("tests/browser/") else super()._split_scope(nodeid)

    return WithOneBrowser(config, log)


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Takes modules and items out of what the garbage collector looks through: it need not, and there are millions.

    pytest collects garbage after each session, and so after each of the hundreds that our tests begin inside this one.
    """
    gc.freeze()
    gc.unfreeze = lambda: None  # which is what a drive by the wall clock ends with
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Skipped tests take one line a reason in the summary, not one a test, and no more than SKIP_LINES: there would be
    hundreds. A line names the file, or the folder of all that have its reason; the rarest reasons share the last line.
    """
    skipped = [report for report in terminalreporter.stats.get("skipped", []) if isinstance(report.longrepr, tuple)]
    by_reason: dict[str, list[Path]] = {}
    for report in skipped:
        path = terminalreporter.config.rootpath / report.longrepr[0]
        by_reason.setdefault(report.longrepr[2], []).append(path)
    often = sorted(by_reason, key=lambda reason: (-len(by_reason[reason]), reason))
    rare = often[SKIP_LINES - 1 :] if len(often) > SKIP_LINES else []
    by_reason[_RARE] = [path for reason in rare for path in by_reason[reason]]
    for report in skipped:
        reason = _RARE if report.longrepr[2] in rare else report.longrepr[2]
        report.longrepr = (os.path.commonpath(by_reason[reason]), None, reason)


@pytest.fixture(scope="session")
def shared_dir() -> Path:
    """Folder of reference material beside the checkout; the product never depends on it."""
    folder = Path(os.environ.get("DVP_SHARED", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no reference material at {folder} (set DVP_SHARED)")
    return folder


@pytest.fixture(scope="session")
def scenarios_dir() -> Path:
    """The scenarios that ship with the product."""
    return ROOT / "scenarios"


@pytest.fixture(autouse=True, scope="session")
def checks_in_this_process() -> Iterator[None]:
    """`dvp check` asks a process of its own which scenarios run; here this one answers, which has imported all of it.

    Tests of that process take the fixture `checks_in_a_child`.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runnable_scenarios, "_ask", answers_here)
        yield


def answers_here(files: Sequence[str], settings: RunSpec) -> dict[str, tuple[str, int | None]]:
    return runnable_scenarios._answers(runnable_scenarios._question(files, settings))


@pytest.fixture
def checks_in_a_child(monkeypatch: pytest.MonkeyPatch) -> None:
    """`dvp check` as a user has it."""
    monkeypatch.setattr(runnable_scenarios, "_ask", ASK)
