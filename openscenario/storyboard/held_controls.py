"""How a vehicle of the storyboard moves while the scenario holds its controls."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from openscenario.storyboard.motion import way

if TYPE_CHECKING:
    from openscenario.storyboard.controls import Controls
    from openscenario.storyboard.entity import Entity
    from openscenario.storyboard.ground import Ground


def operate(entity: Entity, dt: float, ground: Ground) -> None:
    """Let the held controls of a vehicle of the storyboard act for `dt` [s], where no action holds the domain."""
    controls = entity.controls
    if controls is None or not controls.held or entity.moved or entity.drawn_by is not None:
        return
    controls.step(dt)
    if entity.longitudinal is None:
        _press(entity, controls, dt)
    if entity.lateral is None and controls.road_wheel is not None:
        _steer(entity, controls.road_wheel, dt, ground)


def _press(entity: Entity, controls: Controls, dt: float) -> None:
    """Change the speed as the pedals do.

    Full throttle is the maxAcceleration of its Performance, full brake its maxDeceleration, as far as the road holds.
    Where no pedal is held it keeps its speed, as the default controller does.
    """
    throttle, brake = controls.value("throttle"), controls.braked
    speed = entity.speed
    if throttle is not None and entity.max_acceleration < math.inf:
        speed += throttle * controls.engaged * entity.max_acceleration * dt
    if brake:
        speed = math.copysign(max(abs(speed) - brake * entity.max_deceleration * dt, 0.0), speed)
    entity.speed = min(max(speed, -entity.max_speed), entity.max_speed)


def _steer(entity: Entity, angle: float, dt: float, ground: Ground) -> None:
    """Move on a circle, without slip, for `dt` [s], with the road wheels at an angle [rad].

    Source: R. Rajamani, Vehicle Dynamics and Control, 2nd ed., eq. 2.1, with the rear axle as the reference point.
    """
    angle = min(max(angle, -entity.max_steer), entity.max_steer)
    distance = way(entity, dt)
    turn = distance * math.tan(angle) / (entity.wheelbase or 0.6 * entity.length or 1.0)
    middle = entity.h + 0.5 * turn
    x, y = entity.x, entity.y
    chord = distance if abs(turn) < 1e-9 else distance * math.sin(0.5 * turn) / (0.5 * turn)
    entity.ax = (entity.speed - entity.speed_before) / dt
    entity.put(x + chord * math.cos(middle), y + chord * math.sin(middle), entity.z, entity.h + turn)
    ground.stand(entity)
    entity.moved = True
    entity.travelled += abs(distance)
    entity.vx, entity.vy = (entity.x - x) / dt, (entity.y - y) / dt
