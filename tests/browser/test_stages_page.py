"""The page of stages in a real browser: no error, no request, table and figures there, names from files inert."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from reports.stages import write_stages_report

sys.path[:0] = [str(Path(__file__).parent)]
from chromium import Browser, opened  # noqa: E402

READY = "document.body && document.body.dataset.ready === 'true'"
NAME = "</script><img src=x onerror=document.title='owned'>"


def verdict(status: str, name: str) -> dict[str, object]:
    return {"gate": f"{name} <= 0.02 m", "metric": name, "name": name, "status": status, "value": 0.03, "bound": 0.02,
            "unit": "m", "margin": -0.01, "t": 3.0, "object": NAME, "message": NAME, "short": NAME, "file": NAME,
            "line": 3}  # fmt: skip


def cells(*texts: str) -> list[dict[str, object]]:
    return [{"value": 1.0, "text": text, "reason": ""} for text in texts]


def write_stages(path: Path) -> None:
    """A page of three stages with names that no browser may obey."""
    t = np.arange(0.0, 20.0, 0.01)
    courses = {
        stage: {"t": t, "x": 5.0 * t, "y": np.sin(t) + k, "v": 5.0 + 0.1 * k * np.sin(t), "steer": 0.1 * np.cos(t)}
        for k, stage in enumerate(("dt", "pe-surrogate", "rw-surrogate"))
    }
    table = {
        "stages": list(courses),
        "against": ["", "dt", "pe-surrogate"],
        "rows": [
            {"name": "ego x", "metric": "mncc", "signal": "x", "unit": "-", "cells": cells("-", "1.0", "0.9")},
            {"name": "max jerk", "metric": "max_jerk", "signal": "", "unit": "m/s^3", "cells": cells("1", "2", "3")},
        ],
    }
    result = {
        "status": "FAIL", "scenario": NAME, "stage": "dt-rw-surrogate", "seed": 7, "notes": [NAME],
        "verdicts": [verdict("FAIL", "twin_error"), verdict("PASS", "path_distance")],
        "table": table, "logs": {"dt": NAME}, "replay": NAME,
    }  # fmt: skip
    write_stages_report(path, result, courses)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stages") / "report.html"
    write_stages(path)
    return path


@pytest.fixture(scope="module")
def page(report: Path) -> Iterator[Browser]:
    with opened(report, READY) as browser:
        yield browser


def test_opens_without_an_error_and_asks_for_nothing_but_itself(page: Browser, report: Path) -> None:
    assert page.problems == []
    assert [request for request in page.requests if not request.startswith("data:")] == [report.resolve().as_uri()]


def test_hostile_names_did_not_run(page: Browser) -> None:
    assert page.evaluate("document.title") != "owned"


def test_verdict_and_table_are_read(page: Browser) -> None:
    assert "FAIL" in page.evaluate("document.getElementById('verdict').textContent")
    assert page.evaluate("document.querySelectorAll('#stages tbody tr').length") == 2
    heads = page.evaluate("document.querySelector('#stages thead').textContent")
    assert "rw-surrogate to pe-surrogate" in heads


@pytest.mark.parametrize(("figure", "lines"), [("path", 3), ("time", 6)])
def test_each_stage_is_drawn(page: Browser, figure: str, lines: int) -> None:
    assert page.evaluate(f"document.getElementById('{figure}').querySelectorAll('.trace').length") == lines


def test_nothing_is_wider_than_the_page(page: Browser) -> None:
    assert page.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")


def test_without_logs_the_page_says_what_was_judged(tmp_path: Path) -> None:
    result = {"status": "INCONCLUSIVE", "scenario": "s", "stage": "dt-rw", "seed": 7, "verdicts": [], "table": None}
    write_stages_report(tmp_path / "report.html", result, {})
    assert "No gate was judged." in (tmp_path / "report.html").read_text()
