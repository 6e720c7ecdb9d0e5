"""The run report in a real browser: no error, no request, and one time for slider, table, charts and top view."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from reports.html import write_run_report

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "unit" / "reports")]
from chromium import Browser, find_chromium, opened  # noqa: E402
from synthetic_run import synthetic_run  # noqa: E402

READY = "document.body && document.body.dataset.ready === 'true' && !!document.querySelector('#chart .cartesianlayer')"
PIXELS = (
    "(() => { const c = document.getElementById('scene'); const d = c.getContext('2d')"
    ".getImageData(0, 0, c.width, c.height).data; let h = 0;"
    " for (let i = 0; i < d.length; i += 4) h = (h * 31 + d[i] + 3 * d[i + 1] + 7 * d[i + 2]) >>> 0; return h; })()"
)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on PATH")
    with Browser(program) as page:
        yield page


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run: dict[str, Any] = synthetic_run("FAIL")
    run["objects"][0]["name"] = "</script><img src=x onerror=document.title='owned'>"
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_run_report(path, **run)
    return path


@pytest.fixture
def page(browser: Browser, report: Path) -> Browser:
    browser.problems.clear()
    browser.requests.clear()
    browser.open(report, READY)
    return browser


@pytest.fixture(scope="module")
def untouched(report: Path) -> Iterator[Browser]:
    """The page as it opens, for tests that only look."""
    with opened(report, READY) as shown:
        yield shown


def move_slider(page: Browser, t: float) -> None:
    page.evaluate(
        f"(() => {{ const s = document.getElementById('time'); s.value = {t};"
        " s.dispatchEvent(new Event('input', {bubbles: true})); })()"
    )


def cursor_time(page: Browser) -> float:
    """Time [s] on the charts' axis at which their cursor stands."""
    return float(
        page.evaluate(
            "(() => { const x = document.getElementById('chart')._fullLayout.xaxis;"
            " return x.p2d(parseFloat(document.getElementById('cursor').style.left) - x._offset); })()"
        )
    )


def test_opens_without_an_error(untouched: Browser) -> None:
    assert untouched.problems == []


def test_asks_for_nothing_but_itself(untouched: Browser, report: Path) -> None:
    assert untouched.requests == [report.resolve().as_uri()]


def test_opens_at_the_worst_moment(untouched: Browser) -> None:
    assert untouched.evaluate("document.body.dataset.time") == "15.40"


def test_slider_moves_charts_and_top_view(page: Browser) -> None:
    before = page.evaluate(PIXELS)
    move_slider(page, 30.0)
    assert page.evaluate("document.getElementById('now').textContent") == "30.00 s"
    assert cursor_time(page) == pytest.approx(30.0, abs=0.02)
    assert page.evaluate(PIXELS) != before


def test_time_in_the_table_moves_the_slider(page: Browser) -> None:
    page.evaluate("document.querySelector('button.jump[data-t=\"13.62\"]').click()")
    assert page.evaluate("Number(document.getElementById('time').value)") == pytest.approx(13.62)


def test_click_on_the_chart_moves_the_time(page: Browser) -> None:
    x, y = page.evaluate(
        "(() => { const c = document.getElementById('chart'); c.scrollIntoView(); const b = c.getBoundingClientRect();"
        " const x = c._fullLayout.xaxis; return [b.left + x._offset + x.d2p(25), b.top + 120]; })()"
    )
    page.click(x, y)
    assert float(page.evaluate("document.body.dataset.time")) == pytest.approx(25.0, abs=0.2)


def test_play_lets_time_pass(page: Browser) -> None:
    move_slider(page, 1.0)
    page.evaluate("document.getElementById('play').click()")
    page.evaluate(
        "new Promise((done) => { const look = () => Number(document.body.dataset.time) > 1.2 ? done(1)"
        " : requestAnimationFrame(look); look(); })"
    )
    page.evaluate("document.getElementById('play').click()")
    assert page.evaluate("document.getElementById('play').textContent") == "▶ Play"


def test_dark_page_redraws_the_top_view(page: Browser) -> None:
    page.set_colours("light")
    light = page.evaluate(PIXELS)
    page.set_colours("dark")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert page.evaluate(PIXELS) != light
    page.set_colours("light")


def test_markup_in_a_name_is_not_obeyed(untouched: Browser) -> None:
    assert untouched.evaluate("document.images.length") == 0
    assert "owned" not in untouched.evaluate("document.title")


@pytest.mark.parametrize(
    ("events", "t", "first", "last"),
    [
        ([], 4.0, 20.0, 100.0),  # from the car onward
        ([{"kind": "goal"}], 4.0, 20.0, 50.0),  # a path that runs on beyond its goal ends where the ego stopped
        ([{"kind": "goal"}], 10.0, 50.0, 50.0),
    ],
)
def test_the_planned_path_is_drawn_from_the_car_onward(
    untouched: Browser, events: list[dict[str, str]], t: float, first: float, last: float
) -> None:
    ego = {"t": [0.0, 10.0], "x": [0.0, 50.0], "y": [0.0, 0.0], "yaw": [0.0, 0.0]}
    ahead = untouched.evaluate(
        f"View.prototype.ahead.call({{data: {{ego: {ego}, events: {events}}}, along: View.prototype.along}},"
        f" [[-5, 0], [30, 0], [100, 0]], 0.0, {t})"
    )
    assert (ahead[0][0], ahead[-1][0]) == pytest.approx((first, last))


def test_a_path_that_the_car_has_left_is_not_drawn(untouched: Browser) -> None:
    ego = {"t": [0.0, 10.0], "x": [0.0, 50.0], "y": [0.0, 20.0], "yaw": [0.0, 0.0]}
    call = f"View.prototype.ahead.call({{data: {{ego: {ego}, events: []}}, along: View.prototype.along}}"
    assert untouched.evaluate(f"{call}, [[-5, 0], [100, 0]], 0.0, 8.0)") == []


def test_a_path_that_passes_a_place_twice_is_followed(untouched: Browser) -> None:
    # Round a block and over the start again: after 8 s the car is at x = 5 for the second time.
    ego = {"t": [0, 2, 4, 6, 8], "x": [5, 20, 20, 0, 5], "y": [0, 0, 20, 20, 0], "yaw": [0, 0, 1.6, 3.1, 0]}
    call = f"View.prototype.along.call({{data: {{ego: {ego}}}}}, [[0, 0], [20, 0], [20, 20], [0, 20], [0, 0], [40, 0]]"
    assert [untouched.evaluate(f"{call}, 0.0, {t}).i") for t in (0.0, 8.0)] == [0, 4]
