"""AssignRouteAction and AcquirePositionAction: which way to take where roads part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.places import Place
from openscenario.storyboard.positions import Where, resolver
from openscenario.storyboard.registry import action
from openscenario.storyboard.routes import round_trip, wander, way
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

FAR = 10_000.0  # m


class Route(Instant):
    """Gives the entity a route; over at once, the route stays. The default controller follows it where roads part.

    One that is closed leads the default controller back to its first waypoint; whoever is moved by something else is
    told the waypoints once.
    """

    __slots__ = ("_board", "_closed", "_element", "_entity", "_from_here", "_waypoints")

    def __init__(
        self,
        element: model.Element,
        entity: Entity,
        board: Board,
        waypoints: list[Where],
        *,
        from_here: bool,
        closed: bool = False,
    ) -> None:
        super().__init__()
        self._element = element
        self._entity = entity
        self._board = board
        self._waypoints = waypoints
        self._from_here = from_here
        self._closed = closed
        if board.network is None:
            raise Unsupported("the scenario has no road network")

    def _places(self) -> tuple[Place, ...]:
        places = [waypoint() for waypoint in self._waypoints]
        if self._from_here:
            entity = self._entity
            here = Place(entity.x, entity.y, entity.z, entity.h, road=self._board.ground.point(entity))
            places.insert(0, here)
        return tuple(places)

    def start(self) -> bool:
        """Set the route; True, as that was all. A warning if no way leads along its waypoints."""
        entity, board = self._entity, self._board
        entity.route = self._places()
        entity.route_lanes = way(board, round_trip(entity.route, self._closed))
        if len(entity.route) > 1 and not entity.route_lanes:
            board.warn(self._element, "no-way", f"{entity.name}: no way leads along the waypoints of the route")
        return True

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "route" with its waypoints, x, y [m] and h [rad] each; over at once."""
        self.start()
        places = self._entity.route
        points = tuple((place.x, place.y, place.h) for place in places)
        return "route", {"waypoints": points, "places": places}, 0.0


@action(model.AssignRouteAction)
def assign_route(element: model.AssignRouteAction, entity: Entity, board: Board) -> Runner:
    """Give the entity the waypoints of a route, which the default controller follows where roads part."""
    waypoints = [resolver(waypoint.position, board) for waypoint in element.route.waypoints]
    return Route(element, entity, board, waypoints, from_here=False, closed=element.route.closed)


@action(model.RandomRouteAction)
def random_route(element: model.RandomRouteAction, entity: Entity, board: Board) -> Runner:
    """A way from where the entity is, drawn from the storyboard's seed where roads part; 10 km or to a dead end.

    Raises Unsupported in a scenario without a road network.
    """
    if board.network is None:
        raise Unsupported("the scenario has no road network")

    def take() -> None:
        board.ground.track(entity)
        entity.route_lanes = wander(board, entity, FAR)
        entity.route = ()

    return Instant(take)


@action(model.AcquirePositionAction)
def acquire_position(element: model.AcquirePositionAction, entity: Entity, board: Board) -> Runner:
    """At Init an external entity's position is its route's last waypoint, whatever way it takes."""
    return Route(element, entity, board, [resolver(element.position, board)], from_here=True)
