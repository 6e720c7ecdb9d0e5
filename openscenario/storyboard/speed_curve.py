"""Speed over time as pieces of constant jerk: straight lines through points, and the same with rounded corners.

The standard gives limits of jerk and no law. Here: the lines through the points are kept and each corner between two
of them becomes the parabola of the allowed jerk that touches both; the first line begins as soon as its slope can be
reached. To a single target the way is jerk, constant acceleration, jerk: in the given time, or later where the limits
want so. Where a corner has no room for its parabola the lines stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from openscenario import model

SHARP = 1e6  # m/s^3: a corner of no limit
SAME = 1e-6


class Piece(NamedTuple):
    """From `time` [s] on: speed [m/s], acceleration [m/s^2] there, and constant jerk [m/s^3]."""

    time: float
    speed: float
    acceleration: float = 0.0
    jerk: float = 0.0

    def at(self, time: float) -> float:
        after = time - self.time
        return self.speed + (self.acceleration + 0.5 * self.jerk * after) * after

    def slope(self, time: float) -> float:
        return self.acceleration + self.jerk * (time - self.time)


def straight(points: Sequence[tuple[float, float]]) -> list[Piece]:
    """Lines through (time, speed); points at one time are a step."""
    pieces = []
    for (time, speed), (later, target) in pairwise(points):
        if later - time > 0.0:
            pieces.append(Piece(time, speed, (target - speed) / (later - time)))
    return [*pieces, Piece(*points[-1])]


def rounded(
    points: Sequence[tuple[float, float]], acceleration: float, limits: model.DynamicConstraints
) -> list[Piece] | None:
    """The same lines within the limits of jerk, beginning with `acceleration`; None if they leave no room for that."""
    up = SHARP if limits.max_acceleration_rate is None else limits.max_acceleration_rate
    down = SHARP if limits.max_deceleration_rate is None else limits.max_deceleration_rate
    if min(up, down) <= 0.0 or (up == SHARP and down == SHARP):
        return None
    lines = [piece for piece in straight(points)[:-1] if math.isfinite(piece.acceleration)]
    if not lines:
        return None
    most = math.inf if limits.max_acceleration is None else limits.max_acceleration
    least = -math.inf if limits.max_deceleration is None else -limits.max_deceleration
    if len(lines) == 1:
        return _to_one(points[0], points[-1], acceleration, (up, down), (least, most))
    if any(not least - SAME <= line.acceleration <= most + SAME for line in lines):
        return None
    lines.append(Piece(*points[-1]))
    first = lines[0]
    jerk = up if first.acceleration >= acceleration else -down
    pieces = [Piece(first.time, first.speed, acceleration, jerk)]
    start = first.time + (first.acceleration - acceleration) / jerk
    now = Piece(start, pieces[0].at(start), first.acceleration)
    pieces.append(now)
    for line in lines[1:]:
        turn = line.acceleration - now.acceleration
        if abs(turn) < SAME:
            continue
        jerk = up if turn > 0.0 else -down
        # where the lines would meet, and half the parabola before that
        meet = now.time + (line.at(now.time) - now.speed) / (now.acceleration - line.acceleration)
        begin = meet - 0.5 * turn / jerk
        if begin < now.time - SAME:
            return None
        corner = Piece(begin, now.at(begin), now.acceleration, jerk)
        end = begin + turn / jerk
        now = Piece(end, corner.at(end), line.acceleration)
        pieces += [corner, now]
    return pieces


def _to_one(
    start: tuple[float, float],
    target: tuple[float, float],
    acceleration: float,
    rates: tuple[float, float],
    span: tuple[float, float],
) -> list[Piece] | None:
    """Jerk, constant acceleration a, jerk. With the jerks j and i, and b the beginning acceleration:

    v1 - v0 = (1 / 2i - 1 / 2j) a^2 + (T + b / j) a - b^2 / 2j, from the three parts' speeds and times.
    """
    change, time = target[1] - start[1], target[0] - start[0]
    up, down = rates
    if abs(change) < SAME or time <= 0.0:
        return None
    rising = change > 0.0
    if (change / time - acceleration > 0.0) != rising:
        return None
    j, i = (up, -down) if rising else (-down, up)
    square = 0.5 / i - 0.5 / j
    b = acceleration
    root = (time + b / j) ** 2 + 4.0 * square * (0.5 * b * b / j + change)
    if root >= 0.0:
        a = (math.sqrt(root) - (time + b / j)) / (2.0 * square)
    else:  # no time for a constant part
        a = math.copysign(math.sqrt(max((change + 0.5 * b * b / j) / -square, 0.0)), change)
    a = min(max(a, span[0]), span[1])
    if a == 0.0:
        return None
    first = Piece(start[0], start[1], b, j)
    t1 = start[0] + (a - b) / j
    v1 = first.at(t1)
    v2 = target[1] + 0.5 * a * a / i
    t2 = t1 + max((v2 - v1) / a, 0.0)
    return [first, Piece(t1, v1, a), Piece(t2, v2, a, i), Piece(t2 - a / i, target[1])]
