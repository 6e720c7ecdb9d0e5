"""Shapes in time of the standard's TransitionDynamics: how a value goes from where it is to its target.

Source: ASAM OpenSCENARIO XML 1.3, enumerations DynamicsShape and DynamicsDimension. With u = tau / T in [0, 1]:
linear u, cubic u^2 (3 - 2 u), sinusoidal (1 - cos(pi u)) / 2, step 1. The dimension `rate` is the peak rate of change.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

Shape = Callable[[float], float]

PEAK_SLOPE: Final = {"linear": 1.0, "cubic": 1.5, "sinusoidal": math.pi / 2.0, "step": 0.0}
"""Largest d(shape)/du: the factor between mean and peak rate."""


SAME: Final = 1e-9  # smaller changes are rounding


def _linear(u: float) -> float:
    return u


def _cubic(u: float) -> float:
    return u * u * (3.0 - 2.0 * u)


def _sinusoidal(u: float) -> float:
    return 0.5 * (1.0 - math.cos(math.pi * u))


def _step(u: float) -> float:
    return 1.0


def _slope_linear(u: float) -> float:
    return 1.0


def _slope_cubic(u: float) -> float:
    return 6.0 * u * (1.0 - u)


def _slope_sinusoidal(u: float) -> float:
    return 0.5 * math.pi * math.sin(math.pi * u)


def _slope_step(u: float) -> float:
    return 0.0


SHAPES: Final[dict[str, Shape]] = {"linear": _linear, "cubic": _cubic, "sinusoidal": _sinusoidal, "step": _step}
SLOPES: Final[dict[str, Shape]] = {
    "linear": _slope_linear,
    "cubic": _slope_cubic,
    "sinusoidal": _slope_sinusoidal,
    "step": _slope_step,
}


def _area_linear(u: float) -> float:
    return 0.5 * u * u


def _area_cubic(u: float) -> float:
    return u * u * u * (1.0 - 0.5 * u)


def _area_sinusoidal(u: float) -> float:
    return 0.5 * (u - math.sin(math.pi * u) / math.pi)


def _area_step(u: float) -> float:
    return u


AREAS: Final[dict[str, Shape]] = {
    "linear": _area_linear,
    "cubic": _area_cubic,
    "sinusoidal": _area_sinusoidal,
    "step": _area_step,
}
"""Integrals of the shapes from 0 to u: how far a speed of that shape has come. Symmetric shapes end at 1/2."""


def span(shape: str, dimension: str, value: float, change: float) -> float:
    """How long a transition takes: [s] for `time` and `rate`, [m] for `distance`.

    `change` is the difference between target and start in the unit of the quantity, `value` the attribute of
    TransitionDynamics (its sign is ignored: files in the wild brake with a negative rate). A rate of 0 never gets
    there.
    """
    if shape == "step" or abs(change) < SAME:
        return 0.0
    if dimension == "rate":
        rate = abs(value)
        return PEAK_SLOPE[shape] * abs(change) / rate if rate > 0.0 else math.inf
    return abs(value)


def lateral_span(shape: str, acceleration: float, change: float) -> float:
    """Duration [s] of a lateral shift of `change` [m] whose largest lateral acceleration is `acceleration` [m/s^2].

    From the second derivative of the shape: cubic 6 |d| / T^2, sinusoidal pi^2 |d| / (2 T^2). A linear shift has no
    finite acceleration at its ends; it takes the duration of the cubic one (the standard names no law for it).
    """
    if shape == "step" or change == 0.0:
        return 0.0
    if acceleration <= 0.0:
        return math.inf
    if shape == "sinusoidal":
        return math.pi * math.sqrt(abs(change) / (2.0 * acceleration))
    return math.sqrt(6.0 * abs(change) / acceleration)


class Transition:
    """A value under way from `start` to `target` over `span` seconds or metres."""

    __slots__ = ("_shape", "_slope", "done", "elapsed", "span", "start", "target", "value")

    def __init__(self, shape: str, span: float, start: float, target: float) -> None:
        self._shape = SHAPES[shape]
        self._slope = SLOPES[shape]
        self.span = 0.0 if shape == "step" else span
        self.start = start
        self.target = target
        self.elapsed = 0.0
        self.value = start
        self.done = False

    def advance(self, by: float) -> float:
        """Go on by `by` [s] or [m] (>= 0) and return the value there; past the end it is the target exactly."""
        self.elapsed += by
        # a whole number of steps must end the transition in spite of rounding
        if self.elapsed >= self.span - 1e-9 * (1.0 + self.span):
            self.value = self.target
            self.done = True
        else:
            self.value = self.start + (self.target - self.start) * self._shape(self.elapsed / self.span)
        return self.value

    def advance_straight(self, change: float) -> float:
        """Change the value by `change` (>= 0) towards the target, on the straight line from start to target."""
        whole = self.target - self.start
        self.advance(change * self.span / abs(whole))
        if not self.done:
            self.value = self.start + whole * self.elapsed / self.span
        return self.value

    def rate(self) -> float:
        """Rate of change of the value here, per second or per metre; 0 when done."""
        if self.done or self.span <= 0.0 or math.isinf(self.span):
            return 0.0
        return (self.target - self.start) / self.span * self._slope(self.elapsed / self.span)
