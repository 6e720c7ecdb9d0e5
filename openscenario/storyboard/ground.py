"""The road under the entities: keeping their lane, finding it again, moving along it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from openscenario.road.network import RoadNetwork, RouteLane
from openscenario.road.positions import RoadPosition
from openscenario.storyboard.places import Place, RoadPoint, turned_in_plane, wrap, yaw_in_plane
from openscenario.storyboard.stride import stride

if TYPE_CHECKING:
    from openscenario.storyboard.entity import Entity

AT_END = 0.1  # m before the end of its road a vehicle that is moved from outside is at it; chosen, above antenna noise
BESIDE = 0.05  # m: farther from every road there is open ground


class Ground:
    """A road network as the storyboard uses it; without one (`network` None) entities move over open ground."""

    __slots__ = ("_numbers", "network")

    def __init__(self, network: RoadNetwork | None) -> None:
        self.network = network
        # roads of the compiled tables, in file order
        self._numbers = {road: number for number, road in enumerate(network.roads)} if network is not None else {}

    def set_place(self, entity: Entity, place: Place) -> None:
        """Put an entity somewhere; a place given in road coordinates keeps the road and lane it names."""
        entity.put(place.x, place.y, place.z, place.h)
        entity.pitch, entity.roll = place.pitch, place.roll
        entity.end_of_road = False
        if place.road is not None:
            entity.road, entity.lane, entity.s, entity.offset = place.road
            self._face(entity)

    def place(self, entity: Entity, x: float, y: float, z: float, h: float, speed: float) -> None:
        """The true pose of an entity that something else moves; its road state is found when asked for."""
        entity.x, entity.y, entity.z, entity.h = x, y, z, wrap(h)
        entity.speed = speed
        entity.vx, entity.vy = speed * math.cos(h), speed * math.sin(h)
        entity.tracked = False

    def track(self, entity: Entity) -> bool:
        """Make the road state of an entity valid; False where there is no road at all."""
        if entity.tracked:
            return True
        if self.network is None:
            return False
        hint = RoadPosition(entity.road, entity.lane, entity.s, 0.0, entity.offset, 0.0, True) if entity.road else None
        z = None if entity.external else entity.z  # heights that are measured may count from somewhere else
        found = self.network.locate(entity.x, entity.y, entity.h, hint, z=z)
        entity.road, entity.lane, entity.s, entity.offset = found.road, found.lane, found.s, found.offset
        self._face(entity)
        return True

    def stand(self, entity: Entity) -> None:
        """Give an entity that was put somewhere the height, pitch and roll of the road there, if there is one."""
        if not self.track(entity):
            return
        assert self.network is not None
        x, y, z, h, pitch, roll = self.network.lane_pose(entity.road, entity.lane, entity.s, entity.offset)
        if abs(x - entity.x) < BESIDE and abs(y - entity.y) < BESIDE:
            yaw = yaw_in_plane(pitch, roll, entity.h - h)
            entity.z = z
            _, entity.pitch, entity.roll = turned_in_plane(h, pitch, roll, yaw)

    def _face(self, entity: Entity) -> None:
        assert self.network is not None
        pose = self.network.lane_pose(entity.road, entity.lane, entity.s, entity.offset)
        against = yaw_in_plane(pose.pitch, pose.roll, wrap(entity.h - pose.h))
        entity.sense = 1.0 if abs(against) <= 0.5 * math.pi else -1.0
        entity.twist = against if entity.sense > 0.0 else wrap(against - math.pi)
        entity.tracked = True

    def point(self, entity: Entity) -> RoadPoint | None:
        """Where an entity is in road coordinates."""
        if not self.track(entity):
            return None
        return RoadPoint(entity.road, entity.lane, entity.s, entity.offset)

    def position(self, entity: Entity) -> RoadPosition:
        """Road position of an entity, t and road heading included."""
        self.track(entity)
        return self._complete(entity.road, entity.lane, entity.s, entity.offset)

    def position_of(self, place: Place) -> RoadPosition:
        """Road position of a place: the one it was given in, else the nearest lane."""
        network = self.network
        assert network is not None
        if place.road is None:
            return network.locate(place.x, place.y, place.h if place.has_heading else None, z=place.z)
        return self._complete(*place.road)

    def _complete(self, road: str, lane: int, s: float, offset: float) -> RoadPosition:
        network = self.network
        assert network is not None
        t = network.lane_t(road, lane, s) + offset
        return RoadPosition(road, lane, s, t, offset, network.road_pose(road, s, 0.0).h, True)

    def distance(self, here: RoadPosition, goal: RoadPosition) -> float:
        """Way [m] along the reference lines, positive with increasing s of the first; NaN without a way."""
        if here.road == goal.road:
            return goal.s - here.s
        network = self.network
        assert network is not None
        return network.driving_sign(here.road, here.lane, here.s) * network.distance(here, goal)

    def turned(self, here: RoadPosition, there: RoadPosition) -> float:
        """-1 if the road over there runs against the one here, so that lanes and t count the other way, else 1."""
        network = self.network
        return -1.0 if network is not None and network.runs_against(here, there) else 1.0

    def lane_onwards(self, there: RoadPosition, here: RoadPosition) -> tuple[int, bool]:
        """The lane here that the one over there runs on as, and whether links lead so; else the one of the same id, or
        of the same number on the other side of a road that runs against it."""
        network = self.network
        assert network is not None
        lane = network.lane_onwards(there, here)
        if lane:
            return lane, True
        return there.lane if self.turned(here, there) > 0.0 else -there.lane, False

    def spread_friction(self, entities: Sequence[Entity], friction: float) -> None:
        """Limit vehicles by the material of the lane under them times the road's [-], infinite if it is dry."""
        network = self.network
        if network is None or not network.states_friction:
            return
        for entity in entities:
            if entity.kind == "vehicle" and entity.active and self.track(entity):
                here = network.lane_friction(entity.road, entity.lane, entity.s) * min(friction, 1.0)
                entity.limit_friction(here if here < 1.0 else math.inf)

    def on_road(self, entity: Entity) -> bool:
        """Whether a lane holds the reference point, of any type but "none"."""
        network = self.network
        if network is None:
            return False
        found = network.locate(entity.x, entity.y, entity.h, drivable=False)
        return found.on_road and network.lane_type(found.road, found.lane, found.s) != "none"

    def at_end(self, entity: Entity) -> bool:
        """Whether the road of an entity, and its route, go no farther than AT_END the way it faces."""
        if not self.track(entity):
            return False
        assert self.network is not None
        here = RoadPosition(entity.road, entity.lane, entity.s, 0.0, entity.offset, 0.0, True)
        sign = entity.sense * self.network.driving_sign(entity.road, entity.lane, entity.s)
        there = self.network.advance(here, sign * AT_END, 0.0, entity.route_lanes)
        return there.road == entity.road and abs(there.s - entity.s) < 0.9 * AT_END

    def drive(self, entity: Entity, distance: float) -> None:
        """Move a tracked entity `distance` [m] the way it faces at its offset in the lane, and set its pose."""
        network = self.network
        assert network is not None
        number = self._numbers[entity.road]
        lane, s, left, x, y, z, h, pitch, roll = stride(
            network.tables, number, entity.lane, entity.s, entity.offset, entity.sense * distance
        )
        away = network.branching and network.exit_between(
            (number, entity.lane, entity.s), (number, lane, s), entity.sense * distance > 0.0, entity.route_lanes
        )
        if left != 0.0 or x != x or away:
            self._cross(entity, distance)
            x, y, z, h, pitch, roll = network.lane_pose(entity.road, entity.lane, entity.s, entity.offset)
        else:
            entity.lane, entity.s = lane, s
            entity.end_of_road = False
        self._pose(entity, x, y, z, h, pitch, roll)

    def _pose(self, entity: Entity, x: float, y: float, z: float, h: float, pitch: float, roll: float) -> None:
        """Take the pose of its place in the lane, turned as the entity is."""
        turned = entity.twist + entity.drift
        if turned != 0.0 and (pitch != 0.0 or roll != 0.0):
            yaw = turned if entity.sense > 0.0 else turned + math.pi
            h, entity.pitch, entity.roll = turned_in_plane(h, pitch, roll, yaw)
            entity.h = wrap(h)
        elif entity.sense > 0.0:
            entity.h = wrap(h + turned)
            entity.pitch, entity.roll = pitch, roll
        else:
            entity.h = wrap(h + math.pi + turned)
            entity.pitch, entity.roll = -pitch, -roll
        entity.x, entity.y, entity.z = x, y, z

    def _cross(self, entity: Entity, distance: float) -> None:
        """Move beyond the end of a road: onto the next one, along the entity's route if it has one, or no further."""
        network = self.network
        assert network is not None
        here = RoadPosition(entity.road, entity.lane, entity.s, 0.0, entity.offset, 0.0, True)
        sign = entity.sense * network.driving_sign(entity.road, entity.lane, entity.s)
        there = network.advance(here, sign * distance, 0.0, entity.route_lanes)
        if there.road != entity.road:
            # the way one faces is kept, whatever way the next road runs
            heading = entity.h - entity.twist - entity.drift
            entity.sense = 1.0 if math.cos(heading - there.h_road) >= 0.0 else -1.0
            entity.end_of_road = False
        elif entity.sense * (there.s - entity.s) >= 0.0:
            # as far as the road goes; after a whole step without any way the speed is lost
            if entity.end_of_road and entity.blocked:
                entity.speed = 0.0
            entity.blocked = entity.end_of_road
            entity.end_of_road = True
        else:
            entity.end_of_road = False
        entity.road, entity.lane, entity.s, entity.offset = there.road, there.lane, there.s, there.offset

    def along_lane(self, entity: Entity, distance: float, route: Sequence[RouteLane]) -> RoadPoint:
        """Road coordinates `distance` [m] ahead of a tracked entity along its lane; `route` says where roads part."""
        return self._moved(entity, entity.sense * distance, route, on_reference=False)

    def along_road(self, entity: Entity, ds: float, route: Sequence[RouteLane]) -> RoadPoint:
        """Road coordinates `ds` [m] further along the reference line than a tracked entity, < 0: against it."""
        return self._moved(entity, ds, route, on_reference=True)

    def _moved(self, entity: Entity, way: float, route: Sequence[RouteLane], *, on_reference: bool) -> RoadPoint:
        """`way` > 0 with increasing s of the entity's road. The offset is to the side of the entity, on any road."""
        network = self.network
        assert network is not None
        here = RoadPosition(entity.road, entity.lane, entity.s, 0.0, entity.offset, 0.0, True)
        sign = network.driving_sign(entity.road, entity.lane, entity.s)
        there = network.advance(here, sign * way, 0.0, route, on_reference=on_reference)
        point = RoadPoint(there.road, there.lane, there.s, entity.offset)
        mirrored = entity.sense * self.sense_at(entity, point) < 0.0  # t counts the other way there
        return point._replace(offset=-entity.offset) if mirrored else point

    def sense_at(self, entity: Entity, point: RoadPoint) -> float:
        """+1 if what faces as a tracked entity does, with or against the traffic, faces increasing s elsewhere."""
        network = self.network
        assert network is not None
        with_traffic = entity.sense * network.driving_sign(entity.road, entity.lane, entity.s)
        return with_traffic * network.driving_sign(point.road, point.lane, point.s)
