"""AngleCondition and RelativeAngleCondition: how an entity is turned against a coordinate system, or against another.

Source: ASAM OpenSCENARIO XML 1.3, classes AngleCondition, RelativeAngleCondition: the angle lies within `angle` +-
`angleTolerance`, both ends included, modulo a full turn.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from openscenario import model
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Scope, condition, entity_called
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.unsupported import Unsupported

ROUNDING = 1e-9  # rad


def _angle(kind: str) -> Callable[[Entity], float]:
    if kind == "heading":
        return lambda entity: entity.h
    if kind == "pitch":
        return lambda entity: entity.pitch
    return lambda entity: entity.roll


def _within(angle: float, wanted: float, tolerance: float) -> bool:
    return abs(math.remainder(angle - wanted, math.tau)) <= tolerance + ROUNDING


@condition(model.AngleCondition)
def angle(element: model.AngleCondition, entity: Entity, scope: Scope) -> Test:
    """Against the world, the road's surface (heading: its reference line, or the driving direction of the lane) or the
    trajectory that the entity follows, false while it follows none. Against itself it has none: always 0."""
    of, wanted, tolerance = _angle(element.angle_type), element.angle, element.angle_tolerance
    if element.coordinate_system == "world":
        return lambda: _within(of(entity), wanted, tolerance)
    if element.coordinate_system == "entity":
        return lambda: _within(0.0, wanted, tolerance)
    base = _base(element, entity, scope)

    def test() -> bool:
        there = base()
        return there is not None and _within(of(entity) - there, wanted, tolerance)

    return test


def _base(element: model.AngleCondition, entity: Entity, scope: Scope) -> Callable[[], float | None]:
    """The angle [rad] that counts as none in the condition's coordinate system; None where there is no such system."""
    kind, system, ground = element.angle_type, element.coordinate_system, scope.board.ground
    network = ground.network
    if system == "trajectory":

        def along() -> float | None:
            if not isinstance(entity.lateral, FollowTrajectory):
                return None
            h, pitch = entity.lateral.axis()
            if kind == "heading":
                return h
            return pitch * (1.0 if math.cos(entity.h - h) >= 0.0 else -1.0) if kind == "pitch" else 0.0

        return along
    if network is None:
        raise Unsupported("this angle is not known", f"{kind}, {system}", "world or trajectory where there is no road")

    def across() -> float | None:
        here = ground.position(entity)
        if kind == "heading":
            against = system == "lane" and network.driving_sign(here.road, here.lane, here.s) < 0
            return here.h_road + math.pi if against else here.h_road
        pose = network.lane_pose(here.road, here.lane, here.s, here.offset)
        surface = pose.pitch if kind == "pitch" else pose.roll
        return surface if math.cos(entity.h - pose.h) >= 0.0 else -surface  # as one sees it who faces the other way

    return across


@condition(model.RelativeAngleCondition)
def relative_angle(element: model.RelativeAngleCondition, entity: Entity, scope: Scope) -> Test:
    """Angle of the other entity minus that of the triggering one."""
    other, of = entity_called(element.entity_ref, scope.board), _angle(element.angle_type)
    wanted, tolerance = element.angle, element.angle_tolerance
    return lambda: other.active and _within(of(other) - of(entity), wanted, tolerance)
