"""What a road of a stated friction lets tyres do: first along, then across what is left."""

from __future__ import annotations

import math
from typing import Any

from machine_code import compiled
from vehicle.model.bus import GRAVITY

LEAST_ACROSS = 0.05  # of the friction, left across a car that brakes with all of it: keeps the equations solvable


@compiled
def hold(x: Any) -> float:
    """What friction holds between tyres and road, over mass [m/s^2].

    Along, all wheels together hold friction times weight, as brakes do that are spread ideally. Across, each axle holds
    its load's share of what that leaves, smoothly as `tyre_saturation` does. Source: the friction circle, R. Rajamani,
    Vehicle Dynamics and Control, 2nd ed., sec. 13.9.
    """
    return float(x.road_friction * GRAVITY * math.cos(x.grade) * math.cos(x.bank))


@compiled
def hold_along(x: Any) -> None:
    """Cut what drives and brakes to what the road holds, before anything follows from it."""
    most = hold(x) * (x.mass + x.rotating_mass)  # at which the car accelerates with it, turning parts and all
    x.traction = min(x.traction, most)
    x.brake = min(x.brake, max(most - x.resistance, 0.0))


@compiled
def left_across(x: Any) -> float:
    """What the road holds across beside the forces along, over mass [m/s^2]."""
    most = hold(x)
    share = min(abs(x.traction - x.brake) / (most * (x.mass + x.rotating_mass)), 1.0)
    return float(most * max(math.sqrt(1.0 - share * share), LEAST_ACROSS))


@compiled
def hold_across(x: Any) -> None:
    """Cut the side forces of the axles to what the road, or tyres of a lower limit, hold."""
    left = min(left_across(x), x.tyre_limit)
    front = left * x.mass * x.cg_rear / x.wheelbase * x.load_front
    rear = left * x.mass * x.cg_front / x.wheelbase * x.load_rear
    tf, tr = math.tanh(x.fy_front / front), math.tanh(x.fy_rear / rear)
    x.fy_front, x.fy_rear = front * tf, rear * tr
    x.tangent_front *= 1.0 - tf * tf
    x.tangent_rear *= 1.0 - tr * tr


@compiled
def hold_path(x: Any, most: float) -> None:
    """Widen the kinematic path to one on which the tyres hold at most `most` [m/s^2], and a car on a bank with it.

    It is between the path that is steered and straight on: a car without slip cannot slide down a bank.
    """
    weight = GRAVITY * math.sin(x.bank)
    held = x.vx * x.vx * x.curvature + weight
    if abs(held) > most and x.vx != 0.0:
        curvature = (math.copysign(most, held) - weight) / (x.vx * x.vx)
        if x.curvature > 0.0:
            x.curvature = min(max(curvature, 0.0), x.curvature)
        else:
            x.curvature = max(min(curvature, 0.0), x.curvature)
