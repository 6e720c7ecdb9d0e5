"""Pedals, steering wheel and gear of a vehicle that a scenario takes from whoever drives it.

An OverrideControllerValueAction holds until another one sets `active` false (class OverrideControllerValueAction, 1.3).
A lever moves to its new place no faster than its `maxRate`, from where it was: 0, if nobody said.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

STEERING_RATIO: Final = 16.0  # over the road wheel; T. D. Gillespie, Fundamentals of Vehicle Dynamics: 15 to 20
LEVERS: Final = ("throttle", "brake", "clutch", "parking_brake", "steering_wheel")
NEUTRAL: Final = "neutral"


class Setting(NamedTuple):
    """Where a lever shall go: 0 to 1, of the steering wheel [rad]; and how fast, per second."""

    value: float
    rate: float = math.inf


@dataclass
class _Lever:
    """A lever that the scenario holds."""

    now: float
    goal: float
    rate: float

    def step(self, dt: float) -> None:
        """Move towards the goal for `dt` [s]."""
        self.now += min(max(self.goal - self.now, -self.rate * dt), self.rate * dt)


class Controls:
    """What of a vehicle's controls a scenario holds. `gear`: "drive", "neutral", "reverse", "park"; "": not held."""

    def __init__(self) -> None:
        self._levers: dict[str, _Lever] = {}
        self.gear = ""

    @property
    def held(self) -> bool:
        """Whether the scenario holds anything."""
        return bool(self._levers or self.gear)

    def set(self, settings: Mapping[str, Setting | None], gear: str | None = None) -> None:
        """Take levers to new places, by their names in LEVERS; None lets one go. `gear` "" lets go, None: as it is."""
        for name, setting in settings.items():
            if setting is None:
                self._levers.pop(name, None)
                continue
            now = self._levers[name].now if name in self._levers else 0.0
            lever = self._levers[name] = _Lever(now, setting.value, setting.rate)
            if setting.rate == math.inf:
                lever.now = setting.value
        if gear is not None:
            self.gear = gear

    def value(self, name: str) -> float | None:
        """Where a lever is; None: the scenario does not hold it."""
        lever = self._levers.get(name)
        return None if lever is None else lever.now

    def step(self, dt: float) -> None:
        """Let levers that have a rate go on for `dt` [s]."""
        for lever in self._levers.values():
            if lever.now != lever.goal:
                lever.step(dt)

    @property
    def braked(self) -> float | None:
        """Share of the full brake, of the pedal and the parking brake; None: neither is held."""
        pressed = [self.value("brake"), self.value("parking_brake"), 1.0 if self.gear == "park" else None]
        found = [each for each in pressed if each is not None]
        return max(found) if found else None

    @property
    def engaged(self) -> float:
        """Share of the drive that reaches the wheels: clutch and gear; negative in reverse."""
        if self.gear in (NEUTRAL, "park"):
            return 0.0
        share = 1.0 - (self.value("clutch") or 0.0)
        return -share if self.gear == "reverse" else share

    @property
    def road_wheel(self) -> float | None:
        """Angle of the road wheels [rad]; None: the wheel is not held."""
        wheel = self.value("steering_wheel")
        return None if wheel is None else wheel / STEERING_RATIO
