"""Small decisions of metrics and verdicts: at the ends of lines and grids, in the words of a verdict, on both sides."""

from __future__ import annotations

import dataclasses
import math
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times, track

import scenarios
from pytest_dvp.logs import detected_tracks
from pytest_dvp.logs.log_contents import DetectionTable, LogEvent
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._ego_box import ego_size
from pytest_dvp.metrics._polyline import lateral_offsets
from pytest_dvp.metrics.metric import REQUIRED, MetricError, Range
from pytest_dvp.metrics.registry import check_options
from pytest_dvp.metrics.responsibility import _seen, safe_lateral, safe_longitudinal
from pytest_dvp.metrics.signal_similarity import _compare_seen, _on_one_base
from pytest_dvp.verdicts import judging, stage_table, stage_table_text
from pytest_dvp.verdicts.gate import Gate, GateFile
from pytest_dvp.verdicts.model_gate import model_file, read_model_gate
from pytest_dvp.verdicts.result_text import _no_verdict
from pytest_dvp.verdicts.scenario_gates import check_beside
from pytest_dvp.verdicts.silent_events import storyboard_verdict, without_optional
from pytest_dvp.verdicts.verdict_changes import GateChange, change_lines, gates_on

# --- a line


def offsets(points: list[tuple[float, float]], line: list[tuple[float, float]]) -> list[float]:
    x, y = np.array(points).T
    return lateral_offsets(np.ascontiguousarray(x), np.ascontiguousarray(y), np.array(line)).tolist()


def test_an_offset_is_to_the_nearest_piece_of_a_line() -> None:
    """Left is positive; beside a corner it is the distance from it; beyond an open end there is none."""
    corner = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]
    found = offsets([(5.0, 1.0), (5.0, -2.0), (9.0, 5.0), (13.0, -4.0), (-1.0, 1.0), (9.0, 11.0)], corner)
    assert found[:4] == pytest.approx([1.0, -2.0, 1.0, -5.0])
    assert all(math.isnan(value) for value in found[4:])


def test_points_that_stand_twice_in_a_line_change_nothing() -> None:
    line = [(0.0, 0.0), (0.0, 0.0), (4.0, 0.0), (4.0, 0.0), (4.0, 0.0), (4.0, 8.0), (4.0, 8.0)]
    assert offsets([(3.0, 7.0), (1.0, 0.5), (3.5, 7.9), (6.0, 1.0)], line) == pytest.approx([1.0, 0.5, 0.5, -2.0])


def test_the_order_of_points_changes_nothing() -> None:
    """Each search begins where the last one ended."""
    rng = np.random.default_rng(3)
    line = [(float(k), 3.0 * math.sin(0.7 * k)) for k in range(30)]
    points = [tuple(point) for point in rng.uniform((1.0, -4.0), (28.0, 4.0), (50, 2)).tolist()]
    alone = [offsets([point], line)[0] for point in points]
    assert offsets(points, line) == pytest.approx(alone)
    assert offsets(points[::-1], line) == pytest.approx(alone[::-1])


@pytest.mark.parametrize("line", [[(1.0, 2.0)], [(1.0, 2.0), (1.0, 2.0)]])
def test_a_line_without_length_has_no_sides(line: list[tuple[float, float]]) -> None:
    assert math.isnan(offsets([(0.0, 0.0)], line)[0])


# --- likeness


def test_both_ends_of_the_time_in_common_count() -> None:
    """0.1 s does not divide 0.3 s in binary numbers; 4 of 4 samples differ, by 1, 1, 1 and 5: the bias is 2."""
    t, x = np.array([0.0, 0.1, 0.2, 0.3]), np.array([0.0, 4.0, -4.0, 1.0])
    assert _on_one_base((t, x), (t, x + np.array([1.0, 1.0, 1.0, 5.0])), 0.0).bias == pytest.approx(2.0)
    t = np.arange(101) * 0.1
    step = np.where(t == t[-1], 101.0, 0.0)
    assert _on_one_base((t, np.sin(t)), (t, np.sin(t) + step), 0.0).bias == pytest.approx(1.0)


def test_the_finer_time_base_of_two_is_taken() -> None:
    fine, coarse = np.arange(0.0, 10.01, 0.1), np.arange(0.0, 10.01, 0.5)
    one, other = (fine, np.sin(fine)), (coarse, np.sin(coarse))
    for pair in ((one, other), (other, one)):
        assert np.diff(_on_one_base(*pair, 1.0).lags).min() == pytest.approx(0.1)


def test_logs_that_share_less_than_a_step_are_not_compared() -> None:
    t = np.arange(0.0, 1.01, 0.1)
    with pytest.raises(Undefined, match="no time in common"):
        _on_one_base((t, np.sin(t)), (t + 0.95, np.sin(t)), 0.5)


def seen(ahead: Any, duration: float, t: Any) -> Any:
    return SimpleNamespace(t=t, ahead=ahead, left=0.0 * ahead, duration=duration)


def test_road_users_that_keep_their_place_are_left_out_and_long_ones_count_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first does not vary; gains of 1 over 1 s and of 2 over 3 s make 1.75; their clocks are 0.4 s apart."""
    t = np.arange(0.0, 10.01, 0.1)
    wave, still = np.sin(t), np.zeros(len(t))
    pairs = [(seen(still, 9.0, t), seen(still, 9.0, t), 0.4),
             (seen(wave, 1.0, t), seen(wave, 5.0, t + 0.4), 0.4),
             (seen(wave, 8.0, t), seen(2.0 * wave, 3.0, t + 0.4), 0.4)]  # fmt: skip
    monkeypatch.setattr(detected_tracks, "matched_tracks", lambda model, measured: pairs)
    found = _compare_seen(None, None, "objects.x", 1.0)  # type: ignore[arg-type]
    assert (found.gain, found.lag, found.mncc) == pytest.approx((1.75, 0.4, 1.0))
    with pytest.raises(Undefined, match="whose place varied"):
        _compare_seen(None, None, "objects.y", 1.0)  # type: ignore[arg-type]


# --- responsibility-sensitive safety, by definitions 1, 2 and 6 with numbers of one digit


def longitudinal(rear: float, front: float) -> float:
    """Response 2 s, speeding up by 1, braking by 2 at least and by 4 at most [m/s^2]."""
    return float(safe_longitudinal(np.array([rear]), np.array([front]), 2.0, 1.0, 2.0, 4.0)[0])


@pytest.mark.parametrize(
    ("rear", "front", "distance"),
    [
        (6.0, 4.0, 12.0 + 2.0 + 16.0 - 2.0),  # 6 * 2 + 4 / 2, 8^2 / 4, 4^2 / 8
        (2.0, 9.0, 0.0),  # who drives away leaves room enough
        (-5.0, 0.0, 0.0),  # who goes back is no faster than 0 when it brakes
        (6.0, -4.0, 30.0 + 8.0 + 2.0 + 9.0),  # they meet: 4 * 2 + 2 + 6^2 / 4
    ],
)
def test_longitudinal_safe_distance(rear: float, front: float, distance: float) -> None:
    assert longitudinal(rear, front) == pytest.approx(distance)


@pytest.mark.parametrize(
    ("toward", "away", "distance"),
    [
        (1.0, 0.0, 0.3 + (4.0 + 2.25) + (2.0 + 1.0)),  # (1 + 3) / 2 * 2 + 3^2 / 4, and -(0 - 2) / 2 * 2 + 2^2 / 4
        (-9.0, 9.0, 0.3),  # apart from each other: the margin is left
    ],
)
def test_lateral_safe_distance(toward: float, away: float, distance: float) -> None:
    found = safe_lateral(np.array([toward]), np.array([away]), 2.0, 1.0, 2.0, 0.3)
    assert float(found[0]) == pytest.approx(distance)


@pytest.mark.parametrize(("y", "side"), [(3.0, 1.0), (0.5, 1.0), (0.0, 1.0), (-0.5, -1.0), (-3.0, -1.0)])
def test_lateral_speeds_count_towards_the_side_where_the_other_one_is(y: float, side: float) -> None:
    """An ego along x that drifts to the left by 0.4 m/s, and one 8 m ahead that drifts to the right by 0.3 m/s."""
    ego, other = np.array([[0.0, 0.0, 0.0, 4.0, 2.0, 10.0, 0.4]]), np.array([[8.0, y, 0.0, 4.0, 2.0, 9.0, -0.3]])
    along, across, rear, front, mine, its = (float(one[0]) for one in _seen(ego, other))
    assert (along, across) == (4.0, max(abs(y) - 2.0, 0.0))
    assert (rear, front) == (10.0, 9.0)
    assert (mine, its) == (side * 0.4, -side * 0.3)


# --- verdicts


@pytest.mark.parametrize(("speed", "status", "relation"), [(5.4, "PASS", "<= 0.50"), (5.6, "FAIL", "> 0.50")])
def test_a_difference_between_stages_is_told_with_its_relation(speed: float, status: str, relation: str) -> None:
    gate = Gate("test_speed", max_difference=0.5, between=("dt", "rw"))
    values = {5.0: drive_straight(5.0), speed: drive_straight(speed)}
    logs = {"dt": values[5.0], "rw": values[speed]}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judging, "compute", lambda name, log, *_, **__: _value(float(log["v"][0])))
        patch.setattr(judging, "find_metric", lambda name: SimpleNamespace(miss="FAIL", ideal=None, open_loop=False))
        (verdict,) = judging.judge_between([gate], ("dt", "rw"), logs)
    assert verdict.status == status
    assert relation in verdict.short
    assert verdict.margin == pytest.approx(0.5 - (speed - 5.0))
    assert "dt 5.0" in verdict.short
    assert f"rw {speed}" in verdict.short


def _value(value: float) -> Any:
    from pytest_dvp.metrics.metric import MetricValue

    fields = {field.name: None for field in dataclasses.fields(MetricValue)}
    return MetricValue(**{**fields, "name": "test_speed", "value": value, "unit": "m/s", "valid": True, "reason": "",
                          "object": "", "extra": {}})  # type: ignore[arg-type]  # fmt: skip


@pytest.mark.parametrize(
    ("value", "bound", "unit", "told"),
    [
        (3.0, 4.0, "-", ("3", "4")),
        (3.0, 4.0, "m", ("3.00", "4.00")),
        (0.5012, 0.5, "m", ("0.501", "0.500")),  # must not read like its bound
        (0.5, 0.5, "m", ("0.50", "0.50")),
        (1.0, 0.002, "m", ("1.000", "0.002")),  # a bound that must not read like 0
        (0.0042, 1.0, "m", ("0.00", "1.00")),  # 2 % of the bound may be lost
        (0.004, 0.1, "m", ("0.004", "0.100")),  # more than that may not
        (0.098, 0.001, "m", ("0.098", "0.001")),
        (2.5, 4.0, "-", ("2.50", "4.00")),
    ],
)
def test_numbers_have_as_few_decimals_as_tell_them(
    value: float, bound: float, unit: str, told: tuple[str, str]
) -> None:
    assert judging._pair(value, bound, unit) == told


def test_a_gate_that_nobody_has_names_the_nearest_one() -> None:
    """Of the metrics and gates that were judged, and of what was measured beside them."""
    verdicts = [{"metric": "collision", "gate": ""}, {"metric": "", "gate": "storyboard"}]
    assert "did you mean 'collision'" in _no_verdict("INCONCLUSIVE", ["colision"], verdicts, {})
    assert "did you mean 'storyboard'" in _no_verdict("INCONCLUSIVE", ["storybord"], verdicts, {})
    assert "did you mean 'max_jerk'" in _no_verdict("INCONCLUSIVE", ["max_jrk"], verdicts, {"max_jerk": 1.0})
    text = _no_verdict("INCONCLUSIVE", ["collision", "max_jerk"], verdicts, {"max_jerk": 1.0})
    assert text == "INCONCLUSIVE: no gate on collision, max_jerk"
    assert _no_verdict("INCONCLUSIVE", [], verdicts, {}) == (
        "INCONCLUSIVE: no gate was judged, and nothing judged is never a PASS"
    )


def test_an_optional_event_changes_only_a_count_that_was_inconclusive() -> None:
    """Two of three events never fired, one of them may."""
    count = {"metric": "events_fired", "gate": "events", "status": "INCONCLUSIVE", "value": 2.0, "bound": 1.0}
    other = {"metric": "max_jerk", "gate": "jerk", "status": "INCONCLUSIVE", "value": 2.0, "bound": 1.0}
    passed = {**count, "status": "PASS", "value": 0.0}
    unknown = {**count, "value": None}
    result = {"verdicts": [count, other, passed, unknown], "never_fired": ["a", "b"], "events": ["a", "b", "c"]}
    found = without_optional(result, ["a"])
    assert found["verdicts"][0]["value"] == 1.0
    assert found["verdicts"][0]["status"] == "PASS"
    assert found["verdicts"][0]["margin"] == 0.0
    assert found["verdicts"][1:] == [other, passed, unknown]
    assert (found["never_fired"], found["status"]) == (["b"], "INCONCLUSIVE")
    assert without_optional(result, ["c"]) == result


@pytest.mark.parametrize(
    ("silent", "told"),
    [
        (["a"], "event 'a' never fired"),
        (["a", "b", "c"], "3 of 9 events never fired: 'a', 'b', 'c'"),
        (["a", "b", "c", "d"], "4 of 9 events never fired: 'a', 'b', 'c', ..."),
    ],
)
def test_up_to_three_silent_events_are_named(silent: list[str], told: str) -> None:
    assert storyboard_verdict(silent, 9)["short"] == f"storyboard INCONCLUSIVE: {told}"


def test_the_twin_is_what_every_other_stage_is_against() -> None:
    """It itself is against what came before; without a twin each stage is against the one before."""
    logs: Any = {"pe-surrogate": "A", "dt-fine": "B", "rw": "C"}
    pairs: Any = ["first", "second", "third"]
    assert stage_table._twins(logs, pairs) == [("dt-fine", "B"), "first", ("dt-fine", "B")]
    assert stage_table._twins({"pe": "A", "rw": "C"}, pairs[:2]) == pairs[:2]  # type: ignore[dict-item]


@pytest.mark.parametrize(
    ("cell", "text"),
    [((None,), "-"), ((0.0,), "0"), ((1e-4,), "0.0001"), ((-2e-5,), "-2.0e-05"), ((12.34567,), "12.35"),
     ((0.99812, 0.12, 1.0041), "0.9981 +0.12 s x1.004"), ((0.5, 0.1, None), "0.5")],
)  # fmt: skip
def test_cells_of_the_table_of_stages(cell: tuple[float | None, ...], text: str) -> None:
    assert stage_table.Cell(*cell).text == text


def test_rows_of_the_table_of_stages_have_their_unit() -> None:
    def row(metric: str, name: str, unit: str) -> dict[str, Any]:
        return {"metric": metric, "name": name, "unit": unit, "cells": [{"text": "1"}]}

    rows = [row("max_jerk", "jerk", "m/s^3"), row("collision", "hits", "-"), row("mncc", "v", "-")]
    lines = stage_table_text.table_lines({"rows": rows, "stages": ["dt"], "against": ["rw"]})
    assert [line.split("  ")[0] for line in lines[1:]] == ["jerk [m/s^3]", "hits", "MNCC v"]
    assert lines[0].endswith("dt to rw")


def test_no_gate_at_all_and_none_for_the_stage_are_told() -> None:
    verdict = judging.judge(GateFile(None, ()), log_of(1.0))
    assert [each.status for each in verdict] == ["INCONCLUSIVE"]
    (verdict_rw,) = judging.judge([Gate("max_jerk", max=1.0, stages=("rw",))], log_of(1.0))
    assert verdict_rw.short == "no gate applies to stage dt: nothing was judged"


# --- times


def test_a_task_takes_its_time_from_the_first_row_to_the_goal() -> None:
    reached, again, begun = (LogEvent(t, kind, "", "") for t, kind in ((5.0, "goal"), (7.0, "goal"), (2.0, "start")))
    found = compute("completion_time", log_of(10.0, events=(reached, again)))
    assert (found.value, found.t) == (5.0, 5.0)
    assert compute("completion_time", log_of(10.0, events=(begun, reached))).value == 3.0
    assert not compute("completion_time", log_of(10.0, events=(begun,))).valid


def test_a_path_is_measured_each_five_centimetres() -> None:
    """Two lines 0.3 m apart: rms 0.3 over 10 m in 200 points; one that does not lie beside it is told as a share."""
    model, measured = drive_straight(1.0), drive_straight(1.0)
    beside = log_of(columns={"x": measured["x"], "y": 0.3, "v": 1.0})
    found = compute("path_distance", model, beside)
    assert found.value == pytest.approx(0.3)
    assert found.series is not None
    assert len(found.series.t) == pytest.approx(200, abs=1)
    far = log_of(columns={"x": measured["x"] - 8.0, "v": 1.0})
    assert compute("path_distance", model, far).reason == "only 20 % of the measured path lie beside the model's"


@pytest.mark.parametrize(("unit", "told"), [("-", "0.9"), ("m/s", "0.9 m/s")])
def test_a_bound_that_changes_its_verdict_is_told_with_its_unit(unit: str, told: str) -> None:
    def check(value: float | None, holds: bool) -> Any:
        return SimpleNamespace(kind="rmse", signal="v", bound=0.9, unit=unit, value=value, holds=holds)

    changes = [GateChange("a.mcap", "g.toml", 3, check(0.5, True), check(1.5, False)),
               GateChange("b.mcap", "g.toml", 3, check(None, False), check(None, False))]  # fmt: skip
    lines = change_lines(changes)
    assert lines[0] == "1 of 2 gate verdicts change"
    assert [word for word in lines[2].split("  ") if word.strip()][-1].strip() == told
    assert "PASS 0.5" in lines[2]
    assert "FAIL 1.5" in lines[2]
    assert lines[3].count("INCONCLUSIVE") == 2
    assert [change.changed for change in changes] == [True, False]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        *((name, "model must be a file beside or below the gate file")
          for name in ("/car.toml", "../car.toml", "a/../car.toml", "a\\car.toml", "car.toml\0")),
        *((name, "model must be the name of a file") for name in (None, 3, "", "  ")), ("a", "no such model file"),
        ("none.toml", "no such model file"),
    ],
)  # fmt: skip
def test_a_model_is_named_beside_or_below_its_gates(name: object, says: str, tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    for good in ("car.toml", "a/car.toml"):
        (tmp_path / good).write_text("")
        assert model_file(good, tmp_path) == tmp_path / good
    assert model_file(name, tmp_path) == says


def test_only_gates_of_a_model_that_hold_a_log_against_this_file_are_on_it(tmp_path: Path) -> None:
    """Not a metric of somebody's own with an option of this name, and no gate that names no model."""
    model = tmp_path / "car.toml"
    gates = [Gate(metric, max=1.0, options=options) for metric, options in (
        ("open_loop_error", {"signal": "v", "model": str(tmp_path / "." / "car.toml")}), ("own", {"model": str(model)}),
        ("model_lag", {"signal": "v"}), ("model_lag", {"signal": "v", "model": str(tmp_path / "other.toml")}),
        ("model_gain", {"signal": "v", "model": str(model)}))]  # fmt: skip
    assert gates_on(gates, model) == [gates[0], gates[4]]


@pytest.mark.parametrize("missing", ["length", "width"])
@pytest.mark.parametrize("size", [0.0, -1.0])
def test_an_ego_without_length_or_width_has_no_box(missing: str, size: float) -> None:
    ego = {"length": 3.0, "width": 1.5, "center_x": 1.2}
    assert ego_size(log_of(1.0, meta={"ego": ego})) == (3.0, 1.5, 1.2)
    with pytest.raises(Undefined, match="no size"):
        ego_size(log_of(1.0, meta={"ego": {**ego, missing: size}}))


def test_what_is_wrong_with_a_gate_on_a_model_is_told_with_its_key(tmp_path: Any) -> None:
    (tmp_path / "car.toml").write_text("")
    file, found = str(tmp_path / "a.gates.toml"), []

    def find(code: str, line: int | None, element: str, text: str, **more: str) -> None:
        found.append((code, line, element))

    lines = {"rmse": 7, "lag": 8}
    for table in ({}, {"rmse": 0.3}, {"lag": {"speed": 0.1}}, {"rmse": {"v": -1.0}}, {"rmse": {"v": True}}):
        assert read_model_gate({"model": "car.toml", **table}, "gate[1]", 3, lines, file, find, lambda *_: None) == []
    assert found == [
        ("no_bound", 3, "gate[1]"),
        ("bound", 7, "gate[1].rmse"),
        ("signal", 8, "gate[1].lag"),
        ("bound", 7, "gate[1].rmse"),
        ("bound", 7, "gate[1].rmse"),
    ]
    found.clear()  # what is wrong with one kind hides nothing of the next one
    table = {"model": "car.toml", "rmse": 0.3, "lag": {"speed": 0.1}}
    assert read_model_gate(table, "gate[1]", 3, lines, file, find, lambda *_: None) == []
    assert found == [("bound", 7, "gate[1].rmse"), ("signal", 8, "gate[1].lag")]
    table = {"model": "car.toml", "rmse": {"v": 0.3}, "mncc": {"v": 0.9}, "lag": 0.1}
    gates = read_model_gate(table, "gate[1]", 3, lines, file, find, lambda *_: None)
    assert [(g.metric, g.min, g.max, g.options["signal"], g.line) for g in gates] == [
        ("open_loop_error", None, 0.3, "v", 7),
        ("model_mncc", 0.9, None, "v", 3),
        ("model_lag", None, 0.1, "v", 8),
        ("model_lag", None, 0.1, "yaw_rate", 8),
    ]


@pytest.mark.parametrize(("beyond", "count"), [(-0.5, 0.0), (0.5, 1.0)])
def test_a_red_light_is_crossed_when_the_front_is_beyond_its_line(beyond: float, count: float) -> None:
    """The ego comes to a stand half a metre before the line, or behind it."""
    x = 30.0 + beyond - 2.7 - np.maximum(8.0 - times(), 0.0)
    line = {"signal": "1", "x": 30.0, "y": 0.0, "heading": 0.0, "width": 3.5}
    log = log_of(columns={"x": x, "v": 1.0}, meta={"stop_lines": [line]}, events=(LogEvent(0.0, "signal", "1", "red"),))
    assert compute("red_light", log).value == count
    assert compute("stop_line", log).value == pytest.approx(beyond)


@pytest.mark.parametrize(("goal", "told"), [('{ road = "nope", lane = -1, s = 1.0 }', ["task.goal.road"]), ("", [])])
def test_places_of_a_gate_file_are_checked_on_the_road_beside_it(tmp_path: Path, goal: str, told: list[str]) -> None:
    here = Path(scenarios.__file__).parent
    shutil.copytree(here, tmp_path / "s", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    file = tmp_path / "s" / "follow.gates.toml"
    if goal:
        file.write_text(f'[task]\ngoal = {goal}\n\n[[gate]]\nmetric = "collision"\nmax = 0\n')
    assert [finding.element for finding in check_beside(file)] == told


def test_what_is_wrong_with_a_gate_file_itself_is_told_by_its_own_check(tmp_path: Path) -> None:
    shutil.copy(Path(scenarios.__file__).parent / "follow.xosc", tmp_path)
    file = tmp_path / "follow.gates.toml"
    for text in ("[[gate", '[[gate]]\nmetric = "no such metric"\nmax = 0\n'):
        file.write_text(text)
        assert check_beside(file) == ()


# --- options and detections


def test_options_are_of_the_type_of_their_default() -> None:
    options = {"x": 1.0, "word": "a", "names": ("a",), "needed": REQUIRED}
    chosen: Any = SimpleNamespace(
        name="m",
        options=options,
        ranges={"x": Range(0.0, above=True)},
        types={"needed": float},
        words={"word": ("a", "b")},
    )
    good = {"x": 2, "word": "b", "names": ["b", "c"], "needed": 1}
    check_options(chosen, good)
    check_options(chosen, {**good, "names": ("b",), "x": 0.5})
    number, words = "must be a finite number", "must be a list of words"
    wrong = [("x", "2", number), ("x", True, number), ("x", math.inf, number), ("word", 2, "must be a word"),
             ("names", "b", words), ("names", [1], words), ("nams", ["b"], "nearest is 'names'"),
             ("x", -2, "must be > 0, found -2"), ("needed", "1", number),
             ("word", "c", "found 'c', allowed: a, b")]  # fmt: skip
    for key, value, text in wrong:
        with pytest.raises(MetricError, match=text):
            check_options(chosen, {**good, key: value})
    with pytest.raises(MetricError, match="needs the option 'needed'"):
        check_options(chosen, {"x": 2.0})


def test_who_is_ahead_and_never_reported_is_missed() -> None:
    t = times()[::5]
    flat = np.zeros(0)
    nothing = DetectionTable(t=flat, kind=(), x=flat, y=flat, yaw=flat, length=flat, width=flat, vx=flat, vy=flat)
    log = drive_straight(2.0, objects={"car": track(t, 12.0 + 2.0 * t, 0.0, vx=2.0)}, detections=nothing)
    found = compute("detection_recall", log)
    assert (found.value, found.object) == (0.0, "car")
    assert not compute("track_position_error", log).valid


@pytest.mark.parametrize(("beyond", "seconds"), [(0.0, 2.0), (10.0, 1.0)])
def test_only_ghosts_in_the_band_that_is_judged_count(beyond: float, seconds: float) -> None:
    """One 5 m before the bumper for a second, one 15 m before it for another."""
    t = np.arange(0.0, 10.01, 0.05)
    near, far = t[(t > 1.99) & (t < 2.96)], t[(t > 4.99) & (t < 5.96)]
    stamps = np.concatenate([near, far])
    x = 2.0 * stamps + 2.7 + np.concatenate([np.full(len(near), 5.0), np.full(len(far), 15.0)])
    flat = np.zeros(len(stamps))
    ghosts = DetectionTable(t=stamps, kind=("vehicle",) * len(stamps), x=x, y=flat, yaw=flat, length=flat, width=flat,
                            vx=flat, vy=flat)  # fmt: skip
    away = track(t, 500.0, 0.0)
    found = compute(
        "false_tracks", drive_straight(2.0, objects={"car": away}, detections=ghosts), reach=30.0, beyond=beyond
    )
    assert found.value == pytest.approx(seconds, abs=0.06)


@pytest.mark.parametrize(
    ("other", "along", "across", "rear", "front", "lateral"),
    [
        ((20.0, 3.0, 5.0, 0.4), 16.0, 1.25, 10.0, 5.0, (1.0, 0.4)),  # ahead on the left: towards it is +y
        ((20.0, -3.0, 5.0, 0.4), 16.0, 1.25, 10.0, 5.0, (-1.0, -0.4)),
        ((-20.0, 0.0, 5.0, 0.4), 16.0, 0.0, 5.0, 10.0, (1.0, 0.4)),  # behind: it is the rear one
        ((20.0, 0.0, -5.0, 0.0), 16.0, 0.0, 10.0, -5.0, (1.0, 0.0)),  # they meet
        ((1.0, 0.0, 5.0, 0.0), 0.0, 0.0, 10.0, 5.0, (1.0, 0.0)),  # they overlap
        ((-0.5, 0.0, 5.0, 0.0), 0.0, 0.0, 5.0, 10.0, (1.0, 0.0)),
    ],
)
def test_what_rss_looks_at(
    other: tuple[float, ...], along: float, across: float, rear: float, front: float, lateral: tuple[float, float]
) -> None:
    """An ego of 4 x 2 m at 10 m/s along x, 1 m/s to the left; another one of 4 x 1.5 m."""
    x, y, vx, vy = other
    ego, box = np.array([[0.0, 0.0, 0.0, 4.0, 2.0, 10.0, 1.0]]), np.array([[x, y, 0.0, 4.0, 1.5, vx, vy]])
    found = [float(value[0]) for value in _seen(ego, box)]
    assert found == pytest.approx([along, across, rear, front, *lateral])


def test_two_that_drive_backwards_are_seen_from_the_other_end() -> None:
    """Both go against the ego's axis: who is ahead of it follows the ego."""
    ego, box = np.array([[0.0, 0.0, 0.0, 4.0, 2.0, -3.0, 0.0]]), np.array([[20.0, 0.0, 0.0, 4.0, 2.0, -5.0, 0.0]])
    assert [float(value[0]) for value in _seen(ego, box)][:4] == pytest.approx([16.0, 0.0, 5.0, 3.0])


def test_two_that_drive_backwards_at_a_walking_pace_are_seen_from_the_other_end_as_well() -> None:
    ego, box = np.array([[0.0, 0.0, 0.0, 4.0, 2.0, -0.5, 0.0]]), np.array([[20.0, 0.0, 0.0, 4.0, 2.0, -0.8, 0.0]])
    assert [float(value[0]) for value in _seen(ego, box)][:4] == pytest.approx([16.0, 0.0, 0.8, 0.5])
