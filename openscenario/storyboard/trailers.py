"""Trailers: which hang on which vehicle, and how they are drawn along.

A trailer is a body on one axle, its reference point, that does not slip sideways; its coupler stands on the hitch of
the vehicle ahead. So its axle moves towards the hitch: with e the direction from the axle's old place to the hitch H
and c the distance from axle to coupler it comes to H - c e (the tractrix by steps). A vehicle that is placed has its
trailers straight behind it.

Names: a trailer that is defined inside a vehicle has no name that is unique in the scenario; it is called like the
vehicle ahead of it with a `+`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping

from openscenario import model
from openscenario.storyboard.entity import Entity

SMALL = 1e-6  # m


def trains(scenario: model.Scenario, external: Collection[str]) -> Iterator[tuple[Entity, Entity | None]]:
    """All entities in the order of the file, each followed by the trailers defined inside it, with what draws them.

    The trailers of an external entity are left out: whoever moves it does not know of them.
    """
    for each in scenario.entities:
        ahead = Entity(each, external=each.name in external)
        yield ahead, None
        inside = None if ahead.external else _inside(each)
        while inside is not None:
            behind = Entity(inside, external=False)
            behind.name = f"{ahead.name}+"
            yield behind, ahead
            ahead, inside = behind, _inside(inside)


def _inside(scenario_object: model.ScenarioObject) -> model.ScenarioObject | None:
    trailer = getattr(scenario_object.entity, "trailer", None)
    return trailer.trailer if trailer is not None else None


def couple_named(scenario: model.Scenario, entities: Mapping[str, Entity]) -> None:
    """Hang on the trailers that vehicles name; a name that no entity has is a catalogue's and means none."""
    for each in scenario.entities:
        trailer = getattr(each.entity, "trailer", None)
        if trailer is None or trailer.trailer_ref is None or trailer.trailer_ref.entity_ref not in entities:
            continue
        ahead, behind = entities[each.name], entities[trailer.trailer_ref.entity_ref]
        if not ahead.external and not behind.external:
            couple(ahead, behind)


def couple(ahead: Entity, behind: Entity) -> None:
    """Hang `behind` on `ahead`; what hung there before, and what drew it before, let go."""
    uncouple(ahead)
    if behind.drawn_by is not None:
        uncouple(behind.drawn_by)
    ahead.trailer = behind
    behind.drawn_by = ahead


def uncouple(ahead: Entity) -> None:
    """Let go of the trailer of an entity, if it has one; the trailer stands."""
    behind = ahead.trailer
    if behind is not None:
        ahead.trailer = behind.drawn_by = None
        behind.jump_to_speed(0.0)


def line_up(ahead: Entity) -> None:
    """Put the trailers of an entity straight behind it."""
    behind = ahead.trailer
    while behind is not None:
        back = ahead.hitch - behind.coupler
        behind.put(ahead.x + back * math.cos(ahead.h), ahead.y + back * math.sin(ahead.h), ahead.z, ahead.h)
        ahead, behind = behind, behind.trailer


def draw(ahead: Entity, dt: float) -> None:
    """Draw the trailers of an entity to where it is now; `dt` [s] is the time that this took, 0 if none passed."""
    behind = ahead.trailer
    while behind is not None:
        hitch_x = ahead.x + ahead.hitch * math.cos(ahead.h)
        hitch_y = ahead.y + ahead.hitch * math.sin(ahead.h)
        dx, dy = hitch_x - behind.x, hitch_y - behind.y
        # a coupler right above the axle keeps its heading
        h = math.atan2(dy, dx) if behind.coupler > SMALL and math.hypot(dx, dy) > SMALL else behind.h
        x, y = behind.x, behind.y
        behind.put(hitch_x - behind.coupler * math.cos(h), hitch_y - behind.coupler * math.sin(h), ahead.z, h)
        behind.pitch, behind.roll = ahead.pitch, ahead.roll
        behind.speed_before, behind.speed, behind.ax = ahead.speed_before, ahead.speed, ahead.ax
        if dt > 0.0:
            behind.vx, behind.vy = (behind.x - x) / dt, (behind.y - y) / dt
            behind.travelled += math.hypot(behind.x - x, behind.y - y)
        ahead, behind = behind, behind.trailer


def couples(entity: Entity) -> tuple[Entity, ...]:
    """All that an entity is coupled to, from the vehicle that draws to the last trailer, itself included."""
    while entity.drawn_by is not None:
        entity = entity.drawn_by
    return (entity,) if entity.trailer is None else tuple(train(entity))


def train(entity: Entity) -> Iterator[Entity]:
    """The entity and its trailers."""
    each: Entity | None = entity
    while each is not None:
        yield each
        each = each.trailer
