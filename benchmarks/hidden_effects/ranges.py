"""Ranges from which hidden values are drawn, and which effects nobody can tell apart.

Written down apart from the kernel's catalogue: what the catalogue says is under test, too.
"""

from __future__ import annotations

import math

import numpy as np

from tests.truth.effects import KNOWN

# name -> key -> (low, high), the catalogue's typical range; drawn evenly, or evenly in the logarithm where it spans
# more than a factor of eight
RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "drive_delay": {"T": (0.05, 0.5)},
    "drive_lag": {"tau": (0.1, 0.8)},
    "brake_lag": {"tau": (0.1, 0.8)},
    "drive_gain": {"g": (0.7, 1.2)},
    "brake_gain": {"g": (0.6, 1.2)},
    "mass": {"ratio": (0.7, 1.4)},
    "jerk_limit": {"limit": (1.0, 10.0)},
    "power_limit": {"limit": (3.0, 40.0)},
    "brake_limit": {"limit": (1.0, 9.0)},
    "drive_torque_limit": {"limit": (0.8, 6.0)},
    "pedal_deadband": {"width": (0.05, 0.5)},
    "gear_inertia": {"share": (0.05, 0.6), "v1": (2.0, 9.0)},
    "lift_off_braking": {"a": (0.2, 1.0)},
    "creep": {"a": (0.1, 1.0), "v0": (1.0, 6.0)},
    "gear_changes": {"T": (0.2, 1.2), "v1": (2.0, 8.0), "step": (1.3, 2.2), "demand": (0.0, 0.5)},
    "torque_converter": {"ratio": (1.3, 2.6), "stall": (0.8, 4.0), "J": (0.03, 0.5)},
    "rolling_resistance": {"c": (0.05, 0.4)},
    "viscous_resistance": {"c": (0.005, 1.0)},
    "aero_drag": {"k": (0.0002, 0.02)},
    "cornering_drag": {"c": (0.02, 0.5)},
    "road_grade": {"slope": (-0.08, 0.08), "heading": (-math.pi / 2, math.pi / 2)},
    "road_bank": {"slope": (-0.35, 0.35), "heading": (-math.pi / 2, math.pi / 2)},
    "headwind": {"speed": (-12.0, 12.0), "k": (0.0002, 0.02)},
    "steer_delay": {"T": (0.03, 0.5)},
    "steer_lag": {"tau": (0.05, 0.6)},
    "steer_rate_limit": {"limit": (0.05, 1.0)},
    "steer_angle_limit": {"limit": (0.08, 0.6)},
    "steer_stiction": {"width": (0.002, 0.04)},
    "steer_sticking": {"width": (0.01, 0.2)},
    "steer_backlash": {"half_width": (0.002, 0.04)},
    "steer_ratio": {"g": (0.7, 1.3)},
    "steer_asymmetry": {"g_left": (0.7, 1.3), "g_right": (0.7, 1.3)},
    "steer_offset": {"offset": (-0.04, 0.04)},
    "understeer": {"K": (-0.002, 0.015)},
    "tyre_saturation": {"limit": (2.0, 12.0)},
    "tyre_relaxation": {"length": (0.1, 3.0)},
    "load_transfer": {"c": (0.0, 0.5)},
    "steer_compliance": {"c": (0.0, 0.02)},
    "roll_dynamics": {"gain": (0.0, 0.3), "tau": (0.05, 0.5)},
    "yaw_inertia": {"ratio": (0.5, 2.0)},
    "wheel_radius": {"ratio": (0.9, 1.1)},
    "gyro_bias": {"b": (-0.04, 0.04)},
    "yaw_rate_latency": {"T": (0.02, 0.5)},
    "accelerometer_filter": {"tau": (0.02, 0.3)},
    "accelerometer_bias": {"b": (-0.6, 0.6)},
    "lateral_accelerometer_bias": {"b": (-0.6, 0.6)},
    "imu_misalignment": {"angle": (-0.2, 0.2)},
    "pitch": {"gain": (0.0, 0.3)},
    "roll": {"gain": (0.0, 0.3)},
    "heading_bias": {"b": (-0.06, 0.06)},
    "gnss_latency": {"T": (0.03, 0.5)},
    "gnss_lever_arm": {"x": (-2.0, 2.0), "y": (-2.0, 2.0)},
    "speed_controller": {"kp": (0.3, 5.0), "ki": (0.0, 2.0)},
}
# what the perception does; judged on object tracks
PERCEPTION: dict[str, dict[str, tuple[float, float]]] = {
    "detection_latency": {"T": (0.1, 0.5)},
    "detection_offset": {"x": (-1.0, 1.0), "y": (-1.0, 1.0)},
    "detection_range": {"R": (10.0, 40.0)},
    "detection_misses": {"rate": (0.05, 0.5)},
    "detection_false": {"rate": (0.1, 0.5)},
    "detection_noise": {"sigma0": (0.1, 1.0), "slope": (0.0, 0.05)},
}
# those that came after the first record: asked last in each round, and in no pair or triple, so that the questions of
# that record stay as they were
LATER = (
    "drive_torque_limit",
    "steer_sticking",
    "lateral_accelerometer_bias",
    "gear_inertia",
    "creep",
    "accelerometer_filter",
    "torque_converter",
)
# how strong an effect of no library is: times its typical size
OUTSIDE_SCALE = (1.0, 2.0)

# two of one family explain each other (structural ties, or one contains the other): no pair or triple takes two of them
FAMILIES: tuple[frozenset[str], ...] = (
    frozenset({"mass", "gear_inertia", "drive_gain", "brake_gain", "brake_limit", "power_limit", "drive_torque_limit"}),
    frozenset({"drive_delay", "drive_lag", "brake_lag", "jerk_limit"}),
    frozenset(
        {
            "rolling_resistance",
            "viscous_resistance",
            "aero_drag",
            "headwind",
            "road_grade",
            "lift_off_braking",
            "creep",
            "pedal_deadband",
        }
    ),
    frozenset({"steer_delay", "steer_lag", "steer_rate_limit", "yaw_rate_latency"}),
    frozenset({"steer_stiction", "steer_sticking", "steer_backlash"}),
    frozenset({"steer_ratio", "steer_asymmetry", "steer_angle_limit"}),
    frozenset({"pitch", "accelerometer_bias", "imu_misalignment", "roll"}),
    frozenset({"gnss_latency", "gnss_lever_arm"}),
    # a second tyre effect changes what the first means
    frozenset(
        {
            "understeer",
            "tyre_saturation",
            "tyre_relaxation",
            "load_transfer",
            "steer_compliance",
            "roll_dynamics",
            "yaw_inertia",
            "cornering_drag",
        }
    ),
)


def neutral(name: str, key: str) -> float:
    """The value that switches an effect off; 0 for those of the perception."""
    return KNOWN[name][key][0] if name in KNOWN else 0.0


def tied(names: tuple[str, ...]) -> bool:
    """Whether two of the names are of one family."""
    return any(len(family & set(names)) > 1 for family in FAMILIES)


def draw(name: str, rng: np.random.Generator) -> dict[str, float]:
    """Values of one effect, over its typical range."""
    keys = RANGES.get(name) or PERCEPTION.get(name)
    if keys is None:  # of no library
        factor = float(rng.uniform(*OUTSIDE_SCALE))
        first, *others = KNOWN[name]
        return {first: KNOWN[name][first][1] * factor} | {key: KNOWN[name][key][1] for key in others}
    values = {}
    for key, (low, high) in keys.items():
        if low > 0.0 and high > 8.0 * low:
            value = math.exp(rng.uniform(math.log(low), math.log(high)))
        else:
            value = rng.uniform(low, high)
        values[key] = float(f"{value:.4g}")
    return values


def draw_on_top(name: str, rng: np.random.Generator) -> dict[str, float]:
    """Values for cars with physics of their own: once to twice the typical size, of either sign where there are two."""
    factor = float(rng.uniform(1.0, 2.0))
    values = {}
    for key, (off, middle, _) in KNOWN[name].items():
        if key not in RANGES[name]:
            continue
        low, high = RANGES[name][key]
        if math.isinf(off):
            value = max(low, middle / factor)
        else:
            side = -1.0 if low < off < high and low < 0.0 and rng.random() < 0.5 else 1.0
            value = min(max(off + side * factor * (middle - off), low), high)
        values[key] = float(f"{value:.4g}")
    return values
