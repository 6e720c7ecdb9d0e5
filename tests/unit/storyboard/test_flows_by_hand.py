"""Each rule by which traffic comes and goes, with a crowd that only writes down who is admitted and dismissed."""

from __future__ import annotations

import math
import random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openscenario.storyboard.actions import traffic
from openscenario.storyboard.actions.traffic import Area, Kinds, Sink, Source, Swarm, limit, vehicle, within
from openscenario.storyboard.crowd import TOWN, weighted
from openscenario.storyboard.unsupported import Unsupported


@pytest.fixture(autouse=True)
def _given_places(monkeypatch: pytest.MonkeyPatch) -> None:
    """A position is its place, an entity itself."""
    monkeypatch.setattr(traffic, "resolver", lambda position, board: lambda: position)
    monkeypatch.setattr(traffic, "entity_called", lambda entity, board, element: entity)


class Written:
    """A crowd on spots (x, y, h) of road 1, lane -1 (s = x), with room for so many more."""

    def __init__(self, spots: list[tuple[float, float, float]], room: int = 99, speed: float = 7.0) -> None:
        x, y, h = np.array(spots, dtype=float).reshape(-1, 3).T
        points = [SimpleNamespace(road="1", lane=-1 if y <= 0.0 else 1, s=x) for x, y, _ in spots]
        self.spots = SimpleNamespace(points=points, x=x, y=y, h=h)
        self.room, self.came, self.gone = room, list[tuple[str, list[int], float]](), list[Any]()
        self.members: dict[str, tuple[Any, float, Any]] = {}
        self.random = random.Random(1)
        network = SimpleNamespace(lane_speed=lambda road, lane, s: speed + s)
        self.board = SimpleNamespace(ground=SimpleNamespace(network=network))

    def put(self, flow: Any, x: float, y: float = 0.0) -> Any:
        entity = SimpleNamespace(x=x, y=y)
        self.members[str(len(self.members) + 100 * len(self.gone))] = entity, 0.0, flow
        return entity

    def admit(self, flow: Any, name: str, what: Any, where: Any, speed: Any) -> bool:
        if self.room <= 0:
            return False
        self.room -= 1
        self.came.append((name, np.flatnonzero(where).tolist(), speed()))
        self.put(flow, 0.0)
        return True

    def of(self, flow: Any) -> list[Any]:
        return [entity for entity, _, source in self.members.values() if source is flow]

    def dismiss(self, entity: Any) -> None:
        self.gone.append(entity)
        self.members = {name: each for name, each in self.members.items() if each[0] is not entity}


def here(x: float, y: float = 0.0) -> SimpleNamespace:
    return SimpleNamespace(x=x, y=y)


def some(**given: Any) -> Any:
    return SimpleNamespace(**{"traffic_definition": None, "traffic_distribution": None} | given)


# --- what comes


@pytest.mark.parametrize(("drawn", "what"), [(0.0, "a"), (0.249, "a"), (0.251, "b"), (0.99, "b")])
def test_one_is_drawn_by_weight(drawn: float, what: str) -> None:
    entries: Any = [(1.0, "a"), (3.0, "b")]
    chance: Any = SimpleNamespace(random=lambda: drawn)
    assert weighted(chance, entries) == what


def test_without_weights_the_first_is_drawn() -> None:
    entries: Any = [(0.0, "a"), (0.0, "b")]
    assert weighted(random.Random(1), entries) == "a"


def entries(*weights: float) -> list[Any]:
    return [SimpleNamespace(weight=w, scenario_object_template=SimpleNamespace(entity=f"{w:g}")) for w in weights]


def test_the_weights_of_a_distribution_are_shared_out_within_each_entry() -> None:
    distribution: Any = SimpleNamespace(
        traffic_distribution_entries=[
            SimpleNamespace(weight=6.0, entity_distribution=entries(1.0, 2.0)),
            SimpleNamespace(weight=1.0, entity_distribution=entries(0.0)),
        ]
    )
    assert Kinds(None, distribution)._entries == [(2.0, "1"), (4.0, "2"), (0.0, "0")]
    definition: Any = SimpleNamespace(vehicle_category_distribution=[SimpleNamespace(category="bus", weight=0.25)])
    assert Kinds(definition, distribution)._entries[0] == (2.0, "1")
    ((weight, bus),) = Kinds(definition, None)._entries
    assert (weight, bus.vehicle_category) == (0.25, "bus")  # type: ignore[union-attr]
    ((weight, car),) = Kinds(None, None)._entries
    assert (weight, car.vehicle_category) == (1.0, "car")  # type: ignore[union-attr]


@pytest.mark.parametrize("category", ["bicycle", "bus", "car", "motorbike", "truck", "van"])
def test_a_vehicle_is_as_large_as_the_real_ones_of_its_category(category: Any) -> None:
    """Bounds: a bicycle and a motorbike by DIN 79000 and usual models; a car as a VW Golf to a Passat; a van as a
    Sprinter; a bus of 12 m and 2.55 m (Directive 96/53/EC); a truck of two axles."""
    length, width, height = {
        "bicycle": ((1.7, 1.9), (0.5, 0.7), (1.6, 1.8)),
        "bus": ((11.9, 12.1), (2.5, 2.55), (3.0, 3.4)),
        "car": ((4.2, 4.8), (1.75, 1.85), (1.4, 1.6)),
        "motorbike": ((2.1, 2.3), (0.7, 0.9), (1.4, 1.6)),
        "truck": ((8.0, 10.0), (2.4, 2.55), (3.2, 3.8)),
        "van": ((5.5, 6.2), (1.9, 2.1), (2.3, 2.8)),
    }[category]
    made = vehicle(category)
    size, middle = made.bounding_box.dimensions, made.bounding_box.center
    assert length[0] <= size.length <= length[1]
    assert width[0] <= size.width <= width[1]
    assert height[0] <= size.height <= height[1]
    rear, front = middle.x - 0.5 * size.length, middle.x + 0.5 * size.length  # bumpers, from the rear axle
    assert made.axles.front_axle is not None
    wheelbase = made.axles.front_axle.position_x
    assert rear < 0.0 < wheelbase < front
    assert 0.1 * size.length < -rear < 0.3 * size.length
    assert 0.45 * size.length < wheelbase < 0.7 * size.length
    assert (middle.y, middle.z) == (0.0, pytest.approx(0.5 * size.height))
    for axle in (made.axles.front_axle, made.axles.rear_axle):
        assert axle.track_width == pytest.approx(0.85 * size.width)
        assert axle.position_z == pytest.approx(0.5 * axle.wheel_diameter, abs=0.01)
    assert made.axles.rear_axle.position_x == made.axles.rear_axle.max_steering == 0.0
    assert (made.name, made.vehicle_category) == (category, category)
    assert made.performance.max_acceleration == made.performance.max_deceleration == pytest.approx(9.81, abs=0.2)


def test_the_limit_is_that_of_the_first_spot_and_50_km_h_where_there_is_none() -> None:
    crowd: Any = Written([(5.0, 0.0, 0.0), (15.0, 0.0, 0.0), (25.0, 0.0, 0.0)])
    assert limit(crowd, np.array([False, True, True])) == 7.0 + 15.0
    assert limit(crowd, np.array([False, False, False])) == TOWN == pytest.approx(50.0 / 3.6)
    free: Any = Written([(5.0, 0.0, 0.0)], speed=math.inf)
    assert limit(free, np.array([True])) == TOWN
    crowd.board.ground.network = None
    assert limit(crowd, np.array([True, True, True])) == TOWN


# --- sources and sinks

LANE = [(5.0, 0.0, 0.0), (10.0, 0.0, 0.0), (15.0, 0.0, 0.0), (20.0, 0.0, 0.0)]


def source(rate: float, radius: float = 5.0, speed: float | None = 3.0, x: float = 10.0) -> Source:
    element = some(position=here(x), rate=rate, radius=radius, speed=speed)
    return Source(element, "flow", None)  # type: ignore[arg-type]


def test_a_source_lets_one_in_each_time_its_period_is_over_counted_from_its_first_step() -> None:
    crowd: Any = Written(LANE)
    flow = source(0.5)
    for time in (3.0, 4.9, 5.0, 5.1, 9.2):
        before = len(crowd.came)
        flow.come_and_go(crowd, time)
        assert len(crowd.came) - before == {3.0: 1, 4.9: 0, 5.0: 1, 5.1: 0, 9.2: 2}[time]
    assert crowd.came[0] == ("flow", [0, 1, 2], 3.0)


def test_who_finds_no_room_comes_as_soon_as_there_is_some() -> None:
    crowd: Any = Written(LANE, room=0)
    flow = source(0.5)
    flow.come_and_go(crowd, 0.0)
    crowd.room = 1
    flow.come_and_go(crowd, 1.0)
    assert len(crowd.came) == 1
    crowd.room = 9
    flow.come_and_go(crowd, 1.5)  # the next one is due 2 s after the first one was
    assert len(crowd.came) == 1
    flow.come_and_go(crowd, 2.0)
    assert len(crowd.came) == 2


@pytest.mark.parametrize("rate", [0.0, -1.0])
def test_a_source_without_a_rate_lets_nobody_in(rate: float) -> None:
    crowd: Any = Written(LANE)
    source(rate).come_and_go(crowd, 0.0)
    assert crowd.came == []


def test_a_source_takes_the_nearest_spot_if_none_is_within_its_radius_and_the_limit_if_it_has_no_speed() -> None:
    crowd: Any = Written(LANE)
    source(1.0, radius=1.0, x=17.0).come_and_go(crowd, 0.0)
    source(1.0, radius=5.1, speed=None, x=20.0).come_and_go(crowd, 0.0)
    assert crowd.came == [("flow", [2], 3.0), ("flow", [2, 3], 7.0 + 15.0)]
    source(1.0, radius=1.0, x=0.0).come_and_go(Written([]), 0.0)  # type: ignore[arg-type]


def sink(rate: float | None) -> Sink:
    return Sink(some(position=here(10.0, 2.0), radius=5.0, rate=rate), None)  # type: ignore[arg-type]


def test_a_sink_takes_all_within_its_radius() -> None:
    crowd: Any = Written(LANE)
    inside = [crowd.put(None, 10.0, 6.9), crowd.put(None, 14.9, 2.0), crowd.put(None, 7.0, -2.0)]
    outside = [crowd.put(None, 10.0, 7.1), crowd.put(None, 15.1, 2.0), crowd.put(None, 6.0, -2.0)]
    sink(None).come_and_go(crowd, 0.0)
    assert crowd.gone == inside
    assert [entity for entity, _, _ in crowd.members.values()] == outside


def test_a_sink_with_a_rate_takes_one_each_time_its_period_is_over() -> None:
    crowd: Any = Written(LANE)
    for _ in range(5):
        crowd.put(None, 10.0, 2.0)
    flow = sink(0.5)
    for time, gone in ((1.0, 1), (2.9, 1), (3.0, 2), (8.0, 3), (9.9, 3), (10.0, 4)):
        flow.come_and_go(crowd, time)  # a sink that waited does not make up for it
        assert len(crowd.gone) == gone


@pytest.mark.parametrize("rate", [0.0, -2.0])
def test_a_sink_with_a_rate_of_nought_takes_nobody(rate: float) -> None:
    crowd: Any = Written(LANE)
    crowd.put(None, 10.0, 2.0)
    sink(rate).come_and_go(crowd, 0.0)
    assert crowd.gone == []


# --- swarms


def swarm(number: float = 4, h: float = 0.0, **given: Any) -> Swarm:
    central = SimpleNamespace(x=10.0, y=20.0, h=h, active=True)
    fields: dict[str, Any] = {
        "central_object": SimpleNamespace(entity_ref=central), "number_of_vehicles": number, "inner_radius": 4.0,
        "semi_major_axis": 10.0, "semi_minor_axis": 5.0, "offset": 3.0, "velocity": 8.0, "initial_speed_range": None,
        "direction_of_travel_distribution": None,
    }  # fmt: skip
    return Swarm(some(**fields | given), "swarm", None)  # type: ignore[arg-type]


@pytest.mark.parametrize("h", [0.0, 0.5, 2.0, -1.0])
def test_the_ellipse_lies_along_the_central_entity_and_ahead_of_it(h: float) -> None:
    """A point at the angle q of the ellipse, a little inside and a little outside, turned by the heading."""
    q = np.linspace(0.1, 6.1, 9)
    for share, inside in ((0.99, True), (1.01, False)):
        ahead, left = 3.0 + share * 10.0 * np.cos(q), share * 5.0 * np.sin(q)
        x = 10.0 + ahead * math.cos(h) - left * math.sin(h)
        y = 20.0 + ahead * math.sin(h) + left * math.cos(h)
        assert (swarm(h=h)._inside(x, y) == inside).all()


def test_an_ellipse_of_no_size_holds_its_middle_alone() -> None:
    flat = swarm(semi_major_axis=0.0, semi_minor_axis=0.0)
    assert flat._inside(np.array([13.0, 13.1, 13.0]), np.array([20.0, 20.0, 20.1])).tolist() == [True, False, False]


# within the ellipse: 1 to 5; within the inner circle: 2 and 3; heading back: 4
ROUND = [
    (25.0, 20.0, 0.0),
    (20.0, 20.0, 0.1),
    (12.0, 20.0, 0.0),
    (13.9, 20.0, 0.0),
    (14.1, 20.0, 3.0),
    (5.0, 20.0, 0.0),
]


def test_a_swarm_is_filled_up_outside_its_inner_circle_and_who_left_the_ellipse_goes() -> None:
    crowd: Any = Written(ROUND)
    flow = swarm()
    left, stays = crowd.put(flow, 24.0, 20.0), crowd.put(flow, 22.0, 20.0)
    other = crowd.put(None, 99.0)
    flow.come_and_go(crowd, 0.0)
    assert crowd.gone == [left]
    assert crowd.came == 3 * [("swarm", [1, 4, 5], 8.0)]
    assert stays in crowd.of(flow)
    assert len(crowd.of(flow)) == 4
    assert other in [entity for entity, _, _ in crowd.members.values()]


def test_a_swarm_that_is_full_or_has_lost_its_centre_or_finds_no_room_brings_nobody() -> None:
    crowd: Any = Written(ROUND)
    flow = swarm(1)
    crowd.put(flow, 12.0, 20.0)
    flow.come_and_go(crowd, 0.0)
    assert crowd.came == []
    lost = swarm()
    lost._central.active = False
    lost.come_and_go(crowd, 0.0)
    assert crowd.came == []
    small: Any = Written(ROUND, room=2)
    swarm(9).come_and_go(small, 0.0)
    assert len(small.came) == 2


@pytest.mark.parametrize(("drawn", "where"), [(0.74, [1, 5]), (0.76, [4])])
def test_the_direction_is_drawn_by_its_share(drawn: float, where: list[int]) -> None:
    crowd: Any = Written(ROUND)
    crowd.random = SimpleNamespace(random=lambda: drawn)
    kinds = SimpleNamespace(draw=lambda crowd: None)
    flow = swarm(1, direction_of_travel_distribution=SimpleNamespace(same=3.0, opposite=1.0))
    flow._kinds = kinds  # type: ignore[assignment]
    flow.come_and_go(crowd, 0.0)
    assert crowd.came == [("swarm", where, 8.0)]


@pytest.mark.parametrize("h", [0.5 * math.pi, -0.5 * math.pi, 2.0])
def test_the_same_direction_is_that_of_the_central_entity_wherever_it_heads(h: float) -> None:
    crowd: Any = Written([(15.0, 20.0, h), (14.1, 20.0, h + math.pi), (5.0, 20.0, h + 1.5), (5.0, 20.0, h + 1.6)])
    crowd.random = SimpleNamespace(random=lambda: 0.0)
    sides = SimpleNamespace(same=1.0, opposite=1.0)
    flow = swarm(1, h, direction_of_travel_distribution=sides, semi_minor_axis=10.0)
    flow._kinds = SimpleNamespace(draw=lambda crowd: None)  # type: ignore[assignment]
    flow.come_and_go(crowd, 0.0)
    assert crowd.came == [("swarm", [0, 2], 8.0)]


def test_the_speed_of_a_swarm_is_drawn_from_its_range_else_given_else_the_limit() -> None:
    crowd: Any = Written(ROUND)
    crowd.random = SimpleNamespace(uniform=lambda low, high: (low, high))
    where = np.arange(6) == 4
    speeds = SimpleNamespace(lower_limit=5.0, upper_limit=9.0)
    assert swarm(initial_speed_range=speeds)._speed(crowd, where) == (5.0, 9.0)
    assert swarm()._speed(crowd, where) == 8.0
    assert swarm(velocity=0.0)._speed(crowd, where) == 0.0
    assert swarm(velocity=None)._speed(crowd, where) == 7.0 + 14.1


# --- areas


def area(
    number: float = 3, *, corners: tuple[Any, ...] = (), ranges: tuple[Any, ...] = (), lasts: bool = False
) -> Area:
    polygon = SimpleNamespace(positions=corners) if corners else None
    place = SimpleNamespace(polygon=polygon, road_ranges=ranges)
    return Area(some(traffic_area=place, number_of_entities=number, continuous=lasts), "area", None)  # type: ignore[arg-type]


def cursor(s: float | None, *lanes: int, road: str = "1") -> Any:
    return SimpleNamespace(road_id=road, s=s, lanes=[SimpleNamespace(id=lane) for lane in lanes])


def stretch(*cursors: Any, length: float | None = None) -> Any:
    return SimpleNamespace(road_cursors=cursors, length=length)


SIDES = [(5.0, -1.0, 0.0), (10.0, 1.0, 0.0), (15.0, -1.0, 0.0), (20.0, 1.0, 0.0)]


@pytest.mark.parametrize(
    ("ranges", "chosen"),
    [
        ([stretch(cursor(8.0))], [1, 2, 3]),
        ([stretch(cursor(None))], [0, 1, 2, 3]),
        ([stretch(cursor(8.0), length=7.0)], [1, 2]),
        ([stretch(cursor(None), length=12.0)], [0, 1]),
        ([stretch(cursor(8.0), cursor(16.0))], [1, 2]),
        ([stretch(cursor(16.0), cursor(8.0))], [1, 2]),
        ([stretch(cursor(8.0), cursor(None), length=4.0)], [1]),
        ([stretch(cursor(8.0), cursor(16.0), length=99.0)], [1, 2]),
        ([stretch(cursor(5.0), cursor(20.0))], [0, 1, 2, 3]),
        ([stretch(cursor(None, 1))], [1, 3]),
        ([stretch(cursor(None, -1, 1), length=11.0)], [0, 1]),
        ([stretch(cursor(None, road="2"))], []),
        ([stretch(cursor(None), length=6.0), stretch(cursor(18.0))], [0, 3]),
    ],
)
def test_an_area_of_stretches(ranges: list[Any], chosen: list[int]) -> None:
    crowd: Any = Written(SIDES)
    area(ranges=tuple(ranges)).come_and_go(crowd, 0.0)
    assert crowd.came == 3 * [("area", chosen, 7.0 + SIDES[chosen[0]][0] if chosen else TOWN)]


def test_a_stretch_over_two_roads_is_not_supported() -> None:
    with pytest.raises(Unsupported, match="several roads"):
        area(ranges=(stretch(cursor(0.0), cursor(5.0, road="2")),))


@pytest.mark.parametrize("lasts", [False, True])
def test_an_area_is_filled_once_or_kept_full(lasts: bool) -> None:
    """Who is more than 5 m from every spot of the area has left it."""
    crowd: Any = Written(SIDES)
    flow = area(2, corners=(here(0.0, -9.0), here(12.0, -9.0), here(12.0, 9.0), here(0.0, 9.0)), lasts=lasts)
    flow.come_and_go(crowd, 0.0)
    assert crowd.came == 2 * [("area", [0, 1], 12.0)]
    for entity, y in zip(crowd.of(flow), (5.9, 6.1), strict=True):
        entity.x, entity.y = 10.0, y
    gone = crowd.of(flow)[1]
    flow.come_and_go(crowd, 0.1)
    assert crowd.gone == ([gone] if lasts else [])
    assert len(crowd.came) == (3 if lasts else 2)


def test_who_is_of_an_area_without_spots_has_left_it_and_one_without_room_is_asked_once() -> None:
    empty: Any = Written(SIDES)
    flow = area(1, corners=(here(50.0), here(60.0), here(60.0, 9.0)), lasts=True)
    flow.come_and_go(empty, 0.0)
    flow.come_and_go(empty, 0.1)
    assert len(empty.gone) == 1
    small: Any = Written(SIDES, room=1)
    area(3, ranges=(stretch(cursor(None)),)).come_and_go(small, 0.0)
    assert len(small.came) == 1


def test_a_point_is_within_a_polygon_if_its_winding_number_is_not_nought() -> None:
    """The sum of the angles under which the edges are seen; a dent, and edges along both axes."""
    corners = [(0.0, 0.0), (6.0, 0.0), (6.0, 5.0), (3.0, 1.5), (0.0, 5.0)]
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-1.03, 7.11, 21), np.linspace(-1.07, 6.13, 19)))
    turned = np.zeros(len(x))
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        turned += np.angle(((x1 - x) + 1j * (y1 - y)) / ((x0 - x) + 1j * (y0 - y)))
    inside = np.abs(turned) > 1.0
    assert 20 < inside.sum() < 300
    assert (within(corners, x, y) == inside).all()
    assert (within(corners[::-1], x, y) == inside).all()
