"""Manoeuvres on circles."""

from __future__ import annotations

import math

from pytest_dvp.gap.manoeuvres.simulated_driver import Driver, Driving

SHARES = (0.08, 0.3, 0.6, 0.9)  # of the lateral acceleration allowed, of the circles
HELD = 7.0  # s, each speed


def circles_left(d: Driver) -> Driving:
    """Left circles of constant steering at growing speed, as wide as the ground."""
    radius = 0.5 * min(d.area.y_max - d.area.y_min, d.area.x_max - d.area.x_min) - 1.6 * -d.area.y_min
    yield from d.stand(1.0)
    yield from _circles(d, max(radius, d.radius), 1.0)
    yield from d.halt()


def circles_both(d: Driver) -> Driving:
    """Circles of constant steering at growing speed, to the left, and after a turn about to the right."""
    room = 0.5 * (d.area.y_max - d.area.y_min - 2.0 * d.radius + 3.0 * d.area.y_min)
    radius = max(min(room, 0.5 * (d.area.x_max - d.area.x_min) + 2.0 * d.area.y_min), d.radius)
    yield from d.stand(1.0)
    yield from _circles(d, radius, 1.0)
    yield from d.close_circle(math.atan(d.wheelbase / radius))
    yield from d.other_side()
    yield from _circles(d, radius, -1.0)
    yield from d.halt()


def tight_circles(d: Driver) -> Driving:
    """Circles as tight as the car turns, to both sides, at walking speed: a figure of eight."""
    radius = 1.1 * d.wheelbase / math.tan(0.9 * d.lock)
    v = min(2.0, math.sqrt(0.7 * d.lateral * radius))
    yield from d.stand(1.0)
    yield from d.reach(d.slow)
    yield from d.other_side()
    for side in (1.0, -1.0):
        yield from d.circle(v, side * math.atan(d.wheelbase / radius), turns=1.0)
    yield from d.halt()


def _circles(d: Driver, radius: float, side: float) -> Driving:
    angle = side * math.atan(d.wheelbase / radius)
    for share in SHARES:
        yield from d.circle(min(math.sqrt(share * d.lateral * radius), d.top), angle, seconds=HELD)
