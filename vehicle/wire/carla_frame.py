"""Between our frame and CARLA's, in this one place: CARLA's is left-handed (y to the right), its angles are degrees
clockwise, its steering is -1 to 1 and positive to the right.

Source: CARLA 0.9.16 Python API: Transform, Rotation, VehicleControl, Actor.get_angular_velocity.
"""

from __future__ import annotations

from math import cos, degrees, radians, sin
from typing import NamedTuple


class Place(NamedTuple):
    """Location [m] and yaw [deg] as CARLA has them; roll and pitch are 0."""

    x: float
    y: float
    z: float
    yaw: float


def to_carla(x: float, y: float, z: float, yaw: float, rear: float = 0.0) -> Place:
    """The place of an actor whose rear axle stands at x, y, z [m] with `yaw` [rad], `rear` [m] behind its origin."""
    return Place(x + rear * cos(yaw), -(y + rear * sin(yaw)), z, -degrees(yaw))


def from_carla(place: Place, rear: float = 0.0) -> tuple[float, float, float, float]:
    """x, y, z [m], yaw [rad] of the rear axle of an actor."""
    yaw = -radians(place.yaw)
    return place.x - rear * cos(yaw), -place.y - rear * sin(yaw), place.z, yaw


def body_vector(x: float, y: float, yaw: float) -> tuple[float, float]:
    """CARLA's world vector (x, y) along and across (left) a body with `yaw` [rad]."""
    return x * cos(yaw) - y * sin(yaw), -x * sin(yaw) - y * cos(yaw)


def yaw_rate(angular_velocity_z: float) -> float:
    """Yaw rate [rad/s] of an actor's angular velocity about z [deg/s]."""
    return -radians(angular_velocity_z)


def to_steer(angle: float, max_angle: float) -> float:
    """Steering for the road-wheel angle [rad] of a car whose wheels turn by at most `max_angle` [rad]."""
    return min(max(-angle / max_angle, -1.0), 1.0)


def from_steer(steer: float, max_angle: float) -> float:
    """Road-wheel angle [rad] of a steering of -1 to 1."""
    return -steer * max_angle
