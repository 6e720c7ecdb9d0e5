"""What a stack asks for beyond its car: found in every command, told once a field, never in the log.

The car obeys as far as it can, and the log shows what it did; without this a stack that asks for a steering angle in
degrees looks like one that steers hard, and one that asks a car with pedals for an acceleration like one that coasts.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vehicle.messages import Command, VehicleDescription

CODE = "dvp.command_out_of_range"
IGNORED = "dvp.command_ignored"
STEER = 1e-3  # of the limit: data sheets give it in rounded degrees
ACCEL = 0.02  # of the limit: a full pedal asks for 3.5 m/s^2 of the car that ships, whose rotating parts leave 3.44
PEDAL = 1e-6  # of a full pedal: rounding
UNITS = {"steer": " rad", "accel": " m/s^2", "throttle": "", "brake": ""}


@dataclasses.dataclass
class _Field:
    """Bounds of one field, with what is allowed for rounding; what was outside of them."""

    low: float
    high: float
    slack: float  # of the larger bound
    t: float = 0.0
    first: float = 0.0
    worst: float = 0.0
    count: int = 0

    def beyond(self, value: float) -> float:
        """By how much a value is outside; negative or 0 within."""
        return max(self.low - value, value - self.high)

    def note(self, t: float, value: float) -> None:
        """Remember a value if it is outside."""
        slack = self.slack * max(abs(self.low), abs(self.high))
        if self.low - slack <= value <= self.high + slack:
            return
        if not self.count:
            self.t, self.first, self.worst = t, value, value
        elif self.beyond(value) > self.beyond(self.worst):
            self.worst = value
        self.count += 1


class CommandRange:
    """Looks at the commands of one run for the car of `description`."""

    def __init__(self, description: VehicleDescription) -> None:
        car = description
        self._fields = {
            "steer": _Field(-car.max_steer, car.max_steer, STEER),
            "accel": _Field(-car.max_deceleration, car.max_acceleration, ACCEL),
            "throttle": _Field(0.0, 1.0, PEDAL),
            "brake": _Field(0.0, 1.0, PEDAL),
        }
        self._bounds = car.max_steer, -car.max_deceleration, car.max_acceleration
        self._asked = {name: _Field(0.0, 0.0, 0.0) for name in ("accel", "throttle", "brake")}
        self._both = False  # it asked for an acceleration and, maybe later, by a pedal

    def look(self, t: float, command: Command) -> None:
        """A command that was given at `t` [s]."""
        steer, slowest, fastest = self._bounds
        if not self._both:
            self._note_asked(t, command)
        if (
            -steer <= command.steer <= steer
            and slowest <= command.accel <= fastest
            and 0.0 <= command.throttle <= 1.0
            and 0.0 <= command.brake <= 1.0
        ):
            return  # nearly always: a tick has no time for more
        for name, field in self._fields.items():
            field.note(t, getattr(command, name))

    def _note_asked(self, t: float, command: Command) -> None:
        """By which of its ways to ask for an acceleration a stack asked so far."""
        for name, field in self._asked.items():
            field.note(t, getattr(command, name))
        accel, throttle, brake = self._asked.values()
        self._both = bool(accel.count and (throttle.count or brake.count))

    def ignored(self, model: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
        """Findings of a stack that asks for an acceleration only by what the car does not obey.

        model: what the log says of the vehicle model (meta `model`), with its text `toml`; empty for another car. One
        for each field: as `findings`, but allowed says what drives the car.
        """
        fields = {name: field for name, field in self._asked.items() if field.count}
        if self._both or not fields or not model.get("toml"):
            return ()
        drives = str(tomllib.loads(model["toml"]).get("inputs", {}).get("longitudinal", "accel_cmd"))
        if any(f"{name}_cmd" in drives for name in fields):
            return ()
        return tuple(_row(IGNORED, name, field, drives) for name, field in fields.items())

    def findings(self) -> tuple[dict[str, Any], ...]:
        """One for each field: code, field, t [s] and value of the first time, what is allowed, the value farthest
        outside, and in how many ticks."""
        return tuple(
            _row(CODE, name, field, f"{field.low:.4g} to {field.high:.4g}{UNITS[name]}")
            for name, field in self._fields.items()
            if field.count
        )


def _row(code: str, name: str, field: _Field, allowed: str) -> dict[str, Any]:
    return {
        "code": code, "field": name, "t": field.t, "found": field.first, "allowed": allowed, "worst": field.worst,
        "count": field.count,
    }  # fmt: skip


def finding_text(finding: Mapping[str, Any]) -> str:
    """A finding of `CommandRange` in one line."""
    name, count = finding["field"], finding["count"]
    unit, ticks = UNITS[name], f"{count} tick{'' if count == 1 else 's'}"
    found = f"{finding['found']:.6g}{unit} at t={finding['t']:.2f} s"
    if finding["code"] == IGNORED:
        why = f"this car is driven by {finding['allowed']}, and the stack never commands that"
        return f"command that the car ignores: {name} {found}, in {ticks}: {why}"
    worst = "" if finding["worst"] == finding["found"] else f", {finding['worst']:.6g}{unit} at worst"
    return f"command beyond the car: {name} {found}, allowed {finding['allowed']}, in {ticks}{worst}"
