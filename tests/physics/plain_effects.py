"""Effects as plain Python functions on a bus of plain numbers: their equations without compiler, kernel and car."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np

from vehicle.model.bus import BUS_FIELDS
from vehicle.model.effect import Effect

CAR = {
    "wheelbase": 2.8, "cg_front": 1.2, "cg_rear": 1.6, "cg_height": 0.5, "mass": 1600.0, "mass_ref": 1500.0,
    "yaw_inertia": 2500.0, "turning_inertia": 2500.0, "wheel_radius": 0.3, "gear_ratio": 9.0, "full_throttle": 4.0,
    "full_brake": 8.0, "slow": 1.0, "dt": 0.1, "accel_arrived": 0.0,
    "load_front": 1.0, "load_rear": 1.0, "speed_gain": 1.0,
    "tyre_limit": math.inf,
}  # fmt: skip
"""A car of which no two numbers are the same by chance."""


def bus(**fields: float) -> Any:
    """A bus with `CAR`, the given fields, and 0 elsewhere."""
    unknown = {*fields, *CAR} - set(BUS_FIELDS)
    assert not unknown
    return SimpleNamespace(**{**dict.fromkeys(BUS_FIELDS, 0.0), **CAR, **fields})


def memory(effect: Effect, x: Any) -> Any:
    """What an effect remembers at the start."""
    return SimpleNamespace(
        **{m.name: np.zeros(m.size) if m.size > 1 else getattr(x, m.start) if m.start else 0.0 for m in effect.memory}
    )


class Applied:
    """An effect with its values and its memory, to be applied step by step."""

    def __init__(self, effect: Effect, /, **values: float) -> None:
        self._effect = effect
        self.slot: str = effect.slot
        self.order = effect.order
        self._values = SimpleNamespace(**effect.complete(values))
        self.memory: Any = None

    def __call__(self, x: Any) -> Any:
        """Let it act on a bus and return that."""
        if self.memory is None:
            self.memory = memory(self._effect, x)
        self._effect.function(x, self._values, self.memory)
        return x


def applied(effect: Effect, on: Any, /, **values: float) -> Any:
    """A bus on which an effect has acted once."""
    return Applied(effect, **values)(on)
