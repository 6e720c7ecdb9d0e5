"""SpeedProfileAction: speeds over time, straight lines between them, corners rounded where jerk has a limit."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Runner, action
from openscenario.storyboard.speed_curve import Piece, rounded, straight

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


class SpeedProfile:
    """Piecewise constant acceleration through the entries; an entry's time [s] counts from the one before.

    A first entry with time 0 is where the profile begins: mode `position` jumps to its speed, mode `follow` starts from
    the present one and keeps to the action's limits of jerk. An entry without time is reached with the limits of the
    action, or of the vehicle. Speeds may be relative to another entity's at the start.
    """

    __slots__ = ("_clock", "_element", "_entity", "_other", "_pieces", "_times")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.SpeedProfileAction, entity: Entity, board: Storyboard) -> None:
        self._element = element
        self._entity = entity
        self._other = board.entities.get(element.entity_ref) if element.entity_ref else None
        self._pieces: list[Piece] = []
        self._times: list[float] = []
        self._clock = 0.0

    def start(self) -> bool:
        entity, element = self._entity, self._element
        base = self._other.speed if self._other is not None else 0.0
        entries = list(element.speed_profile_entries)
        speed, time = entity.speed, 0.0
        if entries[0].time is not None and entries[0].time <= 0.0:
            if element.following_mode == "position":
                speed = base + entries[0].speed
                entity.jump_to_speed(speed)
            entries = entries[1:]
        points = [(0.0, speed)]
        for entry in entries:
            target = base + entry.speed
            time += entry.time if entry.time is not None else self._needed(target - speed)
            speed = target
            points.append((time, speed))
        entity.set_speed = speed
        limits = element.dynamic_constraints
        curve = None
        if element.following_mode == "follow" and limits is not None:
            curve = rounded(points, entity.ax, limits)
        self._pieces = curve or straight(points)
        self._times = [piece.time for piece in self._pieces]
        self._clock = 0.0
        return time <= 0.0

    def _needed(self, change: float) -> float:
        """Time [s] for a change of speed with the limits in force."""
        limits, entity = self._element.dynamic_constraints, self._entity
        limit = limits and (limits.max_acceleration if change > 0.0 else limits.max_deceleration)
        limit = limit or (entity.max_acceleration if change > 0.0 else entity.max_deceleration)
        return abs(change) / limit if limit > 0.0 else math.inf

    def step(self, dt: float) -> bool:
        self._clock += dt
        done = self._clock >= self._times[-1] - 1e-9
        piece = self._pieces[-1 if done else bisect_right(self._times, self._clock) - 1]
        self._entity.speed = piece.speed if done else piece.at(self._clock)
        return done

    def stop(self) -> None:
        return None

    def ask(self) -> tuple[str, dict[str, Any], float]:
        before = self._entity.speed, self._entity.speed_before
        self.start()
        self._entity.speed, self._entity.speed_before = before
        speeds = tuple(piece.speed for piece in self._pieces)
        return "speed", {"target": speeds[-1], "times": tuple(self._times), "speeds": speeds}, self._times[-1]


@action(model.SpeedProfileAction)
def speed_profile(element: model.SpeedProfileAction, entity: Entity, board: Storyboard) -> Runner:
    return SpeedProfile(element, entity, board)
