"""A report beside its shared library has at most 400 kB, however long the run; one that stands alone can be mailed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reports.frame import plotly_js
from reports.html import render_run_report

MakeRun = Callable[..., dict[str, Any]]
SHARED = "../assets/plotly.min.js"
MOST = 400_000  # bytes of a page beside its library
ALONE = 2_600_000  # bytes of a page with it


def lengthened(run: dict[str, Any], seconds: float, cars: int) -> dict[str, Any]:
    """The run, `seconds` long, its courses noisy and `cars` vehicles around it that nothing but noise moves."""
    noise = np.random.default_rng(1)
    t, ticks = np.arange(0.0, seconds, 0.01), np.arange(0.0, seconds, 0.05)
    columns = {name: np.resize(values, len(t)) for name, values in run["columns"].items()}
    for name in ("v", "steer", "ax", "steer_cmd", "accel_cmd", "ads.x", "ads.y"):
        columns[name] = columns[name] + noise.normal(0.0, 0.02, len(t))
    drive = {name: np.cumsum(noise.normal(0.0, 0.1, len(ticks))) for name in ("x", "y", "yaw")}
    detected = {name: np.resize(values, 4 * len(ticks)) for name, values in run["detections"].items() if name != "kind"}
    detected |= {"t": np.repeat(ticks, 4), "x": noise.normal(size=4 * len(ticks)), "kind": ("car",) * 4 * len(ticks)}
    objects = [run["objects"][1] | drive | {"name": f"car {i}", "t": ticks} for i in range(cars)]
    return {**run, "columns": columns | {"t": t}, "objects": objects, "detections": detected}


def test_library_cannot_end_its_script() -> None:
    assert "</script" not in plotly_js().lower()


def test_page_that_stands_alone_can_be_mailed(make_run: MakeRun) -> None:
    assert len(render_run_report(**make_run()).encode()) < ALONE


@pytest.mark.nightly
@pytest.mark.parametrize(("seconds", "cars"), [(300.0, 4), (600.0, 6)])
def test_page_beside_its_library_stays_below_400_kb(make_run: MakeRun, seconds: float, cars: int) -> None:
    run = lengthened(make_run(), seconds, cars)
    assert len(render_run_report(**run, library=SHARED).encode()) <= MOST
