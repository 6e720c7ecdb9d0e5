"""Distances and closing speeds in the coordinates of a trajectory that is a stub; lanes beside lanes; new entities."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.conditions.distance import _closing
from openscenario.storyboard.distances import measure
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.routes import _across, _point
from openscenario.storyboard.world import World

from .bodies import car

QUARTER = 0.5 * math.pi


class Following(FollowTrajectory):
    """A trajectory that goes along x here, and up where the other one is: 20 m farther on, which is 3 m left of it."""

    def __init__(self) -> None:
        pass

    def axis(self) -> tuple[float, float]:
        return 0.0, 0.0

    def beside(self, x: float, y: float) -> tuple[float, float, float]:
        return 20.0, 3.0, QUARTER


def two(h: float = 0.0, *, follows: bool = True) -> tuple[Any, Any]:
    """A faces along the trajectory or against it; B faces up, as the trajectory does there. Both are 4 m by 2 m, from
    1 m behind their reference points to 3 m ahead of them."""
    a, b = car("A"), car("B")
    a.put(0.0, 0.0, 0.0, h)
    b.put(17.0, 9.0, 0.0, QUARTER)
    if follows:
        a.lateral = Following()
    return a, b


@pytest.mark.parametrize(
    ("h", "kind", "free", "apart"),
    [
        (0.0, "longitudinal", False, 20.0),
        (0.0, "lateral", False, 3.0),
        (math.pi, "longitudinal", False, -20.0),  # rear first: it lies behind, to the right
        (math.pi, "lateral", False, -3.0),
        (0.0, "longitudinal", True, 20.0 - 3.0 - 1.0),  # from A's front to B's rear
        (0.0, "lateral", True, 1.0),
        (math.pi, "longitudinal", True, -(20.0 - 1.0 - 1.0)),  # from A's rear
        (math.pi, "lateral", True, -1.0),
    ],
)
def test_a_distance_along_a_trajectory_is_seen_as_one_faces(h: float, kind: str, free: bool, apart: float) -> None:
    a, b = two(h)
    board: Any = SimpleNamespace(network=None)
    assert measure(board, a, b, kind=kind, system="trajectory", free=free)() == pytest.approx(apart)

    def there() -> Place:
        return Place(17.0, 9.0, 0.0, 0.0)

    point = measure(board, a, there, kind="longitudinal", system="trajectory", free=True)()
    assert point == pytest.approx(17.0 if h == 0.0 else -19.0)


@pytest.mark.parametrize(
    ("h", "kind", "apart", "rate"),
    [
        (0.0, "longitudinal", 20.0, 10.0 - 4.0),  # each along the trajectory where it is
        (0.0, "lateral", 3.0, 2.0 + 1.0),  # B moves to the right there, which is +x
        (0.0, "longitudinal", -20.0, -6.0),
        (math.pi, "longitudinal", 20.0, -6.0),
        (math.pi, "longitudinal", -20.0, 6.0),
    ],
)
def test_who_closes_in_along_a_trajectory(h: float, kind: str, apart: float, rate: float) -> None:
    a, b = two(h)
    a.vx, a.vy, b.vx, b.vy = 10.0, 2.0, 1.0, 4.0
    board: Any = SimpleNamespace(network=None)
    assert _closing(board, a, b, kind, "trajectory")(apart) == pytest.approx(rate)
    alone, b = two(follows=False)
    alone.vx = 10.0
    assert _closing(board, alone, b, kind, "trajectory")(apart) == 0.0

    def there() -> Place:
        return Place(17.0, 9.0, 0.0, 0.0)

    own = {"longitudinal": 10.0, "lateral": 2.0}[kind] * (1.0 if h == 0.0 else -1.0)
    found = _closing(board, a, there, kind, "trajectory")(apart)
    assert found == pytest.approx(math.copysign(1.0, apart) * own)


# --- lanes of a route

SIGNS = {-2: 1, -1: 1, 1: -1, 2: -1, 3: -1}


def lanes(*ids: int, drivable: Any = ()) -> Any:
    section = SimpleNamespace(lanes=[SimpleNamespace(id=i, drivable=i not in drivable) for i in ids])
    return SimpleNamespace(section=lambda road, s: section, driving_sign=lambda road, lane, s: SIGNS[lane])


@pytest.mark.parametrize(
    ("network", "lane", "other"),
    [
        (lanes(-2, -1, 1, 2), -2, 1),
        (lanes(-2, -1, 1, 2), 2, -1),
        (lanes(-2, -1, 1, 2, drivable=(1,)), -1, 2),
        (lanes(-2, -1), -1, None),
        (lanes(1, 2, 3), 2, None),
    ],
)
def test_the_nearest_lane_whose_traffic_goes_the_other_way(network: Any, lane: int, other: int | None) -> None:
    found = _across(network, RoadPoint("7", lane, 12.0, 0.5))
    assert found == (None if other is None else RoadPoint("7", other, 12.0, 0.0))


@pytest.mark.parametrize(("has_heading", "asked"), [(True, 0.5), (False, None)])
def test_a_place_of_the_world_means_the_nearest_lane_there(has_heading: bool, asked: float | None) -> None:
    seen: list[Any] = []

    def locate(x: float, y: float, h: Any, *, z: float) -> Any:
        seen.append((x, y, z, h))
        return SimpleNamespace(road="7", lane=-1, s=3.0, offset=0.25)

    board: Any = SimpleNamespace(network=SimpleNamespace(locate=locate))
    place = Place(1.0, 2.0, 8.0, 0.5, has_heading=has_heading)
    assert _point(board, place) == RoadPoint("7", -1, 3.0, 0.25)
    assert seen == [(1.0, 2.0, 8.0, asked)]
    named = place._replace(road=RoadPoint("8", 1, 4.0, 0.0))
    assert _point(board, named) == RoadPoint("8", 1, 4.0, 0.0)
    assert len(seen) == 1


# --- what there is before anything happens


def test_a_new_entity_stands_at_the_origin_and_holds_nothing() -> None:
    entity = car()
    numbers = ("x", "y", "z", "h", "pitch", "roll", "speed", "vx", "vy", "ax", "speed_before", "s", "offset", "twist",
               "drift", "travelled", "teleports", "lane")  # fmt: skip
    assert {name: getattr(entity, name) for name in numbers} == dict.fromkeys(numbers, 0)
    flags = ("tracked", "shifted", "end_of_road", "blocked", "moved", "placed", "external")
    assert {name: getattr(entity, name) for name in flags} == dict.fromkeys(flags, False)
    nobody = ("set_speed", "longitudinal", "lateral", "trailer", "drawn_by", "driver", "controls")
    assert {name: getattr(entity, name) for name in nobody} == dict.fromkeys(nobody)
    assert (entity.sense, entity.along, entity.still_since, entity.end_since) == (1.0, 1.0, math.inf, math.inf)
    assert (entity.road, entity.route, entity.route_lanes, entity.active) == ("", (), (), True)


def test_a_new_world_has_no_weather_since_its_beginning() -> None:
    world = World()
    assert (world.environment, world.clock, world.friction) == (None, None, math.inf)
    assert world.signals == {}
    assert World().signals is not world.signals
