"""SpeedProfileAction: speeds over time, straight lines between them."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Runner, Unsupported, action

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


class SpeedProfile:
    """Piecewise constant acceleration through the entries; an entry's time [s] counts from the one before.

    A first entry with time 0 is where the profile begins: mode `position` jumps to its speed, mode `follow` starts from
    the present one. An entry without time is reached with the limits of the action, or of the vehicle. Speeds may be
    relative to another entity's at the start. The corners of the profile stay sharp: limits on jerk are refused.
    """

    __slots__ = ("_clock", "_element", "_entity", "_other", "_speeds", "_times")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.SpeedProfileAction, entity: Entity, board: Storyboard) -> None:
        limits = element.dynamic_constraints
        if (
            element.following_mode == "follow"
            and limits is not None
            and (limits.max_acceleration_rate is not None or limits.max_deceleration_rate is not None)
        ):
            raise Unsupported(
                "jerk limits are not supported", "followingMode 'follow' with rates", "no rates, or 'position'"
            )
        self._element = element
        self._entity = entity
        self._other = board.entities.get(element.entity_ref) if element.entity_ref else None
        self._times: list[float] = []
        self._speeds: list[float] = []
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
        self._times, self._speeds, self._clock = [0.0], [speed], 0.0
        for entry in entries:
            target = base + entry.speed
            time += entry.time if entry.time is not None else self._needed(target - speed)
            speed = target
            self._times.append(time)
            self._speeds.append(speed)
        entity.set_speed = speed
        return time <= 0.0

    def _needed(self, change: float) -> float:
        """Time [s] for a change of speed with the limits in force."""
        limits, entity = self._element.dynamic_constraints, self._entity
        limit = limits and (limits.max_acceleration if change > 0.0 else limits.max_deceleration)
        limit = limit or (entity.max_acceleration if change > 0.0 else entity.max_deceleration)
        return abs(change) / limit if limit > 0.0 else math.inf

    def step(self, dt: float) -> bool:
        self._clock += dt
        times, speeds = self._times, self._speeds
        if self._clock >= times[-1] - 1e-9:
            self._entity.speed = speeds[-1]
            return True
        i = bisect_right(times, self._clock) - 1
        share = (self._clock - times[i]) / (times[i + 1] - times[i])
        self._entity.speed = speeds[i] + share * (speeds[i + 1] - speeds[i])
        return False

    def stop(self) -> None:
        return None

    def ask(self) -> tuple[str, dict[str, Any], float]:
        before = self._entity.speed, self._entity.speed_before
        self.start()
        self._entity.speed, self._entity.speed_before = before
        values = {"target": self._speeds[-1], "times": tuple(self._times), "speeds": tuple(self._speeds)}
        return "speed", values, self._times[-1]


@action(model.SpeedProfileAction)
def speed_profile(element: model.SpeedProfileAction, entity: Entity, board: Storyboard) -> Runner:
    return SpeedProfile(element, entity, board)
