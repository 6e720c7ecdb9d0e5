"""Figures as dicts: plotly accepts them, and thinning loses no extreme."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import plotly.graph_objects as go

from reports.figures import is_shown, numbers, place_intervals, thin, timeline

MakeRun = Callable[..., dict[str, Any]]


def test_plotly_accepts_the_timeline(make_run: MakeRun) -> None:
    run = make_run()
    series = run["result"]["metrics"]["max_ttc_inverse"]["series"]
    figure = timeline(run["columns"], ttc_inverse=series, ttc_bound=0.5, events=run["events"])
    go.Figure(figure)  # raises on an unknown property or value


def test_thinning_keeps_a_single_spike() -> None:
    t = np.arange(100_000) * 0.01
    y = np.zeros_like(t)
    y[54_321] = 7.0
    kept_t, kept_y = thin(t, y, 1000)
    assert len(kept_t) <= 1000 + 2
    assert kept_y.max() == 7.0
    assert kept_t[kept_y.argmax()] == t[54_321]


def test_thinning_leaves_short_curves_alone() -> None:
    t = np.arange(10.0)
    assert thin(t, t * 2, 10)[1].tolist() == (t * 2).tolist()


def test_thinning_keeps_gaps_out_of_the_extremes() -> None:
    y = np.full(1000, np.nan)
    y[500] = -3.0
    assert np.nanmin(thin(np.arange(1000.0), y, 100)[1]) == -3.0


def test_what_is_not_finite_is_none() -> None:
    assert numbers([1.0, np.nan, np.inf, -0.0]) == [1.0, None, None, 0.0]


def test_places_become_intervals_in_seconds() -> None:
    t = np.arange(0.0, 1.0, 0.1)
    active = np.array([0, 0, 1, 1, 1, 0, 0, 1, 1, 1], dtype=float)
    columns = {"t": t, "ads.net.crossing.wait": active}
    spans = [(net, place, round(a, 3), round(b, 3)) for net, place, a, b in place_intervals(columns)]
    assert spans == [("crossing", "wait", 0.2, 0.5), ("crossing", "wait", 0.7, 0.9)]


def test_places_active_together_get_rows_of_their_own() -> None:
    t = np.arange(0.0, 1.0, 0.1)
    columns = {"t": t, "v": t, "ads.net.n.a": np.ones(10), "ads.net.n.b": np.ones(10)}
    bars = next(trace for trace in timeline(columns)["data"] if trace["type"] == "bar")
    assert len(set(bars["y"])) == 2


def test_only_firing_storyboard_events_are_marked() -> None:
    fired = {"kind": "story.event", "text": "standbyState -> runningState"}
    ended = {"kind": "story.event", "text": "runningState -> completeState"}
    assert is_shown(fired)
    assert not is_shown(ended)


def legend(figure: dict[str, Any]) -> list[str]:
    return [trace["name"] for trace in figure["data"] if trace.get("showlegend")]


def test_the_legend_names_the_two_kinds_of_line_once(make_run: MakeRun) -> None:
    assert legend(timeline(make_run()["columns"])) == ["wanted by the ADS", "driven"]


def test_the_legend_is_silent_on_what_a_stack_never_sent() -> None:
    t = np.arange(10.0)
    assert legend(timeline({"t": t, "v": t, "ads.target_speed": t * np.nan})) == ["driven"]


def test_a_stack_without_target_speed_still_has_its_commands_in_the_legend() -> None:
    t = np.arange(10.0)
    assert legend(timeline({"t": t, "v": t, "steer_cmd": t})) == ["driven", "wanted by the ADS"]


def test_an_acceleration_that_a_stack_of_pedals_leaves_at_zero_is_not_drawn() -> None:
    t = np.arange(10.0)
    columns = {"t": t, "v": t, "ax": t, "accel_cmd": 0 * t, "throttle_cmd": 0.1 * t, "brake_cmd": 0 * t}
    assert legend(timeline(columns)) == ["driven"]
    assert legend(timeline(columns | {"throttle_cmd": 0 * t})) == ["driven", "wanted by the ADS"]


def test_an_empty_row_gets_no_room() -> None:
    t = np.arange(10.0)
    never = {"t": t, "value": 0 * t}
    figure = timeline({"t": t, "v": t}, ttc_inverse=never, ttc_bound=0.5)
    shown = [name for name, axis in figure["layout"].items() if name.startswith("yaxis") and axis.get("visible", True)]
    assert shown == ["yaxis2"]
    assert figure["layout"]["shapes"] == []


# A car that comes nearer from 100 m at 10 m/s and is struck after 10 s; the sensor of a contact reads 100 1/s.
T = np.arange(0.0, 12.0, 0.05)
APPROACH = {"t": T, "value": np.where(T < 9.99, 1.0 / np.maximum(10.0 - T, 0.01), 100.0)}
STRUCK = [{"t": 10.0, "kind": "collision", "element": "Ego", "text": "Target"}]


def ttc_row(series: dict[str, Any], bound: float, events: list[dict[str, Any]]) -> tuple[dict[str, Any], Any]:
    """Axis of the row of 1/TTC, and the marks beyond it, if there are any."""
    figure = timeline({"t": T, "v": T}, ttc_inverse=series, ttc_bound=bound, events=events)
    go.Figure(figure)
    marks = [trace for trace in figure["data"] if trace["yaxis"] == "y5" and "markers" in trace["mode"]]
    return figure["layout"]["yaxis5"], next(iter(marks), None)


def test_a_collision_leaves_room_for_bound_and_approach_and_is_marked() -> None:
    axis, marks = ttc_row(APPROACH, 0.5, STRUCK)
    low, high = axis["range"]
    assert low == 0.0
    assert 0.5 / high > 0.15  # the bound stands well above the zero line
    assert "cut at 2" in axis["title"]["text"]
    assert (marks["x"], marks["marker"]["symbol"]) == ([10.0], ["x"])
    assert marks["text"] == ["collision, up to 100 1/s"]
    assert low < marks["y"][0] < high


def test_a_near_miss_beyond_the_axis_says_how_near() -> None:
    near = {"t": T, "value": np.where(abs(T - 6.0) < 0.06, 5.0, 0.1)}
    axis, marks = ttc_row(near, 0.5, [])
    assert "cut at 2" in axis["title"]["text"]
    assert (marks["text"], marks["marker"]["symbol"]) == (["up to 5 1/s"], ["triangle-up"])


def test_a_course_below_the_cut_keeps_its_own_axis() -> None:
    axis, marks = ttc_row({"t": T, "value": np.full(len(T), 1.6)}, 0.5, [])
    assert "range" not in axis
    assert "cut" not in axis["title"]["text"]
    assert marks is None


def test_a_high_bound_stays_on_the_axis() -> None:
    axis, _ = ttc_row(APPROACH, 4.0, STRUCK)
    assert axis["range"][1] > 4.0
