"""The default controller: keep lane and speed, as the standard wants where no action says otherwise."""

from __future__ import annotations

import math

from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground

BEAT = 0.01  # s
TINY = 1e-6  # m or rad; against rounding only


def way(entity: Entity, dt: float) -> float:
    """Way [m] of a step of `dt` [s] in which the speed changes evenly [m/s]: that of beats of v x 10 ms.

    A speed holds for the whole beat that reaches it; one that is `late` for the whole beat after it. The standard says
    nothing; the field's tools step so, and it makes the way the same whatever steps the storyboard takes.
    """
    before, speed = entity.speed_before, entity.speed
    beat = 0.5 * (speed - before) * min(BEAT, dt)
    return 0.5 * (before + speed) * dt + (-beat if entity.late else beat)


def lean(entity: Entity, rate: float, dt: float) -> bool:
    """Let the entity's way of this step be oblique: `rate` [m/s] of it to the side (left of where it faces).

    Returns whether it is fast enough for that; if not, all of its way goes to the side.
    """
    ahead = abs(way(entity, dt))
    aside = abs(rate) * dt
    enough = aside < ahead + TINY
    part = min(aside / ahead, 1.0) if ahead > 0.0 else 1.0
    entity.along = math.sqrt(1.0 - part * part)
    angle = math.asin(part) if enough else 0.5 * math.pi - TINY  # a little less: which way it faces stays clear
    entity.drift = math.copysign(angle, rate * entity.speed) if rate != 0.0 else 0.0
    entity.shifted = True
    return enough


def move(entity: Entity, dt: float, ground: Ground) -> None:
    """Move an entity for `dt` [s] with the speed its actions left it, along its lane, sideways as lateral actions want.

    An entity without road moves straight on, but stands where its trajectory has ended.
    """
    if entity.end_of_road and ground.network is None:
        entity.speed = 0.0
    speed = entity.speed
    before = entity.speed_before
    entity.ax = (speed - before) / dt
    distance, moving = way(entity, dt), dt
    if entity.placed and not entity.shifted:
        beat = min(BEAT, dt)
        distance -= (before + (speed - before) * beat / dt) * beat
        moving = dt - beat
        if dt <= BEAT:
            entity.vx, entity.vy = speed * math.cos(entity.h), speed * math.sin(entity.h)
            return
    if distance == 0.0 and entity.drift == 0.0 and not entity.shifted:
        entity.vx = entity.vy = 0.0
        return
    x, y = entity.x, entity.y
    if ground.track(entity):
        h = entity.h
        ground.drive(entity, distance * entity.along)
        if entity.leads > 0.0:
            entity.draw_behind(x, y, h)
        entity.shifted = False
        entity.along = 1.0
    else:
        entity.x += distance * math.cos(entity.h)
        entity.y += distance * math.sin(entity.h)
    entity.travelled += abs(distance)
    entity.vx = (entity.x - x) / moving
    entity.vy = (entity.y - y) / moving
