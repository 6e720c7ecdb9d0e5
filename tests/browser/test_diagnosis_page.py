"""The page of a diagnosis in a real browser: no error, no request, every figure drawn, nothing too wide."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from reports.diagnosis import write_diagnosis_report

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "unit" / "reports")]
from chromium import Browser, opened  # noqa: E402
from test_diagnosis_report import effect, page  # noqa: E402

READY = "document.body && document.body.dataset.ready === 'true' && !!document.querySelector('#time0 .cartesianlayer')"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("diagnosis") / "diagnosis.html"
    rivals = [{"name": "steer_lag", "physics": "a lag"}, {"name": "tyre_relaxation", "physics": "a length"}]
    name = "</script><img src=x onerror=document.title='owned'>"
    given = page(model=name, effects=[effect(name, rivals=rivals)])
    three = [{**given["signals"][0], "name": signal} for signal in ("yaw_rate", "ay", "v")]
    write_diagnosis_report(path, {**given, "signals": three, "tiles": ["yaw_rate", "ay", "v"]})
    return path


@pytest.fixture(scope="module")
def shown(report: Path) -> Iterator[Browser]:
    with opened(report, READY) as browser:
        yield browser


def test_opens_without_an_error(shown: Browser) -> None:
    assert shown.problems == []


def test_asks_for_nothing_but_itself(shown: Browser, report: Path) -> None:
    assert shown.requests == [report.resolve().as_uri()]


def test_hostile_name_did_not_run(shown: Browser) -> None:
    assert shown.evaluate("document.images.length") == 0
    assert shown.evaluate("document.title") != "owned"


@pytest.mark.parametrize("figure", ["close", "ladder", "time0"])
def test_figure_is_drawn(shown: Browser, figure: str) -> None:
    assert shown.evaluate(f"document.getElementById('{figure}').querySelectorAll('.trace').length") > 0


def test_the_bracket_reaches_from_the_effect_to_its_last_rival(shown: Browser) -> None:
    """The bracket is drawn around the effect and both rivals, not around its own words."""
    inside = (
        "(() => { const box = (s) => document.querySelector(s).getBoundingClientRect();"
        " const b = box('.bracket div'), rows = [...document.querySelectorAll('tr.rival .name')];"
        " const last = rows[rows.length - 1].getBoundingClientRect();"
        " return [b.top <= box('.effects .name').bottom, b.bottom >= last.top]; })()"
    )
    assert shown.evaluate(inside) == [True, True]


def test_nothing_is_wider_than_the_page(shown: Browser) -> None:
    assert shown.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")


@pytest.mark.parametrize("width", [1000, 1200, 1600])
def test_a_value_and_its_unit_stand_in_one_line_inside_their_card(shown: Browser, width: int) -> None:
    shown.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
    whole = (
        "[...document.querySelectorAll('.tiles b')].map(b => { const card = b.parentElement.getBoundingClientRect();"
        " const r = document.createRange(); r.selectNodeContents(b); const words = r.getBoundingClientRect();"
        " return words.height < 2 * parseFloat(getComputedStyle(b).fontSize) && words.right <= card.right; })"
    )
    assert set(shown.evaluate(whole)) == {True}
