"""What the top view draws: small, and where it was."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reports.scene import scene

MakeRun = Callable[..., dict[str, Any]]


def draw(run: dict[str, Any], stride: int = 1) -> dict[str, Any]:
    series = run["result"]["metrics"]["max_ttc_inverse"]["series"]
    return scene(run, series, stride)


def distance_to(line: np.ndarray, point: np.ndarray) -> float:
    a, b = line[:-1], line[1:]
    along = np.clip(np.sum((point - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1), 0.0, 1.0)
    return float(np.min(np.hypot(*(a + along[:, None] * (b - a) - point).T)))


def test_thinned_bend_stays_within_2_cm(make_run: MakeRun) -> None:
    angle = np.linspace(0.0, np.pi / 2, 400)
    bend = 15.0 * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1)
    run = make_run()
    run["road"] = [{"kind": "edge", "points": bend}]
    drawn = np.array(draw(run)["road"][0]["points"])
    assert len(drawn) < 60
    assert max(distance_to(drawn, point) for point in bend) < 0.02


def test_straight_line_keeps_its_ends(make_run: MakeRun) -> None:
    run = make_run()
    run["road"] = [{"kind": "lane", "points": np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])}]
    assert draw(run)["road"][0]["points"] == [[0.0, 0.0], [3.0, 0.0]]


def test_corners_of_a_crosswalk_survive(make_run: MakeRun) -> None:
    assert draw(make_run())["road"][-1]["points"] == [[88.5, -3.5], [91.5, -3.5], [91.5, 3.5], [88.5, 3.5]]


def test_ego_comes_20_times_a_second_and_to_the_end(make_run: MakeRun) -> None:
    ego = draw(make_run())["ego"]
    assert np.median(np.diff(ego["t"])) == pytest.approx(0.05)
    assert ego["t"][-1] == pytest.approx(39.99)


def test_detections_are_grouped_by_their_time(make_run: MakeRun) -> None:
    run = make_run()
    table = {
        "t": [1.0, 1.0, 2.0],
        "x": [1, 2, 3],
        "y": [4, 5, 6],
        "yaw": [0, 0, 0],
        "length": [1] * 3,
        "width": [1] * 3,
    }
    run["detections"] = table
    drawn = draw(run)["detections"]
    assert drawn["t"] == [1.0, 2.0]
    assert [len(boxes) for boxes in drawn["boxes"]] == [10, 5]


def test_last_planned_path_is_kept(make_run: MakeRun) -> None:
    run = make_run()
    line = np.array([[0.0, 0.0], [1.0, 1.0]])
    run["paths"] = [(0.0, line), (0.05, line), (0.10, line)]
    assert draw(run)["paths"]["t"] == [0.0, 0.1]


def test_the_plan_that_holds_for_long_is_drawn(make_run: MakeRun) -> None:
    """B comes 0.1 s after A and holds for 25 s."""
    run = make_run()
    shapes = [np.array([[0.0, y], [1.0, y]]) for y in (0.0, 1.0, 2.0)]
    run["paths"] = list(zip((5.0, 5.1, 30.0), shapes, strict=True))
    drawn = draw(run)["paths"]
    assert drawn["t"] == [5.0, 5.1, 30.0]
    assert [points[0][1] for points in drawn["points"]] == [0.0, 1.0, 2.0]
