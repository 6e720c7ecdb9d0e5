"""The reference system of the surrogate: what a GNSS-aided INS says of the car's motion, in place of the truth.

[reference]
unit = "rtk"          # rtk (default), or ideal: the truth
accel_bias = 0.02     # any number of it, see Reference

Wheel speeds are of it as well: their scale is known only so well, and they come in steps.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import msgspec
import numpy as np

from vehicle.messages import VehicleState

RATES = (10.0, 20.0, 25.0, 50.0, 100.0)  # 1/s: those whose period is a whole number of the surrogate's 10 ms
LATEST = 0.5  # s: the greatest latency
_ABOVE_ZERO = ("drift_time", "outage_time")


@dataclass(frozen=True)
class Reference:
    """Errors of a reference system, each a standard deviation in SI units where nothing else is said.

    Those that wander are Gauss-Markov processes with the correlation time `drift_time`; biases are drawn once a drive.
    While satellites are out of sight, the error of the speed is a random walk, and that of the place its integral; both
    are gone when they come back. Raises ValueError on a number that is negative or out of range.
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
    arm: float = 0.0  # m, by which the place of the antenna in the car is known wrongly, ahead and aside
    mounting: float = 0.0  # rad, by which it is turned about the vertical axis
    drift_time: float = 60.0  # s
    outages: float = 0.0  # 1/min, losses of the satellites (not a standard deviation)
    outage_time: float = 3.0  # s, their mean duration (not a standard deviation)
    outage_drift: float = 0.0  # m/s per root of a second: random walk of the speed while they last
    latency: float = 0.0  # s by which the motion is older than its stamp says (not a standard deviation)
    rate: float = 100.0  # 1/s at which it measures: of RATES (not a standard deviation)
    wheel_scale: float = 0.0  # -, of the wheel speeds: tyres that are worn, or warm
    wheel_step: float = 0.0  # m/s, in which the wheel speeds come (not a standard deviation)

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not 0.0 <= value < math.inf or (f.name in _ABOVE_ZERO and value == 0.0):
                least = "above 0" if f.name in _ABOVE_ZERO else "at least 0"
                raise ValueError(f"reference.{f.name} is {value:g}; it must be {least}")
        if self.rate not in RATES:
            raise ValueError(f"reference.rate is {self.rate:g}; known: {', '.join(f'{rate:g}' for rate in RATES)}")
        if self.latency > LATEST:
            raise ValueError(f"reference.latency is {self.latency:g}; it must be at most {LATEST:g}")


UNITS: Mapping[str, Reference] = {
    "ideal": Reference(),
    # In the order of what makers print for a dual-antenna INS with RTK, 1 sigma: position 0.01 m, speed 0.05 km/h,
    # heading 0.1 deg, bias of acceleration 0.01 m/s^2 and of yaw rate 0.01 deg/s; 0.1 m after 10 s without satellites.
    # Wheel speeds: 1/16 km/h, as buses carry them, and 0.2 % of tyre. White noise at 100 Hz, the error of the
    # mounting, the correlation time and how often satellites are lost are chosen; makers print none.
    "rtk": Reference(
        position_drift=0.01, position_noise=0.002, heading_drift=0.0017, heading_noise=0.0003, speed_noise=0.014,
        yaw_rate_bias=0.00017, yaw_rate_noise=0.001, accel_bias=0.01, accel_noise=0.03, arm=0.01, mounting=0.003,
        outages=0.5, outage_drift=0.0055, wheel_scale=0.002, wheel_step=0.0625 / 3.6,
    ),
}  # fmt: skip
"""Reference systems by name."""
USUAL = "rtk"


def reference_of(table: Mapping[str, Any]) -> Reference:
    """The reference system of a table `[reference]`; of an empty one, the usual one.

    Raises ValueError: an unknown unit or key, a number out of range.
    """
    unit = table.get("unit", USUAL)
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


@dataclass
class _Outage:
    """Without satellites since `since` and until `until` [s of calls]; errors of speed [m/s] and place [m] since."""

    since: float = 0.0
    until: float = 0.0
    speed: list[float] = field(default_factory=lambda: [0.0, 0.0])
    place: list[float] = field(default_factory=lambda: [0.0, 0.0])


class ReferenceSystem:
    """Shows a motion as the reference system measures it; `period` [s] between two calls. Same seed, same errors."""

    def __init__(self, reference: Reference, seed: int, period: float) -> None:
        self._is, self._period, self._calls = reference, period, 0
        self._rng, self._lost = np.random.default_rng([seed, 2917]), np.random.default_rng([seed, 2918])
        self._keep = math.exp(-period / reference.drift_time)
        draw = self._rng.standard_normal(10).tolist()
        self._drift = [
            reference.position_drift * draw[0], reference.position_drift * draw[1], reference.heading_drift * draw[2],
        ]  # fmt: skip
        self._gyro = reference.yaw_rate_bias * draw[3]
        self._felt = reference.accel_bias * draw[4], reference.accel_bias * draw[5]
        self._arm = reference.arm * draw[6], reference.arm * draw[7]
        turn = reference.mounting * draw[8]
        self._turn = math.cos(turn), math.sin(turn)
        self._wheel = 1.0 + reference.wheel_scale * draw[9]
        self._before: deque[VehicleState] = deque(maxlen=math.ceil(reference.latency / period - 1e-9) + 1)
        self._outage = _Outage()

    def due(self, call: int) -> bool:
        """Whether it measures at the call of this number, at its rate."""
        return call % round(1.0 / (self._is.rate * self._period)) == 0

    def wheels(self, v: float) -> float:
        """The speed [m/s] that the wheels report of a speed: scaled, and in steps."""
        shown: float = v * self._wheel
        step = self._is.wheel_step
        return round(shown / step) * step if step > 0.0 else shown

    def show(self, true: VehicleState) -> VehicleState:
        """The state [SI] as measured at `true.t`; `steer` is not its matter and stays."""
        is_ = self._is
        white = self._rng.standard_normal(11).tolist()
        kick = math.sqrt(1.0 - self._keep**2)
        scale = (is_.position_drift, is_.position_drift, is_.heading_drift)
        self._drift = [self._keep * d + kick * s * w for d, s, w in zip(self._drift, scale, white[:3], strict=True)]
        self._coast()
        seen, out = self._seen(true), self._outage
        c, s = math.cos(seen.yaw), math.sin(seen.yaw)
        (ahead, aside), (ct, st) = self._arm, self._turn
        vx = seen.v + c * out.speed[0] + s * out.speed[1] + is_.speed_noise * white[6]
        return msgspec.structs.replace(
            true,
            x=seen.x + c * ahead - s * aside + self._drift[0] + out.place[0] + is_.position_noise * white[3],
            y=seen.y + s * ahead + c * aside + self._drift[1] + out.place[1] + is_.position_noise * white[4],
            yaw=seen.yaw + self._drift[2] + is_.heading_noise * white[5],
            v=vx,
            vx=vx,
            vy=seen.vy + c * out.speed[1] - s * out.speed[0] + is_.speed_noise * white[7],
            yaw_rate=seen.yaw_rate + self._gyro + is_.yaw_rate_noise * white[8],
            position_sigma=self._stated(),
            ax=ct * seen.ax + st * seen.ay + self._felt[0] + is_.accel_noise * white[9],
            ay=ct * seen.ay - st * seen.ax + self._felt[1] + is_.accel_noise * white[10],
        )

    def _stated(self) -> float:
        """Standard deviation [m] of x and of y that it states with them, as an INS does: what its filter expects.

        That is noise and drift, and while satellites are out of sight the integral of the speed's random walk; what it
        does not know of, the place of the antenna, is not in it. 0 for one without errors: nothing is stated.
        """
        is_, out, now = self._is, self._outage, self._calls * self._period
        lost = now - out.since if now < out.until else 0.0
        return math.sqrt(is_.position_drift**2 + is_.position_noise**2 + is_.outage_drift**2 * lost**3 / 3.0)

    def _seen(self, true: VehicleState) -> VehicleState:
        """The motion that is measured: that of `latency` ago, or the oldest there is."""
        self._before.append(true)
        if len(self._before) == 1:
            return true
        older, newer = self._before[0], self._before[1]
        steps = self._is.latency / self._period
        share = math.ceil(steps - 1e-9) - steps if len(self._before) == self._before.maxlen else 0.0
        names = ("x", "y", "yaw", "v", "vx", "vy", "yaw_rate", "ax", "ay")
        mixed = {n: getattr(older, n) + share * (getattr(newer, n) - getattr(older, n)) for n in names}
        return msgspec.structs.replace(true, **mixed)

    def _coast(self) -> None:
        """Lose the satellites or find them again, and let the errors grow while they are lost."""
        is_, out, now = self._is, self._outage, self._calls * self._period
        self._calls += 1
        luck, lasts = float(self._lost.random()), float(self._lost.exponential(is_.outage_time))
        walk = self._lost.standard_normal(2).tolist()
        if now >= out.until:
            out.speed, out.place = [0.0, 0.0], [0.0, 0.0]
            if luck < is_.outages / 60.0 * self._period:
                out.since, out.until = now, now + lasts
            return
        step = is_.outage_drift * math.sqrt(self._period)
        out.speed = [v + step * w for v, w in zip(out.speed, walk, strict=True)]
        out.place = [p + v * self._period for p, v in zip(out.place, out.speed, strict=True)]
