"""The default controller: keep lane and speed, as the standard wants where no action says otherwise."""

from __future__ import annotations

import math

from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground


def move(entity: Entity, dt: float, ground: Ground) -> None:
    """Move an entity for `dt` [s] with the speed its actions left it, along its lane, sideways as lateral actions want.

    The distance is that of a constant acceleration over the step. An entity without road moves straight on.
    """
    speed = entity.speed
    before = entity.speed_before
    entity.ax = (speed - before) / dt
    rate = entity.offset_rate
    distance = 0.5 * (before + speed) * dt
    if distance == 0.0 and rate == 0.0 and entity.drift == 0.0:
        entity.vx = entity.vy = 0.0
        return
    x, y = entity.x, entity.y
    if ground.track(entity):
        if rate != 0.0 or entity.drift != 0.0:
            entity.drift = _drift(rate, speed, oblique=entity.oblique)
            ground.drive(entity, distance * math.cos(entity.drift) if entity.oblique else distance)
        else:
            ground.drive(entity, distance)
    else:
        entity.x += distance * math.cos(entity.h)
        entity.y += distance * math.sin(entity.h)
    entity.travelled += abs(distance)
    entity.vx = (entity.x - x) / dt
    entity.vy = (entity.y - y) / dt


def _drift(rate: float, speed: float, *, oblique: bool) -> float:
    """Heading [rad] against the lane of an entity that moves sideways with `rate` [m/s]; 0 while it stands.

    `oblique`: the speed is that of the whole motion, so `rate` is its part to the side; else it is that along the lane.
    """
    if abs(speed) <= 1e-3:
        return 0.0
    if oblique:
        return math.asin(min(max(rate / speed, -1.0), 1.0))
    return math.atan(rate / speed)
