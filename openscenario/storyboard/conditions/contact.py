"""Conditions on contact and on the road's end: collision, off road, end of road."""

from __future__ import annotations

from openscenario import model
from openscenario.storyboard.distances import overlap
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Scope, condition, entity_called
from openscenario.storyboard.triggers import Test

RESOLUTION = 1e-9  # s


@condition(model.CollisionCondition)
def collision(element: model.CollisionCondition, entity: Entity, scope: Scope) -> Test:
    """Bounding boxes overlap, seen from above, with the entity or with any of the given type."""
    entities = scope.board.entities
    target = element.target
    if isinstance(target, model.EntityRef):
        name, kind = entity_called(target.entity_ref, scope.board, target).name, ""
    else:
        name, kind = "", "misc" if target.type == "miscellaneous" else target.type

    def test() -> bool:
        reach = entity.length + entity.width + abs(entity.center_x)
        for other in (entities[name],) if name else entities.values():  # traffic comes and goes
            if other is entity or (not name and other.kind != kind):
                continue
            near = reach + other.length + other.width + abs(other.center_x)
            if not other.active or abs(other.x - entity.x) > near or abs(other.y - entity.y) > near:
                continue
            if overlap(entity.corners(), other.corners()):
                return True
        return False

    return test


@condition(model.EndOfRoadCondition)
def end_of_road(element: model.EndOfRoadCondition, entity: Entity, scope: Scope) -> Test:
    """True once the entity has been at the end of its road for the duration [s]."""
    board, duration = scope.board, element.duration
    board.road_watch.add(entity)
    return lambda: board.time - entity.end_since >= duration - RESOLUTION


@condition(model.OffroadCondition)
def off_road(element: model.OffroadCondition, entity: Entity, scope: Scope) -> Test:
    """Off road is where no lane of any road holds the reference point."""
    board, duration = scope.board, element.duration
    board.road_watch.add(entity)
    return lambda: board.time - entity.off_since >= duration - RESOLUTION
