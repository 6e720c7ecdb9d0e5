"""Which entity the ADS drives, with which body, and what its task is: the rules of "Ego and task"."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

from openscenario.findings import Finding, ScenarioError
from openscenario.model.entities import ScenarioObject, Vehicle, ego_among
from openscenario.model.scenario import Scenario
from pytest_dvp.text.spelling import unknown
from vehicle.messages import RoadPoint, Task

if TYPE_CHECKING:
    from openscenario.road.network import RoadNetwork
    from openscenario.storyboard.entity import Entity
    from openscenario.storyboard.places import Place


AT_START = 5.0  # m ahead of the ego up to which a first waypoint is its start


@dataclasses.dataclass(frozen=True)
class EgoTask:
    """Where the ego starts and what it is asked to do; `goal` None means: keep the lane."""

    start: RoadPoint
    goal: RoadPoint | None
    route: tuple[RoadPoint, ...]
    set_speed: float | None

    def message(self) -> Task:
        """The task as the driving stack is told it: without the start."""
        return Task(set_speed=self.set_speed, goal=self.goal, route=self.route)


def find_ego(scenario: Scenario, name: str | None) -> ScenarioObject:
    """The entity called `name`, else `Ego` in any case, else as CARLA calls it (`hero`, `ego_vehicle`), else the only
    vehicle with an assigned controller.

    Raises ScenarioError if there is none, or if it is not a vehicle.
    """
    objects = {entity.name: entity for entity in scenario.entities}
    if name is not None:
        if name not in objects:
            raise _no_ego(scenario, unknown("entity", name, objects))
        found = objects[name]
    else:
        called = ego_among(objects)
        named = [] if called is None else [objects[called]]
        controlled = [entity for entity in scenario.entities if _is_controlled(scenario, entity)]
        if named:
            found = named[0]
        elif len(controlled) == 1:
            found = controlled[0]
        else:
            hint = f"name it with --ego: {', '.join(objects) or 'the scenario has no entity'}"
            raise _no_ego(scenario, f"no entity is called Ego and {len(controlled)} have a controller; {hint}")
    if not isinstance(found.entity, Vehicle):
        raise _no_ego(scenario, f"the ego {found.name!r} is a {found.kind}, expected a vehicle", found)
    return found


def task_of(
    entity: Entity,
    network: RoadNetwork,
    start: RoadPoint | None,
    goal: RoadPoint | None,
    route: tuple[RoadPoint, ...] = (),
) -> EgoTask:
    """Task from the storyboard's Init (route, set-speed) and the gate file's [task] (start, goal, route).

    The gate file says where measuring ends, so its goal takes the place of the last waypoint of the scenario's route.
    """
    found = network.locate(entity.x, entity.y, entity.h)
    here = RoadPoint(found.road, found.lane, found.s)
    points = route or ahead(network, here, tuple(road_point(network, place) for place in entity.route))
    if points:
        points, goal = points[:-1], goal or points[-1]
    set_speed = entity.set_speed if entity.set_speed is not None and entity.set_speed > 0 else None
    return EgoTask(start or here, goal, points, set_speed)


def ahead(network: RoadNetwork, here: RoadPoint, points: tuple[RoadPoint, ...]) -> tuple[RoadPoint, ...]:
    """A route without its first waypoint where that is the place the ego starts from, as it mostly is."""
    if len(points) < 2:
        return points
    first, sign = points[0], network.driving_sign(here.road, here.lane, here.s)
    passed = first.road == here.road and (first.s - here.s) * sign <= AT_START
    return points[1:] if passed else points


def route_from_here(
    network: RoadNetwork, x: float, y: float, h: float, places: Sequence[Place]
) -> tuple[RoadPoint, ...]:
    """Waypoints of a route given under way, without a first one that is already passed.

    Raises RouteError if no way leads along them from the pose x, y [m], h [rad].
    """
    found = network.locate(x, y, h)
    here = RoadPoint(found.road, found.lane, found.s)
    points = ahead(network, here, tuple(road_point(network, place) for place in places))
    for start, goal in itertools.pairwise((here, *points)):
        network.route(start, goal)
    return points


def road_point(network: RoadNetwork, place: Place) -> RoadPoint:
    """A storyboard's place on the map: as the file gives it, else the nearest lane."""
    if place.road is not None:
        return RoadPoint(place.road.road, place.road.lane, place.road.s)
    found = network.locate(place.x, place.y, place.h if place.has_heading else None, z=place.z)
    return RoadPoint(found.road, found.lane, found.s)


def _is_controlled(scenario: Scenario, entity: ScenarioObject) -> bool:
    """A controller in the entity, or assigned to it in Init."""
    if entity.object_controllers:
        return True
    return any(
        type(action).__name__ == "ControllerAction" or "AssignController" in type(action).__name__
        for private in scenario.storyboard.init.actions.privates
        if private.entity_ref == entity.name
        for action in private.private_actions
    )


def _no_ego(scenario: Scenario, text: str, at: ScenarioObject | None = None) -> ScenarioError:
    place = at.at if at is not None else (scenario.entities[0].at if scenario.entities else scenario.at)
    return ScenarioError(
        [Finding("dvp.ego", "error", place.file or str(scenario.path), place.line or None, "Entities", text=text)]
    )
