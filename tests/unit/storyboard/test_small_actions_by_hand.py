"""Actions that are over at once, who drives by itself, and who is ahead in a lane: with stubs around them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.actions import placing, routing
from openscenario.storyboard.actions.appearance import Flash, Wait, appearance
from openscenario.storyboard.actions.environment import environment
from openscenario.storyboard.actions.monitors import monitor
from openscenario.storyboard.actions.placing import Teleport, entity_action, leave_out
from openscenario.storyboard.actions.routing import Route, acquire_position, random_route
from openscenario.storyboard.actions.traffic_lights import signal_controller, signal_state
from openscenario.storyboard.actions.trailer import connect, disconnect
from openscenario.storyboard.car_following import HEADWAY, ahead, following, queues
from openscenario.storyboard.drivers import ASIDE, BACK, activate, drive
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.nodes import Node
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.trailers import couple
from openscenario.storyboard.unsupported import Unsupported

from .bodies import car
from .conftest import Make, lane_position, speed, teleport

THERE = Place(5.0, 6.0, 7.0, 0.5)


class Board:
    def __init__(self, *entities: Any, **more: Any) -> None:
        self.entities = {entity.name: entity for entity in entities}
        self.running, self.time, self.network = True, 1.5, object()
        self.warned: list[tuple[str, str]] = []
        self.put: list[tuple[Any, Any]] = []
        self.ground: Any = SimpleNamespace(set_place=lambda entity, where: self.put.append((entity, where)),
                                           point=lambda entity: RoadPoint("1", -1, 2.0, 0.0),
                                           track=lambda entity: self.put.append((entity, "tracked")))  # fmt: skip
        self.world: Any = SimpleNamespace(signals={}, monitors={"b": True}, friction=math.inf, environment=None,
                                          environment_since=0.0)  # fmt: skip
        for name, value in more.items():
            setattr(self, name, value)

    def warn(self, element: Any, code: str, text: str) -> None:
        self.warned.append((code, text))


@pytest.fixture
def places(monkeypatch: pytest.MonkeyPatch) -> None:
    """A position is the place that it says."""
    for module in (placing, routing):
        monkeypatch.setattr(module, "resolver", lambda position, board, mover=None: lambda: position)


# --- being put, added and deleted


@pytest.mark.usefixtures("places")
@pytest.mark.parametrize("running", [False, True])
def test_a_teleport_puts_the_whole_train_there_and_takes_a_beat(running: bool) -> None:
    truck, trailer = car("A"), car("T")
    truck.hitch, trailer.coupler = -1.0, 3.0
    couple(truck, trailer)
    board: Any = Board(truck, running=running)
    element: Any = SimpleNamespace(position=THERE)
    action = Teleport(element, truck, board)
    assert action.start()
    assert board.put == [(truck, THERE)]
    assert (truck.placed, truck.teleports) == (running, 1)
    assert trailer.x == pytest.approx(truck.x - 4.0)
    assert action.ask() == ("teleport", {"x": 5.0, "y": 6.0, "z": 7.0, "h": 0.5}, 0.0)


def added(name: str) -> Any:
    return model.EntityAction(entity_ref=name, action=model.AddEntityAction(position=THERE))  # type: ignore[arg-type]


@pytest.mark.usefixtures("places")
@pytest.mark.parametrize(
    ("running", "active", "put"), [(True, True, False), (True, False, True), (False, True, True), (False, False, True)]
)
def test_who_is_there_already_is_not_added_again(running: bool, active: bool, put: bool) -> None:
    truck, trailer = car("A"), car("T")
    couple(truck, trailer)
    truck.active = trailer.active = active
    board: Any = Board(truck, running=running)
    assert entity_action(added("A"), None, board).start()
    assert board.put == ([(truck, THERE)] if put else [])
    assert truck.active
    assert trailer.active
    gone = entity_action(model.EntityAction(entity_ref="A", action=model.DeleteEntityAction()), None, board)
    assert truck.active  # not before it begins
    gone.start()
    assert (truck.active, trailer.active) == (False, False)


@pytest.mark.parametrize(
    ("element", "external", "placed", "there"),
    [(added("A"), False, False, False), (added("A"), True, False, True), (added("A"), False, True, True),
     (added("X"), False, False, True), (SimpleNamespace(), False, False, True),
     (model.EntityAction(entity_ref="A", action=model.DeleteEntityAction()), False, False, True)],
)  # fmt: skip
def test_who_is_added_later_is_not_there_before(element: Any, external: bool, placed: bool, there: bool) -> None:
    truck, trailer = car("A"), car("T")
    couple(truck, trailer)
    truck.external = external
    nodes = iter([Node("action", "x", None, element=element)])
    leave_out(nodes, {"A": truck}, [truck] if placed else [None])
    assert (truck.active, trailer.active) == (there, there)


# --- routes


@pytest.mark.usefixtures("places")
def test_a_route_is_given_and_warned_of_where_no_way_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    entity = car("A")
    entity.put(1.0, 2.0, 3.0, 0.25)
    board: Any = Board(entity)
    found: list[Any] = [("lanes",)]
    monkeypatch.setattr(routing, "way", lambda board, route: found[0])
    route = Route(None, entity, board, [lambda: THERE, lambda: THERE], from_here=False)  # type: ignore[arg-type]
    assert route.start()
    assert (entity.route, entity.route_lanes, board.warned) == ((THERE, THERE), ("lanes",), [])
    found[0] = ()
    kind, values, lasts = route.ask()
    assert (kind, lasts) == ("route", 0.0)
    assert values == {"waypoints": ((5.0, 6.0, 0.5),) * 2, "places": (THERE, THERE)}
    assert board.warned == [("no-way", "A: no way leads along the waypoints of the route")]
    board.warned.clear()
    Route(None, entity, board, [lambda: THERE], from_here=False).start()  # type: ignore[arg-type]
    assert board.warned == []  # one place is no way
    here = acquire_position(SimpleNamespace(position=THERE), entity, board)  # type: ignore[arg-type]
    here.start()
    assert entity.route == (Place(1.0, 2.0, 3.0, 0.25, road=RoadPoint("1", -1, 2.0, 0.0)), THERE)
    assert len(board.warned) == 1


def test_a_way_by_chance_leads_ten_kilometres_from_here(monkeypatch: pytest.MonkeyPatch) -> None:
    entity = car("A")
    entity.route = (THERE,)
    board: Any = Board(entity)
    monkeypatch.setattr(routing, "wander", lambda board, entity, length: (length,))
    element: Any = None
    assert random_route(element, entity, board).start()
    assert (entity.route, entity.route_lanes, board.put) == ((), (10_000.0,), [(entity, "tracked")])


def test_without_a_road_network_there_is_no_way() -> None:
    board: Any = Board(network=None)
    element: Any = None
    with pytest.raises(Unsupported, match="the scenario has no road network"):
        random_route(element, car(), board)
    with pytest.raises(Unsupported, match="the scenario has no road network"):
        Route(element, car(), board, [], from_here=False)


# --- trailers, lights and the weather


def test_a_trailer_is_hung_on_and_let_go() -> None:
    truck, trailer = car("A"), car("T")
    board: Any = Board(truck, trailer)
    hang: Any = SimpleNamespace(trailer_ref="T")
    connect(hang, truck, board).start()
    assert (truck.trailer, trailer.drawn_by, board.warned) == (trailer, truck, [])
    back: Any = SimpleNamespace(trailer_ref="A")
    connect(back, trailer, board).start()
    assert board.warned == [("trailer-circle", "T hangs on A itself: not connected")]
    assert trailer.trailer is None
    disconnect(SimpleNamespace(), truck, board).start()  # type: ignore[arg-type]
    assert (truck.trailer, trailer.drawn_by) == (None, None)
    with pytest.raises(Unsupported, match="a vehicle cannot be its own trailer"):
        connect(hang, trailer, board)


def test_lights_and_monitors_are_set_when_the_action_begins() -> None:
    board: Any = Board()
    action = signal_state(SimpleNamespace(name="1", state="red"), None, board)  # type: ignore[arg-type]
    assert board.world.signals == {}
    action.start()
    assert board.world.signals == {"1": "red"}
    monitor(SimpleNamespace(monitor_ref="a", value=False), None, board).start()  # type: ignore[arg-type]
    assert board.world.monitors == {"a": False, "b": True}


def test_a_controller_goes_on_from_the_phase_that_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[Any] = []
    program = SimpleNamespace(begin=lambda name, time: told.append((name, time)),
                              show=lambda time, world: told.append(time))  # fmt: skip
    monkeypatch.setattr("openscenario.storyboard.actions.traffic_lights.program_with", lambda *asked: program)
    board: Any = Board(programs={})
    element: Any = SimpleNamespace(traffic_signal_controller_ref="c", phase="go")
    action = signal_controller(element, None, board)
    assert told == []
    action.start()
    assert told == [("go", 1.5), 1.5]


@pytest.mark.parametrize(("scale", "friction"), [(0.5, 0.5), (1.0, math.inf), (1.2, math.inf), (None, 0.7)])
def test_a_slippery_road_limits_vehicles_and_a_dry_one_nobody(scale: float | None, friction: float) -> None:
    limited: list[tuple[str, float]] = []

    def one(name: str, kind: str) -> Any:
        return SimpleNamespace(name=name, kind=kind, limit_friction=lambda value: limited.append((name, value)))

    board: Any = Board(one("A", "vehicle"), one("P", "pedestrian"))
    board.world.friction = 0.7
    road = None if scale is None else SimpleNamespace(friction_scale_factor=scale)
    weather = SimpleNamespace(road_condition=road)
    environment(SimpleNamespace(environment=weather), None, board).start()  # type: ignore[arg-type]
    assert (board.world.environment, board.world.environment_since, board.world.friction) == (weather, 1.5, friction)
    assert limited == ([] if scale is None else [("A", friction)])


def test_a_light_takes_its_transition_or_flashes_and_an_animation_its_duration() -> None:
    def light(mode: str) -> Any:
        kind = model.VehicleLight(vehicle_light_type="brakeLights")
        return SimpleNamespace(animation_action=None, light_state_action=SimpleNamespace(
            light_type=kind, light_state=SimpleNamespace(mode=mode), transition_time=0.4))  # fmt: skip

    def animation(duration: float | None, loop: bool) -> Any:
        moving = SimpleNamespace(loop=loop, animation_duration=duration)
        return SimpleNamespace(light_state_action=None, animation_action=moving)

    board: Any = Board()
    on = appearance(light("on"), car(), board)
    assert isinstance(on, Wait)
    assert (on._left, on.domains) == (0.4, ("brakeLights",))
    flash = appearance(light("flashing"), car(), board)
    assert isinstance(flash, Flash)
    assert (flash.domains, flash.start(), flash.step(9.0)) == (("brakeLights",), False, False)
    for duration, loop, left in ((2.0, False, 2.0), (None, False, 0.0), (2.0, True, math.inf)):
        found: Any = appearance(animation(duration, loop), car(), board)
        assert (found._left, found.domains) == (left, ())
    assert appearance(SimpleNamespace(light_state_action=None, animation_action=None), car(), board).start()  # type: ignore[arg-type]


# --- who is ahead, and who drives by itself


@pytest.fixture
def street(make: Make) -> Storyboard:
    """A at 100 m and B at 140 m in lane -1, C against them at 120 m in lane 1; 5 m long, 4 m of it ahead."""
    made = make(A=[teleport(lane_position(100.0, -1)), speed(10.0)], B=[teleport(lane_position(140.0, -1)), speed(6.0)],
                C=[teleport(lane_position(120.0, 1)), speed(5.0)])  # fmt: skip
    made.start()
    return made


def test_lanes_hold_who_traffic_sees_in_the_order_of_the_road(street: Storyboard) -> None:
    found = queues(street.entities.values(), street.ground)
    assert {lane: [(s, e.name) for s, e in queue] for lane, queue in found.items()} == {
        ("1", -1): [(100.0, "A"), (140.0, "B")], ("1", 1): [(120.0, "C")],
    }  # fmt: skip
    street.entities["A"].active = False
    street.entities["C"].visible.traffic = False
    assert list(queues(street.entities.values(), street.ground)) == [("1", -1)]


def test_a_gap_is_from_the_front_to_the_rear_of_the_next(street: Storyboard) -> None:
    """40 m between the reference points, less 4 m ahead of A and 1 m behind B."""
    a, b, c = (street.entities[name] for name in "ABC")
    lanes = queues(street.entities.values(), street.ground)
    assert ahead(a, lanes, street.ground) == pytest.approx((35.0, 6.0))
    assert ahead(b, lanes, street.ground) == (math.inf, 0.0)
    assert ahead(c, lanes, street.ground) == (math.inf, 0.0)
    b.sense = -1.0  # it comes the other way: its front is 4 m nearer
    assert ahead(a, lanes, street.ground) == pytest.approx((32.0, -6.0))


@pytest.mark.parametrize(
    ("wished", "headway", "set_speed", "law"),
    [(None, None, None, (10.0, 10.0, HEADWAY)), (15.0, None, 99.0, (10.0, 15.0, HEADWAY)),
     (None, 2.5, 12.0, (10.0, 12.0, 2.5)), (90.0, None, None, (10.0, 70.0, HEADWAY))],
)  # fmt: skip
def test_a_driver_follows_who_is_ahead(
    street: Storyboard, wished: Any, headway: Any, set_speed: Any, law: tuple[float, float, float]
) -> None:
    a = street.entities["A"]
    driver: Any = SimpleNamespace(longitudinal=False, lateral=False, wished=wished, headway=headway, at_work=True)
    a.driver, a.set_speed = driver, set_speed
    activate(a, longitudinal=True, lateral=None)
    assert (driver.longitudinal, driver.lateral) == (True, False)
    drive(street, 0.1)
    own, goal, time = law
    wanted = following(own, goal, 35.0, 6.0, time)
    assert a.speed == pytest.approx(10.0 + 0.1 * min(max(wanted, -10.0), 10.0))


@pytest.mark.parametrize(
    ("offset", "sense", "after"),
    [(0.5, 1.0, 0.5 - 0.25 * 0.1), (-0.5, 1.0, -0.5 + 0.25 * 0.1), (3.0, 1.0, 2.9), (0.5, -1.0, 0.5 - 0.025),
     (0.0, 1.0, 0.0)],
)  # fmt: skip
def test_lane_keeping_goes_back_to_the_middle(street: Storyboard, offset: float, sense: float, after: float) -> None:
    """In 2 s if it went on like that, and no faster than 1 m/s."""
    assert (BACK, ASIDE) == (2.0, 1.0)
    a = street.entities["A"]
    driver: Any = SimpleNamespace(longitudinal=False, lateral=True, wished=None, headway=None, at_work=True)
    a.driver, a.offset, a.sense = driver, offset, sense
    drive(street, 0.1)
    assert a.offset == pytest.approx(after)
    assert a.speed == 10.0
    a.moved, before = True, a.offset
    drive(street, 0.1)
    assert a.offset == before
