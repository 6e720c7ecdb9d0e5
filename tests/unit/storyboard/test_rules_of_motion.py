"""Rules by which entities move, as functions: ways of a step, oblique ways, steering for a line, ramps that meet."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openscenario import model
from openscenario.storyboard.actions.beside import side_of, steer
from openscenario.storyboard.actions.speed import _time_over
from openscenario.storyboard.actions.synchronize import STOP, Synchronize, _corner
from openscenario.storyboard.actions.traffic import vehicle
from openscenario.storyboard.actions.traffic import within as in_polygon
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.conditions.distance import _closing
from openscenario.storyboard.crowd import following, weighted
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.motion import lean, move, way
from openscenario.storyboard.trajectories import Course


def mover(before: float, speed: float, *, late: bool = False, **more: Any) -> Any:
    return SimpleNamespace(speed_before=before, speed=speed, late=late, along=1.0, drift=9.0, shifted=False, **more)


@pytest.mark.parametrize(("late", "beats"), [(False, 1.0), (True, -1.0)])
def test_a_speed_holds_for_the_beat_that_reaches_it(late: bool, beats: float) -> None:
    """10 to 20 m/s in 1 s: 15 m and half a beat of 10 ms x 10 m/s more; who is late has it less."""
    assert way(mover(10.0, 20.0, late=late), 1.0) == pytest.approx(15.0 + beats * 0.05)
    assert way(mover(10.0, 20.0, late=late), 0.004) == pytest.approx(0.06 + beats * 0.02)  # shorter than a beat


@pytest.mark.parametrize(("rate", "speed"), [(3.0, 5.0), (-3.0, 5.0), (3.0, -5.0), (-3.0, -5.0)])
def test_what_goes_to_the_side_does_not_go_ahead(rate: float, speed: float) -> None:
    """3 of 5 m/s to the side leave 4 ahead; it heads that way, and backwards the tail does."""
    entity = mover(speed, speed)
    assert lean(entity, rate, 0.1)
    assert entity.along == pytest.approx(0.8)
    assert entity.drift == pytest.approx(math.copysign(math.asin(0.6), rate * speed))
    assert entity.shifted


def test_who_is_too_slow_goes_to_the_side_with_all_of_its_way() -> None:
    entity = mover(2.0, 2.0)
    assert not lean(entity, 3.0, 0.1)
    assert (entity.along, entity.drift) == pytest.approx((0.0, 0.5 * math.pi), abs=1e-5)
    assert entity.drift < 0.5 * math.pi
    standing = mover(0.0, 0.0)
    assert not lean(standing, 3.0, 0.1)
    assert standing.along == 0.0


def test_nothing_to_the_side_is_straight_on() -> None:
    for speed in (5.0, 0.0):
        entity = mover(speed, speed)
        assert lean(entity, 0.0, 0.1)
        assert entity.drift == 0.0
    assert mover(5.0, 5.0).along == 1.0


def roadless(**more: Any) -> tuple[Any, Any]:
    fields = {"x": 1.0, "y": 2.0, "h": 0.5 * math.pi, "placed": False, "end_of_road": False, "travelled": 7.0}
    return mover(4.0, 6.0, vx=9.0, vy=9.0, ax=9.0, **{**fields, **more}), SimpleNamespace(
        network=None, track=lambda entity: False
    )


def test_without_a_road_one_goes_straight_on() -> None:
    """4 to 6 m/s in 0.5 s: 2.5 m and half a beat of 2 m/s."""
    entity, ground = roadless()
    entity.drift = 0.0
    move(entity, 0.5, ground)
    assert (entity.x, entity.y, entity.travelled) == pytest.approx((1.0, 2.0 + 2.51, 7.0 + 2.51))
    assert (entity.ax, entity.vx, entity.vy) == pytest.approx((4.0, 0.0, 5.02))


def test_at_the_end_of_its_trajectory_one_stands_where_there_is_no_road() -> None:
    entity, ground = roadless(end_of_road=True)
    entity.drift, entity.speed_before = 0.0, 0.0
    move(entity, 0.5, ground)
    assert (entity.speed, entity.x, entity.y, entity.vx, entity.vy) == (0.0, 1.0, 2.0, 0.0, 0.0)


def test_being_put_takes_a_beat() -> None:
    """Of 0.5 s only 0.49 s are driven, at 4.04 to 6 m/s."""
    entity, ground = roadless(placed=True)
    entity.drift = 0.0
    move(entity, 0.5, ground)
    assert entity.y == pytest.approx(2.0 + 2.51 - 4.04 * 0.01)
    assert entity.vy == pytest.approx((2.51 - 0.0404) / 0.49)
    short, ground = roadless(placed=True)
    move(short, 0.01, ground)
    assert (short.y, short.vx, short.vy) == (2.0, pytest.approx(0.0), pytest.approx(6.0))


ALONG, ASIDE = 0.3, 0.3 + 0.5 * math.pi


def test_far_from_its_line_one_steers_straight_for_it() -> None:
    """No harder than 1.5 times the turn of its radius: 1.5 x 0.1 / 5 rad a step."""
    assert steer(ASIDE - 0.02, 6.0, ASIDE, ALONG, 5.0, 0.1) == pytest.approx(ASIDE)
    assert steer(ASIDE - 0.5, 6.0, ASIDE, ALONG, 5.0, 0.1) == pytest.approx(ASIDE - 0.5 + 0.03)
    assert steer(ASIDE + 0.5, 6.0, ASIDE, ALONG, 5.0, 0.1) == pytest.approx(ASIDE + 0.5 - 0.03)


def test_on_its_line_one_heads_along_it() -> None:
    assert steer(0.9, 0.9e-6, ASIDE, ALONG, 5.0, 0.1) == ALONG
    assert steer(0.9, 1.1e-6, ASIDE, ALONG, 5.0, 0.1) != ALONG


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 1.0])
def test_near_its_line_one_turns_into_it_as_on_an_even_turn(share: float) -> None:
    """An even turn of radius r is r (1 - cos a) from its end; the share that is left half a step later is eased."""
    left = math.acos(1.0 - share)
    part = (2.0 * left - 0.5 * 0.02) / math.pi
    part = 3.0 * part**2 - 2.0 * part**3
    wanted = part * ASIDE + (1.0 - part) * ALONG
    assert steer(wanted - 0.001, share * 5.0, ASIDE, ALONG, 5.0, 0.1) == pytest.approx(wanted)


def test_a_step_longer_than_the_turn_goes_there_straight() -> None:
    """Seven radii a step: a share of more than all is all."""
    assert steer(ASIDE - 2.0, 0.2, ASIDE, ALONG, 0.5, 3.5) == pytest.approx(ASIDE)


def test_a_heading_stays_within_a_turn() -> None:
    assert abs(steer(math.pi - 0.01, 6.0, -math.pi + 0.3, 0.0, 5.0, 1.0)) <= math.pi


@pytest.mark.parametrize(
    ("displacement", "left", "side"),
    [("any", 0.0, 1.0), ("any", 2.0, 1.0), ("any", -2.0, -1.0), ("leftToReferencedEntity", -2.0, 1.0),
     ("rightToReferencedEntity", 2.0, -1.0)],
)  # fmt: skip
def test_the_side_is_the_one_asked_for_or_where_one_is(displacement: Any, left: float, side: float) -> None:
    element = model.LateralDistanceAction(entity_ref="B", continuous=True, freespace=False, displacement=displacement)
    assert side_of(element, left) == side


@pytest.mark.parametrize(
    ("distance", "speed", "target", "time"),
    [(20.0, 3.0, 7.0, 4.0), (20.0, -3.0, -7.0, 4.0), (20.0, 0.0, 8.0, 5.0), (20.0, 0.0, 0.0, 0.0),
     (25.0, 3.0, -4.0, 2.0 * 9.0 / 3.0 + 2.0 * 16.0 / 4.0)],
)  # fmt: skip
def test_the_time_in_which_a_change_of_speed_covers_a_distance(
    distance: float, speed: float, target: float, time: float
) -> None:
    """2 s / (v0 + v1); through zero each part has its share v^2 of the distance: 9 and 16 of 25 m."""
    assert _time_over(distance, speed, target) == pytest.approx(time)


@pytest.mark.parametrize(
    ("way_", "time", "speed", "final"),
    [(100.0, 10.0, 8.0, 15.0), (100.0, 10.0, 15.0, 8.0), (100.0, 10.0, 5.0, 8.0), (60.0, 10.0, 8.0, 2.0),
     (200.0, 10.0, 8.0, 15.0), (100.0, 10.0, 0.0, 15.0)],
)  # fmt: skip
def test_two_ramps_meet_in_time_and_place(way_: float, time: float, speed: float, final: float) -> None:
    """Equal magnitudes, away from the final speed's line and back: the ways add up, the slopes are opposite."""
    between, first = _corner(way_, time, speed, final)
    second = time - first
    assert 0.0 < first < time
    assert 0.5 * (speed + between) * first + 0.5 * (between + final) * second == pytest.approx(way_)
    assert (between - speed) / first == pytest.approx((between - final) / second)


def test_ramps_between_equal_speeds_meet_half_way() -> None:
    """100 m in 10 s from and to 8 m/s: 12 m/s after 5 s."""
    assert _corner(100.0, 10.0, 8.0, 8.0) == pytest.approx((12.0, 5.0))
    assert _corner(100.0, 10.0, 8.0, 8.0 + 1e-7) == pytest.approx((12.0, 5.0))


def phased(phase: str, *, linger: bool = False, steady: Any = None) -> Synchronize:
    board: Any = object.__new__(Synchronize)
    board._phase, board._linger = phase, linger
    board._final = None if steady is None else SimpleNamespace(steady_state=steady)
    return board  # type: ignore[no-any-return]


def next_speed(board: Synchronize, way_: float, time: float, speed: float, final: float, dt: float = 0.1) -> float:
    return board._next_speed(way_, time, speed, final, dt)


def test_who_brakes_to_a_stand_does_so_until_it_stands() -> None:
    board = phased("braking")
    assert next_speed(board, 50.0, 10.0, 3.0, 2.0) == pytest.approx(3.0 - STOP * 0.1)
    assert board._phase == "braking"
    assert next_speed(board, 50.0, 10.0, STOP * 0.1 - 0.01, 2.0) < 0.0
    assert board._phase == "stopped"


@pytest.mark.parametrize("phase", ["last ramp", "stopped"])
def test_who_waits_for_a_standing_master_stands(phase: str) -> None:
    assert next_speed(phased(phase), 50.0, 1e10, 3.0, 2.0) == 0.0


@pytest.mark.parametrize(("time", "speed"), [(10.1, 0.0), (10.0, 0.0), (9.9, None)])
def test_who_has_stopped_starts_when_the_last_ramp_fits(time: float, speed: float | None) -> None:
    """50 m to 10 m/s from rest take 2 x 50 / 10 s; with less time left one ramp begins at 2 s / t - 10 m/s."""
    board = phased("stopped")
    found = next_speed(board, 50.0, time, 0.0, 10.0)
    if speed is None:
        start = 100.0 / time - 10.0
        assert (found, board._phase) == (pytest.approx(start + (10.0 - start) * 0.1 / time), "last ramp")
    else:
        assert (found, board._phase) == (speed, "stopped")


@pytest.mark.parametrize("final", [0.0, 1e-6])
def test_who_is_to_stand_at_the_end_does_not_start_again(final: float) -> None:
    """A millionth of 1 m/s is none yet."""
    assert next_speed(phased("stopped"), 50.0, 1.0, 0.0, final) == 0.0


def test_on_the_last_ramp_the_final_speed_is_there_in_time() -> None:
    """40 m in 4 s to 12 m/s begin with 8 m/s: 1 m/s more each second; in the last step it is 12."""
    assert next_speed(phased("last ramp"), 40.0, 4.0, 8.0, 12.0) == pytest.approx(8.1)
    assert next_speed(phased("last ramp"), 0.6, 0.05, 12.0, 12.0) == 12.0


@pytest.mark.parametrize(("speed", "lingers"), [(8.0, False), (14.0, True)])
def test_a_new_one_is_slower_first_if_it_would_come_too_early(speed: float, lingers: bool) -> None:
    """100 m in 10 s: the mean of present and final speed is more or less than 10 m/s."""
    board = phased("new")
    found = next_speed(board, 100.0, 10.0, speed, 8.0)
    between, first = _corner(100.0, 10.0, speed, 8.0)
    assert (board._phase, board._linger) == ("two ramps", lingers)
    assert found == pytest.approx(speed + (between - speed) / first * 0.1)


@pytest.mark.parametrize(
    ("speed", "phase"), [(8.09, "last ramp"), (7.91, "last ramp"), (8.2, "two ramps"), (7.8, "two ramps")]
)
def test_near_the_final_ramp_one_takes_it(speed: float, phase: str) -> None:
    """40 m in 4 s to 12 m/s: it begins with 8 m/s, and 0.1 m/s off counts as on it."""
    board = phased("two ramps", linger=speed > 8.0)
    next_speed(board, 40.0, 4.0, speed, 12.0)
    assert board._phase == phase


def test_beyond_the_corner_the_last_ramp_begins() -> None:
    """It is to be slower first, and the corner lies above: it keeps its speed for this step."""
    board = phased("two ramps", linger=True)
    assert next_speed(board, 100.0, 10.0, 5.0, 8.0) == 5.0
    assert board._phase == "last ramp"


def test_where_two_ramps_would_go_back_one_brakes_to_a_stand() -> None:
    """10 m in 20 s to 4 m/s: from 2 m/s with (2^2 + 4^2) / 20 = 1 m/s^2; who is faster than that end with STOP."""
    assert next_speed(phased("two ramps", linger=True), 10.0, 20.0, 2.0, 4.0) == pytest.approx(2.0 - 1.0 * 0.1)
    # 2 T vx^2 - 4 s vx + 2 s (v0 + v1) - T (v0^2 + v1^2) = 0 for vx = -0.5 m/s, and T = 140 / 19.5 s: no farther back
    assert next_speed(phased("two ramps", linger=True), 10.0, 140.0 / 19.5, 2.0, 4.0) == pytest.approx(1.9)
    board = phased("two ramps", linger=True)
    assert next_speed(board, 10.0, 20.0, 0.05, 4.0) == 0.0
    assert board._phase == "stopped"
    fast = phased("two ramps", linger=True)
    assert next_speed(fast, 10.0, 20.0, 6.0, 4.0) == pytest.approx(6.0 - STOP * 0.1)
    assert fast._phase == "braking"


def test_a_steady_state_is_driven_at_the_final_speed() -> None:
    """20 m, or 2.5 s at 8 m/s, before the target; before that they are off the way and off the time."""
    for steady in (model.TargetDistanceSteadyState(distance=20.0), model.TargetTimeSteadyState(time=2.5)):
        assert next_speed(phased("new", steady=steady), 19.9, 9.0, 5.0, 8.0) == 8.0
        assert next_speed(phased("new", steady=steady), 90.0, 2.4, 5.0, 8.0) == 8.0
        board, plain = phased("last ramp", steady=steady), phased("last ramp")
        assert next_speed(board, 60.0, 6.5, 12.0, 8.0) == pytest.approx(next_speed(plain, 40.0, 4.0, 12.0, 8.0))


def test_following_is_the_intelligent_driver_model() -> None:
    """Treiber, Hennecke, Helbing (2000): a = 1.5, b = 2, T = 1.5, s0 = 2."""
    assert following(10.0, 20.0, math.inf, 0.0) == pytest.approx(1.5 * (1.0 - 0.5**4))
    closing = 10.0 * 4.0 / (2.0 * math.sqrt(3.0))
    assert following(10.0, 20.0, 40.0, 6.0) == pytest.approx(
        1.5 * (1.0 - 0.5**4 - ((2.0 + 15.0 + closing) / 40.0) ** 2)
    )
    assert following(10.0, 20.0, 40.0, 99.0) == pytest.approx(1.5 * (1.0 - 0.5**4 - (2.0 / 40.0) ** 2))
    assert following(10.0, 20.0, 0.0, 0.0) == following(99.0, 1.0, math.inf, 0.0) == -8.0
    assert following(1.0, 0.0, math.inf, 0.0) == -1.5
    assert following(0.0, 20.0, 0.05, 0.0) == following(0.0, 20.0, 0.1, 0.0) == -8.0


class Chance:
    def __init__(self, value: float) -> None:
        self.value = value

    def random(self) -> float:
        return self.value


@pytest.mark.parametrize(("chance", "drawn"), [(0.0, "a"), (0.24, "a"), (0.26, "b"), (0.99, "b")])
def test_what_is_drawn_goes_by_weight(chance: float, drawn: str) -> None:
    entries: Any = [(1.0, "a"), (3.0, "b"), (0.0, "c")]
    assert weighted(Chance(chance), entries) == drawn  # type: ignore[arg-type]
    assert weighted(Chance(chance), [(0.0, "a"), (0.0, "b")]) == "a"  # type: ignore[arg-type, list-item]


def test_points_in_a_polygon() -> None:
    corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0)]  # an L
    x, y = np.array([1.0, 3.0, 3.0, 1.0, -1.0, 5.0, 1.0]), np.array([1.0, 1.0, 3.0, 3.0, 1.0, 1.0, 5.0])
    assert in_polygon(corners, x, y).tolist() == [True, True, False, True, False, False, False]
    slanted = [(0.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
    assert in_polygon(slanted, np.array([1.0, 2.5]), np.array([2.0, 2.0])).tolist() == [True, False]


def closing(kind: str, system: str | None, apart: float, *, h: float = 0.5 * math.pi) -> float:
    """A at (7, -3) with (1, 2) m/s, B 30 m and 40 m from it with (-2, 5); no road."""

    def at(x: float, y: float, vx: float, vy: float) -> Entity:
        entity = Entity(model.ScenarioObject(name="A", entity=vehicle("car")), external=False)
        entity.put(x, y, 0.0, h)
        entity.vx, entity.vy = vx, vy
        return entity

    board: Any = SimpleNamespace(network=None)
    return _closing(board, at(7.0, -3.0, 1.0, 2.0), at(37.0, 37.0, -2.0, 5.0), kind, system)(apart)


@pytest.mark.parametrize(
    ("kind", "system", "rate"),
    [("longitudinal", "world", 3.0), ("lateral", "world", -3.0), ("longitudinal", "entity", -3.0),
     ("lateral", "entity", -3.0), ("euclidianDistance", None, 3.0 * 0.6 - 3.0 * 0.8)],
)  # fmt: skip
def test_two_close_in_along_the_axis_that_is_measured(kind: str, system: str | None, rate: float) -> None:
    """Facing +y: ahead is +y, left is -x. Relative velocity (3, -3) m/s; the direction is (0.6, 0.8)."""
    assert closing(kind, system, 5.0) == pytest.approx(rate)
    if system is not None:
        assert closing(kind, system, -5.0) == pytest.approx(-rate)  # to what is behind it catches up


def test_who_stands_at_the_very_place_does_not_close_in() -> None:
    """No direction leads there."""

    def here(h: float) -> Entity:
        entity = Entity(model.ScenarioObject(name="A", entity=vehicle("car")), external=False)
        entity.put(3.0, 4.0, 0.0, h)
        entity.vx = 5.0
        return entity

    board: Any = SimpleNamespace(network=None)
    assert _closing(board, here(0.0), here(1.0), "euclidianDistance", None)(1.0) == 0.0


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [(10.0, 10.04, False), (10.0, 10.06, True), (10.0, 9.99, False), (10.0, 9.97, True), (10.0, 10.0, False),
     (10.0, 10.05, False), (10.0, 9.98, False)],
)  # fmt: skip
def test_what_is_beyond_the_performance_is_told_of_either_sign(before: float, after: float, told: bool) -> None:
    """In 10 ms: 5 m/s^2 upwards are 0.05 m/s, 2 m/s^2 downwards 0.02 m/s."""
    warned: list[str] = []
    entity = SimpleNamespace(name="A", speed=before, max_speed=70.0, max_acceleration=5.0, max_deceleration=2.0)

    class Stepped(Synchronize):
        __slots__ = ()

        def _go_on(self, dt: float) -> bool:
            entity.speed = after
            return False

    action: Any = object.__new__(Stepped)
    action._entity, action._element, action._told = entity, None, False
    action._board = SimpleNamespace(warn=lambda element, code, text: warned.append(f"{code} {text}"))
    assert not action.step(0.01)
    entity.speed = before
    action.step(0.01)
    text = f"A: to be there in time takes {100.0 * abs(after - before):.1f} m/s^2, beyond its Performance"
    assert warned == ([f"beyond-performance {text}"] if told else [])  # once
    entity.speed, entity.max_speed = before, 10.02
    action.step(0.01)
    assert entity.speed == min(after, 10.02)


def test_where_no_road_leads_the_way_is_straight() -> None:
    action: Any = object.__new__(Synchronize)
    here, there = SimpleNamespace(x=3.0, y=-5.0, lateral=None), SimpleNamespace(x=6.0, y=-1.0)
    action._board = SimpleNamespace(ground=SimpleNamespace(network=None))
    assert action._way(here, there) == pytest.approx(5.0)
    for along, way_ in ((-40.0, 40.0), (math.nan, 5.0)):
        ground = SimpleNamespace(
            network=1, position=lambda e: e, position_of=lambda p: p, distance=lambda a, b, d=along: d
        )
        action._board = SimpleNamespace(ground=ground)
        assert action._way(here, there) == pytest.approx(way_)


@pytest.mark.parametrize(("h", "rate"), [(0.0, 3.0), (math.pi, -3.0)])
def test_on_a_trajectory_one_closes_in_on_what_lies_where_one_faces(h: float, rate: float) -> None:
    """Along +x with 5 m/s, the other one with 2: who goes rear first moves away from what it faces."""

    def on_line(x: float, vx: float) -> Entity:
        entity = Entity(model.ScenarioObject(name="A", entity=vehicle("car")), external=False)
        entity.put(x, 0.0, 0.0, h)
        entity.vx = vx
        return entity

    follower: Any = object.__new__(FollowTrajectory)
    follower._course, follower._s = Course([(0.0, 0.0, 0.0, 0.0), (100.0, 0.0, 0.0, 0.0)]), 10.0
    entity, other = on_line(10.0, 5.0), on_line(40.0, 2.0)
    board: Any = SimpleNamespace(network=None)
    closing_in = _closing(board, entity, other, "longitudinal", "trajectory")
    assert closing_in(1.0) == 0.0  # it follows none yet
    entity.lateral = follower
    assert closing_in(1.0) == pytest.approx(rate)
    assert closing_in(-1.0) == pytest.approx(-rate)
