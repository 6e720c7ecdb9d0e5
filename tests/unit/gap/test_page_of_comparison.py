"""The report page of a comparison: what it draws, and that a hostile name stays text."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.words.comparison_page import page_of
from reports.compare import groups_figure, path_figure, render_compare_report, time_figure
from reports.embed import ARRAYS
from reports.figures import sampled, thin


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    return page_of("drive.csv", compare(drive(brake_gain=0.85), baseline()))


def test_worst_signal_stands_on_top_of_the_groups(page: dict[str, Any]) -> None:
    chart = groups_figure(page["groups"], page["signals"])["data"][0]
    worst = max(page["signals"], key=lambda name: page["signals"][name]["chi2_per_n"])
    assert chart["y"][0] == worst


def test_groups_hold_regimes_and_speeds(page: dict[str, Any]) -> None:
    names = groups_figure(page["groups"], page["signals"])["data"][0]["x"]
    assert {"launch", "braking", "turn in"} <= set(names)
    assert any(name.endswith("m/s") for name in names)


def test_braking_error_stands_out_in_its_column(page: dict[str, Any]) -> None:
    assert (page["groups"]["braking"]["ax"] or 0.0) > 2.0 > (page["groups"]["launch"]["ax"] or 0.0)


def test_band_is_two_sigma_around_the_model(page: dict[str, Any]) -> None:
    figure = time_figure(page)
    band = next(trace for trace in figure["data"] if trace.get("fill") == "toself")
    first = band["y"].index(None)
    upper, lower = band["y"][0], band["y"][first - 1]
    titles = {"speed": "v", "yaw rate": "yaw_rate", "acceleration<br>along": "ax", "acceleration<br>across": "ay"}
    title = figure["layout"]["yaxis2"]["title"]["text"]
    name = next(name for label, name in titles.items() if title.startswith(label))
    assert upper - lower == pytest.approx(4.0 * page["signals"][name]["noise"], rel=0.02)


def test_all_rows_share_one_time_axis(page: dict[str, Any]) -> None:
    assert {trace["xaxis"] for trace in time_figure(page)["data"]} == {"x"}


def test_position_error_is_drawn_along_and_across_the_car(page: dict[str, Any]) -> None:
    rest = page["residuals"]
    known = np.isfinite(rest["along"])
    length = np.hypot(rest["x"], rest["y"])[known]
    assert np.hypot(rest["along"], rest["across"])[known] == pytest.approx(length)


def test_worst_points_of_the_path_lie_on_top(page: dict[str, Any]) -> None:
    traces = path_figure(page["t"], *page["position"], page["error"])["data"]
    (colours,) = (trace["marker"]["color"] for trace in traces if "colorbar" in trace.get("marker", {}))
    assert colours == sorted(colours)


def test_what_is_not_judged_is_no_noise_on_the_map(page: dict[str, Any]) -> None:
    error = np.where(page["t"] < 10.0, np.nan, page["error"])
    traces = path_figure(page["t"], *page["position"], error)["data"]
    (left_out,) = (trace for trace in traces if trace.get("name") == "not judged")
    (judged,) = (trace for trace in traces if "colorbar" in trace.get("marker", {}))
    assert all("not judged" in text for text in left_out["text"])
    assert len(left_out["x"]) > 0.9 * np.sum(page["t"] < 10.0) * len(judged["x"]) / np.isfinite(error).sum()


def test_a_pause_of_the_log_breaks_the_line_also_of_a_long_one() -> None:
    """A straight line over half a minute without rows had looked like a measurement."""
    t = np.concatenate([0.02 * np.arange(5000), 130.0 + 0.02 * np.arange(5000)])
    at, value = thin(*sampled(t, np.sin(t)), 400)
    assert len(at) < 450
    (pause,) = np.flatnonzero(np.isnan(value))
    assert at[pause] == pytest.approx(99.98)
    assert at[pause + 1] >= 130.0
    sparse = np.where(np.arange(10000) % 2, np.nan, 1.0)
    assert np.isnan(thin(np.arange(10000.0), sparse, 400)[1]).sum() <= 1  # holes between samples are no pauses


def test_a_slow_channel_is_drawn_as_a_line() -> None:
    t = np.arange(0.0, 10.0, 0.01)
    y = np.full(len(t), np.nan)
    y[::4] = 1.0
    y[(t > 4.0) & (t < 5.0)] = np.nan
    at, value = sampled(t, y)
    assert np.isnan(value).sum() == 1
    assert len(at) == np.isfinite(y).sum() + 1


def test_hostile_name_stays_text(page: dict[str, Any]) -> None:
    evil = "</script><img src=x onerror=alert(1)>"
    text = render_compare_report([{**page, "log": evil, "model": evil}])
    assert evil not in text
    assert "<img" not in text


def test_figures_are_json_without_nan(page: dict[str, Any]) -> None:
    text = render_compare_report([page])
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found is not None
    assert set(json.loads(found[1])) - {ARRAYS} == {"groups0", "path0", "time0"}


def test_log_without_positions_has_no_map() -> None:
    log = drive(20.0)
    for name in ("x", "y"):
        del log.columns[name]
    text = render_compare_report([page_of("a", compare(log, baseline()))])
    assert "On the map" not in text


def test_several_logs_share_a_page(page: dict[str, Any]) -> None:
    text = render_compare_report([page, {**page, "log": "second.csv"}])
    assert "second.csv" in text
    assert 'id="time1"' in text
