"""Quantities of the car of which a law is made: how each is computed, its usual size, and its unit."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from numba.extending import register_jitable

PEDAL = 0.05  # m/s^2: a command beyond it counts as a pedal that is pressed
TURNING = 0.1  # rad/s, at which the smooth sign of a turn is at 76 %
LIVELY = 10.0  # m/s, at which the root of the speed is 1, so that it has no unit

Unit = tuple[int, int, int]
"""Exponents of m, s and rad."""


@dataclasses.dataclass(frozen=True, slots=True)
class Factor:
    """One quantity. code: as an effect file writes it; usual: its size in a lively drive, by which coefficients become
    comparable; odd: it changes its sign when left and right are exchanged."""

    name: str
    code: str
    usual: float
    unit: Unit
    odd: bool = False


FACTORS: tuple[Factor, ...] = (
    Factor("1", "1.0", 1.0, (0, 0, 0)),
    Factor("v", "x.vx", 10.0, (1, -1, 0)),
    Factor("d", "x.steer", 0.1, (0, 0, 1), odd=True),
    Factor("|d|", "abs(x.steer)", 0.1, (0, 0, 1)),
    Factor("a+", "max(x.accel, 0.0)", 2.0, (1, -2, 0)),
    Factor("a-", "max(-x.accel, 0.0)", 2.0, (1, -2, 0)),
    Factor("ax", "x.ax", 2.0, (1, -2, 0)),
    Factor("ay", "x.ay", 3.0, (1, -2, 0), odd=True),
    Factor("|ay|", "abs(x.ay)", 3.0, (1, -2, 0)),
    Factor("r", "x.yaw_rate", 0.3, (0, -1, 1), odd=True),
    Factor("(v - v0)+", "max(x.vx - p.v0, 0.0)", 5.0, (1, -1, 0)),
    Factor("tanh(r)", f"tanh(x.yaw_rate / {TURNING})", 1.0, (0, 0, 0), odd=True),
    Factor("[drive]", f"float(x.accel > {PEDAL})", 1.0, (0, 0, 0)),
    Factor("[brake]", f"float(x.accel < -{PEDAL})", 1.0, (0, 0, 0)),
    Factor("[coast]", f"float(abs(x.accel) <= {PEDAL})", 1.0, (0, 0, 0)),
    Factor("sqrt(v)", f"sqrt(max(x.vx, 0.0) / {LIVELY})", 1.0, (0, 0, 0)),
)
"""Their place in this table is their number in `value`; number 0 is no factor."""

NUMBER = {factor.name: k for k, factor in enumerate(FACTORS)}
THRESHOLD = NUMBER["(v - v0)+"]


@register_jitable  # type: ignore[untyped-decorator,unused-ignore]
def value(x: Any, k: int, v0: float) -> float:
    """Factor number `k` on the bus `x` in SI units; v0 [m/s] is the threshold of the one that has one."""
    if k == 1:
        return float(x.vx)
    if k == 2:
        return float(x.steer)
    if k == 3:
        return float(abs(x.steer))
    if k == 4:
        return float(max(x.accel, 0.0))
    if k == 5:
        return float(max(-x.accel, 0.0))
    if k == 6:
        return float(x.ax)
    if k == 7:
        return float(x.ay)
    if k == 8:
        return float(abs(x.ay))
    if k == 9:
        return float(x.yaw_rate)
    if k == 10:
        return float(max(x.vx - v0, 0.0))
    if k == 11:
        return float(math.tanh(x.yaw_rate / TURNING))
    if k == 12:
        return 1.0 if x.accel > PEDAL else 0.0
    if k == 13:
        return 1.0 if x.accel < -PEDAL else 0.0
    if k == 14:
        return 1.0 if abs(x.accel) <= PEDAL else 0.0
    if k == 15:
        return float(math.sqrt(max(x.vx, 0.0) / LIVELY))
    return 1.0


def unit_text(unit: Unit) -> str:
    """A unit as a model file writes it: (1, -2, 0) -> "m/s^2"."""
    above = [_power(name, power) for name, power in zip(("m", "s", "rad"), unit, strict=True) if power > 0]
    below = [_power(name, -power) for name, power in zip(("m", "s", "rad"), unit, strict=True) if power < 0]
    if not above and not below:
        return "-"
    under = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return " ".join(above or ["1"]) + (f"/{under}" if below else "")


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"
