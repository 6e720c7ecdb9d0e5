"""Ways along roads through waypoints, and who is ahead over a road's end: on networks that are stubs."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.road.positions import RoadPosition
from openscenario.road.route import RouteError, RouteLane
from openscenario.storyboard import positions, routes
from openscenario.storyboard.actions import routing
from openscenario.storyboard.actions.routing import assign_route
from openscenario.storyboard.car_following import LOOK_AHEAD, ahead
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.routes import MOST_LANES, _piece, along_route, wander, way
from openscenario.storyboard.unsupported import Unsupported

from .bodies import car

HERE = Place(0.0, 0.0, 0.0, 0.0)


def at(road: str, lane: int, s: float) -> Place:
    return HERE._replace(road=RoadPoint(road, lane, s, 0.0))


# --- places along a route

STRETCHES = (RouteLane("1", -1, 20.0, 100.0), RouteLane("2", 1, 50.0, 0.0), RouteLane("3", -2, 0.0, 30.0))


@pytest.mark.parametrize(
    ("path_s", "road", "lane", "s"),
    [
        (0.0, "1", -1, 20.0),
        (50.0, "1", -1, 70.0),
        (80.0, "1", -1, 100.0),
        (81.0, "2", 1, 49.0),  # the second one runs against its s
        (130.0, "2", 1, 0.0),
        (135.0, "3", -2, 5.0),
        (160.0, "3", -2, 30.0),
        (999.0, "3", -2, 30.0),  # beyond its end
        (-5.0, "1", -1, 20.0),  # before its beginning
    ],
)
def test_a_place_along_a_route_is_so_many_metres_of_its_stretches_away(
    path_s: float, road: str, lane: int, s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "way", lambda board, places: STRETCHES)
    warned: list[str] = []
    board: Any = SimpleNamespace(
        network=SimpleNamespace(lane_t=lambda road, lane, s: 3.5 * lane + 0.01 * s),
        warn=lambda element, code, text: warned.append(f"{code}: {text}"),
    )
    inside: Any = model.PositionInLaneCoordinates(path_s=path_s, lane_id=7, lane_offset=0.4)
    assert along_route(board, [at("1", -1, 20.0)], inside) == RoadPoint(road, 7, pytest.approx(s), 0.4)
    beside: Any = model.PositionInRoadCoordinates(path_s=path_s, t=2.0)
    offset = 2.0 - (3.5 * lane + 0.01 * s)
    assert along_route(board, [at("1", -1, 20.0)], beside) == RoadPoint(
        road, lane, pytest.approx(s), pytest.approx(offset)
    )
    text = f"pathS = {path_s:g} m is beyond the route, which has 160 m: the nearer end of it is taken"
    assert warned == ([f"beyond-route: {text}"] * 2 if not 0.0 <= path_s <= 160.0 else [])


@pytest.mark.parametrize(
    ("path_s", "road", "s"), [(160.0, "3", 30.0), (161.0, "1", 21.0), (325.0, "1", 25.0), (-10.0, "3", 20.0)]
)
def test_a_closed_route_goes_round(path_s: float, road: str, s: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 160 m with the way back to the first waypoint."""
    gone: list[Any] = []
    monkeypatch.setattr(routes, "way", lambda board, places: gone.append(tuple(places)) or STRETCHES)
    inside: Any = model.PositionInLaneCoordinates(path_s=path_s, lane_id=7)
    first, last = at("1", -1, 20.0), at("2", 1, 30.0)
    board: Any = SimpleNamespace(network=SimpleNamespace())
    assert along_route(board, [first, last], inside, closed=True) == RoadPoint(road, 7, pytest.approx(s), 0.0)
    assert gone == [(first, last, first)]


def test_without_a_way_a_place_along_it_is_where_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(routes, "way", lambda board, places: ())
    warned: list[tuple[str, str]] = []
    board: Any = SimpleNamespace(
        network=SimpleNamespace(lane_t=lambda road, lane, s: -1.75), warn=lambda _, *said: warned.append(said)
    )
    inside: Any = model.PositionInRoadCoordinates(path_s=30.0, t=-1.0)
    places = [at("4", -1, 12.0), at("7", -2, 3.0)]
    assert along_route(board, places, inside) == RoadPoint("4", -1, 12.0, 0.75)
    text = "no way leads along the waypoints of the route: pathS = 30 m is taken as its first waypoint"
    assert warned == [("beyond-route", text)]


class Network:
    """Roads of which each pair (road, lane) is joined to the ones that are told; asked: what ways were looked for."""

    def __init__(self, *joined: tuple[tuple[str, int], tuple[str, int]], other: int | None = None) -> None:
        self.joined, self.other = joined, other
        self.asked: list[Any] = []

    def route(self, start: Any, goal: Any) -> Any:
        self.asked.append((start, goal))
        if (start[:2], goal[:2]) not in self.joined:
            raise RouteError("no way")
        return (RouteLane(start[0], start[1], start[2], 99.0), RouteLane(goal[0], goal[1] - 1, 0.0, goal[2]))

    def driving_sign(self, road: str, lane: int, s: float) -> int:
        return -1 if lane > 0 else 1

    def section(self, road: str, s: float) -> Any:
        lanes = (-1, 1) if self.other else (-1,)
        return SimpleNamespace(lanes=[SimpleNamespace(id=i, drivable=True) for i in lanes])


def test_a_way_goes_from_place_to_place_and_on_in_the_lane_that_the_last_one_ended_in() -> None:
    network = Network((("1", -1), ("2", -1)), (("2", -2), ("3", -2)), (("3", -3), ("4", -1)))
    board: Any = SimpleNamespace(network=network)
    found = way(board, [at("1", -1, 5.0), at("2", -1, 40.0), at("3", -2, 7.0), at("4", -1, 3.0)])
    assert network.asked == [
        (("1", -1, 5.0), ("2", -1, 40.0)), (("2", -2, 40.0), ("3", -2, 7.0)), (("3", -3, 7.0), ("4", -1, 3.0))
    ]  # fmt: skip
    assert [(each.road, each.lane) for each in found] == [
        ("1", -1), ("2", -2), ("2", -2), ("3", -3), ("3", -3), ("4", -2)
    ]  # fmt: skip


def test_a_way_is_cut_where_none_leads_on_and_without_a_network_there_is_none() -> None:
    network = Network((("1", -1), ("2", -1)))
    board: Any = SimpleNamespace(network=network)
    places = [at("1", -1, 5.0), at("2", -1, 40.0), at("3", -1, 7.0), at("1", -1, 5.0), at("2", -1, 40.0)]
    assert [each.road for each in way(board, places)] == ["1", "2"]
    assert way(SimpleNamespace(network=None), places) == ()  # type: ignore[arg-type]


@pytest.mark.parametrize(("closed", "roads"), [(False, ["1", "2"]), (True, ["1", "2", "2", "1"])])
def test_a_closed_route_leads_back_to_its_first_waypoint(
    closed: bool, roads: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Class Route: in a closed route `the last waypoint is followed by the first`; its waypoints stay two."""
    there = [at("1", -1, 5.0), at("2", -1, 40.0)]
    monkeypatch.setattr(routing, "resolver", lambda position, board: lambda: position)
    board: Any = SimpleNamespace(network=Network((("1", -1), ("2", -1)), (("2", -2), ("1", -1))))
    waypoints = [SimpleNamespace(position=each) for each in there]
    element: Any = SimpleNamespace(route=SimpleNamespace(closed=closed, waypoints=waypoints))
    entity = car("A")
    assert assign_route(element, entity, board).start()
    assert [each.road for each in entity.route_lanes] == roads
    assert entity.route == tuple(there)


def test_where_no_lane_leads_there_one_beside_it_may_do() -> None:
    start, goal = RoadPoint("1", -1, 5.0, 0.0), RoadPoint("2", -1, 40.0, 0.0)
    network: Any = Network((("1", 1), ("2", -1)), other=1)
    assert [each.lane for each in _piece(network, start, goal)] == [1, -2]
    assert [(a[1], b[1]) for a, b in network.asked] == [(-1, -1), (-1, 1), (1, -1)]
    alone: Any = Network((("1", 1), ("2", -1)))
    assert _piece(alone, start, goal) == ()
    assert len(alone.asked) == 1


@pytest.mark.parametrize(
    ("length", "lanes"),
    [(40.0, [("1", -1, 0.0, 50.0)]), (50.0, [("1", -1, 0.0, 50.0)]),
     (51.0, [("1", -1, 0.0, 50.0), ("2", 1, 20.0, 0.0)]), (99.0, [("1", -1, 0.0, 50.0), ("2", 1, 20.0, 0.0)])],
)  # fmt: skip
def test_who_wanders_goes_on_until_it_is_far_enough_or_no_lane_follows(length: float, lanes: Any) -> None:
    roads = {"1": SimpleNamespace(length=50.0), "2": SimpleNamespace(length=20.0)}
    after = {("1", -1): [("9", 9), ("2", 1)], ("2", 1): []}
    seen: list[float] = []

    def sign(road: str, lane: int, s: float) -> int:
        seen.append(s)
        return 1 if lane < 0 else -1

    network = SimpleNamespace(roads=roads, driving_sign=sign, lane_successors=lambda road, lane: after[road, lane])
    board: Any = SimpleNamespace(network=network, random=SimpleNamespace(choice=lambda options: options[-1]))
    entity: Any = SimpleNamespace(road="1", lane=-1, s=33.0)
    assert [tuple(each) for each in wander(board, entity, length)] == lanes
    assert seen == [33.0, 0.0][: len(lanes)]


def test_roads_without_a_length_come_to_an_end() -> None:
    network = SimpleNamespace(roads={"1": SimpleNamespace(length=0.0)}, driving_sign=lambda road, lane, s: 1,
                              lane_successors=lambda road, lane: [("1", -1)])  # fmt: skip
    board: Any = SimpleNamespace(network=network, random=SimpleNamespace(choice=lambda options: options[0]))
    assert len(wander(board, SimpleNamespace(road="1", lane=-1, s=0.0), 1.0)) == MOST_LANES == 10_000  # type: ignore[arg-type]


# --- the position of a route


def route_position(inside: Any) -> Any:
    waypoints = [SimpleNamespace(position="first"), SimpleNamespace(position="second")]
    return SimpleNamespace(route=SimpleNamespace(waypoints=waypoints, closed=True), in_route_position=inside,
                           orientation=None, at=model.At("x.xosc", 3, "E"))  # fmt: skip


def test_a_place_of_a_route_needs_a_road_and_may_be_that_of_an_entity(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(Unsupported, match="no road network"):
        positions._route(route_position(None), SimpleNamespace(network=None))  # type: ignore[arg-type]
    other = car("B")
    other.x, other.y, other.z, other.h = 3.0, 4.0, 5.0, 0.6
    board: Any = SimpleNamespace(network=object(), entities={"B": other})
    monkeypatch.setattr(positions, "resolver", lambda position, board: lambda: position)
    monkeypatch.setattr(routes, "along_route", lambda board, places, inside, closed: (places, inside, closed))
    monkeypatch.setattr(positions, "_on_lane", lambda board, point, orientation: point)
    inside: Any = model.PositionInLaneCoordinates(path_s=1.0, lane_id=-1)
    assert positions._route(route_position(inside), board)() == (["first", "second"], inside, True)
    there = positions._route(route_position(model.PositionOfCurrentEntity(entity_ref="B")), board)()
    assert (there.x, there.y, there.z, there.h) == (3.0, 4.0, 5.0, 0.6)


# --- who is ahead over the end of a road


def two_roads(far: float = 100.0) -> tuple[Any, list[float]]:
    """Road 1 of `far` metres, lane -1, goes on in road 2, lane 1, of 50 m, which runs the other way."""
    asked: list[float] = []

    def advance(here: RoadPosition, distance: float) -> RoadPosition:
        asked.append(distance)
        left = far - here.s if here.road == "1" else here.s
        if distance <= left or here.road == "2":
            return here
        return RoadPosition("2", 1, 50.0 - (distance - left), 0.0, 0.0, 0.0, True)

    network = SimpleNamespace(roads={"1": SimpleNamespace(length=far), "2": SimpleNamespace(length=50.0)},
                              driving_sign=lambda road, lane, s: 1 if road == "1" else -1, advance=advance)  # fmt: skip
    return SimpleNamespace(network=network), asked


def standing(name: str, road: str, lane: int, s: float, sense: float, speed: float = 5.0) -> Any:
    found = car(name)
    found.road, found.lane, found.s, found.sense, found.speed = road, lane, s, sense, speed
    return found


def test_who_is_ahead_may_be_on_the_next_road_which_runs_the_other_way() -> None:
    """10 m to the end, a hundredth beyond it, and 20 m less that: 30 m between reference points. A reaches 3 m ahead
    of its own, B 1 m behind its own."""
    ground, asked = two_roads()
    a, b = standing("A", "1", -1, 90.0, 1.0), standing("B", "2", 1, 30.0, -1.0, 4.0)
    assert ahead(a, {("2", 1): [(30.0, b)]}, ground) == pytest.approx((10.0 + 19.99 - 3.0 - 1.0, 4.0))
    assert asked == [pytest.approx(10.01)]


def test_who_comes_against_it_is_met_with_its_front_and_a_speed_below_nought() -> None:
    ground, _ = two_roads()
    a, b = standing("A", "1", -1, 90.0, 1.0), standing("B", "2", 1, 30.0, 1.0, 4.0)
    assert ahead(a, {("2", 1): [(30.0, b)]}, ground) == pytest.approx((10.0 + 19.99 - 3.0 - 3.0, -4.0))


def test_at_the_last_end_and_beyond_what_is_looked_at_nobody_is_ahead() -> None:
    ground, asked = two_roads()
    a = standing("A", "2", 1, 30.0, -1.0)
    assert ahead(a, {("2", 1): [(30.0, a)]}, ground) == (math.inf, 0.0)
    assert asked == [pytest.approx(30.01)]
    far, asked = two_roads(LOOK_AHEAD + 1.0)
    a, b = standing("A", "1", -1, 0.5, 1.0), standing("B", "2", 1, 30.0, -1.0)
    assert ahead(a, {("2", 1): [(30.0, b)]}, far) == (math.inf, 0.0)
    assert len(asked) == 1
    near, _ = two_roads(LOOK_AHEAD)
    assert ahead(a, {("2", 1): [(30.0, b)]}, near)[1] == 5.0
    a.s = 0.0  # exactly as far from the end as is looked
    assert ahead(a, {("2", 1): [(30.0, b)]}, near) == (math.inf, 0.0)


def test_a_circle_leads_back_to_oneself_and_nobody_is_ahead() -> None:
    ground, _ = two_roads()
    a = standing("A", "1", -1, 90.0, 1.0)
    queue: Any = {("2", 1): [(30.0, a)]}
    assert ahead(a, queue, ground) == (math.inf, 0.0)
