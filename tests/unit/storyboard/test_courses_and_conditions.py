"""Courses, ramps that meet in time, and conditions on motion and distance, each with numbers worked out by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard.actions.synchronize import Synchronize, _corner
from openscenario.storyboard.conditions import distance as distances
from openscenario.storyboard.conditions.angle import angle, relative_angle
from openscenario.storyboard.conditions.distance import reach_position, time_headway, time_to_collision
from openscenario.storyboard.conditions.motion import relative_speed, stand_still, travelled
from openscenario.storyboard.conditions.values import simulation_time
from openscenario.storyboard.distances import Span, _to_edges, gap, overlap
from openscenario.storyboard.places import Place
from openscenario.storyboard.trajectories import Course, _arc, _between, _pace

from .bodies import car

INF = math.inf

# --- courses: a straight of 3 m and one of 4 m to the left, rising by 3 m in the second

CORNERED = [(0.0, 0.0, 0.0, 0.0), (3.0, 0.0, 0.0, 0.0), (3.0, 4.0, 3.0, 0.5 * math.pi)]


@pytest.mark.parametrize(
    ("s", "x", "y", "z", "h"),
    [
        (-1.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (1.5, 1.5, 0.0, 0.0, 0.0),
        (3.0, 3.0, 0.0, 0.0, 0.0),
        (5.0, 3.0, 2.0, 1.5, 0.25 * math.pi),
        (7.0, 3.0, 4.0, 3.0, 0.5 * math.pi),
        (9.0, 3.0, 4.0, 3.0, 0.5 * math.pi),
    ],
)
def test_a_place_along_a_course(s: float, x: float, y: float, z: float, h: float) -> None:
    assert Course(CORNERED).at(s) == pytest.approx((x, y, z, h))


def test_a_course_of_one_point_and_one_whose_points_coincide() -> None:
    one = Course([(1.0, 2.0, 3.0, 0.5)], [7.0])
    assert (one.at(5.0), one.length, one.pitch(0.0)) == ((1.0, 2.0, 3.0, 0.5), 0.0, 0.0)
    assert (one.s_at(9.0), one.start_time, one.end_time, one.nearest(0.0, 0.0)) == (0.0, 7.0, 7.0, 0.0)
    twice = Course([(1.0, 2.0, 3.0, 0.5), (1.0, 2.0, 4.0, 0.7)])
    assert twice.at(0.0) == pytest.approx((1.0, 2.0, 4.0, 0.7))
    assert (twice.tangent(0.0), twice.pitch(0.0)) == (0.5, 0.0)
    assert (twice.s_at(3.0), twice.start_time, twice.end_time) == (0.0, 0.0, 0.0)
    assert Course(CORNERED, [2.0, 2.0, 3.0]).s_at(2.0) == 0.0  # it begins at its first point
    late = Course([(0.0, 0.0, 0.0, 0.9), (0.0, 0.0, 0.0, 0.9), (0.0, 5.0, 0.0, 0.9)])
    assert late.tangent(0.0) == pytest.approx(0.5 * math.pi)


@pytest.mark.parametrize(("s", "tangent", "pitch"), [(-1.0, 0.0, 0.0), (2.9, 0.0, 0.0), (3.0, 0.5 * math.pi, -0.6435),
                                                     (9.0, 0.5 * math.pi, -0.6435)])  # fmt: skip
def test_direction_and_pitch_are_those_of_the_piece(s: float, tangent: float, pitch: float) -> None:
    """3 m up on 4 m; uphill is negative."""
    assert Course(CORNERED).tangent(s) == pytest.approx(tangent)
    assert Course(CORNERED).pitch(s) == pytest.approx(pitch, abs=1e-4)


@pytest.mark.parametrize(("x", "y", "s"), [(-5.0, 1.0, 0.0), (1.0, 2.0, 1.0), (2.0, 3.0, 6.0), (9.0, 9.0, 7.0),
                                           (2.0, 1.0, 2.0)])  # fmt: skip
def test_the_nearest_point_of_a_course(x: float, y: float, s: float) -> None:
    """At (2, 1) both pieces are 1 m away: the first counts."""
    assert Course(CORNERED).nearest(x, y) == pytest.approx(s)


@pytest.mark.parametrize(
    ("t", "s"), [(0.0, 0.0), (1.0, 0.0), (2.0, 1.5), (3.0, 3.0), (4.0, 5.0), (5.0, 7.0), (9.0, 7.0)]
)
def test_where_a_course_is_between_its_time_stamps(t: float, s: float) -> None:
    timed = Course(CORNERED, [1.0, 3.0, 5.0])
    assert timed.s_at(t) == pytest.approx(s)
    assert (timed.start_time, timed.end_time) == (1.0, 5.0)
    if 1.0 <= t <= 5.0:
        assert timed.time_at(s) == pytest.approx(t)


def test_with_a_speed_it_goes_on_between_time_stamps_at_constant_acceleration() -> None:
    """3 m in 2 s from 0.5 m/s: 1 m/s^2, then 4 m in 2 s from 2.5 m/s: -0.5; it arrives with 1.5 m/s."""
    timed = Course(CORNERED, [1.0, 3.0, 5.0], speed=0.5)
    assert timed.s_at(2.0) == pytest.approx(0.5 + 0.5)
    assert timed.s_at(3.0) == pytest.approx(3.0)
    assert timed.s_at(4.0) == pytest.approx(3.0 + 2.5 - 0.25)
    assert _pace([0.0, 3.0, 7.0], [1.0, 3.0, 5.0], 0.5) == [pytest.approx((0.5, 1.0)), pytest.approx((2.5, -0.5))]


def test_who_would_have_to_go_back_stands_at_the_next_point_before_its_time() -> None:
    """3 m in 2 s from 6 m/s: braked with 36 / 6 m/s^2 it stands after 1 s."""
    assert _pace([0.0, 3.0, 7.0], [0.0, 2.0, 4.0], 6.0) == [pytest.approx((6.0, -6.0)), pytest.approx((0.0, 2.0))]
    timed = Course(CORNERED, [0.0, 2.0, 4.0], speed=6.0)
    assert [timed.s_at(t) for t in (0.5, 1.0, 1.9, 3.0)] == pytest.approx([2.25, 3.0, 3.0, 4.0])


def test_points_at_one_place_or_time_have_no_acceleration() -> None:
    assert _pace([0.0, 0.0, 4.0], [0.0, 1.0, 2.0], 3.0) == [(0.0, 0.0), (0.0, 8.0)]
    assert _pace([0.0, 5e-7, 4.0], [0.0, 1.0, 2.0], 3.0)[0] == (0.0, 0.0)
    assert _pace([0.0, 2.0, 4.0], [0.0, 0.0, 1.0], 3.0) == [(3.0, 0.0), pytest.approx((3.0, -2.0))]
    # 3 m in 4 s from 1 m/s: 0.5 m/s at the end, which is no way back
    assert _pace([0.0, 3.0], [0.0, 4.0], 1.0) == [pytest.approx((1.0, -0.125))]


@pytest.mark.parametrize(
    ("s", "h"),
    [(0.0, 0.0), (7.9, 0.0), (9.0, 0.25), (9.99, 0.4975), (10.01, 0.5025), (11.0, 0.75), (12.1, 1.0), (20.0, 1.0)],
)
def test_near_a_vertex_a_heading_turns_within_two_metres(s: float, h: float) -> None:
    """Pieces of 10 m with headings of 0 and 1 rad: half of the turn lies before the vertex, half behind."""
    points = [(0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 0.0, 1.0), (20.0, 0.0, 0.0, 1.0)]
    assert Course(points, smooth=[False] * 3).at(s)[3] == pytest.approx(h)
    assert Course(points, smooth=[False] * 3, corner=0.0).at(s)[3] == pytest.approx(0.0 if s < 10.0 else 1.0)


def test_on_short_pieces_a_heading_turns_within_half_of_them() -> None:
    points = [(0.0, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 1.0), (4.0, 0.0, 0.0, 1.0)]
    line = Course(points, smooth=[False] * 3)
    assert [line.at(s)[3] for s in (0.9, 1.5, 2.5, 3.1)] == pytest.approx([0.0, 0.25, 0.75, 1.0])


@pytest.mark.parametrize(
    ("u", "value"), [(-1.0, 10.0), (0.0, 10.0), (1.0, 15.0), (2.0, 40.0), (3.0, 50.0), (9.0, 60.0)]
)
def test_values_between_places_that_may_coincide(u: float, value: float) -> None:
    assert _between([0.0, 2.0, 2.0, 4.0], [10.0, 20.0, 40.0, 60.0], u) == pytest.approx(value)


def test_an_arc_has_its_points_each_decimetre_and_ends_on_the_circle() -> None:
    points = _arc(1.0, 2.0, 3.0, 0.0, 0.1, 0.0, 5.0 * math.pi)
    assert len(points) == 1 + math.ceil(50.0 * math.pi)
    assert points[0] == (1.0, 2.0, 3.0, 0.0)
    assert points[-1] == pytest.approx((11.0, 12.0, 3.0, 0.5 * math.pi))
    assert len(_arc(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)) == 2
    assert len(_arc(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2)) == 3


# --- boxes


@pytest.mark.parametrize(
    ("low", "high", "apart"),
    [(3.0, 4.0, 1.0), (2.0, 4.0, 0.0), (-4.0, -3.0, -2.0), (-3.0, -1.0, 0.0), (-9.0, 9.0, 0.0)],
)
def test_a_gap_is_signed_and_nought_where_intervals_touch(low: float, high: float, apart: float) -> None:
    assert gap(Span(-1.0, 2.0), Span(low, high)) == apart


def test_the_distance_of_a_point_from_a_box_and_of_boxes_that_touch() -> None:
    box = ((2.0, 1.0), (-2.0, 1.0), (-2.0, -1.0), (2.0, -1.0))
    assert _to_edges((5.0, 5.0), box) == pytest.approx(5.0)  # 3-4-5 from the corner
    assert _to_edges((0.0, 4.0), box) == pytest.approx(3.0)
    assert _to_edges((-4.5, 0.5), box) == pytest.approx(2.5)
    assert _to_edges((1.0, 0.0), ((0.0, 0.0),) * 4) == 1.0
    for shift, met in ((4.0, True), (4.001, False), (-4.0, True), (-4.001, False)):
        assert overlap(box, tuple((x + shift, y) for x, y in box)) is met
    for shift, met in ((2.0, True), (2.001, False)):
        assert overlap(box, tuple((x, y + shift) for x, y in box)) is met


# --- ramps that meet in time


@pytest.mark.parametrize(
    ("way", "time", "speed", "final", "between", "first"),
    [
        (20.0, 4.0, 2.0, 2.0, 8.0, 2.0),  # 2 -> 8 -> 2 m/s: 10 m in each half
        (8.0, 4.0, 4.0, 4.0, 0.0, 2.0),
        (10.0, 4.0, 0.0, 2.0, 0.5 * (5.0 + math.sqrt(13.0)), None),  # 8 vx^2 - 40 vx + 24 = 0
        (0.35, 0.3, 0.0, 1.0, 2.0, 0.2),  # 0.2 m to 2 m/s with 10 m/s^2, and 0.15 m on the way back to 1 m/s
    ],
)
def test_the_speed_between_two_ramps_of_one_steepness(
    way: float, time: float, speed: float, final: float, between: float, first: float | None
) -> None:
    vx, until = _corner(way, time, speed, final)
    assert vx == pytest.approx(between)
    if first is not None:
        assert until == pytest.approx(first)
    if speed != final:
        assert (vx - speed) / until == pytest.approx((vx - final) / (time - until))
    assert 0.5 * (speed + vx) * until + 0.5 * (vx + final) * (time - until) == pytest.approx(way)


def synchronizing(phase: str = "new", *, linger: bool = False, steady: tuple[float, float] = (0.0, 0.0)) -> Any:
    action: Any = Synchronize.__new__(Synchronize)
    action._phase, action._linger, action._final = phase, linger, None

    class Steady(Synchronize):
        __slots__ = ()

        def _steady(self, final: float) -> tuple[float, float]:
            return steady

    action.__class__ = Steady
    return action


@pytest.mark.parametrize(
    ("phase", "way", "time", "speed", "final", "after", "then"),
    [
        ("new", 20.0, 4.0, 2.0, 2.0, 2.3, "two ramps"),  # to 8 m/s in 2 s: 3 m/s^2 for 0.1 s
        ("last ramp", 6.0, 2.0, 4.0, 2.0, 3.9, "last ramp"),  # from 4 to 2 m/s in 2 s
        ("last ramp", 6.0, 0.1, 4.0, 2.0, 2.0, "last ramp"),
        ("two ramps", 6.0, 2.0, 4.05, 2.0, 3.9, "last ramp"),  # as good as on it
        ("two ramps", 6.0, 2.0, 4.11, 2.0, 4.11, "last ramp"),  # beyond the corner: it keeps its speed once
        ("stopped", 6.0, 6.1, 0.0, 2.0, 0.0, "stopped"),  # 12 m at 2 m/s: the ramp fits in 6 s
        ("stopped", 6.0, 5.9, 0.0, 2.0, None, "last ramp"),
        ("stopped", 6.0, 5.9, 0.0, 0.0, 0.0, "stopped"),
        ("stopped", 6.0, 1e10, 0.0, 2.0, 0.0, "stopped"),
        ("last ramp", 6.0, 1e10, 3.0, 2.0, 0.0, "last ramp"),  # the master stands
        ("braking", 6.0, 5.0, 3.0, 2.0, 2.2, "braking"),  # 8 m/s^2 for 0.1 s
        ("braking", 6.0, 5.0, 1.2, 2.0, 0.4, "braking"),
        ("braking", 6.0, 5.0, 0.7, 2.0, -0.1, "stopped"),
        ("steady", 6.0, 5.0, 3.0, 2.0, 2.0, "steady"),
    ],
)
def test_the_next_speed_of_who_synchronizes(
    phase: str, way: float, time: float, speed: float, final: float, after: float | None, then: str
) -> None:
    action = synchronizing(phase)
    found = action._next_speed(way, time, speed, final, 0.1)
    assert action._phase == then
    if after is not None:
        assert found == pytest.approx(after)


@pytest.mark.parametrize(("way", "time", "steady"), [(4.1, 2.1, False), (4.0, 9.0, True), (9.0, 2.0, True)])
def test_a_steady_state_takes_its_way_and_its_time(way: float, time: float, steady: bool) -> None:
    action = synchronizing(steady=(4.0, 2.0))
    found = action._next_speed(way, time, 1.0, 2.0, 0.01)
    assert (action._phase == "steady") is steady
    assert (found == 2.0) is steady
    short = synchronizing(steady=(0.5, 0.25))
    assert short._next_speed(0.4, 9.0, 1.0, 2.0, 0.01) == 2.0  # half a metre is a way, too


@pytest.mark.parametrize(
    ("linger", "way", "after", "phase"),
    [
        (True, 67.5, 8.0 - 0.05, "two ramps"),  # to 5.5 m/s
        (True, 92.5, 8.0, "last ramp"),  # to 10.5 m/s, which is not slower first
        (False, 92.5, 8.0 + 0.05, "two ramps"),
        (False, 67.5, 8.0, "last ramp"),
        (True, 42.5, 8.0 - 0.15, "two ramps"),  # to 0.5 m/s, which is not back yet
    ],
)
def test_the_first_of_two_ramps_is_the_slower_or_the_faster_one(
    linger: bool, way: float, after: float, phase: str
) -> None:
    """Both in 5 s, from 8 m/s to way / 5 - 8 m/s and back; 0.1 s of the first."""
    action = synchronizing("two ramps", linger=linger)
    assert action._two_ramps(way, 10.0, 8.0, 8.0, 0.1) == pytest.approx(after)
    assert action._phase == phase


@pytest.mark.parametrize(
    ("speed", "final", "after", "phase"),
    [
        (6.0, 2.0, 5.2, "braking"),  # faster than at the end: with 8 m/s^2
        (1.0, 2.0, 1.0 - 0.1 * 5.0 / 4.0, "two ramps"),  # with (1 + 4) / (2 x 2) m/s^2
        (2.0, 2.0, 2.0 - 0.1 * 8.0 / 4.0, "two ramps"),  # as fast as at the end: it stands half of the way on
        (0.1, 2.0, 0.0, "stopped"),
    ],
)
def test_who_has_too_much_time_brakes_to_a_stand(speed: float, final: float, after: float, phase: str) -> None:
    """2 m in 9 s."""
    action = synchronizing("two ramps", linger=True)
    assert action._two_ramps(2.0, 9.0, speed, final, 0.1) == pytest.approx(after)
    assert action._phase == phase


# --- conditions


def board(**more: Any) -> Any:
    return SimpleNamespace(board=SimpleNamespace(**{"time": 0.0, "dt": 0.1, "network": None, "entities": {}, **more}))


def test_who_has_stood_so_long_and_gone_so_far() -> None:
    scope, entity = board(time=5.0), car()
    stands = stand_still(SimpleNamespace(duration=2.0), entity, scope)  # type: ignore[arg-type]
    went = travelled(SimpleNamespace(value=10.0), entity, scope)  # type: ignore[arg-type]
    assert not stands()
    for since, holds in ((3.0, True), (3.001, False), (1.0, True)):
        entity.still_since = since
        assert stands() is holds
    for way, holds in ((10.0, True), (9.99, False), (10.0 - 5e-7, True)):
        entity.travelled = way
        assert went() is holds


@pytest.mark.parametrize(
    ("rule", "times"),
    [("greaterOrEqual", (False, True, True)), ("greaterThan", (False, False, True)), ("lessThan", (True, False, False)),
     ("lessOrEqual", (True, True, False)), ("notEqualTo", (True, False, True))],
)  # fmt: skip
def test_a_time_is_compared(rule: str, times: tuple[bool, ...]) -> None:
    scope = board()
    test = simulation_time(SimpleNamespace(rule=rule, value=3.0), None, scope)  # type: ignore[arg-type]
    found = []
    for time in (2.9, 3.0, 3.1):
        scope.board.time = time
        found.append(test())
    assert tuple(found) == times


def test_a_time_is_equal_in_the_step_that_passes_it() -> None:
    scope = board()
    test = simulation_time(SimpleNamespace(rule="equalTo", value=3.05), None, scope)  # type: ignore[arg-type]
    found = []
    for time in (2.9, 3.0, 3.1, 3.2):
        scope.board.time = time
        found.append(test())
    assert found == [False, False, True, False]


def two(**other: Any) -> tuple[Any, Any, Any]:
    """A at the origin heading to the left of the world at 4 m/s, and B."""
    a, b = car("A"), car("B")
    a.put(0.0, 0.0, 0.0, 0.5 * math.pi)
    a.speed, a.vx, a.vy = 4.0, 0.0, 4.0
    for name, value in other.items():
        setattr(b, name, value)
    return a, b, board(entities={"A": a, "B": b})


@pytest.mark.parametrize(
    ("direction", "relative"), [(None, 1.0), ("longitudinal", 3.0), ("lateral", 2.0), ("vertical", 0.0)]
)
def test_a_relative_speed_is_the_own_less_the_other_s(direction: str | None, relative: float) -> None:
    """B at (2, 1) m/s with a speed of 3: ahead of A is y, to its left -x."""
    a, b, scope = two(speed=3.0, vx=2.0, vy=1.0)
    for value, holds in ((relative - 0.01, True), (relative + 0.01, False)):
        element: Any = SimpleNamespace(entity_ref="B", rule="greaterThan", value=value, direction=direction)
        test = relative_speed(element, a, scope)
        assert test() is holds
        b.active = False
        assert not test()
        b.active = True


@pytest.mark.parametrize(("wanted", "holds"), [(0.3, True), (0.19, False), (0.41, False), (0.21, True), (-1.27, False)])
def test_an_angle_to_another_is_its_own_less_that_of_the_first(wanted: float, holds: bool) -> None:
    a, _, scope = two(h=0.5 * math.pi + 0.3)
    element: Any = SimpleNamespace(entity_ref="B", angle_type="heading", angle=wanted, angle_tolerance=0.1)
    assert relative_angle(element, a, scope)() is holds


@pytest.mark.parametrize(("kind", "value"), [("heading", 0.5), ("pitch", -0.2), ("roll", 0.1)])
def test_an_angle_in_the_world_and_to_itself(kind: str, value: float) -> None:
    entity = car()
    entity.h, entity.pitch, entity.roll = 0.5, -0.2, 0.1
    for wanted, system, holds in ((value, "world", True), (value + 0.02, "world", False), (0.0, "entity", True),
                                  (value, "entity", False)):  # fmt: skip
        element: Any = SimpleNamespace(angle_type=kind, angle=wanted, angle_tolerance=0.01, coordinate_system=system)
        assert angle(element, entity, board())() is holds


@pytest.mark.parametrize(("x", "y", "holds"), [(3.0, 4.0, True), (3.0, 4.01, False), (-5.0, 0.0, True)])
def test_a_position_is_reached_within_its_tolerance(
    monkeypatch: pytest.MonkeyPatch, x: float, y: float, holds: bool
) -> None:
    monkeypatch.setattr(distances, "resolver", lambda position, board: lambda: Place(1.0, 2.0, 0.0, 0.0))
    entity = car()
    entity.put(1.0 + x, 2.0 + y, 9.0, 0.0)
    element: Any = SimpleNamespace(position=None, tolerance=5.0)
    assert reach_position(element, entity, board())() is holds


def asked(**more: Any) -> Any:
    base = {"entity_ref": "B", "rule": "lessThan", "value": 3.0, "freespace": False, "along_route": None,
            "relative_distance_type": "longitudinal", "coordinate_system": "entity"}  # fmt: skip
    return SimpleNamespace(**{**base, **more})


@pytest.mark.parametrize(
    ("y", "speed", "kind", "holds"),
    [
        (11.9, 4.0, "longitudinal", True),  # less than 3 s at 4 m/s
        (12.1, 4.0, "longitudinal", False),
        (-11.9, 4.0, "longitudinal", False),  # behind
        (11.9, 0.0, "longitudinal", False),  # who stands never gets there
        (-11.9, 4.0, "euclidianDistance", True),
    ],
)
def test_a_headway_is_the_distance_over_the_own_speed(y: float, speed: float, kind: str, holds: bool) -> None:
    a, b, scope = two(y=y)
    a.speed = speed
    test = time_headway(asked(relative_distance_type=kind), a, scope)
    assert test() is holds
    b.active = False
    assert not test()


@pytest.mark.parametrize(
    ("y", "vy", "kind", "holds"),
    [
        (8.9, 1.0, "longitudinal", True),  # closing at 3 m/s
        (9.1, 1.0, "longitudinal", False),
        (8.9, 5.0, "longitudinal", False),  # it draws away
        (-2.9, 5.0, "longitudinal", True),  # it catches up from behind at 1 m/s
        (-3.1, 5.0, "longitudinal", False),
        (0.0, 1.0, "longitudinal", False),  # there already
        (8.9, 1.0, "euclidianDistance", True),
        (-2.9, 5.0, "euclidianDistance", True),
        (9.1, 1.0, None, False),
    ],
)
def test_a_time_to_collision_is_the_distance_over_the_closing_speed(
    y: float, vy: float, kind: str | None, holds: bool
) -> None:
    a, b, scope = two(y=y, vy=vy)
    target = SimpleNamespace(entity_ref=SimpleNamespace(entity_ref="B"), position=None)
    element = asked(relative_distance_type=kind, time_to_collision_condition_target=target)
    test = time_to_collision(element, a, scope)
    assert test() is holds
    b.active = False
    assert not test()
