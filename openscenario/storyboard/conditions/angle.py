"""AngleCondition and RelativeAngleCondition: how an entity is turned against a coordinate system, or against another.

Source: ASAM OpenSCENARIO XML 1.3, classes AngleCondition, RelativeAngleCondition: the angle lies within `angle` +-
`angleTolerance`, both ends included, modulo a full turn.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Scope, Unsupported, condition, entity_called
from openscenario.storyboard.triggers import Test

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
    """Against the world, or (heading only) the driving direction of the lane or the reference line of the road."""
    of, wanted, tolerance = _angle(element.angle_type), element.angle, element.angle_tolerance
    system, ground = element.coordinate_system, scope.board.ground
    if system == "world":
        return lambda: _within(of(entity), wanted, tolerance)
    network = ground.network
    if system not in ("lane", "road") or element.angle_type != "heading" or network is None:
        raise Unsupported(
            "this angle is not known", f"{element.angle_type}, {system}", "world, or heading, lane or road"
        )

    def test() -> bool:
        here = ground.position(entity)
        base = here.h_road
        if system == "lane" and network.driving_sign(here.road, here.lane, here.s) < 0:
            base += math.pi
        return _within(entity.h - base, wanted, tolerance)

    return test


@condition(model.RelativeAngleCondition)
def relative_angle(element: model.RelativeAngleCondition, entity: Entity, scope: Scope) -> Test:
    """Angle of the other entity minus that of the triggering one."""
    other, of = entity_called(element.entity_ref, scope.board), _angle(element.angle_type)
    wanted, tolerance = element.angle, element.angle_tolerance
    return lambda: other.active and _within(of(other) - of(entity), wanted, tolerance)
