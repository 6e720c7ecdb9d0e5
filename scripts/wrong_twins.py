"""Twins that are wrong in one property each, by a little or by much, made of one that is right."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from vehicle.model.effect_catalogue import find_effect
from vehicle.model.vehicle_model import VehicleModel


@dataclasses.dataclass(frozen=True)
class Fault:
    """How a twin is made wrong: `key` of `effect` becomes its value, times or plus something from `little` to `much`.

    Of the right twin's value where it has the effect, else of the value at which the effect does nothing (`neutral`).
    An `effect` of "car" is a parameter of the model file.
    """

    effect: str
    key: str
    how: str  # "times" or "plus"
    little: float
    much: float
    neutral: float = 0.0

    @property
    def name(self) -> str:
        """As a user would call the parameter."""
        return self.key if self.effect == "car" else f"{self.effect}.{self.key}"

    @property
    def parameter(self) -> str:
        """What a verdict is to name: an effect, of a parameter of the model file that which shows it."""
        return self.key if self.effect == "car" else self.effect

    def made(self, right: VehicleModel, size: float) -> VehicleModel:
        """The right twin with this fault of a size [as `little` and `much`]."""
        before = right.car.values()[self.key] if self.effect == "car" else right.value(self.effect, self.key)
        before = self.neutral if before is None else before
        value = before * size if self.how == "times" else before + size
        if self.effect == "car":
            return right.with_car(
                {**right.car.values(), self.key: value}
            )  # all else as it is, what follows from it too
        lowest = 0.0 if find_effect(self.effect).name in _NOT_BELOW_ZERO else -np.inf
        return right.with_effect(self.effect, {self.key: max(value, lowest)})


_NOT_BELOW_ZERO = frozenset({"steer_delay", "steer_lag", "drive_lag", "drive_delay", "brake_lag", "rolling_resistance"})

FAULTS: tuple[Fault, ...] = (
    Fault("car", "wheelbase", "times", 1.03, 1.10),
    Fault("car", "cornering_stiffness_front", "times", 0.8, 0.5),
    Fault("car", "yaw_inertia", "times", 1.3, 2.0),
    Fault("mass", "ratio", "times", 1.05, 1.3, 1.0),
    Fault("drive_gain", "g", "times", 0.95, 0.8, 1.0),
    Fault("brake_gain", "g", "times", 0.95, 0.8, 1.0),
    Fault("drive_lag", "tau", "plus", 0.08, 0.3),
    Fault("brake_lag", "tau", "plus", 0.08, 0.3),
    Fault("drive_delay", "T", "plus", 0.05, 0.2),
    Fault("rolling_resistance", "c", "plus", 0.04, 0.2),
    Fault("aero_drag", "k", "plus", 0.001, 0.01),
    Fault("road_grade", "slope", "plus", 0.004, 0.02),
    Fault("lift_off_braking", "a", "plus", 0.1, 0.4),
    Fault("brake_limit", "limit", "plus", 2.0, 0.6),
    Fault("jerk_limit", "limit", "plus", 3.0, 1.0),
    Fault("steer_delay", "T", "plus", -0.03, -0.15),
    Fault("steer_lag", "tau", "plus", 0.04, 0.2),
    Fault("steer_ratio", "g", "times", 1.03, 1.2, 1.0),
    Fault("steer_offset", "offset", "plus", 0.002, 0.015),
    Fault("steer_backlash", "half_width", "plus", 0.003, 0.015),
    Fault("steer_rate_limit", "limit", "plus", 0.3, 0.08),
    Fault("understeer", "K", "plus", 0.002, 0.008),
    Fault("tyre_saturation", "limit", "plus", 6.0, 3.0),
    Fault("tyre_relaxation", "length", "plus", 0.3, 1.5),
    Fault("wheel_radius", "ratio", "times", 1.01, 1.05, 1.0),
    Fault("gyro_bias", "b", "plus", 0.002, 0.015),
    Fault("accelerometer_bias", "b", "plus", 0.05, 0.3),
    Fault("heading_bias", "b", "plus", 0.006, 0.035),
    Fault("gnss_latency", "T", "plus", 0.03, 0.2),
    Fault("gnss_lever_arm", "x", "plus", 0.15, 0.8),
    Fault("detection_offset", "x", "plus", 0.3, 0.9),
    Fault("detection_range", "R", "plus", 30.0, 12.0),
    Fault("detection_misses", "rate", "plus", 0.15, 0.5),
    Fault("detection_latency", "T", "plus", 0.1, 0.4),
    Fault("detection_false", "rate", "plus", 0.3, 2.0),
    Fault("detection_size", "length_ratio", "times", 1.15, 1.4, 1.0),
    Fault("detection_yaw", "b", "plus", 0.06, 0.25),
    Fault("detection_noise", "sigma0", "plus", 0.15, 0.6),
)
"""What a twin may have wrong: of the car, of its sensors, and of its perception. Little is about the least that matters
to a driving stack; much is a gross error."""


@dataclasses.dataclass(frozen=True)
class WrongTwin:
    """A fault and its size."""

    fault: Fault
    size: float

    @property
    def name(self) -> str:
        """`steer_delay.T -0.03`, `steer_ratio.g x1.03`."""
        size = f"x{self.size:.3g}" if self.fault.how == "times" else f"{self.size:+.3g}"
        return f"{self.fault.name} {size}"


def little_and_much(of: Sequence[Fault] = FAULTS) -> list[WrongTwin]:
    """Each fault by a little and by much: what bounds are chosen on."""
    return [WrongTwin(fault, size) for fault in of for size in (fault.little, fault.much)]


def drawn(seed: int, count: int) -> list[WrongTwin]:
    """`count` wrong twins of which nothing was known: every fault in turn, in an order and of sizes that are drawn.

    Sizes are uniform from little to much. Same seed, same twins.
    """
    rng = np.random.default_rng([seed, 60])
    order = [FAULTS[k] for _ in range(count // len(FAULTS) + 1) for k in rng.permutation(len(FAULTS)).tolist()]
    return [WrongTwin(f, f.little + float(rng.random()) * (f.much - f.little)) for f in order[:count]]
