"""A report is a file that can be mailed: below 8 MB, however long the run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from reports.html import plotly_js, render_run_report

MakeRun = Callable[..., dict[str, Any]]


def test_library_cannot_end_its_script() -> None:
    assert "</script" not in plotly_js().lower()


def test_page_stays_below_8_mb(make_run: MakeRun) -> None:
    assert len(render_run_report(**make_run()).encode()) < 8_000_000


def test_long_run_with_much_traffic_stays_below_8_mb(make_run: MakeRun) -> None:
    run = make_run()
    t = np.arange(0.0, 600.0, 0.01)
    run["columns"] = {name: np.resize(values, len(t)) for name, values in run["columns"].items()} | {"t": t}
    ticks = np.arange(0.0, 600.0, 0.05)
    track = {name: np.random.default_rng(1).normal(size=len(ticks)) for name in ("x", "y", "yaw")}
    run["objects"] = [run["objects"][0] | track | {"name": f"car {i}", "t": ticks} for i in range(20)]
    assert len(render_run_report(**run).encode()) < 8_000_000
