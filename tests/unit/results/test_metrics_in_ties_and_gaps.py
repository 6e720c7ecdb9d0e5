"""What metrics and verdicts say of ties, of gaps and of values just at a bound, on logs that are written down here."""

from __future__ import annotations

import hashlib
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, LogEvent
from pytest_dvp.metrics import compute
from pytest_dvp.metrics.tracking import _step
from pytest_dvp.verdicts import excited_parameters, judging
from pytest_dvp.verdicts.clean_gates import applies, read_clean
from pytest_dvp.verdicts.diagnose_command import gap_command
from pytest_dvp.verdicts.excited_parameters import not_validated, unexcited
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.scenario_gates import _a_place

# --- traffic lights: the front of this ego is 2 m ahead of its reference point

EGO = {"length": 2.0, "width": 1.5, "height": 1.4, "center_x": 1.0}


def at_lights(v: Any, phases: list[tuple[float, str, str]], *lines: tuple[str, float], x: Any = 0.0) -> Log:
    """An ego at x with a speed; lights (name, x of their lines) and their phases (t, name, state)."""
    events = tuple(LogEvent(at, "signal", name, state) for at, name, state in phases)
    stop_lines = [{"signal": name, "x": at, "y": 0.0, "heading": 0.0, "width": 4.0} for name, at in lines]
    return log_of(columns={"x": x, "v": v}, events=events, meta={"stop_lines": stop_lines, "ego": EGO})


def test_a_light_turns_green_in_the_row_of_its_event() -> None:
    """It stands in the row of 2 s and is fast in the next one: it waited, and set off 0.01 s later."""
    v = np.where(times() < 2.005, 0.0, 3.0)
    found = compute("start_up_delay", at_lights(v, [(0.0, "a", "red"), (2.0, "a", "green")], ("a", 5.0)))
    assert (found.value, found.t, found.object) == (pytest.approx(0.01), 2.0, "a")


def test_a_light_that_turns_green_behind_the_ego_does_not_hide_the_next_time() -> None:
    """It is beyond the line at 1 s, before it from 4 s on (a loop), and waits when the light turns green at 6 s."""
    x = np.where(times() < 4.0, 10.0, 0.0)
    phases = [(0.0, "a", "red"), (1.0, "a", "green"), (5.0, "a", "red"), (6.0, "a", "green")]
    v = np.where(times() < 8.0, 0.0, 3.0)
    found = compute("start_up_delay", at_lights(v, phases, ("a", 5.0), x=x))
    assert (found.value, found.t) == (pytest.approx(2.0), 6.0)


def test_of_two_waits_of_the_same_length_the_first_is_told() -> None:
    v = np.where(np.isin(np.floor(times()), (3.0, 6.0)), 3.0, 0.0)
    phases = [(0.0, "a", "red"), (2.0, "a", "green"), (4.5, "a", "red"), (5.0, "a", "green")]
    found = compute("start_up_delay", at_lights(v, phases, ("a", 5.0)))
    assert (found.value, found.t) == (pytest.approx(1.0), 2.0)


def test_beside_a_line_the_ego_is_not_beyond_it() -> None:
    """It leaves the lane of a red light before the line and passes it there: at most 1 m before it."""
    t = times()
    log = at_lights(1.0, [(0.0, "a", "red")], ("a", 7.0), x=t)
    log.columns["y"][:] = np.where(t < 4.0, 0.0, 9.0)
    found = compute("stop_line", log)
    assert (found.value, found.t) == (pytest.approx(-1.01), pytest.approx(3.99))


# --- a log of a car whose logger paused for 10 s


def paused(**columns: Any) -> Log:
    """0 to 5 s and 15 to 20 s at 100 Hz, as two parts of a drive that were written into one file."""
    t = np.concatenate([np.arange(500) * 0.01, 15.0 + np.arange(500) * 0.01])
    still = dict.fromkeys(("y", "yaw", "v", "yaw_rate", "steer", "steer_cmd", "accel_cmd"), np.zeros(1000))
    return Log({"t": t, "x": 10.0 * t, **still, **columns}, meta={"ego": EGO}, reference=LINE)


LINE = np.array([[-10.0, 0.0], [300.0, 0.0]])


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("max_jerk", "v"), ("max_deceleration", "v"), ("max_acceleration", "v"), ("max_lateral_acceleration", "v"),
        ("max_lateral_jerk", "v"), ("max_steer_rate", "steer"), ("steer_roughness", "steer_cmd"),
        ("accel_roughness", "accel_cmd"),
    ],
)  # fmt: skip
def test_a_hole_in_a_log_was_not_driven_calmly(name: str, column: str) -> None:
    """From 10 m/s before the hole to 5 m/s behind it: a line through it is 0.5 m/s^2, and a stop is possible."""
    found = compute(name, paused(v=np.repeat([10.0, 5.0], 500)))
    assert found.reason == f"{column} was not measured throughout: a hole of 10.0 s from t=4.99 s on"


@pytest.mark.parametrize("name", ["road_departure", "lane_time_outside"])
def test_a_hole_in_a_log_is_no_time_outside(name: str) -> None:
    """Beside the road in the last sample before the hole: for a step, not for 10 s."""
    y = np.where(np.arange(1000) == 499, 3.0, 0.0)
    log = paused(y=y, on_road=np.where(y > 0.0, 0.0, 1.0), lane_width=np.full(1000, 3.5))
    assert compute(name, log).value == pytest.approx(0.01)


# --- who is ahead and who was seen


def detected(t: Any, x: Any, y: Any = 0.0, **given: Any) -> DetectionTable:
    n = len(t)
    full = {"yaw": 0.0, "length": 4.0, "width": 2.0, "vx": 0.0, "vy": 0.0, "x": x, "y": y} | given
    columns = {name: np.broadcast_to(np.asarray(value, dtype=float), n).copy() for name, value in full.items()}
    return DetectionTable(t=np.asarray(t, dtype=float), kind=("vehicle",) * n, **columns)


INSTANTS = np.arange(0.0, 10.05, 0.1)


def test_of_several_detections_of_an_instant_the_nearest_counts() -> None:
    """A road user at 12 m has boxes that are 2 m, 1 m and 2.5 m off, in this order."""
    t, off = np.repeat(INSTANTS, 3), np.tile([2.0, -1.0, 2.5], len(INSTANTS))
    log = log_of(objects={"a": track(INSTANTS, 12.0, 0.0)}, detections=detected(t, 12.0 + off))
    assert compute("detection_error", log).value == pytest.approx(1.0)
    few = log_of(objects={"a": track(INSTANTS, 12.0, 0.0)}, detections=detected(INSTANTS, 14.0))
    assert compute("detection_error", few).value == pytest.approx(2.0)


def test_of_two_that_were_missed_at_once_the_first_is_named() -> None:
    """Both for the nine seconds after the one in which they settle: 91 instants of 0.1 s each."""
    objects = {"a": track(INSTANTS, 12.0, 0.0), "b": track(INSTANTS, 15.0, 0.0)}
    found = compute("missed_objects", log_of(objects=objects))
    assert (found.value, found.object) == (pytest.approx(2 * 9.1), "a")
    later = {"a": track(INSTANTS[5:], 12.0, 0.0), "b": track(INSTANTS, 15.0, 0.0)}
    assert compute("missed_objects", log_of(objects=later)).object == "b"


def test_the_time_between_instants_is_that_of_the_road_users_where_there_is_but_one() -> None:
    log = log_of(objects={"once": track(np.array([3.0]), 0.0, 0.0), "a": track(np.array([0.0, 0.2, 0.4]), 0.0, 0.0)})
    assert _step(np.array([1.0]), log) == pytest.approx(0.2)
    assert _step(np.array([1.0, 1.5]), log) == 0.5
    twice = log_of(objects={"a": track(np.array([0.0, 0.3]), 0.0, 0.0)})
    assert _step(np.array([1.0]), twice) == pytest.approx(0.3)
    assert _step(np.array([1.0]), log_of()) == 0.0


@pytest.mark.parametrize("name", ["track_speed_error", "track_size_error", "kind_error"])
def test_who_is_just_before_the_bumper_counts_unless_it_is_asked_for_beyond(name: str) -> None:
    """The ego's front is at 2.7 m: a road user whose middle is half a metre ahead of it."""
    log = log_of(objects={"a": track(INSTANTS, 3.2, 0.0)}, detections=detected(INSTANTS, 3.2, vx=1.0, length=2.0))
    expected = {"track_speed_error": 1.0, "track_size_error": 0.5, "kind_error": 0.0}[name]
    assert compute(name, log).value == pytest.approx(expected)
    assert not compute(name, log, beyond=0.6).valid
    assert compute(name, log, beyond=0.4).valid


AHEAD = ("detection_recall", "track_position_error", "track_yaw_error", "track_speed_error", "track_size_error",
         "kind_error", "track_coasting")  # fmt: skip


@pytest.mark.parametrize("name", AHEAD)
def test_ahead_is_whose_middle_is_ahead_of_the_bumper(name: str) -> None:
    """The ego's front is at 2.7 m."""
    for x, ahead in ((3.2, True), (2.2, False)):
        log = log_of(objects={"a": track(INSTANTS, x, 0.0)}, detections=detected(INSTANTS, x))
        assert compute(name, log).valid is ahead
        assert not compute(name, log, beyond=0.6).valid


def test_detections_that_are_nobody_count_ahead_of_the_bumper() -> None:
    """One of them for each instant, a tenth of a second each."""
    for x, seconds in ((3.2, 10.1), (2.2, 0.0)):
        log = log_of(objects={"a": track(INSTANTS, 15.0, 0.0)}, detections=detected(INSTANTS, x))
        assert compute("false_tracks", log).value == pytest.approx(seconds)
        assert compute("false_tracks", log, beyond=0.6).value == 0.0


def test_an_estimate_without_any_error_is_worst_where_it_is_known() -> None:
    t = times()
    log = log_of(columns={"ads.v": np.where(t < 2.0, np.nan, 0.0)})
    found = compute("speed_error", log)
    assert found.value == 0.0
    assert found.t is not None
    assert found.t >= 2.0


# --- the task


def test_how_far_away_the_goal_is_is_told_only_of_a_task_that_has_one_and_a_line_to_it() -> None:
    line = np.array([[0.0, 0.0], [30.0, 40.0]])
    for meta, reference, told in (
        ({"task": {"goal": [1]}}, line, ": the ego ended 50.0 m from it at t=10.00 s"), ({"task": {}}, line, ""),
        ({"task": {"goal": [1]}}, None, ""), ({"task": None}, line, ""),
    ):  # fmt: skip
        log = log_of(meta=meta, **({} if reference is None else {"reference": reference}))
        assert compute("completion_time", log).reason == f"the goal was never reached{told}"


@pytest.mark.parametrize("again", [3.0, 3.004])
def test_of_two_paths_of_one_instant_the_later_one_holds(again: float) -> None:
    """The ego drives along y = 0; the path is 1 m to its right until 3 s, then 2 m."""
    x = np.array([-10.0, 110.0])
    right = {off: np.column_stack([x, [-off, -off]]) for off in (1.0, 2.0, 5.0)}
    log = log_of(columns={"x": 5.0 * times()}, paths=[(0.0, right[1.0]), (3.0, right[5.0]), (again, right[2.0])])
    found = compute("lateral_rmse_path", log)
    late = int((times() >= 3.0 - 1e-9).sum())
    five = 1 if again > 3.0 else 0
    squares = (1001 - late) * 1.0 + five * 25.0 + (late - five) * 4.0
    assert found.value == pytest.approx(math.sqrt(squares / 1001.0))


# --- verdicts


@pytest.mark.parametrize(("value", "used"), [(-0.5, 0.0), (0.0, 0.0), (1.0, 0.25), (8.0, 2.0)])
def test_nothing_of_a_bound_is_used_by_a_value_that_is_better_than_the_best(
    value: float, used: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(judging, "find_metric", lambda name: SimpleNamespace(ideal=0.0))
    assert judging._used(Gate("any", max=4.0), value, 4.0) == used


def failed(status: str = "FAIL") -> Any:
    return [SimpleNamespace(status="PASS"), SimpleNamespace(status=status)]


def test_a_diagnosis_is_advised_if_a_gate_failed_and_both_the_log_and_the_model_are_known(tmp_path: Any) -> None:
    twin, bare, car = log_of(meta={"model": {"toml": "x", "file": "gone.toml"}}), log_of(), log_of()
    file = tmp_path / "car.mcap"
    assert gap_command(failed(), (twin, None), (car, file)).startswith("dvp diagnose ")
    assert gap_command(failed("PASS"), (twin, None), (car, file)) == ""
    assert gap_command(failed(), (twin, None), (car, None)) == ""
    assert gap_command(failed(), (bare, None), (car, file)) == ""


def test_the_model_that_is_advised_has_the_digest_of_the_twin_s_one(tmp_path: Any) -> None:
    """The user's own file if it is the one, else one of its name beside the folder of runs; else none is named."""
    given, beside = tmp_path / "mine.toml", tmp_path / "project" / "car.toml"
    beside.parent.mkdir()
    for file in (given, beside):
        file.write_text("[model]\n")
    other = tmp_path / "other.toml"
    other.write_text("[model]\nname = 'x'\n")
    about = {"toml": "x", "file": "somewhere/car.toml", "sha256": hashlib.sha256(b"[model]\n").hexdigest()}
    twin, car = log_of(meta={"model": about}), (log_of(), tmp_path / "car.mcap")
    place = beside.parent / "runs" / "1"
    assert f"--model {given} " in gap_command(failed(), (twin, place), car, given) + " "
    assert f"--model {beside} " in gap_command(failed(), (twin, place), car, other) + " "
    assert "which is not here" in gap_command(failed(), (twin, None), car, other)
    assert "which is not here" in gap_command(failed(), (twin, None), car)


@pytest.fixture
def drives(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Two drives that lack what the drag and the mass need; the twin claims its mass."""
    monkeypatch.setattr(excited_parameters, "_lacking", lambda logs: {"aero_drag": "speed", "mass": "a hill"})
    monkeypatch.setattr(excited_parameters, "_claimed", lambda log: {"command_mass": "mass"})
    return {"dt": log_of(), "rw": log_of()}


def test_what_no_gate_lists_is_not_validated(drives: Any) -> None:
    def left(*gates: Gate, pairs: Any = (("dt", "rw"),)) -> list[str]:
        return [one["parameter"] for one in not_validated(gates, pairs, drives)]

    assert left() == ["aero_drag", "mass"]
    assert left(Gate("mncc", between=("dt", "rw"), parameters=("aero_drag.c",))) == ["mass"]
    assert left(Gate("mncc", between=("dt", "rw"), parameters=("model",))) == ["aero_drag"]
    assert left(Gate("mncc", parameters=("model",))) == ["aero_drag", "mass"]  # of no stages
    assert left(Gate("mncc", between=("pe", "rw"), parameters=("model",))) == ["aero_drag", "mass"]  # not driven
    assert left(pairs=(("dt", "pe"), ("dt", "rw"))) == ["aero_drag", "mass"]
    (first, _) = not_validated([], [("dt", "rw")], drives)
    assert (first["between"], first["needs"]) == (["dt", "rw"], "speed")
    assert first["command"] == "dvp plan --model MODEL.toml --excite aero_drag"


def test_a_gate_speaks_for_what_it_lists_and_what_the_twin_claims(drives: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(excited_parameters, "idle_claims", lambda twin, measured: ["steer_lag"])
    assert unexcited(Gate("mncc", parameters=("aero_drag",)), drives) == ""
    assert unexcited(Gate("mncc", between=("dt", "rw")), drives) == ""
    assert unexcited(Gate("mncc", between=("dt", "rw"), parameters=("steer_lag",)), drives) == ""
    told = unexcited(Gate("mncc", between=("dt", "rw"), parameters=("aero_drag.c", "model")), drives)
    assert told.startswith("within its bound, but these drives do not excite aero_drag.c (speed; drive: ")
    assert "command_mass (a hill; drive: " in told
    assert told.endswith(": dvp plan --model MODEL.toml --excite aero_drag,mass")


@pytest.mark.parametrize("facts", [None, SimpleNamespace(lengths={}, lanes={})])
def test_without_a_road_an_example_of_a_place_is_given(facts: Any) -> None:
    assert _a_place(facts) == '{ road = "1", lane = -1, s = 420.0 }'


def clean(text: str, table: dict[str, Any]) -> tuple[list[Gate], list[tuple[Any, ...]]]:
    found: list[tuple[Any, ...]] = []
    head = {"only_if_logged": "ads.sigma"}
    gates = read_clean(head | table, text, "g.toml", lambda code, line, element, text, **more: found.append(
        (code, line, element, text)))  # fmt: skip
    return gates, found


TEXT = """[[gate]]
metric = "max_jerk"

[clean]
only_if_logged = "ads.sigma"
[clean.max]
max_jerk = 3.0
"detection_recall reach=40.0" = 0.5
[clean.min]
max_jerk = 4.0
"""


def test_bounds_of_clean_drives_stand_in_their_lines() -> None:
    gates, found = clean(TEXT, {"max": {"max_jerk": 3.0, "detection_recall reach=40.0": 0.5}})
    assert found == []
    assert [(g.metric, g.max, g.min, g.line, dict(g.options)) for g in gates] == [
        ("max_jerk", 3.0, None, 7, {}), ("detection_recall", 0.5, None, 8, {"reach": 40.0}),
    ]  # fmt: skip
    both, none = clean(TEXT, {"max": {"max_jerk": 3.0}, "min": {"max_jerk": 3.0}})
    assert none == []
    assert [(g.max, g.min, g.line) for g in both] == [(3.0, 3.0, 7)]
    _, crossed = clean(TEXT, {"max": {"max_jerk": 3.0}, "min": {"max_jerk": 4.0}})
    assert crossed == [("min_over_max", 10, "clean.min.max_jerk", "min 4 is greater than max 3")]
    _, unknown = clean(TEXT, {"max": {"max_jerk": True}})
    assert unknown[0][:3] == ("bound", 7, "clean.max.max_jerk")
    _, hidden = clean(TEXT, {"min": {"speed_excess": math.inf}})  # a line that is not found: that of the table
    assert hidden[0][:3] == ("bound", 4, "clean.min.speed_excess")


def test_a_bound_of_clean_drives_applies_to_drives_with_the_same_parameters_alone() -> None:
    gate = Gate("max_jerk", max=3.0, only_if_logged="ads.sigma", only_with={"speed": 5.5})
    like = {"parameters": {"speed": "5.5"}}
    assert applies(gate, log_of(columns={"ads.sigma": 0.1}, meta=like))
    assert not applies(gate, log_of(columns={"ads.sigma": 0.1}, meta={"parameters": {"speed": "5.6"}}))
    assert not applies(gate, log_of(columns={"ads.sigma": 0.1}, meta={"parameters": {"speed": "fast"}}))
    assert not applies(gate, log_of(columns={"ads.sigma": 0.1}))
    assert not applies(gate, log_of(columns={"ads.sigma": np.nan}, meta=like))
    assert not applies(gate, log_of(meta=like))
    assert not applies(gate, log_of(columns={"ads.sigma": 0.1}, meta=like | {"S": {"noise": 2.0}}))
    assert applies(Gate("max_jerk", max=3.0), log_of())


@pytest.mark.parametrize("table", [{}, {"max": {}}, {"max": 3.0}, {"max": {"max_jerk": 3.0}, "min": 2.0}, {"min": [1]}])
def test_clean_drives_need_a_table_with_a_bound_and_nothing_else(table: dict[str, Any]) -> None:
    gates, found = clean(TEXT, table)
    assert gates == []
    assert found == [("clean", 4, "clean", "[clean] needs [clean.max] or [clean.min] with bounds by metric")]
