"""Actions that are over at once, and actions of traffic lights and looks: with stubs around them."""

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
from openscenario.storyboard.nodes import Node
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.trailers import couple
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.world import World

from .bodies import car

THERE = Place(5.0, 6.0, 7.0, 0.5)


class Board:
    def __init__(self, *entities: Any, **more: Any) -> None:
        self.entities = {entity.name: entity for entity in entities}
        self.running, self.time = True, 1.5
        self.network: Any = SimpleNamespace()
        self.warned: list[tuple[str, str]] = []
        self.put: list[tuple[Any, Any]] = []
        self.ground: Any = SimpleNamespace(set_place=lambda entity, where: self.put.append((entity, where)),
                                           point=lambda entity: RoadPoint("1", -1, 2.0, 0.0),
                                           track=lambda entity: self.put.append((entity, "tracked")))  # fmt: skip
        lights: Any = [SimpleNamespace(id="7", name="north"), SimpleNamespace(id="8", name="7")]
        self.world = World(lights)
        self.world.monitors["b"] = True
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
    for called, light in (("north", "7"), ("7", "7")):  # by its name; an id comes before a name
        board.world.signals.clear()
        signal_state(SimpleNamespace(name=called, state="green"), None, board).start()  # type: ignore[arg-type]
        assert board.world.signals == {light: "green"}
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
    noon = SimpleNamespace(animation=False)
    weather = SimpleNamespace(road_condition=road, time_of_day=noon)
    environment(SimpleNamespace(environment=weather), None, board).start()  # type: ignore[arg-type]
    assert (board.world.environment, board.world.friction) == (weather, friction)
    assert (board.world.clock, board.world.clock_since) == (noon, 1.5)
    assert limited == ([] if scale is None else [("A", friction)])


def test_an_environment_without_a_time_of_day_leaves_the_clock_as_it_was() -> None:
    board: Any = Board()
    board.world.clock, board.world.clock_since = (noon := object()), 0.5
    weather = SimpleNamespace(road_condition=None, time_of_day=None)
    environment(SimpleNamespace(environment=weather), None, board).start()  # type: ignore[arg-type]
    assert (board.world.environment, board.world.clock, board.world.clock_since) == (weather, noon, 0.5)


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
