"""The reference system of the surrogate: what a GNSS-aided INS says of the car's motion, in place of the truth.

[reference]
unit = "rtk"          # ideal (default: the truth), rtk
accel_bias = 0.02     # any number of it, see Reference
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import msgspec
import numpy as np

from vehicle.messages import VehicleState


@dataclass(frozen=True)
class Reference:
    """Errors of a reference system, each a standard deviation in SI units. All 0: it shows the truth.

    Those that wander are Gauss-Markov processes with the correlation time `drift_time`; biases are drawn once a drive.
    Raises ValueError on a negative number.
    """

    position_drift: float = 0.0  # m, of x and of y, wandering
    position_noise: float = 0.0  # m, white
    heading_drift: float = 0.0  # rad, wandering
    heading_noise: float = 0.0  # rad, white
    speed_noise: float = 0.0  # m/s, white, along and across
    yaw_rate_bias: float = 0.0  # rad/s
    yaw_rate_noise: float = 0.0  # rad/s, white
    accel_bias: float = 0.0  # m/s^2, of ax and of ay
    accel_noise: float = 0.0  # m/s^2, white
    arm: float = 0.0  # m, by which its place in the car is known wrongly, ahead and aside
    mounting: float = 0.0  # rad, by which it is turned about the vertical axis
    drift_time: float = 60.0  # s

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not 0.0 <= value < math.inf or (f.name == "drift_time" and value == 0.0):
                least = "above 0" if f.name == "drift_time" else "at least 0"
                raise ValueError(f"reference.{f.name} is {value:g}; it must be {least}")

    @property
    def ideal(self) -> bool:
        """True if it shows the truth."""
        return not any(getattr(self, f.name) for f in fields(self) if f.name != "drift_time")


UNITS: Mapping[str, Reference] = {
    "ideal": Reference(),
    # In the order of what makers print for a dual-antenna INS with RTK, 1 sigma: position 0.01 m, speed 0.05 km/h,
    # heading 0.1 deg, bias of acceleration 0.01 m/s^2 and of yaw rate 0.01 deg/s. White noise at 100 Hz, the error of
    # the mounting and the correlation time are chosen; makers print none.
    "rtk": Reference(
        position_drift=0.01, position_noise=0.002, heading_drift=0.0017, heading_noise=0.0003, speed_noise=0.014,
        yaw_rate_bias=0.00017, yaw_rate_noise=0.001, accel_bias=0.01, accel_noise=0.03, arm=0.01, mounting=0.003,
    ),
}  # fmt: skip
"""Reference systems by name."""


def reference_of(table: Mapping[str, Any]) -> Reference:
    """The reference system of a table `[reference]`.

    Raises ValueError: an unknown unit or key, a number out of range.
    """
    unit = table.get("unit", "ideal")
    if unit not in UNITS:
        raise ValueError(f"reference.unit is {unit!r}; known: {', '.join(UNITS)}")
    known = [f.name for f in fields(Reference)]
    numbers = {}
    for key, value in table.items():
        if key == "unit":
            continue
        if key not in known:
            raise ValueError(f"reference has no {key!r}; known: unit, {', '.join(known)}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"reference.{key} is {value!r}; a number is needed")
        numbers[key] = float(value)
    return replace(UNITS[unit], **numbers)


class ReferenceSystem:
    """Shows a motion as the reference system measures it; `period` [s] between two calls. Same seed, same errors."""

    def __init__(self, reference: Reference, seed: int, period: float) -> None:
        self._is = reference
        self._rng = np.random.default_rng([seed, 2917])
        self._keep = math.exp(-period / reference.drift_time)
        draw = self._rng.standard_normal(9).tolist()
        self._drift = [
            reference.position_drift * draw[0], reference.position_drift * draw[1], reference.heading_drift * draw[2],
        ]  # fmt: skip
        self._gyro = reference.yaw_rate_bias * draw[3]
        self._felt = reference.accel_bias * draw[4], reference.accel_bias * draw[5]
        self._arm = reference.arm * draw[6], reference.arm * draw[7]
        turn = reference.mounting * draw[8]
        self._turn = math.cos(turn), math.sin(turn)

    def show(self, true: VehicleState) -> VehicleState:
        """The state [SI] as measured at `true.t`; `steer` is not its matter and stays."""
        is_ = self._is
        if is_.ideal:
            return true
        white = self._rng.standard_normal(11).tolist()
        kick = math.sqrt(1.0 - self._keep**2)
        scale = (is_.position_drift, is_.position_drift, is_.heading_drift)
        self._drift = [self._keep * d + kick * s * w for d, s, w in zip(self._drift, scale, white[:3], strict=True)]
        c, s = math.cos(true.yaw), math.sin(true.yaw)
        (ahead, aside), (ct, st) = self._arm, self._turn
        vx = true.v + is_.speed_noise * white[6]
        return msgspec.structs.replace(
            true,
            x=true.x + c * ahead - s * aside + self._drift[0] + is_.position_noise * white[3],
            y=true.y + s * ahead + c * aside + self._drift[1] + is_.position_noise * white[4],
            yaw=true.yaw + self._drift[2] + is_.heading_noise * white[5],
            v=vx,
            vx=vx,
            vy=true.vy + is_.speed_noise * white[7],
            yaw_rate=true.yaw_rate + self._gyro + is_.yaw_rate_noise * white[8],
            ax=ct * true.ax + st * true.ay + self._felt[0] + is_.accel_noise * white[9],
            ay=ct * true.ay - st * true.ax + self._felt[1] + is_.accel_noise * white[10],
        )
