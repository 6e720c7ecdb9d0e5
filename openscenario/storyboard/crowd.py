"""Traffic that comes and goes: what sources, sinks, swarms and areas put on the road, and how it drives.

The standard says where such traffic is and how much of it, not how it drives. Here: in the middle of its lane, straight
on where roads part, behind others as `car_following` says; it never changes lanes and goes where its lane ends.
Everything is drawn from the storyboard's seed.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from openscenario import model
from openscenario.storyboard.car_following import HEADWAY, STANDSTILL, ahead, following, queues
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.places import RoadPoint

MOST = 300  # entities of traffic at a time
SPACING = 5.0  # m between the spots of a lane
PERIOD = 0.1  # s between two looks at who comes and who goes
TRIES = 20  # draws of a place until nobody comes in this step; chosen, not measured
TOWN = 50.0 / 3.6  # m/s where the road names no limit

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Spots(NamedTuple):
    """Places on driving lanes, heading as their traffic does [m, rad]."""

    points: list[RoadPoint]
    x: Floats
    y: Floats
    h: Floats


class Flow(Protocol):
    """One source, sink, swarm or area."""

    def come_and_go(self, crowd: Crowd, time: float) -> None:
        """Let members of the crowd come and go at `time` [s]."""


class Streets(Protocol):
    """What a crowd needs of the storyboard it drives in."""

    random: random.Random
    time: float
    ground: Ground
    entities: dict[str, Entity]

    def admit(self, entity: Entity) -> None:
        """One more entity from now on."""

    def dismiss(self, entity: Entity) -> None:
        """An entity that came is gone."""


class Crowd:
    """All traffic of a storyboard."""

    def __init__(self, board: Streets) -> None:
        self.board = board
        self.random = random.Random(board.random.random())
        self.members: dict[str, tuple[Entity, float, Flow]] = {}  # name -> entity, wished speed, where it came from
        self._flows: list[tuple[str, Flow]] = []
        self._number = 0
        self._due = 0.0
        self._spots: Spots | None = None

    def add(self, name: str, flow: Flow) -> None:
        """Add a flow under the name of its action; it acts from the next step on."""
        self._flows.append((name, flow))
        self._due = 0.0

    def stop(self, name: str) -> None:
        """No more come and go by the action of that name (all actions, if it is empty); who is there drives on."""
        self._flows = [each for each in self._flows if name and each[0] != name]

    @property
    def spots(self) -> Spots:
        """Places on all driving lanes of the network."""
        if self._spots is None:
            network = self.board.ground.network
            assert network is not None
            points, poses = [], []
            for road in network.roads.values():
                count = max(int(road.length / SPACING), 1)
                for s in ((i + 0.5) * road.length / count for i in range(count)):
                    for lane in network.section(road.id, s).lanes:
                        if lane.type == "driving" and network.lane_width(road.id, lane.id, s) > 2.0:
                            pose = network.lane_pose(road.id, lane.id, s)
                            turn = 0.0 if network.driving_sign(road.id, lane.id, s) > 0 else math.pi
                            points.append(RoadPoint(road.id, lane.id, s, 0.0))
                            poses.append((pose.x, pose.y, pose.h + turn))
            x, y, h = np.array(poses).reshape(-1, 3).T
            self._spots = Spots(points, x, y, h)
        return self._spots

    # --- who comes and who goes

    def come_and_go(self) -> None:
        """Every PERIOD, dismiss whoever is at the end of the road or gone, and let each flow bring and take others."""
        time = self.board.time
        if time < self._due - 1e-9:
            return
        self._due = time + PERIOD
        for entity, _, _ in list(self.members.values()):
            if entity.end_of_road or not entity.active:
                self.dismiss(entity)
        for _, flow in self._flows:
            flow.come_and_go(self, time)

    def of(self, flow: Flow) -> list[Entity]:
        """The members that a flow brought and that are still there."""
        return [entity for entity, _, source in self.members.values() if source is flow]

    def admit(self, flow: Flow, name: str, what: model.EntityObject, where: Mask, speed: Callable[[], float]) -> bool:
        """Put another entity on a free one of some spots; False if there is none."""
        candidates = np.flatnonzero(where)
        if not len(candidates) or len(self.members) >= MOST:
            return False
        number = self._number + 1
        while f"{name}-{number}" in self.board.entities:
            number += 1
        label = f"{name}-{number}"
        entity = Entity(model.ScenarioObject(name=label, entity=what), external=False)
        wished = min(speed(), entity.max_speed)
        for _ in range(TRIES):
            k = int(candidates[self.random.randrange(len(candidates))])
            if self._free(k, entity, wished):
                self._put(entity, k, wished)
                self.members[label] = entity, wished, flow
                self._number = number
                return True
        return False

    def _put(self, entity: Entity, k: int, speed: float) -> None:
        spots, board = self.spots, self.board
        network = board.ground.network
        assert network is not None
        point = spots.points[k]
        pose = network.lane_pose(point.road, point.lane, point.s)
        entity.put(pose.x, pose.y, pose.z, float(spots.h[k]))
        entity.road, entity.lane, entity.s, entity.offset = point
        entity.sense = 1.0 if math.cos(entity.h - pose.h) >= 0.0 else -1.0
        entity.pitch, entity.roll = entity.sense * pose.pitch, entity.sense * pose.roll
        entity.tracked = True
        entity.jump_to_speed(speed)
        entity.vx, entity.vy = speed * math.cos(entity.h), speed * math.sin(entity.h)
        board.admit(entity)

    def _free(self, k: int, entity: Entity, speed: float) -> bool:
        point, x, y = self.spots.points[k], self.spots.x[k], self.spots.y[k]
        for other in self.board.entities.values():
            if not other.active:
                continue
            sizes = 0.5 * (entity.length + other.length) + abs(other.center_x) + abs(entity.center_x)
            same = self.board.ground.track(other) and (other.road, other.lane) == (point.road, point.lane)
            room = STANDSTILL + HEADWAY * max(speed, abs(other.speed)) if same else 0.0
            beside = other.road == point.road and not same
            if not beside and math.hypot(other.x - x, other.y - y) < sizes + room:
                return False
        return True

    def dismiss(self, entity: Entity) -> None:
        """Let a member go. It must be one."""
        del self.members[entity.name]
        self.board.dismiss(entity)

    # --- how it drives

    def drive(self, dt: float) -> None:
        """New speeds of the traffic, before it moves."""
        if not self.members:
            return
        ground = self.board.ground
        lanes = queues(self.board.entities.values(), ground)
        for entity, wished, _ in self.members.values():
            gap, other = ahead(entity, lanes, ground)
            entity.speed = max(0.0, entity.speed + following(entity.speed, wished, gap, other) * dt)


def weighted(chance: random.Random, entries: Iterable[tuple[float, model.EntityObject]]) -> model.EntityObject:
    """One of some entries, by weight; the first if no weight is above 0."""
    listed = list(entries)
    left = chance.random() * sum(weight for weight, _ in listed)
    for weight, what in listed:
        left -= weight
        if left < 0.0:
            return what
    return listed[0][1]
