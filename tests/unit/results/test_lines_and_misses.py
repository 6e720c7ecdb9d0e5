"""The line that a car has driven, and what of the road users a stack missed: by rows that are counted by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import log_of, times

from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics import compute, detection_error, tracking
from pytest_dvp.metrics.path_distance import STRIDE, _line


def test_a_line_has_a_point_each_stride_of_the_way_and_the_time_at_which_it_was_there() -> None:
    """2 m/s for 3 s, 4 s of standstill, 2 m/s again, along 3-4-5: at 6 m it was 3 s old, and 7 s just beyond."""
    t = times()
    way = 2.0 * np.clip(t, 0.0, 3.0) + 2.0 * np.clip(t - 7.0, 0.0, 3.0)
    at, points = _line(log_of(columns={"x": 0.6 * way + 5.0, "y": 0.8 * way}))
    grid = np.arange(0.0, 12.0 - 1e-9, STRIDE)
    assert points == pytest.approx(np.column_stack([5.0 + 0.6 * grid, 0.8 * grid]), abs=1e-6)
    before, after = grid < 5.99, grid > 6.03
    assert at[before] == pytest.approx(grid[before] / 2.0, abs=1e-6)
    assert at[after] == pytest.approx(4.0 + grid[after] / 2.0, abs=1e-6)


def test_where_a_car_stood_it_was_when_it_arrived() -> None:
    """From the start to 3 s at 0, from 4 s to 6 s a stride further on, both places of the grid."""
    x = STRIDE * np.interp(times(), [0.0, 3.0, 4.0, 6.0, 10.0], [0.0, 0.0, 1.0, 1.0, 3.5])
    at, points = _line(log_of(columns={"x": x, "y": 0.0}))
    assert points[:, 0] == pytest.approx(STRIDE * np.arange(4.0))
    assert at == pytest.approx([0.0, 4.0, 6.0 + 4.0 / 2.5, 6.0 + 8.0 / 2.5], abs=1e-6)


def test_rows_without_a_place_are_left_out_of_a_line_and_two_are_needed() -> None:
    t = times()
    x = np.where((t > 2.0) & (t < 4.0), np.nan, t)
    at, points = _line(log_of(columns={"x": x, "y": 0.0}))
    assert at == pytest.approx(points[:, 0], abs=1e-6)
    assert len(at) == len(np.arange(0.0, 10.0 - 1e-9, STRIDE))
    one = np.where(t == 0.0, 1.0, np.nan)
    with pytest.raises(Undefined, match="not measured"):
        _line(log_of(columns={"x": one, "y": 0.0}))
    with pytest.raises(Undefined, match="did not move"):
        _line(log_of(columns={"x": 3.0, "y": 0.0}))
    short = log_of(columns={"x": np.minimum(t, 1.01 * STRIDE), "y": 0.0})
    assert len(_line(short)[0]) == 2
    two = np.where((t == t[0]) | (t == t[-1]), 0.5 * t, np.nan)  # straight from 0 to 5 m, at half a metre per second
    at, points = _line(log_of(columns={"x": two, "y": 0.0}))
    assert points[:, 0] == pytest.approx(STRIDE * np.arange(100.0))
    assert at == pytest.approx(points[:, 0] / 0.5)


@pytest.mark.parametrize(
    ("rows", "share", "first"),
    [([0, 1, 2, 3], 1.0, (None, "")), ([0, -1, 1, -1], 0.5, (0.3, "d")), ([-1, -1, -1, 0], 0.25, (0.2, "c"))],
)
def test_a_road_user_is_missed_where_no_row_was_assigned_to_it(
    rows: list[int], share: float, first: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first row of a table counts, too; the first miss is that of the least time."""
    table: Any = SimpleNamespace(row=np.array(rows), t=np.array([0.5, 0.6, 0.2, 0.3]), names=["a", "b", "c", "d"])
    monkeypatch.setattr(tracking, "matches", lambda *given: table)
    found = tracking.detection_recall(SimpleNamespace())  # type: ignore[arg-type]
    assert (found.value, found.t, found.object) == (pytest.approx(share), *first)


def test_missed_time_is_that_of_the_rows_of_each_road_user(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two rows at 10 Hz and one at 4 Hz; two rows have a step, a single one has none and adds no time."""
    errors = [("a", [1.0, 1.1, 1.2], [np.nan, np.nan, 0.5]), ("b", [0.75, 1.0], [0.2, np.nan]), ("c", [0.5], [np.nan])]
    objects = {"a": [1.0, 1.1, 1.2], "b": [0.75, 1.0], "c": [0.5]}
    log: Any = SimpleNamespace(objects={name: SimpleNamespace(t=np.array(t)) for name, t in objects.items()})
    ahead = [(name, np.array(t), np.array(error)) for name, t, error in errors]
    monkeypatch.setattr(detection_error, "objects_ahead", lambda *given: ahead)
    found = detection_error.missed_objects(log)
    assert (found.value, found.t, found.object) == (pytest.approx(0.2 + 0.25), 0.5, "c")
    monkeypatch.setattr(detection_error, "objects_ahead", lambda *given: ahead[:2])
    found = detection_error.missed_objects(log)
    assert (found.value, found.t, found.object) == (pytest.approx(0.45), 1.0, "a")  # of two at once the first
    monkeypatch.setattr(detection_error, "objects_ahead", lambda *given: [])
    with pytest.raises(Undefined, match="no road user"):
        detection_error.missed_objects(log)


@pytest.mark.parametrize(("turn", "far"), [(0.5 * np.pi, 3.0), (-0.5 * np.pi, 3.0), (0.0, 1.0), (np.pi, 1.0)])
def test_the_corner_that_is_farthest_from_the_line_counts(turn: float, far: float) -> None:
    """4 m by 2 m, the middle 1 m ahead: across the line its front is 3 m away from it, its rear 1 m."""
    ego = {"length": 4.0, "width": 2.0, "height": 1.5, "center_x": 1.0}
    line = np.array([[-50.0, 0.0], [50.0, 0.0]])
    log = log_of(columns={"yaw": turn}, meta={"ego": ego}, reference=line)
    found = compute("lane_time_outside", log, width=3.5)
    assert found.extra["farthest"] == pytest.approx(far - 1.75)
    assert (found.value > 0.0) is (far > 1.75)
