"""Small functions that effects share. Plain Python here; the compiler learns them in `vehicle.model.compiled`.

Compiled effects are cached by their own file: after editing this one, remove the `__pycache__` of the effects.
"""

from __future__ import annotations

import math
from typing import Any

DELAY_LINE = 1024  # values in a delay line: 1.02 s at 1 kHz


def clip(value: float, low: float, high: float) -> float:
    """`value` limited to low..high."""
    return min(max(value, low), high)


def lag_end(y: float, u: float, tau: float, dt: float) -> float:
    """Output of tau y' = u - y after `dt` [s] of constant input u, from y; tau <= 0 [s] passes u through. Exact."""
    if tau <= 0.0:
        return u
    return u + (y - u) * math.exp(-dt / tau)


def lag_mean(y: float, end: float, u: float, tau: float, dt: float) -> float:
    """Mean of the same output over the step, whose end value is `end`: u + (y - end) tau/dt. Exact."""
    if tau <= 0.0:
        return u
    return u + (y - end) * tau / dt


def delayed(ring: Any, head: int, u: float, delay: float, dt: float) -> float:
    """Store u at `head` of a ring of DELAY_LINE values and return the input of `delay` [s] ago, mean over the step.

    Exact for an input that is constant over each step, also when the delay is no multiple of the step.
    """
    ring[head] = u
    steps = delay / dt
    whole = int(steps)
    part = steps - whole
    newer = ring[(head - whole) % DELAY_LINE]
    if part <= 0.0:
        return float(newer)
    older = ring[(head - whole - 1) % DELAY_LINE]
    return float((1.0 - part) * newer + part * older)
