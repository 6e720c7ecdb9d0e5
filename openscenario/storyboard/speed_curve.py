"""Speed over time as pieces of constant jerk: straight lines through points, and the same with rounded corners.

The standard gives limits and no law. Here: what is asked for is first brought within the limits of speed and
acceleration (`within`). Where jerk has limits, too, the lines through the points are kept and each corner between two
of them becomes the parabola of the allowed jerk that touches both; the first line begins as soon as its slope can be
reached. To a single target, and where a corner has no room for its parabola to each target by itself, the way is jerk,
constant acceleration, jerk (`reach`): in the given time, or later where the limits want so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from openscenario.storyboard.limits import Limits

SHARP = 1e6  # m/s^3: a corner of no limit
SAME = 1e-6  # s, m/s or m/s^2; against rounding only

Point = tuple[float, float]
"""Time [s], speed [m/s]."""


class Piece(NamedTuple):
    """From `time` [s] on: speed [m/s], acceleration [m/s^2] there, and constant jerk [m/s^3]."""

    time: float
    speed: float
    acceleration: float = 0.0
    jerk: float = 0.0

    def at(self, time: float) -> float:
        """Speed [m/s] at `time` [s], on the same clock as the piece's own time."""
        after = time - self.time
        return self.speed + (self.acceleration + 0.5 * self.jerk * after) * after

    def slope(self, time: float) -> float:
        """Acceleration [m/s^2] at `time` [s], on the same clock as the piece's own time."""
        return self.acceleration + self.jerk * (time - self.time)


def within(points: Sequence[Point], limits: Limits) -> list[Point]:
    """The points with speeds and slopes within the limits: a change that needs more time puts off all that follows.

    Ends with a point at an infinite time where the limits allow no change at all.
    """
    out = [points[0]]
    for (before, _), (time, speed) in pairwise(points):
        start, now = out[-1]
        target = min(max(speed, -limits.speed), limits.speed)
        limit = limits.up if target > now else limits.down
        change = abs(target - now)
        needed = 0.0 if change == 0.0 else change / limit if limit > 0.0 else math.inf
        out.append((start + max(time - before, needed), target))
        if needed == math.inf:
            break
    return out


def curve(points: Sequence[Point], acceleration: float, limits: Limits) -> list[Piece]:
    """Through the points within all limits, beginning with `acceleration` [m/s^2] if that may not jump.

    The last piece stands still at the last speed; its time is infinite if the limits never let it be reached.
    """
    points = within(points, limits)
    never = points[-1][0] == math.inf
    if not limits.smooth:
        return straight(points)
    if limits.rise <= 0.0 or limits.fall <= 0.0:
        return [Piece(*points[0]), Piece(math.inf, points[-1][1])] if len(points) > 1 else [Piece(*points[0])]
    reachable = points[:-1] if never else points
    pieces = _rounded(reachable, acceleration, limits) or _one_by_one(reachable, acceleration, limits)
    return [*pieces, Piece(math.inf, points[-1][1])] if never else pieces


def straight(points: Sequence[Point]) -> list[Piece]:
    """Lines through (time, speed); points at one time are a step."""
    pieces = []
    for (time, speed), (later, target) in pairwise(points):
        if later - time > 0.0:
            pieces.append(Piece(time, speed, (target - speed) / (later - time)))
    return [*pieces, Piece(*points[-1])]


def _rounded(points: Sequence[Point], acceleration: float, limits: Limits) -> list[Piece] | None:
    """Several lines with rounded corners; None if there is only one, or if they leave no room for that."""
    up, down = min(limits.rise, SHARP), min(limits.fall, SHARP)
    lines = straight(points)
    if len(lines) < 3:
        return None
    first = lines[0]
    jerk = up if first.acceleration >= acceleration else -down
    turning = Piece(first.time, first.speed, acceleration, jerk)
    start = first.time + (first.acceleration - acceleration) / jerk
    now = Piece(start, turning.at(start), first.acceleration)
    pieces = [turning, now]
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
    if abs(now.speed - points[-1][1]) > SAME or _top(pieces) > limits.speed + SAME:
        return None
    return pieces


def _top(pieces: Sequence[Piece]) -> float:
    """The largest speed [m/s], either way, after the first."""
    top = 0.0
    for piece, after in pairwise(pieces):
        top = max(top, abs(after.speed))
        turn = piece.time - piece.acceleration / piece.jerk if piece.jerk != 0.0 else piece.time
        if piece.time < turn < after.time:
            top = max(top, abs(piece.at(turn)))
    return top


def _one_by_one(points: Sequence[Point], acceleration: float, limits: Limits) -> list[Piece]:
    """To each point by itself, with no acceleration there."""
    pieces = [Piece(points[0][0], points[0][1], acceleration)]
    for (before, _), (time, target) in pairwise(points):
        last = pieces.pop()
        pieces += reach(last, target, time - before, limits)
    return pieces


def reach(now: Piece, target: float, duration: float, limits: Limits) -> list[Piece]:
    """Jerk, constant acceleration, jerk to a speed [m/s]: in `duration` [s], or as soon as the limits allow.

    Written for a rising speed; a falling one is its mirror image. With the jerks j up and i down, the beginning
    acceleration b and the constant one a, the three parts' speeds and times give

        v1 - v0 = (a^2 - b^2) / 2j + a h + a^2 / 2i,   T = (a - b) / j + h + a / i   if a > b, else
        v1 - v0 = b^2 / 2i + a h,                      T = b / i + h
    """
    rise, fall = min(limits.rise, SHARP), min(limits.fall, SHARP)
    b = now.acceleration
    still = now.speed + 0.5 * b * abs(b) / (fall if b > 0.0 else rise)  # where the acceleration is taken back to 0
    if abs(target - still) < SAME:
        end = now.time + abs(b) / (fall if b > 0.0 else rise)
        pieces = [Piece(now.time, now.speed, b, -fall if b > 0.0 else rise)] if b != 0.0 else []
        return [*pieces, Piece(end, target), Piece(max(end, now.time + duration), target)]
    sign = 1.0 if target > still else -1.0
    j, i, most = (rise, fall, limits.up) if sign > 0.0 else (fall, rise, limits.down)
    b *= sign
    change = sign * (target - now.speed)
    square = 0.5 / j + 0.5 / i
    whole = change + 0.5 * b * b / j
    peak = min(math.sqrt(whole / square), most)
    span = duration + b / j
    root = span * span - 4.0 * square * whole
    if span > 0.0 and root >= 0.0:
        peak = min(peak, 2.0 * whole / (span + math.sqrt(root)))
    if peak >= b:
        first, hold = (peak - b) / j, max(whole / peak - square * peak, 0.0)
    else:  # it already accelerates by more than it needs
        j = -i
        rest = change - 0.5 * b * b / i
        left = duration - b / i
        peak = min(rest / left, most) if left > 0.0 else min(b, most)
        first, hold = (b - peak) / i, rest / peak
    begin = Piece(now.time, now.speed, sign * b, sign * j)
    t1 = now.time + first
    even = Piece(t1, begin.at(t1), sign * peak)
    t2 = t1 + hold
    return [begin, even, Piece(t2, even.at(t2), sign * peak, -sign * i), Piece(t2 + peak / i, target)]
