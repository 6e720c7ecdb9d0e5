"""Pages beside the library that they share, and without it; the numbers that a page's scripts read."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reports.embed import compact
from reports.frame import library_address, place_library
from reports.html import write_run_report

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "unit" / "reports")]
from chromium import Browser, opened  # noqa: E402
from synthetic_run import synthetic_run  # noqa: E402

READY = "document.body && document.body.dataset.ready === 'true'"
MISSING = "(() => { const p = document.getElementById('missing'); return !p || p.hidden ? '' : p.textContent; })()"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    (folder / "0001-x-dt").mkdir()
    run: dict[str, Any] = synthetic_run()
    write_run_report(folder / "0001-x-dt" / "report.html", **run, library=library_address())
    place_library(folder)
    return folder


@pytest.fixture(scope="module")
def page(runs: Path) -> Iterator[Browser]:
    with opened(runs / "0001-x-dt" / "report.html", READY) as browser:
        yield browser


@pytest.mark.nightly
def test_charts_are_drawn_by_the_library_beside_the_run_folder(page: Browser, runs: Path) -> None:
    assert page.problems == []
    files = [runs / "0001-x-dt" / "report.html", next((runs / "assets").iterdir())]
    assert page.requests == [file.resolve().as_uri() for file in files]
    assert page.evaluate("document.querySelectorAll('#chart .trace').length") > 5
    assert page.evaluate(MISSING) == ""


def test_a_script_without_the_nonce_does_not_run(page: Browser, runs: Path) -> None:
    """The policy allows one file, not its folder: markup that got into the page would still be inert."""
    (runs / "assets" / "other.js").write_text("document.title = 'owned';")
    added = (
        "new Promise((done) => { const script = document.createElement('script'); script.src = '../assets/other.js';"
        " script.onload = () => done('ran'); script.onerror = () => done('refused'); document.head.append(script); })"
    )
    assert page.evaluate(added) == "refused"
    inline = "const script = document.createElement('script'); script.textContent = \"document.title = 'owned'\";"
    page.evaluate(f"(() => {{ {inline} document.head.append(script); }})()")
    assert page.evaluate("document.title") != "owned"


def test_every_number_is_read_as_it_was_written(page: Browser) -> None:
    noise = np.random.default_rng(5).normal(size=300)
    data = {"t": np.round(np.arange(300) * 0.01 + 123.0, 3).tolist(), "gaps": [None, *np.round(noise, 4).tolist()],
            "fine": noise.tolist(), "nested": [[1.5, None]] * 40, "short": [0.1]}  # fmt: skip
    text = json.dumps(compact(data))
    put = f"document.getElementById('data').textContent = {json.dumps(text)}"
    assert page.evaluate(f"(async () => {{ {put}; return await contents(); }})()") == data


def test_without_the_library_the_page_says_so_and_shows_all_else(runs: Path, tmp_path: Path) -> None:
    shutil.copytree(runs / "0001-x-dt", tmp_path / "0001-x-dt")
    with opened(tmp_path / "0001-x-dt" / "report.html", READY) as alone:
        said = alone.evaluate(MISSING)
        assert "plotly" in said
        assert "dvp report FOLDER --single-file" in said
        assert alone.evaluate("document.querySelectorAll('table.verdicts tbody tr').length") == 6
        assert alone.evaluate("document.getElementById('now').textContent") == "15.40 s"


def test_figures_are_there_when_the_page_counts_as_loaded(runs: Path) -> None:
    page = runs / "0001-x-dt" / "report.html"
    with opened(page, READY) as old:
        seen = "addEventListener('load', () => { window.atLoad = document.querySelectorAll('.trace').length; });"
        old.call("Page.addScriptToEvaluateOnNewDocument", source=f"delete globalThis.DecompressionStream; {seen}")
        old.open(page, "window.atLoad !== undefined")
        assert old.evaluate("window.atLoad") > 0
