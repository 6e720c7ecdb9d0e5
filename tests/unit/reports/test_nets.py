"""Drawings of nets and the rows of what the stack believed."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

from reports.beliefs import belief_rows
from reports.figures import place_shares, timeline
from reports.html import render_run_report
from reports.nets import RADIUS, SLOT, Bar, drawings

LIGHT: dict[str, Any] = {
    "name": "light",
    "parent": "main.drive",
    "initial": ["go"],
    "places": {"go": "nothing", "stop": "stop at the signal", "wait": "wait"},
    "transitions": [
        {"name": "red", "take": ["go"], "give": ["stop"], "when": ["is_red"], "unless": ["too_late"]},
        {"name": "green", "take": ["stop"], "give": ["go"], "when": [], "unless": ["is_red"]},
        {"name": "off", "take": ["wait"], "give": ["go"], "when": [], "unless": []},
    ],
}


def ends(bar: Bar) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """First and last point of every arc."""
    numbers = [[float(n) for n in re.findall(r"-?\d+\.\d+", arc)] for arc, _ in bar.arcs]
    return [((n[0], n[1]), (n[-2], n[-1])) for n in numbers]


def test_arcs_lead_from_the_place_taken_to_the_place_given() -> None:
    (net,) = drawings([LIGHT], {})
    y = {place.name: place.y for place in net.places}
    red = next(bar for bar in net.bars if bar.name == "red")
    (take, give), heads = ends(red), [arrow for _, arrow in red.arcs]
    assert (take[0][1], give[1][1]) == (y["go"], y["stop"])
    assert (take[1][0], give[0][0]) == (red.x - 3.0, red.x - 3.0)
    assert heads == [False, True]


def test_what_leads_back_stands_on_the_other_side() -> None:
    (net,) = drawings([LIGHT], {})
    assert {bar.name: bar.anchor for bar in net.bars} == {"red": "start", "green": "end", "off": "end"}


def test_words_and_circles_never_cover_each_other() -> None:
    many = [{"name": f"t{i}", "take": ["go"], "give": ["stop"], "when": [], "unless": []} for i in range(12)]
    (net,) = drawings([LIGHT | {"transitions": many}], {})
    heights = sorted(bar.y for bar in net.bars)
    assert min(np.diff(heights)) >= SLOT - 1e-9
    assert min(np.diff([place.y for place in net.places])) > 2.0 * RADIUS
    assert heights[-1] < net.height


def test_the_guard_is_in_words() -> None:
    (net,) = drawings([LIGHT], {})
    assert next(bar for bar in net.bars if bar.name == "red").guard == ("is red and not too late",)


def test_places_tell_their_share_of_the_time() -> None:
    columns = {"t": np.arange(4.0), "ads.net.light.go": np.array([1.0, 1.0, 1.0, 0.0])}
    (net,) = drawings([LIGHT], place_shares(columns))
    assert [place.share for place in net.places] == [0.75, None, None]


@pytest.mark.parametrize("broken", [7, {}, {"name": "x", "places": {"a": ""}, "transitions": [{"take": ["b"]}]}])
def test_what_is_no_net_is_left_out(broken: Any) -> None:
    assert [net.name for net in drawings([broken, LIGHT], {})] == ["light"]


def test_a_hostile_name_is_words_on_the_page(make_run: Any) -> None:
    run = make_run()
    run["meta"] = run["meta"] | {"nets": [LIGHT | {"name": "<script>alert(1)</script>"}]}
    page = render_run_report(**run)
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page


def test_a_stack_without_nets_has_no_section_for_them(make_run: Any) -> None:
    assert "Decision nets" not in render_run_report(**make_run())


def series(value: float) -> dict[str, Any]:
    return {"value": value, "series": {"t": np.arange(5.0), "value": np.full(5, value)}}


def test_every_metric_with_a_course_gets_a_row() -> None:
    metrics = {
        "lateral_rmse_path": series(0.1),
        "localization_error": series(0.2),
        "heading_error": series(math.radians(0.4)),
        "detection_error": series(0.3),
    }
    columns = {"t": np.arange(5.0), "v": np.arange(5.0), "ads.position_sigma": np.full(5, 0.04)}
    rows = belief_rows(metrics, columns)
    assert [[trace["name"] for trace in row.traces] for row in rows] == [
        ["left of the planned path"],
        ["1 σ that the ADS states", "estimated − true position"],
        ["estimated − true heading"],
        ["detected − true"],
    ]
    assert rows[2].traces[0]["y"] == pytest.approx([0.4] * 5)  # deg
    shown = timeline(columns, more=rows)["layout"]
    tops = [shown[f"yaxis{axis}"]["domain"][1] for axis in (2, 7, 8, 10, 9)]
    assert tops == sorted(tops, reverse=True)


def test_what_was_not_measured_has_no_row() -> None:
    assert belief_rows({"localization_error": {"value": None, "series": None}}, {"t": np.arange(5.0)}) == ()
