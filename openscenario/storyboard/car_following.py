"""How a car follows another in its lane: the intelligent driver model, and who is ahead.

Source: M. Treiber, A. Hennecke, D. Helbing, Congested traffic states in empirical observations and microscopic
simulations, Physical Review E 62, 2000, doi:10.1103/PhysRevE.62.1805. It knows no right of way and no lane changes.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

from openscenario.road.positions import RoadPosition

if TYPE_CHECKING:
    from openscenario.storyboard.entity import Entity
    from openscenario.storyboard.ground import Ground

# a [m/s^2], b [m/s^2], T [s], s0 [m] of the model: its table I but for a and b, which there are 0.73 and 1.67; chosen
COMFORT, BRAKE, HEADWAY, STANDSTILL = 1.5, 2.0, 1.5, 2.0
HARDEST: Final = 8.0  # m/s^2
LOOK_AHEAD: Final = 150.0  # m
Queue = list[tuple[float, "Entity"]]  # along a lane, by s


def queues(entities: Iterable[Entity], ground: Ground) -> dict[tuple[str, int], Queue]:
    """Who is in each lane, by s; those that traffic does not see are left out."""
    lanes: dict[tuple[str, int], Queue] = {}
    for entity in entities:
        if entity.active and entity.visible.traffic and ground.track(entity):
            lanes.setdefault((entity.road, entity.lane), []).append((entity.s, entity))
    for queue in lanes.values():
        queue.sort(key=lambda each: each[0])
    return lanes


def ahead(entity: Entity, lanes: dict[tuple[str, int], Queue], ground: Ground) -> tuple[float, float]:
    """Gap [m] to the next one in the lane, and its speed [m/s] in the entity's direction; inf if there is none."""
    network = ground.network
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


def following(speed: float, wished: float, gap: float, other: float, headway: float = HEADWAY) -> float:
    """Acceleration [m/s^2] of the intelligent driver model, at least -HARDEST.

    speed, wished, and that of who is ahead [m/s]; gap between the two bodies [m], inf if there is nobody; headway [s].
    """
    free = 1.0 - (speed / wished) ** 4 if wished > 0.0 else -1.0
    if gap == math.inf:
        return max(COMFORT * free, -HARDEST)
    closing = speed * (speed - other) / (2.0 * math.sqrt(COMFORT * BRAKE))
    desired = STANDSTILL + max(0.0, speed * headway + closing)
    return max(COMFORT * (free - (desired / max(gap, 0.1)) ** 2), -HARDEST)
