"""Distances, clearances, headways and closing speeds between two cars on the straight road: each system and kind."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.road.positions import Pose, RoadPosition
from openscenario.storyboard.conditions.angle import angle
from openscenario.storyboard.conditions.clearance import _exists, _number, relative_clearance
from openscenario.storyboard.conditions.distance import _closing
from openscenario.storyboard.distances import _seen, box_distance, measure, overlap
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.places import Place
from openscenario.storyboard.unsupported import Unsupported

from .conftest import Make, lane_position, speed, teleport

QUARTER = 0.5 * math.pi


@pytest.fixture
def board(make: Make) -> Storyboard:
    """A drives along x from 100 m in lane -1 (y = -1.75), B against x at 120 m in lane 1 (y = 1.75), C behind A in lane
    -2 (y = -5.25) at 90 m. All are 5 m by 2 m, from 1 m behind their reference points to 4 m ahead of them."""
    made = make(A=[teleport(lane_position(100.0, -1)), speed(10.0)], B=[teleport(lane_position(120.0, 1)), speed(5.0)],
                C=[teleport(lane_position(90.0, -2)), speed(4.0)])  # fmt: skip
    made.start()
    for entity in made.entities.values():
        entity.vx, entity.vy = made.velocity(entity)
    return made


def between(board: Storyboard, one: str, other: Any, kind: Any, system: Any = None, *, free: bool = False) -> Any:
    target = board.entities[other] if isinstance(other, str) else other
    return measure(board, board.entities[one], target, kind=kind, system=system, free=free)()


@pytest.mark.parametrize("system", [None, "entity", "road", "lane"])
@pytest.mark.parametrize(
    ("one", "other", "along", "across"),
    [("A", "B", 20.0, 3.5), ("B", "A", 20.0, 3.5), ("A", "C", -10.0, -3.5), ("C", "A", 10.0, 3.5),
     ("B", "C", 30.0, 7.0), ("A", "A", 0.0, 0.0)],
)  # fmt: skip
def test_ahead_and_to_the_left_are_positive_as_one_faces(
    board: Storyboard, one: str, other: str, along: float, across: float, system: Any
) -> None:
    assert between(board, one, other, "longitudinal", system) == pytest.approx(along)
    assert between(board, one, other, "lateral", system) == pytest.approx(across)


@pytest.mark.parametrize(
    ("one", "other", "x", "y"), [("A", "B", 20.0, 3.5), ("B", "A", -20.0, -3.5), ("A", "C", -10.0, -3.5)]
)
def test_in_the_world_the_axes_are_x_and_y(board: Storyboard, one: str, other: str, x: float, y: float) -> None:
    assert between(board, one, other, "longitudinal", "world") == pytest.approx(x)
    assert between(board, one, other, "lateral", "world") == pytest.approx(y)


@pytest.mark.parametrize("system", [None, "road", "world"])
@pytest.mark.parametrize(
    ("one", "other", "along", "across"),
    [
        ("A", "B", 12.0, 1.5),  # both fronts are 4 m ahead: 20 - 8; 3.5 less two halves of 2
        ("A", "C", -5.0, -1.5),  # its front is 4 m ahead of 90 m, A's rear 1 m behind 100 m
        ("C", "A", 5.0, 1.5),
        ("B", "A", 12.0, 1.5),
    ],
)
def test_free_distances_are_those_of_the_boxes(
    board: Storyboard, one: str, other: str, along: float, across: float, system: Any
) -> None:
    sign = -1.0 if system == "world" and one == "B" else 1.0
    assert between(board, one, other, "longitudinal", system, free=True) == pytest.approx(sign * along)
    assert between(board, one, other, "lateral", system, free=True) == pytest.approx(sign * across)


@pytest.mark.parametrize("kind", [None, "euclidianDistance", "cartesianDistance"])
def test_a_straight_distance_has_no_sign(board: Storyboard, kind: Any) -> None:
    assert between(board, "A", "B", kind) == pytest.approx(math.hypot(20.0, 3.5))
    assert between(board, "A", "C", kind) == pytest.approx(math.hypot(10.0, 3.5))
    assert between(board, "A", "B", kind, free=True) == pytest.approx(math.hypot(12.0, 1.5))
    assert between(board, "A", "C", kind, free=True) == pytest.approx(math.hypot(5.0, 1.5))


def test_along_the_route_both_parts_count_and_what_is_behind_is_negative(board: Storyboard) -> None:
    assert between(board, "A", "B", "alongRoute") == pytest.approx(math.hypot(20.0, 3.5))
    assert between(board, "A", "C", "alongRoute") == pytest.approx(-math.hypot(10.0, 3.5))
    assert between(board, "A", "C", "alongRoute", free=True) == pytest.approx(-math.hypot(5.0, 1.5))
    for ahead in (0.5, -0.5):
        there = Place(100.0 + ahead, -5.25, 0.0, 0.0)
        apart = math.copysign(math.hypot(0.5, 3.5), ahead)
        assert between(board, "A", lambda place=there: place, "alongRoute") == pytest.approx(apart)


@pytest.mark.parametrize("system", [None, "road", "world"])
@pytest.mark.parametrize(
    ("x", "y", "along", "free", "across"),
    [(110.0, 0.25, 10.0, 6.0, 2.0), (97.0, -1.75, -3.0, -2.0, 0.0), (102.0, -4.75, 2.0, 0.0, -3.0),
     (104.0, -1.75, 4.0, 0.0, 0.0)],
)  # fmt: skip
def test_a_place_is_a_point(
    board: Storyboard, x: float, y: float, along: float, free: float, across: float, system: Any
) -> None:
    def there() -> Place:
        return Place(x, y, 0.0, 0.0)

    assert between(board, "A", there, "longitudinal", system) == pytest.approx(along)
    assert between(board, "A", there, "longitudinal", system, free=True) == pytest.approx(free)
    assert between(board, "A", there, "lateral", system) == pytest.approx(across)
    straight = between(board, "A", there, None, free=True)
    assert straight == pytest.approx(math.hypot(free, math.copysign(max(abs(across) - 1.0, 0.0), across)))


def test_where_no_way_leads_there_is_no_distance_along_it() -> None:
    here = SimpleNamespace(t=-1.75)
    ground = SimpleNamespace(position=lambda entity: here, position_of=lambda place: here, turned=lambda a, b: 1.0,
                             distance=lambda a, b: math.nan)  # fmt: skip
    apart: Any = SimpleNamespace(network=object(), ground=ground)
    entity: Any = SimpleNamespace(sense=1.0)
    there = Place(9.0, 0.0, 0.0, 0.0)
    for kind, found in (("alongRoute", None), ("longitudinal", None), ("lateral", 0.0)):
        assert measure(apart, entity, lambda: there, kind=kind, system="road", free=False)() == found


def test_who_follows_no_trajectory_has_no_distance_along_it(board: Storyboard) -> None:
    assert between(board, "A", "B", "longitudinal", "trajectory") is None
    assert between(board, "A", "B", "lateral", "trajectory", free=True) is None


@pytest.mark.parametrize(("sign", "seen"), [(1.0, (-1.0, 4.0)), (-1.0, (-4.0, 1.0))])
def test_an_extent_is_turned_round_for_who_faces_the_other_way(sign: float, seen: tuple[float, float]) -> None:
    assert _seen((-1.0, 4.0), sign) == seen


SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))


def moved(x: float, y: float, turn: float = 0.0) -> Any:
    c, s = math.cos(turn), math.sin(turn)
    return tuple((x + c * u - s * v, y + s * u + c * v) for u, v in SQUARE)


@pytest.mark.parametrize(
    ("other", "apart"),
    [
        (moved(3.0, 0.0), 1.0),
        (moved(2.0, 0.0), 0.0),  # they touch
        (moved(0.0, -3.5), 1.5),
        (moved(5.0, 6.0), 5.0),  # corner to corner: 3 and 4
        (moved(4.0, 0.0, math.pi / 4.0), 3.0 - math.sqrt(2.0)),  # a corner before a side
        (moved(1.5, 0.5), 0.0),
        (moved(2.5, 2.5, math.pi / 4.0), math.sqrt(2.0) * 1.5 - 1.0),  # a side before a corner
    ],
)
def test_the_distance_of_two_boxes(other: Any, apart: float) -> None:
    assert box_distance(SQUARE, other) == pytest.approx(apart)
    assert box_distance(other, SQUARE) == pytest.approx(apart)
    assert overlap(SQUARE, other) is (apart == 0.0)


# --- closing in


@pytest.mark.parametrize(
    ("one", "other", "kind", "system", "rate"),
    [
        ("A", "B", "longitudinal", None, 15.0),
        ("A", "B", "longitudinal", "road", 15.0),
        ("A", "B", "longitudinal", "world", 15.0),
        ("A", "B", "alongRoute", None, 15.0),
        ("A", "C", "longitudinal", "entity", -6.0),  # it is behind and slower
        ("A", "C", "longitudinal", "lane", -6.0),
        ("C", "A", "longitudinal", "lane", -6.0),
        ("A", "B", "lateral", None, 0.0),
        ("A", "B", "lateral", "road", 0.0),
    ],
)
def test_the_rate_at_which_a_distance_shrinks(
    board: Storyboard, one: str, other: str, kind: str, system: Any, rate: float
) -> None:
    apart = measure(board, board.entities[one], board.entities[other], kind=kind, system=system, free=False)()
    assert apart is not None
    closing = _closing(board, board.entities[one], board.entities[other], kind, system)
    assert closing(apart) == pytest.approx(rate, abs=1e-9)


@pytest.mark.parametrize(("kind", "system"), [("lateral", "road"), ("lateral", None), ("lateral", "world")])
def test_to_the_side_the_speed_to_the_side_counts(board: Storyboard, kind: str, system: Any) -> None:
    """A moves to the left at 2 m/s, B, which is left of it, to A's left at 0.5: they close in at 1.5."""
    a, b, c = (board.entities[name] for name in "ABC")
    a.vy, b.vy, c.vy = 2.0, 0.5, 0.0
    assert _closing(board, a, b, kind, system)(3.5) == pytest.approx(1.5)
    assert _closing(board, a, c, kind, system)(-3.5) == pytest.approx(-2.0)
    assert _closing(board, a, lambda: Place(100.0, 1.75, 0.0, 0.0), kind, system)(3.5) == pytest.approx(2.0)


def test_straight_at_each_other_the_speed_along_the_line_counts(board: Storyboard) -> None:
    a, b = board.entities["A"], board.entities["B"]
    length = math.hypot(20.0, 3.5)
    assert _closing(board, a, b, "euclidianDistance", None)(length) == pytest.approx(15.0 * 20.0 / length)

    def there() -> Place:
        return Place(103.0, 2.25, 0.0, 0.0)

    assert _closing(board, a, there, "euclidianDistance", None)(5.0) == pytest.approx(10.0 * 3.0 / 5.0)
    for system in ("road", "world", "entity"):
        assert _closing(board, a, there, "longitudinal", system)(3.0) == pytest.approx(10.0)
    assert _closing(board, a, lambda: Place(a.x, a.y, 0.0, 0.0), "euclidianDistance", None)(0.0) == 0.0


# --- clearance


def clear(board: Storyboard, *ranges: tuple[Any, Any], ahead: float = 50.0, behind: float = 50.0, free: bool = False,
          opposite: bool = False, named: Any = (), entity: str = "A") -> bool:  # fmt: skip
    element: Any = SimpleNamespace(
        entity_refs=[SimpleNamespace(entity_ref=name) for name in named], free_space=free, opposite_lanes=opposite,
        relative_lane_ranges=[SimpleNamespace(from_=low, to=high) for low, high in ranges],
        distance_forward=ahead, distance_backward=behind,
    )  # fmt: skip
    scope: Any = SimpleNamespace(board=board)
    return relative_clearance(element, board.entities[entity], scope)()


def test_a_name_of_nobody_is_told_before_it_is_asked_for(board: Storyboard) -> None:
    element: Any = SimpleNamespace(
        entity_refs=[SimpleNamespace(entity_ref="Z")], relative_lane_ranges=[], free_space=False, opposite_lanes=False,
        distance_forward=9.0, distance_backward=9.0,
    )  # fmt: skip
    with pytest.raises(Unsupported, match="no entity of this name"):
        relative_clearance(element, board.entities["A"], SimpleNamespace(board=board))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "free"),
    [
        ({}, False),  # C is beside it
        ({"behind": 9.9}, True),
        ({"behind": 10.0}, False),  # just as far as is asked for
        ({"behind": 9.9, "opposite": True}, False),  # B counts, too
        ({"behind": 9.9, "ahead": 19.9, "opposite": True}, True),
        ({"behind": 9.9, "ahead": 20.0, "opposite": True}, False),
        ({"behind": 4.9, "free": True}, True),
        ({"behind": 5.1, "free": True}, False),
        ({"named": ("B",)}, True),  # its lane runs the other way
        ({"named": ("B",), "opposite": True}, False),
        ({"named": ("C",)}, False),
        ({"named": ("A",)}, True),  # oneself is not in the way
    ],
)
def test_it_is_free_where_nobody_is_in_the_lanes_within_the_distances(
    board: Storyboard, given: dict[str, Any], free: bool
) -> None:
    assert clear(board, **given) is free


@pytest.mark.parametrize(
    ("ranges", "opposite", "free"),
    [
        (((0, 0),), False, True),
        (((-1, -1),), False, False),
        (((-1, 0),), False, False),
        (((None, -1),), False, False),
        (((-1, None),), False, False),
        (((0, None),), False, True),
        (((0, 0), (-1, -1)), False, False),
        (((1, 1),), True, False),  # B's lane is the next one to the left
        (((2, 2),), True, True),
        (((1, 1),), False, False),  # a lane that does not count is none
        (((-2, -2),), False, False),  # nor is one that the road does not have
        (((-2, -2), (0, 0)), False, True),
    ],
)
def test_lanes_count_from_the_own_one_to_the_left(
    board: Storyboard, ranges: tuple[tuple[Any, Any], ...], opposite: bool, free: bool
) -> None:
    assert clear(board, *ranges, opposite=opposite) is free


def test_who_faces_the_other_way_counts_lanes_to_its_own_left(board: Storyboard) -> None:
    """Left of B is A's lane, then C's."""
    assert clear(board, (0, 0), entity="B", opposite=True)
    assert not clear(board, (1, 1), entity="B", opposite=True)
    assert not clear(board, (2, 2), entity="B", opposite=True)
    assert clear(board, (2, 2), entity="B", opposite=True, ahead=29.9)
    assert clear(board, (-1, -1), entity="B")


def test_who_is_gone_is_in_nobodys_way(board: Storyboard) -> None:
    assert not clear(board, (-1, -1))
    board.entities["C"].active = False
    assert clear(board, (-1, -1))


@pytest.mark.parametrize(("lane", "number"), [(-2, -2), (-1, -1), (1, 0), (2, 1)])
def test_lanes_are_numbered_without_a_gap(lane: int, number: int) -> None:
    assert _number(lane) == number


@pytest.mark.parametrize(
    ("first", "last", "opposite", "there"),
    [(0, 0, False, True), (-1, -1, False, True), (-2, -2, False, False), (-3, -1, False, True), (1, 1, False, False),
     (1, 1, True, True), (2, 2, True, True), (3, 3, True, False), (-math.inf, -5, False, True),
     (5, math.inf, False, True)],
)  # fmt: skip
def test_a_range_of_lanes_is_there_if_one_of_them_is(
    board: Storyboard, first: float, last: float, opposite: bool, there: bool
) -> None:
    assert board.network is not None
    here = board.ground.position(board.entities["A"])
    assert _exists(board.network, here, 1.0, first, last, opposite) is there


# --- angles on a road


@pytest.mark.parametrize(
    ("entity", "system", "wanted", "holds"),
    [("A", "road", 0.0, True), ("A", "lane", 0.0, True), ("B", "road", math.pi, True), ("B", "lane", 0.0, True),
     ("B", "lane", math.pi, False), ("A", "road", 0.11, False), ("A", "road", 0.1, True),
     ("A", "trajectory", 0.0, False)],
)  # fmt: skip
def test_a_heading_on_a_road_is_one_to_its_line_or_to_the_traffic(
    board: Storyboard, entity: str, system: str, wanted: float, holds: bool
) -> None:
    element: Any = SimpleNamespace(angle_type="heading", angle=wanted, angle_tolerance=0.1, coordinate_system=system)
    scope: Any = SimpleNamespace(board=board)
    assert angle(element, board.entities[entity], scope)() is holds
    board.entities[entity].pitch = 0.3
    pitched: Any = SimpleNamespace(angle_type="pitch", angle=0.3, angle_tolerance=0.1, coordinate_system=system)
    assert angle(pitched, board.entities[entity], scope)() is (system != "trajectory")


@pytest.mark.parametrize(("kind", "slope"), [("pitch", 0.2), ("roll", 0.1)])
def test_a_slope_counts_as_it_is_seen_by_who_is_turned_more_or_less_that_way(kind: str, slope: float) -> None:
    """A road along x, 0.2 rad down and 0.1 rad up on its left: so it is up to a quarter turn off, then the opposite."""
    network = SimpleNamespace(lane_pose=lambda road, lane, s, offset: Pose(0.0, 0.0, 0.0, 0.0, 0.2, 0.1))
    here = RoadPosition("1", -1, 100.0, -1.75, 0.0, 0.0, True)
    ground = SimpleNamespace(network=network, position=lambda entity: here)
    scope: Any = SimpleNamespace(board=SimpleNamespace(ground=ground))
    for h, sign in ((0.0, 1.0), (1.5, 1.0), (-1.5, 1.0), (1.6, -1.0), (math.pi, -1.0)):
        for wanted in (slope, -slope):
            element: Any = SimpleNamespace(angle_type=kind, angle=0.0, angle_tolerance=0.01, coordinate_system="road")
            entity: Any = SimpleNamespace(h=h, pitch=wanted, roll=wanted)
            assert angle(element, entity, scope)() is (wanted == sign * slope)
