"""Every page on a telephone, on half a window and on a whole one: nothing runs off, no word a line."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.tuning.iteration_page import iterate_page
from reports.diagnosis import write_diagnosis_report
from reports.html import write_run_report
from reports.mcrpg import write_mcrpg_report

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), *(str(HERE.parent / "unit" / room) for room in ("reports", "tuning"))]
from chromium import Browser, find_chromium  # noqa: E402
from synthetic_run import synthetic_run  # noqa: E402
from test_compare_page import write_compared  # noqa: E402
from test_diagnosis_report import effect, page  # noqa: E402
from test_page import document  # noqa: E402
from test_stages_page import write_stages  # noqa: E402

REDRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
READY = "document.body && document.body.dataset.ready === 'true'"
# What reaches beyond the card that it stands in, unless the card lets it be scrolled.
BEYOND = """(() => "td th p button".split(" ").flatMap((tag) => [...document.querySelectorAll("main section " + tag)])
  .filter((each) => !each.closest(".wide"))
  .filter((each) => each.getBoundingClientRect().right > each.closest("section").getBoundingClientRect().right + 1)
  .map((each) => each.textContent.slice(0, 40)))()"""
# Words a line of the heading and of the paragraphs under it, the least of all.
WORDS = r"""(() => Math.min(...[...document.querySelectorAll("header h1, header p")].map((each) => {
  const range = document.createRange(); range.selectNodeContents(each);
  const lines = range.getBoundingClientRect().height / parseFloat(getComputedStyle(each).lineHeight);
  const words = each.textContent.trim().split(/\s+/).length;
  return words < 6 ? 99 : words / Math.max(Math.round(lines), 1); })))()"""


def run_page(path: Path) -> None:
    run: dict[str, Any] = synthetic_run("FAIL")
    words = "dvp run scenarios/pedestrian_crossing.xosc --seed 7 --ads my_package.my_stack:Stack --set P.LQR_q11=30"
    run["result"] |= {"ads": "my_package.my_stack:Stack", "replay": words, "notes": ["an event never fired"]}
    write_run_report(path, **run)


def diagnosis_page(path: Path) -> None:
    rivals = [{"name": "steer_lag", "physics": "a lag"}, {"name": "tyre_relaxation", "physics": "a length"}]
    write_diagnosis_report(path, page(effects=[effect("steer_delay", rivals=rivals)]))


def iterate(path: Path) -> None:
    write_mcrpg_report(path, iterate_page(document()))


PAGES = {"run": run_page, "diagnosis": diagnosis_page, "iterate": iterate, "compare": write_compared,
         "stages": write_stages}  # fmt: skip


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on PATH")
    with Browser(program) as shown:
        yield shown


@pytest.mark.parametrize("name", PAGES)
@pytest.mark.nightly(by_day=4)
def test_nothing_runs_off_the_page_or_stands_a_word_a_line(browser: Browser, name: str, tmp_path: Path) -> None:
    PAGES[name](tmp_path / "page.html")
    browser.open(tmp_path / "page.html", READY)
    for width in (390, 768, 1400):
        browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        browser.evaluate(REDRAWN)
        assert browser.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth"), width
        assert browser.evaluate(BEYOND) == [], width
        assert browser.evaluate(WORDS) >= 2.0, width
