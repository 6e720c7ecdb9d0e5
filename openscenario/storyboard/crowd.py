"""Traffic that comes and goes: what sources, sinks, swarms and areas put on the road, and how it drives.

The standard says where such traffic is and how much of it, not how it drives. Here: in the middle of its lane, straight
on where roads part, behind others by the intelligent driver model (Treiber, Hennecke, Helbing 2000,
doi:10.1103/PhysRevE.62.1805); it never changes lanes and goes where its lane ends. Everything is drawn from the
storyboard's seed.
"""

from __future__ import annotations

import math
import random
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from openscenario import model
from openscenario.road.positions import RoadPosition
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.places import RoadPoint

MOST = 300  # entities of traffic at a time
SPACING = 5.0  # m between the spots of a lane
PERIOD = 0.1  # s between two looks at who comes and who goes
TRIES = 20  # draws of a place until nobody comes in this step; chosen, not measured
COMFORT, BRAKE, HEADWAY, STANDSTILL = 1.5, 2.0, 1.5, 2.0  # m/s^2, m/s^2, s, m: a, b, T, s0 of the model
HARDEST = 8.0  # m/s^2
LOOK_AHEAD = 150.0  # m
TOWN = 50.0 / 3.6  # m/s where the road names no limit

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Queue = list[tuple[float, Entity]]  # along a lane, by s


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
        lanes: dict[tuple[str, int], Queue] = {}
        for entity in self.board.entities.values():
            if entity.active and entity.visible.traffic and ground.track(entity):
                lanes.setdefault((entity.road, entity.lane), []).append((entity.s, entity))
        for queue in lanes.values():
            queue.sort(key=lambda each: each[0])
        for entity, wished, _ in self.members.values():
            gap, other = self._ahead(entity, lanes)
            entity.speed = max(0.0, entity.speed + following(entity.speed, wished, gap, other) * dt)

    def _ahead(self, entity: Entity, lanes: dict[tuple[str, int], Queue]) -> tuple[float, float]:
        """Gap [m] to the next one in the lane, and its speed [m/s] in the entity's direction; inf if there is none."""
        network = self.board.ground.network
        assert network is not None
        road, lane, s, sense = entity.road, entity.lane, entity.s, entity.sense
        way, own = 0.0, entity.center_x + 0.5 * entity.length
        while way < LOOK_AHEAD:
            other = _next(lanes.get((road, lane), []), s, sense, strictly=way == 0.0)
            if other is not None and other is not entity:
                along = 1.0 if other.sense == sense else -1.0
                reach = 0.5 * other.length - along * other.center_x
                return way + abs(other.s - s) - own - reach, along * other.speed
            left = network.roads[road].length - s if sense > 0.0 else s
            there = network.advance(RoadPosition(road, lane, s, 0.0, 0.0, 0.0, True), left + 0.01)
            if (there.road, there.lane) == (road, lane):
                break
            way += left
            road, lane, s = there.road, there.lane, there.s
            sense = float(network.driving_sign(road, lane, s))
        return math.inf, 0.0


def _next(queue: Queue, s: float, sense: float, *, strictly: bool) -> Entity | None:
    if sense > 0.0:
        i = (bisect_right if strictly else bisect_left)(queue, s, key=lambda each: each[0])
        return queue[i][1] if i < len(queue) else None
    i = (bisect_left if strictly else bisect_right)(queue, s, key=lambda each: each[0])
    return queue[i - 1][1] if i > 0 else None


def following(speed: float, wished: float, gap: float, other: float) -> float:
    """Acceleration [m/s^2] of the intelligent driver model, at least -HARDEST.

    speed, wished, and that of who is ahead [m/s]; gap between the two bodies [m], inf if there is nobody.
    """
    free = 1.0 - (speed / wished) ** 4 if wished > 0.0 else -1.0
    if gap == math.inf:
        return max(COMFORT * free, -HARDEST)
    closing = speed * (speed - other) / (2.0 * math.sqrt(COMFORT * BRAKE))
    desired = STANDSTILL + max(0.0, speed * HEADWAY + closing)
    return max(COMFORT * (free - (desired / max(gap, 0.1)) ** 2), -HARDEST)


def weighted(chance: random.Random, entries: Iterable[tuple[float, model.EntityObject]]) -> model.EntityObject:
    """One of some entries, by weight; the first if no weight is above 0."""
    listed = list(entries)
    left = chance.random() * sum(weight for weight, _ in listed)
    for weight, what in listed:
        left -= weight
        if left < 0.0:
            return what
    return listed[0][1]
