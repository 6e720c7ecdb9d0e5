"""The comparison page in a real browser: no error, no request, every figure drawn, zoom linked."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.words.comparison_page import page_of
from reports.compare import write_compare_report

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "unit" / "gap")]
from chromium import Browser, opened  # noqa: E402
from gap_logs import baseline, drive  # noqa: E402

READY = "document.body && document.body.dataset.ready === 'true' && !!document.querySelector('#time0 .cartesianlayer')"


def write_compared(path: Path) -> None:
    """A page of one log with a name that no browser may obey."""
    name = "</script><img src=x onerror=document.title='owned'>"
    write_compare_report(path, [page_of(name, compare(drive(brake_gain=0.85), baseline()))])


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("compare") / "compare.html"
    write_compared(path)
    return path


@pytest.fixture(scope="module")
def page(report: Path) -> Iterator[Browser]:
    with opened(report, READY) as browser:
        yield browser


def test_opens_without_an_error(page: Browser) -> None:
    assert page.problems == []


def test_asks_for_nothing_but_itself(page: Browser, report: Path) -> None:
    foreign = [request for request in page.requests if not request.startswith("data:")]  # plotly paints a heat map so
    assert foreign == [report.resolve().as_uri()]


def test_hostile_name_did_not_run(page: Browser) -> None:
    assert page.evaluate("document.title") != "owned"


@pytest.mark.parametrize("figure", ["groups0", "path0", "time0"])
def test_figure_is_drawn(page: Browser, figure: str) -> None:
    assert page.evaluate(f"document.getElementById('{figure}').querySelectorAll('.trace, .hm').length") > 0


def test_nothing_is_wider_than_the_page(page: Browser) -> None:
    assert page.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
