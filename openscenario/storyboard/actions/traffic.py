"""TrafficAction: sources, sinks, swarms and areas of traffic, and their end."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from openscenario import model
from openscenario.storyboard.crowd import TOWN, Crowd, Flow, Mask, weighted
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.positions import Where, resolver
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

# length, width, height, rear axle to rear bumper, wheelbase [m] where the file names categories only
SIZES = {
    "bicycle": (1.8, 0.6, 1.7, 0.35, 1.1),
    "bus": (12.0, 2.55, 3.2, 3.3, 5.9),
    "motorbike": (2.2, 0.8, 1.5, 0.4, 1.4),
    "truck": (9.0, 2.5, 3.5, 2.0, 5.0),
    "van": (5.9, 2.0, 2.5, 1.1, 3.7),
}
CAR = (4.5, 1.8, 1.5, 0.9, 2.7)


class Kinds:
    """What the traffic is made of: of the templates of a distribution, else of categories, else cars."""

    def __init__(
        self, definition: model.TrafficDefinition | None, distribution: model.TrafficDistribution | None
    ) -> None:
        self._entries: list[tuple[float, model.EntityObject]] = []
        if distribution is not None:
            for entry in distribution.traffic_distribution_entries:
                total = sum(each.weight for each in entry.entity_distribution) or 1.0
                for each in entry.entity_distribution:
                    share = entry.weight * each.weight / total
                    self._entries.append((share, each.scenario_object_template.entity))
        elif definition is not None:
            for category in definition.vehicle_category_distribution:
                self._entries.append((category.weight, vehicle(category.category)))
        self._entries = self._entries or [(1.0, vehicle("car"))]

    def draw(self, crowd: Crowd) -> model.EntityObject:
        """What comes next, drawn from the crowd's random numbers by the weights of the distribution."""
        return weighted(crowd.random, self._entries)


def vehicle(category: model.VehicleCategory) -> model.Vehicle:
    """A vehicle of usual size and performance."""
    length, width, height, rear, wheelbase = SIZES.get(category, CAR)
    box = model.BoundingBox(
        center=model.Center(x=0.5 * length - rear, y=0.0, z=0.5 * height),
        dimensions=model.Dimensions(width=width, length=length, height=height),
    )
    axles = model.Axles(
        front_axle=model.Axle(
            max_steering=0.5, wheel_diameter=0.65, track_width=0.85 * width, position_x=wheelbase, position_z=0.32
        ),
        rear_axle=model.Axle(
            max_steering=0.0, wheel_diameter=0.65, track_width=0.85 * width, position_x=0.0, position_z=0.32
        ),
    )
    performance = model.Performance(max_speed=70.0, max_acceleration=10.0, max_deceleration=10.0)
    return model.Vehicle(
        name=category, vehicle_category=category, bounding_box=box, performance=performance, axles=axles
    )


def limit(crowd: Crowd, where: Mask) -> float:
    """Speed limit [m/s] of the first of some spots, that of a town where there is none."""
    network = crowd.board.ground.network
    found = np.flatnonzero(where)
    if network is None or not len(found):
        return TOWN
    point = crowd.spots.points[int(found[0])]
    speed = network.lane_speed(point.road, point.lane, point.s)
    return speed if math.isfinite(speed) else TOWN


class Source:
    """Every 1 / rate seconds one more within the radius (on the nearest lane, if none is so near), as soon as there is
    room; with the given speed, else that of the limit."""

    def __init__(self, element: model.TrafficSourceAction, name: str, board: Board) -> None:
        self._element = element
        self._name = name
        self._where: Where = resolver(element.position, board)
        self._kinds = Kinds(element.traffic_definition, element.traffic_distribution)
        self._due: float | None = None

    def come_and_go(self, crowd: Crowd, time: float) -> None:
        """Let those come that are due at `time` [s], within the radius, while there is a free place."""
        element = self._element
        if element.rate <= 0.0:
            return
        if self._due is None:
            self._due = time
        if time < self._due - 1e-9:
            return
        place = self._where()
        apart = np.hypot(crowd.spots.x - place.x, crowd.spots.y - place.y)
        near = apart <= max(element.radius, float(apart.min(initial=math.inf)))
        speed = element.speed if element.speed is not None else limit(crowd, near)
        while time >= self._due - 1e-9 and crowd.admit(self, self._name, self._kinds.draw(crowd), near, lambda: speed):
            self._due += 1.0 / element.rate


class Sink:
    """Takes traffic (nothing that the file names as an entity) out of its radius, so many a second if it has a rate."""

    def __init__(self, element: model.TrafficSinkAction, board: Board) -> None:
        self._element = element
        self._where: Where = resolver(element.position, board)
        self._due = -math.inf

    def come_and_go(self, crowd: Crowd, time: float) -> None:
        """Let those within the radius go at `time` [s], no more often than the rate says; without a rate all."""
        place, rate = self._where(), self._element.rate
        for entity, _, _ in list(crowd.members.values()):
            if math.hypot(entity.x - place.x, entity.y - place.y) > self._element.radius:
                continue
            if rate is not None and (rate <= 0.0 or time < self._due - 1e-9):
                return
            crowd.dismiss(entity)
            if rate is not None:
                self._due = max(self._due, time) + 1.0 / rate


class Swarm:
    """Keeps so many in the ellipse around the central entity, turned and moved with it, but lets none appear in the
    inner circle; who leaves the ellipse is gone."""

    def __init__(self, element: model.TrafficSwarmAction, name: str, board: Board) -> None:
        self._element = element
        self._name = name
        self._central = entity_called(element.central_object.entity_ref, board, element.central_object)
        self._kinds = Kinds(element.traffic_definition, element.traffic_distribution)

    def _inside(self, x: np.ndarray, y: np.ndarray) -> Mask:
        central, element = self._central, self._element
        dx, dy = x - central.x, y - central.y
        c, s = math.cos(central.h), math.sin(central.h)
        ahead, aside = c * dx + s * dy - element.offset, c * dy - s * dx
        major, minor = max(element.semi_major_axis, 1e-9), max(element.semi_minor_axis, 1e-9)
        return np.asarray((ahead / major) ** 2 + (aside / minor) ** 2 <= 1.0)

    def come_and_go(self, crowd: Crowd, time: float) -> None:
        """Let those go that have left the ellipse, and others come into it until there are as many as stated."""
        element, central = self._element, self._central
        mine = crowd.of(self)
        for entity in mine:
            if not self._inside(np.array([entity.x]), np.array([entity.y]))[0]:
                crowd.dismiss(entity)
        missing = int(element.number_of_vehicles) - len(crowd.of(self))
        if missing <= 0 or not central.active:
            return
        spots = crowd.spots
        where = self._inside(spots.x, spots.y)
        where &= np.hypot(spots.x - central.x, spots.y - central.y) >= element.inner_radius
        same = np.cos(spots.h - central.h) >= 0.0
        for _ in range(missing):
            sides = where
            directions = element.direction_of_travel_distribution
            if directions is not None:
                total = directions.same + directions.opposite
                sides = where & (same == (crowd.random.random() * total < directions.same))
            if not crowd.admit(self, self._name, self._kinds.draw(crowd), sides, lambda: self._speed(crowd, where)):
                break

    def _speed(self, crowd: Crowd, where: Mask) -> float:
        speeds = self._element.initial_speed_range
        if speeds is not None:
            return crowd.random.uniform(speeds.lower_limit, speeds.upper_limit)
        velocity = self._element.velocity
        return velocity if velocity is not None else limit(crowd, where)


class Area:
    """Puts so many into a polygon or onto stretches of roads; `continuous` keeps the number, who leaves is gone."""

    def __init__(self, element: model.TrafficAreaAction, name: str, board: Board) -> None:
        self._element = element
        self._name = name
        self._kinds = Kinds(None, element.traffic_distribution)
        area = element.traffic_area
        self._corners: list[Where] = [resolver(each, board) for each in area.polygon.positions] if area.polygon else []
        for stretch in area.road_ranges:
            if len({cursor.road_id for cursor in stretch.road_cursors}) != 1:
                raise Unsupported("a RoadRange over several roads is not supported", element=stretch)
        self._filled = False

    def _mask(self, crowd: Crowd) -> Mask:
        spots, area = crowd.spots, self._element.traffic_area
        if self._corners:
            places = [where() for where in self._corners]
            return within([(place.x, place.y) for place in places], spots.x, spots.y)
        chosen = np.zeros(len(spots.points), dtype=np.bool_)
        for stretch in area.road_ranges:
            first, last = stretch.road_cursors[0], stretch.road_cursors[-1]
            low = first.s or 0.0
            high = low + stretch.length if stretch.length is not None else math.inf
            if last is not first and last.s is not None:
                high = last.s
            lanes = {lane.id for lane in first.lanes}
            for k, point in enumerate(spots.points):
                here = point.road == first.road_id and min(low, high) <= point.s <= max(low, high)
                chosen[k] |= here and (not lanes or point.lane in lanes)
        return chosen

    def come_and_go(self, crowd: Crowd, time: float) -> None:
        """Fill the area once; if `continuous`, replace whoever leaves it."""
        where = self._mask(crowd)
        if self._filled and not self._element.continuous:
            return
        if self._filled:
            for entity in crowd.of(self):
                x, y = crowd.spots.x[where], crowd.spots.y[where]
                if not len(x) or float(np.hypot(x - entity.x, y - entity.y).min()) > 5.0:
                    crowd.dismiss(entity)
        self._filled = True
        for _ in range(int(self._element.number_of_entities) - len(crowd.of(self))):
            if not crowd.admit(self, self._name, self._kinds.draw(crowd), where, lambda: limit(crowd, where)):
                break


def within(corners: list[tuple[float, float]], x: np.ndarray, y: np.ndarray) -> Mask:
    """Mask (n,) of the points x (n,), y (n,) [m] that lie in a polygon with these corners [m].

    A ray to the right crosses its edges an odd number of times.
    """
    inside = np.zeros(len(x), dtype=np.bool_)
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return inside


@action(model.TrafficAction)
def traffic(element: model.TrafficAction, entity: Entity | None, board: Board) -> Runner:
    """Cars and the like come and go by the storyboard's seed, at most 300 at a time; see below.

    Raises Unsupported in a scenario without a road network.
    """
    inner = element.action
    if isinstance(inner, model.TrafficStopAction):
        return Instant(lambda: board.crowd().stop(element.traffic_name))
    if board.network is None:
        raise Unsupported("the scenario has no road network")
    name = element.traffic_name or "traffic"
    flow: Flow
    if isinstance(inner, model.TrafficSourceAction):
        flow = Source(inner, name, board)
    elif isinstance(inner, model.TrafficSinkAction):
        flow = Sink(inner, board)
    elif isinstance(inner, model.TrafficSwarmAction):
        flow = Swarm(inner, name, board)
    else:
        flow = Area(inner, name, board)
    return Instant(lambda: board.crowd().add(element.traffic_name, flow))
