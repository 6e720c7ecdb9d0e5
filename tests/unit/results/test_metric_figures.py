"""All that a metric returns of a small log: value, moment, object, figures beside it, course, and why it has none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, LogEvent
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._box_touch import touch
from pytest_dvp.metrics._even_time import uniform
from pytest_dvp.metrics._pairs import Course, worst_of

NAN = math.nan


def few(columns: dict[str, Any], t: Any = None, **more: Any) -> Log:
    """A log of some rows, 1 s apart if nothing else is said."""
    rows = len(next(iter(columns.values())))
    table = {"t": np.arange(float(rows)) if t is None else np.asarray(t, dtype=np.float64)}
    table |= {name: np.asarray(values, dtype=np.float64) for name, values in columns.items()}
    ego = {"length": 3.0, "width": 1.5, "height": 1.4, "center_x": 1.2}
    return Log(table, meta={"stage": "dt", "ego": ego, **more.pop("meta", {})}, **more)


def of(name: str, log: Log, **options: Any) -> Any:
    found = compute(name, log, **options)
    assert found.valid, found.reason
    return found


def course(found: Any) -> tuple[list[float], list[float]]:
    assert found.series is not None
    return found.series.t.tolist(), found.series.value.tolist()


# --- greatest of a column, gaps left out, with its moment


def test_the_greatest_yaw_rate_is_that_of_either_side() -> None:
    found = of("max_yaw_rate", few({"yaw_rate": [0.1, NAN, -0.5, 0.3]}))
    assert (found.value, found.t, course(found)[0]) == (0.5, 2.0, [0.0, 1.0, 2.0, 3.0])
    assert compute("max_yaw_rate", few({"yaw_rate": [NAN, NAN]})).reason == "yaw_rate was not measured"


def test_the_age_of_a_command_is_the_greatest_and_its_mean_is_told() -> None:
    found = of("command_age", few({"command_age": [NAN, 0.1, 0.4, 0.1]}))
    assert (found.value, found.t, found.extra["mean"]) == (0.4, 2.0, pytest.approx(0.2))
    assert not compute("command_age", few({"command_age": [NAN, NAN]})).valid


def test_the_age_of_an_input_is_the_greatest_or_the_least() -> None:
    log = few({"ads.age_gnss": [NAN, 0.3, -0.1, 0.2, 0.4]})
    found = of("input_age", log, sensor="gnss")
    assert (found.value, found.t, found.extra["mean"]) == (0.4, 4.0, pytest.approx(0.2))
    least = of("input_age", log, sensor="gnss", statistic="least")
    assert (least.value, least.t) == (-0.1, 2.0)
    assert "ads.age_imu" in compute("input_age", log, sensor="imu").reason


def test_messages_out_of_order_are_what_the_stack_counted_last() -> None:
    found = of("disordered_inputs", few({"ads.disordered": [NAN, 0.0, 2.0, 2.0]}))
    assert (found.value, found.t) == (2.0, 2.0)


def test_speed_over_the_limit_is_signed_where_the_limit_is_known() -> None:
    found = of("speed_excess", few({"v": [9.0, 5.0, 8.0], "speed_limit": [NAN, 7.0, 7.0]}))
    assert (found.value, found.t) == (1.0, 2.0)
    assert course(found)[1][1:] == [-2.0, 1.0]
    assert (
        compute("speed_excess", few({"v": [1.0, 1.0]})).reason == "the log does not tell the speed limit (speed_limit)"
    )


def test_an_assumed_width_of_the_lane_is_off_on_average() -> None:
    found = of("lane_width_error", few({"ads.lane_width": [3.0, 3.0, NAN, 3.0], "lane_width": [3.5, 2.0, 3.0, 3.0]}))
    assert (found.value, found.t) == (pytest.approx(0.5), 1.0)
    assert not compute("lane_width_error", few({"ads.lane_width": [3.0, 3.0]})).valid


@pytest.mark.parametrize(("name", "column"), [("replay_steer_error", "steer_cmd"), ("replay_accel_error", "accel_cmd")])
def test_a_stack_against_its_recording(name: str, column: str) -> None:
    log = few({column: [1.0, 2.0, NAN, 0.0], f"replay.{column}": [1.0, 5.0, 3.0, 4.0]})
    found = of(name, log)
    assert (found.value, found.t) == (pytest.approx(math.sqrt((9.0 + 16.0) / 3.0)), 3.0)
    assert found.extra == {"greatest": 4.0}
    assert course(found)[1][:2] == [0.0, -3.0]
    assert f"replay.{column}" in compute(name, few({column: [1.0, 2.0]})).reason
    never = few({column: [NAN, 1.0], f"replay.{column}": [1.0, NAN]})
    assert compute(name, never).reason == f"replay.{column} and {column} have no value at the same time"


# --- what the stack believes, at its ticks


def believed(**more: Any) -> Log:
    """Two ticks and a repeated row of a foreign log: 3 and 4 m off, and 5 m the second time."""
    columns = {"x": [0.0, 1.0, 2.0, 3.0], "y": [0.0] * 4, "v": [1.0] * 4, "yaw": [0.0, 0.0, 0.0, 3.0],
               "ads.x": [NAN, 1.0, 1.0, 0.0], "ads.y": [NAN, 3.0, 3.0, 4.0]}  # fmt: skip
    return few({**columns, **more}, meta={"stage": ""})


def test_an_estimate_counts_when_it_is_new() -> None:
    found = of("localization_error", believed())
    assert found.value == pytest.approx(math.sqrt((9.0 + 25.0) / 2.0))
    assert found.t == 3.0
    assert found.extra == {"greatest": pytest.approx(5.0), "mean": pytest.approx(4.0)}
    greatest = of("localization_error", believed(), statistic="greatest")
    assert (greatest.value, greatest.t) == (pytest.approx(5.0), 3.0)


def test_a_heading_is_off_the_short_way_round() -> None:
    """From 3 to -3 rad it is 2 pi - 6 to the left."""
    found = of("heading_error", believed(**{"ads.yaw": [NAN, -0.1, -0.1, -3.0]}))
    turn = 2.0 * math.pi - 6.0
    assert found.value == pytest.approx(math.sqrt((0.01 + turn**2) / 2.0))
    assert found.extra == {"greatest": pytest.approx(turn), "mean": pytest.approx((turn - 0.1) / 2.0)}


def test_a_speed_is_off_with_its_sign() -> None:
    found = of("speed_error", believed(**{"ads.v": [NAN, 0.5, 0.5, 3.0]}))
    assert (found.value, found.t) == (pytest.approx(math.sqrt((0.25 + 4.0) / 2.0)), 3.0)
    assert found.extra == {"greatest": pytest.approx(2.0), "mean": pytest.approx(0.75)}


def test_consistency_is_the_squared_error_over_the_variance() -> None:
    """3 m at a sigma of 1.5 m are 4, 5 m at 2.5 m are 4; a sigma of nought says nothing."""
    found = of("localization_nees", believed(**{"ads.position_sigma": [1.0, 1.5, 1.5, 2.5]}))
    assert found.value == pytest.approx(4.0)
    found = of("localization_nees", believed(**{"ads.position_sigma": [1.0, 0.0, 0.0, 1.0]}))
    assert (found.value, found.t, course(found)[0]) == (pytest.approx(25.0), 3.0, [3.0])
    never = believed(**{"ads.position_sigma": [0.0] * 4})
    assert compute("localization_nees", never).reason == "the stack never stated how sure it is of its position"


def test_innovations_count_once_each() -> None:
    """Held until the next one: 2 and 6 are the two that there were."""
    log = few({"ads.nis_gnss": [NAN, 2.0, 2.0, 6.0, 6.0, NAN]})
    found = of("nis", log, sensor="gnss")
    assert (found.value, found.t, found.extra) == (pytest.approx(4.0), 3.0, {"greatest": 6.0})
    assert of("nis", log, sensor="gnss", statistic="greatest").value == 6.0
    assert course(found) == ([1.0, 3.0], [2.0, 6.0])


# --- standing


GOAL = {"task": {"goal": {"road": "1"}}}


def stopped(x: float, y: float, *, v: Any = (5.0, 1.0, 0.05, 0.0), line: Any = ((0.0, 0.0), (6.0, 8.0))) -> Log:
    """At rest at a place, the goal being the end of a line that goes 6 m along and 8 m across."""
    places = {"x": [0.0, 0.0, x, x], "y": [0.0, 0.0, y, y], "v": list(v)}
    return few(places, reference=np.array(line, dtype=np.float64), meta=GOAL)


@pytest.mark.parametrize(
    ("x", "y", "beyond", "left"),
    [(6.0, 8.0, 0.0, 0.0), (9.0, 12.0, 5.0, 0.0), (3.0, 4.0, -5.0, 0.0), (2.0, 11.0, 0.0, 5.0), (10.0, 5.0, 0.0, -5.0)],
)
def test_where_the_ego_stopped_is_told_along_and_across_the_last_piece_of_its_line(
    x: float, y: float, beyond: float, left: float
) -> None:
    for line in (((0.0, 0.0), (6.0, 8.0)), ((0.0, 9.0), (0.0, 0.0), (6.0, 8.0), (6.0, 8.0))):
        found = of("stop_error", stopped(x, y, line=line))
        assert found.value == pytest.approx(abs(beyond))
        assert found.extra == {"beyond": pytest.approx(beyond), "left": pytest.approx(left)}
        assert found.t == 2.0  # slower than 0.05 m/s from then on


@pytest.mark.parametrize(
    ("log", "reason"),
    [
        (stopped(0.0, 0.0, v=(5.0, 1.0, 0.0, 0.051)), "the ego did not stand at the end of the log: 0.05 m/s"),
        (stopped(0.0, 0.0, v=(5.0, 1.0, 0.0, -0.2)), "the ego did not stand at the end of the log: -0.20 m/s"),
        (stopped(0.0, 0.0, line=((1.0, 2.0),)), "the task has no goal"),
        (stopped(0.0, 0.0, line=((1.0, 2.0), (1.0, 2.0))), "the reference line has no direction at the goal"),
    ],
)
def test_without_a_stop_or_a_direction_there_is_no_error(log: Log, reason: str) -> None:
    assert compute("stop_error", log).reason == reason


def test_who_never_moved_stopped_at_the_first_row() -> None:
    assert of("stop_error", stopped(0.0, 0.0, v=(0.05, 0.0, 0.0, 0.05))).t == 0.0
    assert of("stop_error", stopped(0.0, 0.0, v=(0.0, 0.06, 0.0, 0.05))).t == 2.0


def test_creeping_is_the_way_of_the_stretch_in_which_it_is_greatest() -> None:
    """1 s slower than 0.3 m/s counts: 0.2 and 0.1 over 1 s make 0.15 m; of 0.29, 0.29 and 0.29 it is 0.58 m."""
    v = [1.0, 0.2, 0.1, 1.0, 0.29, 0.29, 0.29, 0.3]
    found = of("creep", few({"v": v}))
    assert (found.value, found.t) == (pytest.approx(0.58), 4.0)
    assert of("creep", few({"v": v[:4]})).value == pytest.approx(0.15)
    assert of("creep", few({"v": v}), slow=0.25).value == pytest.approx(0.15)
    assert of("creep", few({"v": v[::-1]})).t == 1.0
    assert compute("creep", few({"v": v[:4]}), least=1.01).reason == "the ego was never slower than 0.3 m/s for 1.01 s"
    assert not compute("creep", few({"v": [NAN, NAN, 1.0]})).valid
    assert of("creep", few({"v": [0.0, 0.0, 1.0]})).value == 0.0


def test_who_rocks_creeps_from_the_hindmost_to_the_foremost_place() -> None:
    """Places after each second: 0.2, 0.2, 0, -0.2, -0.2 m. Noise that alternates leaves nothing."""
    assert of("creep", few({"v": [1.0, 0.2, 0.2, -0.2, -0.2, -0.2, 0.2]})).value == pytest.approx(0.4)
    assert of("creep", few({"v": [-1.0, -0.2, -0.2, -0.2, -1.0]})).value == pytest.approx(0.4)
    assert of("creep", few({"v": [1.0, *[0.02, -0.02] * 20]})).value == pytest.approx(0.0)


# --- commands that repeat


def test_repetitions_are_a_share_of_the_ticks_at_which_the_ego_moves() -> None:
    """Ticks 0.05 s apart; 2 of 4 are as the one before, in a row; up to 0.5 m/s is standing."""
    log = few({"v": [1.0] * 5, "steer_cmd": [0.1, 0.2, 0.2, 0.2, 0.3]}, t=0.05 * np.arange(5.0))
    found = of("repeated_commands", log)
    assert (found.value, found.t, found.extra) == (0.5, pytest.approx(0.1), {"longest": pytest.approx(0.1)})
    slow = few({"v": [1.0, 1.0, 0.5, 0.6, 1.0], "steer_cmd": [0.1, 0.2, 0.2, 0.2, NAN]}, t=0.05 * np.arange(5.0))
    found = of("repeated_commands", slow)
    assert (found.value, found.t, found.extra) == (0.5, pytest.approx(0.15), {"longest": pytest.approx(0.05)})
    none = of("repeated_commands", few({"v": [1.0] * 3, "steer_cmd": [0.1, 0.2, 0.3]}, t=0.05 * np.arange(3.0)))
    assert (none.value, none.t, none.extra) == (0.0, None, {"longest": 0.0})
    assert compute("repeated_commands", few({"v": [0.5, 0.5], "steer_cmd": [0.1, 0.1]}, t=[0.0, 0.05])).reason == (
        "the ego was never faster than 0.5 m/s under a command"
    )
    assert compute("repeated_commands", log, signal="accel_cmd").reason == "accel_cmd was not recorded"


# --- on and beside the lane


def test_time_off_the_road_is_that_to_the_next_row_and_at_the_end_a_usual_step() -> None:
    found = of("road_departure", few({"on_road": [1.0, 0.4, 0.6, 0.0, 1.0]}))
    assert (found.value, found.t) == (2.0, 1.0)
    assert course(found)[1] == [0.0, 1.0, 0.0, 1.0, 0.0]
    assert of("road_departure", few({"on_road": [1.0, 1.0, 0.0]})).value == 1.0
    never = of("road_departure", few({"on_road": [1.0, 0.5, NAN]}))
    assert (never.value, never.t) == (0.0, None)


def beside(y: Any, width: float = 4.0, **columns: Any) -> Log:
    """Along a line at y = 0, the ego's sides 0.75 m to either side of its middle."""
    rows = len(y)
    told = {"x": 5.0 + np.arange(rows), "y": y, "yaw": [0.0] * rows, "lane_width": [width] * rows, **columns}
    return few(told, reference=np.array([(0.0, 0.0), (100.0, 0.0)]))


def test_who_is_on_no_lane_at_all_is_outside_the_last_one() -> None:
    far = beside([0.0, 1.3, 20.0, 20.0, 0.0], lane_width=[4.0, 4.0, NAN, NAN, 4.0])
    assert of("lane_time_outside", far).value == 3.0
    first = beside([20.0, 20.0, 0.0], lane_width=[NAN, NAN, 4.0])  # which lane it came from is not known
    assert of("lane_time_outside", first).value == 0.0


def test_a_lane_is_left_when_a_side_is_farther_than_half_of_it() -> None:
    """Half of 4 m less 0.75 m is 1.25 m."""
    found = of("lane_time_outside", beside([0.0, 1.25, -1.35, 1.5, 0.0]))
    assert (found.value, found.t) == (2.0, 3.0)
    assert found.extra == {"farthest": pytest.approx(0.25)}
    assert course(found)[1] == pytest.approx([-1.25, 0.0, 0.1, 0.25, -1.25])
    last = of("lane_time_outside", beside([0.0, 0.0, 1.3]))
    assert (last.value, last.t) == (1.0, 2.0)
    kept = of("lane_time_outside", beside([0.0, 1.0]))
    assert (kept.value, kept.t, kept.extra) == (0.0, None, {"farthest": pytest.approx(-0.25)})
    assert of("lane_time_outside", beside([0.0, 1.0, 0.0]), width=3.0).value == 1.0
    assert not compute("lane_time_outside", beside([0.0, 1.0], width=0.0)).valid


def test_offsets_from_the_line_count_from_start_to_goal() -> None:
    """Of 3, 1, -2 and 5 m the middle two, both ends included."""
    events = (LogEvent(1.0, "start", "", ""), LogEvent(2.0, "goal", "", ""))
    log = beside([3.0, 1.0, -2.0, 5.0])
    part = few({name: log[name] for name in ("x", "y")}, reference=log.reference, events=events)
    found = of("lateral_rmse", part)
    assert (found.value, found.t) == (pytest.approx(math.sqrt(2.5)), 2.0)
    assert found.extra == {"greatest": pytest.approx(2.0), "coverage": 1.0}
    assert course(found) == ([1.0, 2.0], pytest.approx([1.0, -2.0]))
    assert of("lateral_rmse", log).value == pytest.approx(math.sqrt((9.0 + 1.0 + 4.0 + 25.0) / 4.0))
    one = few({name: log[name] for name in ("x", "y")}, reference=log.reference,
              events=(LogEvent(1.5, "start", "", ""), events[1]))  # fmt: skip
    assert compute("lateral_rmse", one).reason == "no samples between start and goal"


@pytest.mark.parametrize(("rows", "valid"), [(2, True), (3, False)])
def test_half_of_the_way_must_lie_beside_the_line(rows: int, valid: bool) -> None:
    x = np.array([-9.0] * rows + [5.0] * (4 - rows))
    found = compute("lateral_rmse", few({"x": x, "y": [1.0] * 4}, reference=np.array([(0.0, 0.0), (9.0, 0.0)])))
    assert found.valid is valid
    if valid:
        assert found.extra == {"greatest": 1.0, "coverage": 0.5}
    else:
        assert found.reason == "the ego is beside the line for 25 % of the time only"


def test_a_planned_path_holds_from_its_instant_until_the_next() -> None:
    paths = [(1.0, np.array([(0.0, 1.0), (9.0, 1.0)])), (2.0, np.array([(0.0, -1.0), (9.0, -1.0)]))]
    found = of("lateral_rmse_path", few({"x": [1.0, 2.0, 3.0, 4.0], "y": [0.0, 0.0, 1.0, 0.0]}, paths=paths))
    assert found.value == pytest.approx(math.sqrt((1.0 + 4.0 + 1.0) / 3.0))
    assert (found.t, found.extra["coverage"]) == (2.0, 0.75)


# --- others


def pair_at(x: float, y: float, yaw: float = 0.0) -> bool:
    """Whether boxes of 4 m by 2 m touch, one at the origin."""
    one, other = np.array([0.0, 0.0, 0.0, 4.0, 2.0]), np.array([x, y, yaw, 4.0, 2.0])
    found = {bool(touch(one, other)), bool(touch(other, one))}
    assert len(found) == 1
    return found.pop()


@pytest.mark.parametrize(
    ("x", "y", "yaw", "met"),
    [
        (4.0, 0.0, 0.0, True),  # bumper on bumper
        (4.001, 0.0, 0.0, False),
        (0.0, 2.0, 0.0, True),
        (0.0, -2.001, 0.0, False),
        (3.0, 0.0, math.pi / 2.0, True),  # across: half its width of 1 m
        (3.001, 0.0, math.pi / 2.0, False),
        (0.0, 3.0, math.pi / 2.0, True),
        (0.0, 3.001, math.pi / 2.0, False),
        (2.0 + 1.5 * math.sqrt(2.0) - 0.001, 0.0, math.pi / 4.0, True),  # its corner reaches (2 + 1) / sqrt(2)
        (2.0 + 1.5 * math.sqrt(2.0) + 0.001, 0.0, math.pi / 4.0, False),
        (2.0 + 1.5 * math.sqrt(2.0) - 0.001, 2.2, math.pi / 4.0, False),  # beside the corner: its own edge parts them
    ],
)
def test_boxes_touch_unless_an_edge_parts_them(x: float, y: float, yaw: float, met: bool) -> None:
    assert pair_at(x, y, yaw) is met


def test_the_worst_of_several_courses_keeps_its_moment_and_its_road_user() -> None:
    a = Course("a", np.array([0.0, 1.0, 2.0]), np.array([3.0, NAN, 1.0]))
    b = Course("b", np.array([1.0, 2.0, 3.0]), np.array([2.0, 5.0, 1.0]))
    never = Course("c", np.array([0.0]), np.array([NAN]))
    found = worst_of([never, a, b], "none", greatest=True)
    assert (found.value, found.t, found.object) == (5.0, 2.0, "b")
    assert (found.series.t.tolist(), found.series.value.tolist()) == ([0.0, 1.0, 2.0, 3.0], [3.0, 2.0, 5.0, 1.0])
    found = worst_of([never, a, b], "none", greatest=False)
    assert (found.value, found.t, found.object) == (1.0, 2.0, "a")
    assert found.series.value.tolist() == [3.0, 2.0, 1.0, 1.0]  # type: ignore[union-attr]


def alongside(speed: float) -> Log:
    t = times(0.02)
    return log_of(0.02, columns={"v": 3.0, "vx": 3.0}, objects={"other": track(t, 1.0, 4.0, vx=speed)})


@pytest.mark.parametrize(("speed", "passes"), [(2.0, False), (1.9, True), (4.0, False), (4.1, True), (-3.0, True)])
def test_who_is_a_metre_a_second_faster_or_slower_is_passed(speed: float, passes: bool) -> None:
    """4 m to the left, 1 m for half its width and 0.75 m for the ego's."""
    found = compute("passing_clearance", alongside(speed))
    assert found.valid is passes
    assert of("min_distance_lateral", alongside(speed)).value == pytest.approx(2.25)
    if passes:
        assert found.value == pytest.approx(2.25)
    else:
        assert found.reason == "the ego passed nobody faster than 1 m/s"


def test_hits_are_counted_by_what_was_hit_with_the_first_moment_of_all() -> None:
    """Two reports of one, the later one first; one that overlaps from 2 s on."""
    t = times(4.0)
    events = (LogEvent(3.0, "collision", "wall"), LogEvent(1.5, "collision", "wall"))
    others = {"car": track(t, np.where(t < 2.0, 50.0, 1.0), 0.0), "far": track(t, 90.0, 0.0)}
    found = of("collision", log_of(4.0, events=events, objects=others))
    assert (found.value, found.t, found.object) == (2.0, 1.5, "wall")
    found = of("collision", log_of(4.0, events=(LogEvent(3.0, "collision", "car"),), objects=others))
    assert (found.value, found.t, found.object) == (1.0, pytest.approx(2.0), "car")


# --- the task


def test_how_far_from_its_goal_an_ego_ended_is_told() -> None:
    log = few({"x": [0.0, 3.0], "y": [0.0, 4.0]}, reference=np.array([(1.0, 0.0), (0.0, 0.0)]), meta=GOAL)
    assert compute("completion_time", log).reason == (
        "the goal was never reached: the ego ended 5.0 m from it at t=1.00 s"
    )
    aimless = few({"x": [0.0, 3.0], "y": [0.0, 4.0]}, reference=np.array([(1.0, 0.0), (0.0, 0.0)]))
    assert compute("completion_time", aimless).reason == "the goal was never reached"


def test_a_task_that_took_place_says_when() -> None:
    events = (LogEvent(4.0, "goal", ""), LogEvent(3.0, "stop", ""), LogEvent(1.0, "start", ""))
    done, still = few({"x": [0.0] * 6}, events=events), few({"x": [0.0] * 6}, meta=GOAL)
    assert [(of(name, done).value, of(name, done).t) for name in ("goal_reached", "scenario_ended")] == [
        (1.0, 4.0), (1.0, 3.0),
    ]  # fmt: skip
    assert [(of(name, still).value, of(name, still).t) for name in ("goal_reached", "scenario_ended")] == [
        (0.0, 5.0), (0.0, 5.0),
    ]  # fmt: skip
    assert of("completion_time", done).value == 3.0


def test_an_event_is_counted_each_time_it_begins() -> None:
    began = [LogEvent(t, "story.event", "S::A::Cut", "standbyState -> runningState") for t in (3.0, 1.0)]
    over = LogEvent(4.0, "story.event", "S::A::Cut", "runningState -> completeState")
    meta = {"storyboard_events": ["S::A::Cut", "S::A::Other"]}
    log = few({"x": [0.0] * 6}, events=(*began, over), meta=meta)
    found = of("event_started", log, event="Cut")
    assert (found.value, found.t, found.object) == (2.0, 3.0, "Cut")
    none = of("event_started", log, event="Other")
    assert (none.value, none.t) == (0.0, None)
    assert compute("event_started", log, event="Cat").reason == "the scenario has no storyboard event 'Cat'"
    missing = of("events_fired", log)
    assert (missing.value, missing.t, missing.object) == (1.0, None, "S::A::Other")


# --- what is detected; this ego's bumper is 2.7 m ahead of its reference point


def watched(y: Any, *, at: float = 12.0, kind: str = "vehicle", n: int = 61) -> Log:
    """A car `at` metres ahead, 0.05 s a row, and detections beside it by `y` (NaN: none)."""
    t = 0.05 * np.arange(float(n))
    y = np.asarray(y, dtype=np.float64)
    rows = np.flatnonzero(np.isfinite(y))
    flat = {name: np.zeros(len(rows)) for name in ("yaw", "length", "width", "vx", "vy")}
    table = DetectionTable(t=t[rows], kind=(kind,) * len(rows), x=np.full(len(rows), at), y=y[rows], **flat)
    return drive_straight(0.0, 3.0, objects={"car": track(t, at, 0.0)}, detections=table)


def test_a_road_user_ahead_counts_after_a_second_and_is_missed_where_nothing_is_near() -> None:
    """Rows from 1 s on: 41 of 61; ten of them without a detection within 3 m are half a second."""
    y = np.full(61, 0.5)
    y[30:35], y[40:45], y[50] = 3.1, NAN, -2.0
    found = of("detection_error", watched(y))
    assert found.value == pytest.approx(math.sqrt((30.0 * 0.25 + 4.0) / 31.0))
    assert (found.t, found.object) == (pytest.approx(2.5), "car")
    assert found.extra == {"greatest": pytest.approx(2.0), "seen": pytest.approx(31.0 / 41.0)}
    missed = of("missed_objects", watched(y))
    assert (missed.value, missed.t, missed.object) == (pytest.approx(0.5), pytest.approx(1.5), "car")
    blind = watched(np.full(61, 0.5), kind="pedestrian")
    assert compute("detection_error", blind).reason == "no road user ahead of the ego was seen"
    assert of("missed_objects", blind).value == pytest.approx(41 * 0.05)


@pytest.mark.parametrize(
    ("at", "beside_it", "ahead"),
    [(2.7, 0.0, False), (2.71, 0.0, True), (22.69, 0.0, True), (22.7, 0.0, False), (12.0, 4.0, False),
     (12.0, -3.99, True)],
)  # fmt: skip
def test_ahead_is_from_the_bumper_to_twenty_metres_and_four_to_a_side(at: float, beside_it: float, ahead: bool) -> None:
    log = watched(np.full(61, beside_it), at=at)
    t = log.objects["car"].t
    log = drive_straight(0.0, 3.0, objects={"car": track(t, at, beside_it)}, detections=log.detections)
    for name in ("missed_objects", "detection_recall"):
        assert compute(name, log).valid is ahead
    recall = compute("detection_recall", log)
    assert recall.value == (1.0 if ahead else None)


def test_a_column_on_an_even_time_base_is_left_alone_within_a_thousandth_of_a_step() -> None:
    even, odd = few({"v": [0.0, 1.0, 2.0, 3.0]}), few({"v": [0.0, 1.0, 2.0, 3.0]}, t=[0.0, 1.0009, 2.0, 3.0])
    assert uniform(even, "v")[0] is even.t
    assert uniform(odd, "v")[0] is odd.t
    uneven = few({"v": [0.0, 1.0, 2.0, 3.0]}, t=[0.0, 1.1, 2.0, 3.0])
    t, v = uniform(uneven, "v")
    assert t == pytest.approx([0.0, 1.0, 2.0, 3.0])
    assert v == pytest.approx([0.0, 1.0 / 1.1, 2.0, 3.0])
    for log, reason in ((few({"v": [0.0, 1.0, 2.0]}), "too few samples"),
                        (few({"v": [0.0] * 4}, t=[0.0, 1.0, 1.0, 2.0]), "the time of the log does not increase"),
                        (few({"v": [0.0, NAN, 1.0, 1.0]}), "v was not measured throughout")):  # fmt: skip
        assert compute("max_jerk", log).reason == reason
