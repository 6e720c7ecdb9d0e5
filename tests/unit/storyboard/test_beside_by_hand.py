"""A lateral distance in the coordinates of an entity, step by step: with stubs around it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard.actions.beside import ALIGNED, HARDEST, REACHED, Beside

from .bodies import car

INF = math.inf


def limits(**given: float | None) -> Any:
    names = ("max_speed", "max_acceleration", "max_deceleration", "max_acceleration_rate", "max_deceleration_rate")
    return SimpleNamespace(**(dict.fromkeys(names) | given))


def beside(
    distance: float | None = 3.0, *, free: bool = False, given: Any = None, h: float = 0.5, heading: float = 0.0,
    at: tuple[float, float] = (0.0, 0.0), speed: float = 8.0, running: bool = True, continuous: bool = True,
    side: float = 1.0,
) -> tuple[Beside, Any, Any, Any]:  # fmt: skip
    """A at `at` (along, to the left) of B, which heads `h`; turned by `heading` against it. And what is warned."""
    a, b = car("A"), car("B")
    b.x, b.y, b.h = 100.0, 50.0, h
    c, s = math.cos(h), math.sin(h)
    a.x, a.y, a.h = 100.0 + c * at[0] - s * at[1], 50.0 + s * at[0] + c * at[1], h + heading
    a.speed = a.speed_before = speed
    element: Any = SimpleNamespace(entity_ref="B", distance=distance, freespace=free, dynamic_constraints=given,
                                   continuous=continuous, displacement="leftToReferencedEntity")  # fmt: skip
    warned: list[str] = []
    board: Any = SimpleNamespace(entities={"A": a, "B": b}, running=running,
                                 ground=SimpleNamespace(stand=lambda entity: warned.append("stand")),
                                 warn=lambda at, code, text: warned.append(code))  # fmt: skip
    action = Beside(element, a, board)
    action._side = side
    return action, a, b, warned


def left_of(a: Any, b: Any) -> tuple[float, float]:
    """A along and to the left of B."""
    c, s = math.cos(b.h), math.sin(b.h)
    return c * (a.x - b.x) + s * (a.y - b.y), c * (a.y - b.y) - s * (a.x - b.x)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("h", [0.0, 0.5, 2.8])
def test_a_free_distance_is_between_the_sides_of_the_boxes(side: float, h: float) -> None:
    action, a, b, _ = beside(3.0, free=True, h=h, at=(-4.0, 7.0), side=side)
    a.width, a.center_y, b.width, b.center_y = 1.8, 0.3, 2.5, -0.2
    place = left_of(a, b)[1] + action._to_go()
    near = place + a.center_y - side * 0.5 * a.width  # the side of A that faces B
    facing = b.center_y + side * 0.5 * b.width
    assert side * (near - facing) == pytest.approx(3.0)


@pytest.mark.parametrize(("distance", "side", "wanted"), [(3.0, 1.0, 3.0), (3.0, -1.0, -3.0), (None, 1.0, 0.0)])
def test_a_distance_is_between_the_reference_points(distance: float | None, side: float, wanted: float) -> None:
    action, a, b, _ = beside(distance, at=(9.0, -2.0), side=side)
    assert action._apart() == pytest.approx(-2.0)
    assert left_of(a, b)[1] + action._to_go() == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("given", "limit", "top"),
    [(None, None, INF), (limits(), None, INF), (limits(max_acceleration=2.0), 2.0, INF),
     (limits(max_deceleration=3.0), 3.0, INF), (limits(max_acceleration=5.0, max_deceleration=3.0), 3.0, INF),
     (limits(max_acceleration=1e9), HARDEST, INF), (limits(max_speed=4.0), None, 4.0)],
)  # fmt: skip
def test_the_narrowest_limit_counts(given: Any, limit: float | None, top: float) -> None:
    action, *_ = beside(given=given)
    assert (action._limit(), action._top()) == (limit, top)


@pytest.mark.parametrize(
    ("given", "running", "placed", "warned"),
    [(None, False, True, []), (None, True, False, []), (limits(max_speed=4.0), False, False, []),
     (limits(max_acceleration=4.0), False, False, []),
     (limits(max_acceleration_rate=1.0), True, False, ["no-limit-of-jerk"]),
     (limits(max_deceleration_rate=1.0), True, False, ["no-limit-of-jerk"])],
)  # fmt: skip
def test_without_limits_who_begins_like_this_stands_there_and_no_jerk_is_limited(
    given: Any, running: bool, placed: bool, warned: list[str]
) -> None:
    action, a, b, told = beside(given=given, running=running, at=(5.0, 1.0), heading=0.3)
    assert not action.start()
    assert [code for code in told if code != "stand"] == warned
    assert left_of(a, b) == pytest.approx((5.0, 3.0 if placed else 1.0))
    assert a.h - b.h == pytest.approx(0.0 if placed else 0.3)
    assert (a.moved, a.travelled) == (False, 0.0)


@pytest.mark.parametrize(("across", "ahead"), [(2.6, 0.4), (3.7, 0.1), (-5.0, 0.0)])
def test_without_limits_what_is_left_of_its_way_goes_along(across: float, ahead: float) -> None:
    """0.8 m in a tenth of a second: what the way to the side needs of it does not go ahead."""
    action, a, b, told = beside(at=(0.0, across), heading=0.7)
    assert not action.step(0.1)
    assert left_of(a, b) == pytest.approx((ahead, 3.0))
    assert (a.h, a.moved, told) == (pytest.approx(b.h), True, ["stand"])
    assert a.travelled == pytest.approx(ahead)
    assert math.hypot(a.vx, a.vy) == pytest.approx(math.hypot(ahead, 3.0 - across) / 0.1)


@pytest.mark.parametrize(
    ("across", "top", "angle"),
    [(2.6, 6.0, math.asin(0.5)), (3.4, 6.0, -math.asin(0.5)), (2.6, 2.0, math.asin(0.25)), (-5.0, 20.0, 0.5 * math.pi),
     (9.0, 20.0, -0.5 * math.pi)],
)  # fmt: skip
def test_a_limit_of_speed_to_the_side_is_one_of_the_angle(across: float, top: float, angle: float) -> None:
    """0.8 m a step: 0.4 m to go are half of it, 2 m/s a quarter, and 20 m/s more than all."""
    action, a, b, _ = beside(given=limits(max_speed=top), at=(0.0, across))
    assert not action.step(0.1)
    assert a.h - b.h == pytest.approx(angle)
    assert left_of(a, b) == pytest.approx((0.8 * math.cos(angle), across + 0.8 * math.sin(angle)))


@pytest.mark.parametrize("across", [-20.0, 20.0])
def test_with_a_limit_of_acceleration_it_turns_no_harder_and_no_faster_to_the_side(across: float) -> None:
    """At 8 m/s and 6 m/s^2 the radius is 1.5 x 64 / 6 = 16 m, and an S turns 1.5 times as hard at its peak: 0.8 m turn
    it by 0.075 rad. At 0.2 m/s to the side the angle is asin(1/40)."""
    action, a, b, _ = beside(given=limits(max_acceleration=6.0), at=(0.0, across))
    action.step(0.1)
    assert a.h - b.h == pytest.approx(math.copysign(0.075, -across))
    both, a, b, _ = beside(given=limits(max_acceleration=6.0, max_speed=0.2), at=(0.0, across))
    both.step(0.1)
    assert a.h - b.h == pytest.approx(math.copysign(math.asin(0.025), -across))


def test_who_stands_keeps_its_heading() -> None:
    action, a, b, _ = beside(given=limits(max_speed=2.0), heading=0.3, speed=0.0)
    action.step(0.1)
    assert a.h - b.h == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("off", "turned", "continuous", "over"),
    [(0.9 * REACHED, 0.9 * ALIGNED, False, True), (1.1 * REACHED, 0.0, False, False),
     (0.0, 1.1 * ALIGNED, False, False), (0.0, -1.1 * ALIGNED, False, False), (0.0, 0.0, True, False)],
)  # fmt: skip
def test_it_is_over_after_a_step_on_the_line_in_its_direction(
    off: float, turned: float, continuous: bool, over: bool
) -> None:
    action, a, b, _ = beside(at=(0.0, 3.0 + off), heading=turned, continuous=continuous)
    assert not action.step(0.1)  # it has been there for no step yet
    b.x, b.y = a.x + 3.0 * math.sin(b.h), a.y - 3.0 * math.cos(b.h)
    a.x, a.y = b.x - (3.0 + off) * math.sin(b.h), b.y + (3.0 + off) * math.cos(b.h)
    a.h = b.h + turned
    assert action.step(0.1) is over
    if over:
        assert (left_of(a, b), a.h) == (pytest.approx((0.0, 3.0)), b.h)


@pytest.mark.parametrize(("lateral", "longitudinal", "late"), [(1, 2, True), (2, 2, False), (3, 2, False)])
def test_what_comes_first_in_the_file_is_late_and_an_acceleration_is_that_of_its_speed(
    lateral: int, longitudinal: int, late: bool
) -> None:
    action, a, _, _ = beside()
    a.lateral_order, a.longitudinal_order, a.speed_before = lateral, longitudinal, 7.5
    action.step(0.1)
    assert (a.late, a.ax) == (late, pytest.approx(5.0))


def test_a_body_that_is_moved_heads_where_its_way_went() -> None:
    action, a, b, _ = beside(h=0.0, at=(0.0, 0.0))
    action._put(2.0, 0.5 * math.pi, 1.5, 0.5)
    assert left_of(a, b) == pytest.approx((0.0, 3.5))
    assert (a.h, a.travelled, a.moved) == (pytest.approx(0.5 * math.pi), 2.0, True)
    assert (a.vx, a.vy) == pytest.approx((0.0, 7.0))


def test_an_external_one_is_asked_for_the_distance() -> None:
    action, a, *_ = beside(2.5)
    before = (a.x, a.y)
    action.stop()
    assert action.ask() == ("lateral_distance", {"to": "B", "distance": 2.5}, 0.0)
    assert ((a.x, a.y), action.domains) == (before, ("lateral",))
