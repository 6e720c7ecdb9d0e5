"""Boxes in the plane: corners, extents, distances and overlaps, by figures that one can draw."""

from __future__ import annotations

import math

import pytest

from openscenario import model
from openscenario.storyboard.actions.traffic import vehicle
from openscenario.storyboard.distances import Span, box_distance, gap, overlap
from openscenario.storyboard.entity import GRAVITY, Entity, _number
from openscenario.storyboard.road_extents import _nearest

Corners = tuple[tuple[float, float], ...]


def body(x: float = 0.0, y: float = 0.0, h: float = 0.0, *, center: tuple[float, float] = (1.5, 0.2)) -> Entity:
    """5 m long, 2 m wide, its middle `center` ahead and left of the reference point."""
    box = model.BoundingBox(
        center=model.Center(x=center[0], y=center[1], z=0.75),
        dimensions=model.Dimensions(width=2.0, length=5.0, height=1.5),
    )
    what = model.MiscObject(name="box", misc_object_category="obstacle", mass=1.0, bounding_box=box)
    entity = Entity(model.ScenarioObject(name="A", entity=what), external=False)
    entity.put(x, y, 0.0, h)
    return entity


def square(x: float, y: float, half: float = 1.0, turn: float = 0.0) -> Corners:
    angles = (turn + k * 0.5 * math.pi + 0.25 * math.pi for k in range(4))
    reach = half * math.sqrt(2.0)
    return tuple((x + reach * math.cos(a), y + reach * math.sin(a)) for a in angles)


def test_corners_run_counter_clockwise_from_the_front_left() -> None:
    """From 1 m behind the reference point to 4 m ahead of it, 1.2 m to its left, 0.8 m to its right."""
    assert body(10.0, 20.0).corners() == ((14.0, 21.2), (9.0, 21.2), (9.0, 19.2), (14.0, 19.2))


def test_corners_turn_with_the_body() -> None:
    """Facing +y its left is -x."""
    expected = ((8.8, 24.0), (8.8, 19.0), (10.8, 19.0), (10.8, 24.0))
    for corner, wanted in zip(body(10.0, 20.0, 0.5 * math.pi).corners(), expected, strict=True):
        assert corner == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("h", "axis", "low", "high"),
    [
        (0.0, 0.0, -1.0, 4.0),
        (0.0, 0.5 * math.pi, -0.8, 1.2),
        (math.pi, 0.0, -4.0, 1.0),
        (0.5 * math.pi, 0.0, -1.2, 0.8),
        (0.5 * math.pi, 0.5 * math.pi, -1.0, 4.0),
    ],
)
def test_the_extent_along_an_axis_is_that_of_the_corners(h: float, axis: float, low: float, high: float) -> None:
    assert body(3.0, 7.0, h).extent(axis) == pytest.approx((low, high))


def test_an_oblique_extent_is_that_of_the_outermost_corners() -> None:
    turned = body(3.0, 7.0, 0.6)
    along = [(x - 3.0) * math.cos(0.9) + (y - 7.0) * math.sin(0.9) for x, y in turned.corners()]
    assert turned.extent(0.9) == pytest.approx((min(along), max(along)))


@pytest.mark.parametrize(
    ("theirs", "apart"),
    [
        ((3.0, 4.0), 1.0),
        ((2.0, 4.0), 0.0),
        ((-9.0, 9.0), 0.0),
        ((0.5, 0.6), 0.0),
        ((-4.0, -1.0), 0.0),
        ((-4.0, -3.0), -2.0),
    ],
)
def test_a_gap_is_signed_and_zero_where_spans_meet(theirs: tuple[float, float], apart: float) -> None:
    assert gap(Span(-1.0, 2.0), Span(*theirs)) == apart


@pytest.mark.parametrize(
    ("other", "apart"),
    [
        (square(4.0, 0.0), 2.0),  # side to side
        (square(0.0, -3.5), 1.5),
        (square(5.0, 6.0), 5.0),  # corner to corner, 3 and 4
        (square(-5.0, -6.0), 5.0),
        (square(3.0, 0.0, turn=0.25 * math.pi), 2.0 - math.sqrt(2.0)),  # a corner before a side
        (square(2.0, 0.0), 0.0),  # they touch
        (square(0.5, 0.5), 0.0),
        (square(0.0, 0.0, half=0.1), 0.0),  # one inside the other
        (square(0.0, 0.0, half=9.0), 0.0),
    ],
)
def test_the_distance_of_boxes(other: Corners, apart: float) -> None:
    box = square(0.0, 0.0)
    assert box_distance(box, other) == pytest.approx(apart, abs=1e-12)
    assert box_distance(other, box) == pytest.approx(apart, abs=1e-12)


@pytest.mark.parametrize(
    ("x", "y", "meet"),
    [
        (1.9, 1.9, False),
        (1.6, 1.6, True),
        (2.3, 0.0, True),
        (2.5, 0.0, False),
        (-1.9, 1.9, False),
        (-1.6, -1.6, True),
        (0.0, -2.5, False),
    ],
)
def test_overlap_is_decided_along_the_sides_of_both(x: float, y: float, meet: bool) -> None:
    """A square on its corner: along the axes it reaches 1.414 m, along the diagonal 1 m; the other one 1.414 m."""
    box, other = square(0.0, 0.0), square(x, y, turn=0.25 * math.pi)
    assert overlap(box, other) is meet
    assert overlap(other, box) is meet


def test_long_boxes_that_cross_overlap() -> None:
    """Neither has a corner in the other."""
    along = ((5.0, 1.0), (-5.0, 1.0), (-5.0, -1.0), (5.0, -1.0))
    across = ((1.0, 5.0), (-1.0, 5.0), (-1.0, -5.0), (1.0, -5.0))
    assert overlap(along, across)


@pytest.mark.parametrize(
    ("polygon", "distance"),
    [
        ([(1.0, -1.0), (3.0, -1.0), (3.0, 1.0), (1.0, 1.0)], 1.0),
        ([(1.0, 2.0), (3.0, 2.0), (3.0, 5.0), (1.0, 5.0)], math.sqrt(5.0)),
        ([(-3.0, -2.0), (-1.0, -2.0), (-1.0, 4.0), (-3.0, 4.0)], 1.0),
        ([(2.0, 0.0), (4.0, 2.0), (2.0, 4.0), (0.0, 2.0)], math.sqrt(2.0)),
        ([(3.0, 4.0), (3.0, 4.0), (6.0, 8.0)], 5.0),
        ([(4.0, 1.0), (0.0, -3.0), (8.0, -3.0)], 3.0 / math.sqrt(2.0)),
    ],
)
def test_the_distance_of_the_origin_from_a_polygon(polygon: list[tuple[float, float]], distance: float) -> None:
    assert _nearest(polygon) == pytest.approx(distance)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("2.5", 2.5),
        ("0", 0.0),
        ("-1", 0.0),
        ("inf", 0.0),
        ("nan", 0.0),
        ("two", 0.0),
        ("", 0.0),
        (None, 0.0),
        ("0.5", 0.5),
    ],
)
def test_a_property_is_a_number_above_zero_or_none(text: str | None, number: float) -> None:
    found = _number(text)
    assert found == number
    assert math.copysign(1.0, found) == 1.0


@pytest.mark.parametrize(
    ("category", "length", "width", "height", "rear", "wheelbase"),
    [
        ("car", 4.5, 1.8, 1.5, 0.9, 2.7),
        ("bicycle", 1.8, 0.6, 1.7, 0.35, 1.1),
        ("bus", 12.0, 2.55, 3.2, 3.3, 5.9),
        ("motorbike", 2.2, 0.8, 1.5, 0.4, 1.4),
        ("truck", 9.0, 2.5, 3.5, 2.0, 5.0),
        ("van", 5.9, 2.0, 2.5, 1.1, 3.7),
        ("semitrailer", 4.5, 1.8, 1.5, 0.9, 2.7),
    ],
)
def test_traffic_has_usual_sizes(
    category: model.VehicleCategory, length: float, width: float, height: float, rear: float, wheelbase: float
) -> None:
    """No wider than the 2.55 m of Directive 96/53/EC; the box ends `rear` behind the rear axle, on the ground."""
    car = Entity(model.ScenarioObject(name="A", entity=vehicle(category)), external=False)
    assert (car.length, car.width, car.height, car.wheelbase) == (length, width, height, wheelbase)
    assert car.extent(0.0) == pytest.approx((-rear, length - rear))
    assert car.extent(0.5 * math.pi) == pytest.approx((-0.5 * width, 0.5 * width))
    assert car.center_z == pytest.approx(0.5 * height)
    assert (car.max_speed, car.max_acceleration, car.max_deceleration) == (70.0, 10.0, 10.0)


def test_a_slippery_road_limits_to_friction_times_weight() -> None:
    car = Entity(model.ScenarioObject(name="A", entity=vehicle("car")), external=False)
    car.limit_friction(0.3)
    assert (car.max_acceleration, car.max_deceleration) == pytest.approx((0.3 * GRAVITY, 0.3 * GRAVITY))
    car.limit_friction(2.0)
    assert (car.max_acceleration, car.max_deceleration) == (10.0, 10.0)


@pytest.mark.parametrize(
    ("speed", "since"), [(0.0, 2.0), (9e-4, 2.0), (-9e-4, 2.0), (1.1e-3, math.inf), (-1.1e-3, math.inf)]
)
def test_slower_than_a_millimetre_a_second_is_standing(speed: float, since: float) -> None:
    car = body()
    car.speed = speed
    car.note_rest(2.0)
    car.note_rest(3.0)
    assert (car.still_since, car.end_since) == (since, math.inf)


def test_the_rest_at_the_end_of_a_road_counts_from_its_first_moment() -> None:
    car = body()
    car.end_of_road = True
    car.note_rest(1.0)
    car.note_rest(2.0)
    assert car.end_since == 1.0
    car.end_of_road = False
    car.note_rest(3.0)
    assert car.end_since == math.inf


def test_a_point_behind_is_drawn_along() -> None:
    """2 m behind (5, 5) facing +x is (3, 5); from there to (7, 8) the direction is (4, 3)."""
    car = body(7.0, 8.0)
    car.leads = 2.0
    car.draw_behind(5.0, 5.0, 0.0)
    assert car.h == pytest.approx(math.atan2(3.0, 4.0))
