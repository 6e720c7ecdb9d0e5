"""The page of an iteration in a real browser: no error, no request, every figure drawn."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_dvp.tuning.iteration_page import iterate_page
from reports.mcrpg import write_mcrpg_report

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "unit" / "tuning")]
from chromium import Browser, opened  # noqa: E402
from test_page import document  # noqa: E402

READY = "document.body && document.body.dataset.ready === 'true'"


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    path = tmp_path_factory.mktemp("mcrpg") / "report.html"
    write_mcrpg_report(path, iterate_page(document()))
    with opened(path, READY) as browser:
        yield browser


def test_opens_without_an_error_and_asks_for_nothing(shown: Browser) -> None:
    assert shown.problems == []
    assert [r for r in shown.requests if not r.startswith("data:")] == shown.requests[:1]  # a heat map is an image


def test_hostile_name_did_not_run(shown: Browser) -> None:
    assert shown.evaluate("document.images.length") == 0
    assert shown.evaluate("document.title") != "owned"


@pytest.mark.parametrize("figure", ["twin", "likeness", "tunedP", "sensitivity"])
def test_figure_is_drawn(shown: Browser, figure: str) -> None:
    drawn = f"document.getElementById('{figure}').querySelectorAll('.trace, .hm').length"
    assert shown.evaluate(drawn) > 0


def test_nothing_is_wider_than_the_window(shown: Browser) -> None:
    assert shown.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
