"""Boundaries of metrics and of gate files: on a line, beside it, in contact, at the border of a section, in a tie."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._box_collision_time import time_to_collision
from pytest_dvp.metrics._box_gaps import distances, gaps, overlap
from pytest_dvp.metrics.responsibility import _seen
from pytest_dvp.metrics.traffic_light import is_green, is_red
from pytest_dvp.verdicts.scenario_gates import _a_place, _off_road
from vehicle.messages import RoadPoint

# --- traffic lights; the front of this ego is 2 m ahead of its reference point, which is at x = t


def lit(*lines: dict[str, Any], phases: list[tuple[float, str, str]], y: float = 0.0, speed: float = 1.0) -> Log:
    """Lights at x; phases (t, name, state)."""
    t = times()
    events = tuple(LogEvent(at, "signal", name, state) for at, name, state in phases)
    ego = {"length": 2.0, "width": 1.5, "height": 1.4, "center_x": 1.0}
    return log_of(columns={"x": t * speed, "y": y, "v": speed, "vx": speed}, events=events,
                  meta={"stop_lines": list(lines), "ego": ego})  # fmt: skip


def line(name: str, x: float, width: float = 4.0) -> dict[str, Any]:
    return {"signal": name, "x": x, "y": 0.0, "heading": 0.0, "width": width}


def value(name: str, log: Log, **options: Any) -> Any:
    found = compute(name, log, **options)
    assert found.valid, found.reason
    return found


def test_a_front_that_stands_on_the_line_has_passed_it() -> None:
    """At t = 5 s it is at 7 m, to the last bit; the row that reaches the line is the one that counts."""
    found = value("red_light", lit(line("a", 7.0), phases=[(0.0, "a", "red")]))
    assert (found.value, found.t, found.object) == (1.0, 5.0, "a")
    assert value("red_light", lit(line("a", 7.0), phases=[(5.0, "a", "red")])).value == 1.0
    assert value("red_light", lit(line("a", 7.0), phases=[(5.005, "a", "red")])).value == 0.0
    assert value("red_light", lit(line("a", 7.0), phases=[(0.0, "a", "red"), (5.0, "a", "green")])).value == 0.0
    assert value("red_light", lit(line("a", 2.0), phases=[(0.0, "a", "red")])).value == 0.0  # began on it


@pytest.mark.parametrize(("y", "lights"), [(2.0, 1.0), (-2.0, 1.0), (2.01, 0.0), (-2.01, 0.0)])
def test_a_line_ends_at_half_its_width(y: float, lights: float) -> None:
    assert value("red_light", lit(line("a", 7.0), phases=[(0.0, "a", "red")], y=y)).value == lights


def test_of_several_lights_the_first_that_was_passed_is_named() -> None:
    """One that is never in a state, whichever place it has, is no light."""
    phases = [(0.0, "far", "red"), (0.0, "near", "red")]
    found = value("red_light", lit(line("dark", 3.0), line("far", 9.0), line("near", 4.0), phases=phases))
    assert (found.value, found.t, found.object) == (2.0, pytest.approx(2.0), "near")
    assert not compute("red_light", lit(line("dark", 3.0), phases=phases)).valid


@pytest.mark.parametrize(("x", "counts"), [(51.99, True), (52.0, False), (2.01, True), (2.0, False)])
def test_a_light_is_the_ego_s_from_50_m_to_the_line(x: float, counts: bool) -> None:
    """It stands with its front at 2 m; neither end belongs to it."""
    log = lit(line("a", x), phases=[(0.0, "a", "red"), (4.0, "a", "green")], speed=0.0)
    delay, beyond = compute("start_up_delay", log), compute("stop_line", log)
    assert delay.valid is beyond.valid is counts
    if counts:
        assert delay.value == pytest.approx(6.0)  # never sets off
        assert beyond.value == pytest.approx(2.0 - x)


def test_the_light_that_turns_green_is_the_one_that_is_waited_for() -> None:
    """From green to green nobody waits; of two phases at any order in the log the times count."""
    phases = [(4.0, "a", "green"), (1.0, "a", "red"), (6.0, "a", "green")]
    found = value("start_up_delay", lit(line("a", 5.0), phases=phases, speed=0.0))
    assert (found.value, found.t) == (pytest.approx(6.0), 4.0)


@pytest.mark.parametrize(
    ("state", "red", "green"),
    [
        ("red", True, False),
        (" Red ", True, False),
        ("red amber", True, False),  # Vienna Convention on Road Signs, article 23: red still holds
        ("red;yellow", True, False),
        ("amber", False, False),
        ("amber;off;off", False, False),
        ("green", False, True),
        ("on;off;off", True, False),
        ("true;false;false", True, False),
        ("1;0;0", True, False),
        ("on;on;off", True, False),  # soon green, and red until then
        ("off;on;off", False, False),
        ("off;off;on", False, True),
        ("0 ; 0 ; 1", False, True),
        ("on;off", True, False),  # two lamps: for walkers
        ("off;off;off", False, False),
        ("on;off;off;", True, False),  # a separator at the end as well
        ("off;off;on; ", False, True),
        ("stop", True, False),
        ("go", False, True),
        ("orange", False, False),
        ("flashing red", True, False),  # Vienna Convention, article 23, 1 b: nobody passes; amber that flashes warns
        ("flashing;off;off", True, False),
        ("off;flashing;off", False, False),
        ("off;off;blinking", False, True),
    ],
)
def test_lamps_and_words(state: str, red: bool, green: bool) -> None:
    assert (is_red(state), is_green(state)) == (red, green)


# --- boxes: x, y [m], yaw [rad], length, width [m], vx, vy [m/s]


def box(*numbers: float) -> Any:
    return np.array([[*numbers, *(0.0,) * (7 - len(numbers))]])


def turned(x: float, y: float, angle: float) -> Any:
    """A box of 2 m by 1 m."""
    return box(x, y, angle, 2.0, 1.0)


@pytest.mark.parametrize("angle", [0.3, 0.8, 1.2, -0.3, -0.8, -1.2, 0.8 + math.pi])
def test_boxes_touch_where_a_corner_meets_an_edge(angle: float) -> None:
    """A box of 40 m by 20 m, and beside the middle of each edge one of 2 m by 1 m, turned: it reaches c |cos| + d |sin|
    along the x axis, c |sin| + d |cos| along the y axis. Moved away by 1 mm they meet after 1 ms at 1 m/s."""
    large = box(0.0, 0.0, 0.0, 40.0, 20.0)
    c, s = abs(math.cos(angle)), abs(math.sin(angle))
    along, across = 20.0 + c + 0.5 * s, 10.0 + s + 0.5 * c
    for x, y in ((along, 0.0), (-along, 0.0), (0.0, across), (0.0, -across)):
        far = math.hypot(x, y)
        for off, touch in ((-0.001, True), (0.001, False)):
            small = turned(x * (1.0 + off / far), y * (1.0 + off / far), angle)
            assert overlap(large, small)[0] == overlap(small, large)[0] == touch
            assert distances(large, small)[0] == pytest.approx(max(off, 0.0), abs=1e-9)
            small[0, 5:] = -x / far, -y / far
            for pair in ((large, small), (small, large)):
                assert time_to_collision(*pair)[0] == pytest.approx(max(off, 0.0), abs=1e-9)


@pytest.mark.parametrize(("x", "y"), [(4.0, 0.0), (-4.0, 0.0), (0.0, 2.0), (0.0, -2.0), (4.0, 2.0), (-4.0, -2.0)])
def test_boxes_that_touch_are_in_contact_even_if_nobody_moves(x: float, y: float) -> None:
    """Two of 4 m by 2 m along the axes: no rounding. A millimetre apart they never meet."""
    still = box(0.0, 0.0, 0.0, 4.0, 2.0)
    for share, time in ((1.0, 0.0), (1.0005, math.inf)):
        other = box(share * x, share * y, 0.0, 4.0, 2.0)
        assert time_to_collision(still, other)[0] == time_to_collision(other, still)[0] == time


def test_boxes_beside_a_corner_meet_only_if_they_come_that_way() -> None:
    still, far = box(0.0, 0.0, 0.0, 4.0, 2.0), box(12.0, 11.0, 0.0, 4.0, 2.0)
    for vx, vy, time in ((-1.0, -1.0, 9.0), (-8.0, -9.0, 1.0), (-1.0, -0.5, math.inf), (1.0, 1.0, math.inf)):
        far[0, 5:] = vx, vy
        assert time_to_collision(still, far)[0] == pytest.approx(time)
    assert time_to_collision(still, box(4.5, 0.0, 0.0, 4.0, 2.0))[0] == math.inf  # nobody moves
    assert time_to_collision(still, box(3.9, 1.9, 0.0, 4.0, 2.0))[0] == 0.0


@pytest.mark.parametrize(
    ("x", "y", "along", "across"),
    [
        (10.0, 0.5, 6.0, 0.0),  # ahead: 10 - 2 - 2
        (-10.0, 0.5, 6.0, 0.0),
        (10.0, 2.1, math.nan, math.nan),
        (1.0, 5.0, 0.0, 3.0),  # beside: 5 - 1 - 1
        (1.0, -5.0, 0.0, 3.0),
        (1.0, 0.5, 0.0, 0.0),  # in each other
    ],
)
def test_free_distance_along_and_across(x: float, y: float, along: float, across: float) -> None:
    """Both are 4 m by 2 m. Along: of what is in the strip as wide as the first; across: in the one as long as it."""
    first, other = box(0.0, 0.0, 0.0, 4.0, 2.0), box(x, y, 0.0, 4.0, 2.0)
    if abs(y) <= 2.0:
        assert gaps(first, other, 0)[0] == pytest.approx(along, nan_ok=True)
    else:
        assert math.isnan(gaps(first, other, 0)[0])
    if abs(x) <= 4.0:
        assert gaps(first, other, 1)[0] == pytest.approx(across, nan_ok=True)
    else:
        assert math.isnan(gaps(first, other, 1)[0])


@pytest.mark.parametrize(("x", "rear", "front"), [(0.5, 5.0, 3.0), (0.0, 5.0, 3.0), (-0.5, 3.0, 5.0)])
def test_whose_middle_is_ahead_leads(x: float, rear: float, front: float) -> None:
    """At 5 and at 3 m/s, 3 m beside each other; sideways speeds count from the ego to the other one."""
    ego, other = box(0.0, 0.0, 0.0, 4.0, 2.0, 5.0, 0.5), box(x, 5.0, 0.0, 4.0, 2.0, 3.0, -0.25)
    found = [float(part[0]) for part in _seen(ego, other)]
    assert found == pytest.approx([0.0, 3.0, rear, front, 0.5, -0.25])
    other = box(x, -5.0, 0.0, 4.0, 2.0, 3.0, 0.25)
    assert [float(part[0]) for part in _seen(ego, other)] == pytest.approx([0.0, 3.0, rear, front, -0.5, -0.25])


# --- what is straight ahead; this ego's middle is 1.2 m ahead of its reference point, its front 1.5 m farther


def approach(x: float, speed: float = 0.0, own: float = 4.0) -> Log:
    t = times(0.02)
    return log_of(0.02, columns={"v": own, "vx": own}, objects={"other": track(t, x, 0.0, vx=speed)})


def test_a_contact_is_a_gap_of_0_and_counts_as_the_resolution() -> None:
    """The rear of the other one is 2 m behind its middle, and the ego's front at 2.7 m."""
    assert value("time_headway", approach(6.7)).value == pytest.approx(0.5)  # 2 m at 4 m/s
    assert value("time_headway", approach(4.0)).value == 0.0
    assert value("required_deceleration", approach(6.7)).value == pytest.approx(4.0)  # 16 / 4
    assert value("required_deceleration", approach(4.0)).value == pytest.approx(80.0)  # 16 / 0.2
    assert value("required_deceleration", approach(4.0), resolution=0.5).value == pytest.approx(16.0)


def test_whose_middle_is_not_ahead_is_not_ahead() -> None:
    for name in ("time_headway", "required_deceleration"):
        assert compute(name, approach(1.21)).valid
        assert not compute(name, approach(1.2)).valid
        assert not compute(name, approach(-9.0)).valid


def test_a_gap_that_does_not_close_needs_no_braking_and_who_is_slow_has_no_headway() -> None:
    for speed in (4.0, 5.0):
        found = value("required_deceleration", approach(6.7, speed))
        assert (found.value, found.object) == (0.0, "")
    assert compute("time_headway", approach(6.7, own=0.51)).valid
    assert not compute("time_headway", approach(6.7, own=0.5)).valid  # faster than that, it says
    assert not compute("time_headway", approach(6.7, own=-4.0)).valid


# --- the task of a gate file on the road of its scenario

FACTS: Any = SimpleNamespace(
    lengths={"1": 50.0, "long": 120.66, "2": 80.0},
    lanes={
        "1": ((0.0, frozenset({-1, 0, 1})),),
        "long": ((0.0, frozenset({-2, -1, 0, 1})), (60.4, frozenset({0, 2, 3})), (100.0, frozenset({0}))),
        "2": (),
    },
)


@pytest.mark.parametrize(
    ("road", "lane", "s", "wrong"),
    [
        ("1", -1, 50.0, None),  # the end of a road is on it
        ("1", -1, 50.1, "s"),
        ("1", 0, 10.0, "lane"),  # the middle is no lane
        ("1", 1, 0.0, None),
        ("long", -2, 60.3, None),
        ("long", 2, 60.3, "lane"),
        ("long", 2, 60.4, None),  # a section begins at its s
        ("long", -2, 60.4, "lane"),
        ("long", 3, 99.9, None),
        ("long", 3, 100.0, "lane"),
        ("2", -1, 10.0, "lane"),
        ("3", -1, 10.0, "road"),
    ],
)
def test_places_at_the_borders_of_roads_and_sections(road: str, lane: int, s: float, wrong: str | None) -> None:
    found = _off_road(RoadPoint(road, lane, s), FACTS)
    assert (found and found[0]) == wrong


def test_what_is_allowed_is_told_without_the_middle_lane() -> None:
    def off(road: str, lane: int, s: float) -> Any:
        return _off_road(RoadPoint(road, lane, s), FACTS)

    assert off("long", 5, 10.0)[3] == "-2, -1, 1"
    assert off("long", 5, 110.0)[3] == "none"
    assert off("2", 5, 10.0)[3] == "none"
    assert off("1", -1, 60.0)[2:4] == ("60", "0 ... 50 m on road 1")
    assert "long" in off("lon", -1, 60.0)[4]
    assert off("3", -1, 60.0)[4] == ""  # a number is no misspelling of another


def test_a_place_that_is_proposed_exists() -> None:
    """The middle of the longest road to 0.1 m; of its lanes there the one nearest to the middle."""
    assert _a_place(FACTS) == '{ road = "long", lane = -1, s = 60.3 }'
    for lanes, lane in (({1, -1, 0}, -1), ({0, 2, -3}, 2), ({0, -2, 2}, -2), ({0}, -1)):
        facts: Any = SimpleNamespace(lengths={"a": 40.0}, lanes={"a": ((0.0, frozenset(lanes)),)})
        assert _a_place(facts) == f'{{ road = "a", lane = {lane}, s = 20.0 }}'
    begins: Any = SimpleNamespace(lengths={"a": 40.0}, lanes={"a": ((0.0, frozenset({-1})), (20.0, frozenset({3})))})
    assert "lane = 3, s = 20.0" in _a_place(begins)
    assert _off_road(RoadPoint("a", 3, 20.0), begins) is None


def test_a_map_whose_lines_are_not_as_a_run_writes_them_is_told() -> None:
    log = lit({"signal": "a", "x": 7.0}, phases=[(0.0, "a", "red")])
    assert "signal, x, y, heading, width" in compute("red_light", log).reason
    assert "stop_lines" in compute("red_light", log_of()).reason


# --- the same drive anywhere on the map, and the worst of several


def moved(x: Any, y: Any, angle: float) -> tuple[Any, Any]:
    """Places of a map that was turned about its origin and shifted by 30 m and -20 m."""
    return (30.0 + x * math.cos(angle) - y * math.sin(angle), -20.0 + x * math.sin(angle) + y * math.cos(angle))


@pytest.mark.parametrize("angle", [0.7, 2.5, -1.9])
def test_lights_do_not_depend_on_the_frame_of_the_map(angle: float) -> None:
    """At 1 m/s to where its front is 1.5 m beyond the line, 0.9 m beside its middle; it stands from 6 s on."""
    t = times()
    way = np.minimum(t, 6.0)
    x, y = moved(way, 0.9, angle)
    px, py = moved(6.5, 0.0, angle)
    stop = {"signal": "a", "x": px, "y": py, "heading": angle, "width": 2.0}
    v = np.where(t < 6.0, 1.0, 0.0)
    ego = {"length": 2.0, "width": 1.5, "height": 1.4, "center_x": 1.0}
    log = log_of(columns={"x": x, "y": y, "yaw": angle, "v": v, "vx": v},
                 events=(LogEvent(0.0, "signal", "a", "red"),), meta={"stop_lines": [stop], "ego": ego})  # fmt: skip
    assert value("red_light", log).t == pytest.approx(4.5, abs=0.011)
    found = value("stop_line", log)
    assert (found.value, found.t) == (pytest.approx(1.5), pytest.approx(6.0, abs=0.011))
    narrow = log_of(columns={"x": x, "y": y, "yaw": angle, "v": v, "vx": v},
                    events=(LogEvent(0.0, "signal", "a", "red"),),
                    meta={"stop_lines": [stop | {"width": 1.7}], "ego": ego})  # fmt: skip
    assert value("red_light", narrow).value == 0.0


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5, -1.9])
def test_who_is_ahead_does_not_depend_on_the_frame_of_the_map(angle: float) -> None:
    """6 m/s behind one of 2 m/s, middle 10 m ahead of the own reference point: 10 - 2.7 - 2 = 5.3 m are free."""
    t = times(0.02)
    (x, y), (ox, oy), (bx, by) = (moved(*place, angle) for place in ((0.0, 0.0), (10.0, 0.4), (-9.0, 0.0)))
    cos, sin = math.cos(angle), math.sin(angle)
    others = {"behind": track(t, bx, by, yaw=angle, vx=9.0 * cos, vy=9.0 * sin),
              "ahead": track(t, ox, oy, yaw=angle, vx=2.0 * cos, vy=2.0 * sin)}  # fmt: skip
    log = log_of(0.02, columns={"x": x, "y": y, "yaw": angle, "v": 6.0, "vx": 6.0}, objects=others)
    headway, braking = value("time_headway", log), value("required_deceleration", log)
    assert (headway.value, headway.object) == (pytest.approx(5.3 / 6.0), "ahead")
    assert (braking.value, braking.object) == (pytest.approx(16.0 / 10.6), "ahead")


def test_of_several_ahead_the_worst_counts() -> None:
    """Least for a headway (near, and as fast as the ego), greatest for a deceleration (far, and standing)."""
    t = times(0.02)
    others = {"far": track(t, 14.7, 0.0), "near": track(t, 8.7, 0.0, vx=4.0)}
    log = log_of(0.02, columns={"v": 4.0, "vx": 4.0}, objects=others)
    headway, braking = value("time_headway", log), value("required_deceleration", log)
    assert (headway.value, headway.object) == (pytest.approx(1.0), "near")
    assert (braking.value, braking.object) == (pytest.approx(0.8), "far")


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5, -1.9])
@pytest.mark.parametrize(
    ("mine", "its", "rear", "front"),
    [
        (5.0, 3.0, 5.0, 3.0),
        (5.0, -3.0, 5.0, -3.0),  # they meet
        (-5.0, 3.0, -5.0, 3.0),  # apart
        (-5.0, -3.0, 3.0, 5.0),  # both go back: the other follows
        (-5.0, 0.0, -5.0, 0.0),  # one that stands follows nobody
        (1e-7, -3.0, 0.0, -3.0),  # rounding is no motion
    ],
)
def test_who_leads_by_where_both_drive(angle: float, mine: float, its: float, rear: float, front: float) -> None:
    """The other one's middle is 10 m ahead and 4 m to the left: 6 m and 2 m are free; aside 0.5 and -0.25 m/s."""
    cos, sin = math.cos(angle), math.sin(angle)
    (x, y), (ox, oy) = moved(0.0, 0.0, angle), moved(10.0, 4.0, angle)
    ego = box(x, y, angle, 4.0, 2.0, mine * cos - 0.5 * sin, mine * sin + 0.5 * cos)
    other = box(ox, oy, angle, 4.0, 2.0, its * cos + 0.25 * sin, its * sin - 0.25 * cos)
    found = [float(part[0]) for part in _seen(ego, other)]
    assert found == pytest.approx([6.0, 2.0, rear, front, 0.5, -0.25], abs=1e-12)


def test_the_farthest_beyond_a_line_and_the_longest_wait_are_told_with_their_light() -> None:
    """The ego stands with its front at 2 m, sets off at 8 s, and comes to 4 m: lines at 2.5 and 3 m."""
    t = times()
    x = np.clip(t - 8.0, 0.0, 2.0)
    v = np.where(t >= 8.0 - 1e-9, 1.0, 0.0)
    ego = {"length": 2.0, "width": 1.5, "height": 1.4, "center_x": 1.0}
    phases = [(0.0, "b", "red"), (0.0, "a", "red"), (4.0, "b", "green"), (7.0, "c", "red"), (7.5, "a", "green"),
              (9.0, "c", "green")]  # fmt: skip
    for names in ("abc", "cba"):
        lines = [line(name, {"a": 3.0, "b": 2.5, "c": 2.6}[name]) for name in names]
        log = log_of(columns={"x": x, "v": v, "vx": v}, meta={"stop_lines": lines, "ego": ego},
                     events=tuple(LogEvent(at, "signal", name, state) for at, name, state in phases))  # fmt: skip
        wait = value("start_up_delay", log)
        assert (wait.value, wait.t, wait.object) == (pytest.approx(4.0), 4.0, "b")
        beyond = value("stop_line", log)  # c is red until the front is at 3 m, all but a row
        assert (beyond.value, beyond.object) == (pytest.approx(0.39), "c")
