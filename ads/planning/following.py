"""Following: the nearest thing ahead in the planned path and how much room it leaves."""

from __future__ import annotations

import math
from collections.abc import Callable

from vehicle.messages import Detection, VehicleDescription

GAP = 4.0  # m between bumpers at standstill
TIME = 2.0  # s behind a moving vehicle
MARGIN = 0.35  # m beside the car that belongs to its path
REACH = 150.0  # m
SPAN = 30.0  # m of a standing object's length that are looked along
STEP = 2.0  # m
STANDS = 1.0  # m/s
LOOK_AHEAD = 1.0  # s; a vehicle that will be in the path so soon is in it


def find_lead(
    s: float, v: float, car: VehicleDescription, offset: Callable[[float], float],
    detections: tuple[Detection, ...], placed: list[list[float]], passing: frozenset[int] = frozenset(),
) -> tuple[float, float] | None:  # fmt: skip
    """Distance left to keep [m] and speed [m/s] of what limits the car most in its planned path, None if nothing.

    `s` [m], `v` [m/s] of the car; `offset(s)` [m] of the planned path; `placed` as scene.place gives it;
    tracks `passing` only cross the path.
    """
    half = 0.5 * car.width + MARGIN
    front = car.center_x + 0.5 * car.length
    best: tuple[float, float] | None = None
    worst = math.inf
    for row, detection in zip(placed, detections, strict=True):
        s_from, s_to, l_from, l_to, along, across = row
        if s_to < s + front or s_from > s + REACH or detection.track in passing:
            continue
        begins = max(s_from, s)  # a plan begins at the car: of one beside it, what lies ahead counts
        o = offset(begins)
        low, high = l_from - o, l_to - o
        if abs(along) < STANDS:  # a long one may be met where the plan leads back to the lane
            last = min(s_to, s + SPAN)
            while (low > half or high < -half) and begins < last:
                begins = min(begins + STEP, last)
                o = offset(begins)
                low, high = l_from - o, l_to - o
            s_from = max(s_from, begins)
        if along > 1.0 and detection.kind != "pedestrian":  # changes into this lane
            low, high = min(low, low + across * LOOK_AHEAD), max(high, high + across * LOOK_AHEAD)
        if low > half or high < -half:
            continue
        speed = max(along, 0.0)
        free = s_from - s - front - GAP - TIME * speed
        if speed > v + 1.0 and free > 0.0:
            continue
        urgency = free + 3.0 * speed
        if urgency < worst:
            worst, best = urgency, (free, speed)
    return best
