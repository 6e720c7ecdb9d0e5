"""What can be hidden in a truth car: names and keys of DIAGNOSIS's catalogue, and some that no catalogue has.

Written down here a second time on purpose: the kernel's own catalogue is what the truth is to test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]

# name -> key -> (value that switches it off, a value in the middle of its range, unit)
PLANT: dict[str, dict[str, tuple[float, float, str]]] = {
    "drive_delay": {"T": (0.0, 0.2, "s")},
    "drive_lag": {"tau": (0.0, 0.3, "s"), "brakes": (1.0, 1.0, "-")},
    "brake_lag": {"tau": (0.0, 0.3, "s"), "release": (0.0, 0.0, "-")},
    "drive_gain": {"g": (1.0, 0.85, "-")},
    "brake_gain": {"g": (1.0, 0.8, "-")},
    "mass": {"ratio": (1.0, 1.2, "-")},
    "jerk_limit": {"limit": (math.inf, 3.0, "m/s^3")},
    "power_limit": {"limit": (math.inf, 8.0, "W/kg")},
    "brake_limit": {"limit": (math.inf, 2.0, "m/s^2")},
    "drive_torque_limit": {"limit": (math.inf, 1.2, "m/s^2")},
    "pedal_deadband": {"width": (0.0, 0.3, "m/s^2")},
    "gear_inertia": {"share": (0.0, 0.3, "-"), "v1": (5.0, 5.0, "m/s")},
    "lift_off_braking": {
        "a": (0.0, 0.5, "m/s^2"),
        "braking": (0.0, 0.0, "-"),
        "rise": (0.0, 0.0, "1/s"),
        "fade": (0.0, 0.0, "m/s"),
        "lag": (0.0, 0.0, "s"),
        "drive": (1.0, 0.0, "-"),
        "blend": (0.0, 0.3, "m/s^2"),
    },
    "rolling_resistance": {"c": (0.0, 0.2, "m/s^2")},
    "viscous_resistance": {"c": (0.0, 0.05, "1/s")},
    "aero_drag": {"k": (0.0, 0.003, "1/m")},
    "cornering_drag": {"c": (0.0, 0.15, "-")},
    "road_grade": {"slope": (0.0, 0.03, "rad"), "heading": (0.0, 0.4, "rad")},
    "road_bank": {"slope": (0.0, 0.06, "rad"), "heading": (0.0, 0.4, "rad")},
    # heading: inf is a wind that always comes from ahead
    "headwind": {"speed": (0.0, 6.0, "m/s"), "k": (0.0, 0.003, "1/m"), "heading": (math.inf, math.inf, "rad")},
    "steer_delay": {"T": (0.0, 0.15, "s")},
    "steer_lag": {"tau": (0.0, 0.2, "s")},
    "steer_rate_limit": {"limit": (math.inf, 0.2, "rad/s")},
    "steer_angle_limit": {"limit": (math.inf, 0.2, "rad")},
    "steer_stiction": {"width": (0.0, 0.012, "rad")},
    "steer_sticking": {"width": (0.0, 0.05, "rad")},
    "steer_backlash": {"half_width": (0.0, 0.01, "rad")},
    "steer_ratio": {"g": (1.0, 0.88, "-")},
    "steer_asymmetry": {"g_left": (1.0, 0.9, "-"), "g_right": (1.0, 1.1, "-")},
    "steer_offset": {"offset": (0.0, 0.012, "rad")},
    "understeer": {"K": (0.0, 0.004, "rad s^2/m")},
    "tyre_saturation": {"limit": (math.inf, 3.0, "m/s^2")},
    "tyre_relaxation": {"length": (0.0, 0.8, "m")},
    "load_transfer": {"c": (0.0, 0.4, "-")},
    "steer_compliance": {"c": (0.0, 0.008, "rad/kN")},
    "roll_dynamics": {"gain": (0.0, 0.15, "-"), "tau": (0.2, 0.2, "s")},
    "yaw_inertia": {"ratio": (1.0, 1.5, "-")},
    "speed_controller": {"kp": (0.0, 1.2, "1/s"), "ki": (0.0, 0.2, "1/s^2")},
    # shows only beside speed_controller
    "speed_limit": {"limit": (math.inf, 6.0, "m/s")},
    # of the catalogue, but no ordinary search tries it
    "steer_assist": {"g": (0.0, -0.25, "-"), "v0": (5.0, 5.0, "m/s")},
    "road_profile": {
        "height": (0.0, 1.0, "m"),
        "x": (20.0, 20.0, "m"),
        "y": (5.0, 5.0, "m"),
        "length": (15.0, 15.0, "m"),
    },
    # in no catalogue: a diagnosis must say UNKNOWN or PARTIAL
    "torque_ripple": {"amplitude": (0.0, 0.5, "m/s^2"), "per_metre": (0.5, 0.35, "1/m")},
    "speed_dependent_ratio": {"c": (0.0, 0.025, "s/m")},
    # drop, heat: of a brake that never cools; k, tau: of one that does, as in the catalogue
    "brake_fade": {
        "drop": (0.0, 0.5, "-"),
        "heat": (60.0, 60.0, "m^2/s^2"),
        "k": (0.0, 0.0, "kg/J"),
        "tau": (60.0, 60.0, "s"),
    },
    "cross_wind": {"amplitude": (0.0, 0.012, "rad"), "period": (7.0, 7.0, "s")},
    # steer_servo of the catalogue, in another form
    "steer_resonance": {"frequency": (0.0, 1.8, "Hz"), "damping": (0.25, 0.25, "-")},
    "battery_sag": {"drop": (0.0, 0.4, "-"), "energy": (100.0, 100.0, "m^2/s^2")},
    "gear_changes": {
        "T": (0.0, 0.6, "s"),
        "v1": (4.0, 3.5, "m/s"),
        "step": (1.6, 1.7, "-"),
        "demand": (0.0, 0.2, "s^2/m"),
        "cut": (1.0, 1.0, "-"),
        "fall": (0.0, 0.6, "-"),
    },
    "torque_converter": {
        "ratio": (1.0, 1.9, "-"),
        "stall": (1.5, 1.8, "m/s"),
        "J": (0.0, 0.12, "-"),
        "lock": (30.0, 12.0, "m/s"),
        "idle": (0.0, 1.2, "m/s"),
    },
    "creep": {"a": (0.0, 0.8, "m/s^2"), "v0": (2.0, 3.0, "m/s"), "braking": (1.0, 1.0, "-")},
    # beside the drive, not in its place: a torque converter that multiplies
    "converter_gain": {"a": (0.0, 0.6, "m/s^2"), "speed": (2.0, 2.5, "m/s")},
}
"""Effects of the car itself, integrated with its motion."""

SENSORS: dict[str, dict[str, tuple[float, float, str]]] = {
    "wheel_radius": {"ratio": (1.0, 0.96, "-")},
    "gyro_bias": {"b": (0.0, 0.01, "rad/s")},
    "yaw_rate_latency": {"T": (0.0, 0.1, "s")},
    "accelerometer_filter": {"tau": (0.0, 0.08, "s")},
    "accelerometer_bias": {"b": (0.0, 0.2, "m/s^2")},
    "lateral_accelerometer_bias": {"b": (0.0, 0.2, "m/s^2")},
    "imu_misalignment": {"angle": (0.0, 0.06, "rad")},
    "pitch": {"gain": (0.0, 0.12, "-")},
    "roll": {"gain": (0.0, 0.12, "-")},
    "heading_bias": {"b": (0.0, 0.025, "rad")},
    "gnss_latency": {"T": (0.0, 0.15, "s")},
    "gnss_lever_arm": {"x": (0.0, 0.8, "m"), "y": (0.0, 0.2, "m")},
}
"""Effects of what the sensors show."""

OUTSIDE = (
    "torque_ripple",
    "speed_dependent_ratio",
    "brake_fade",
    "cross_wind",
    "battery_sag",
    "converter_gain",
)
"""Effects that no ordinary search is expected to name: no library has them, or (brake_fade) in another form."""

REFINED: dict[str, dict[str, float]] = {
    "brake_fade": {"k": 0.005, "tau": 60.0},
    "steer_assist": {"g": -0.25, "v0": 5.0},
    "road_profile": {"height": 1.0, "x": 20.0, "y": 5.0, "length": 15.0},
}
"""Effects of the catalogue that are the form of a constant one that changes while driving, with plain values."""

SPEED_MODE = frozenset({"speed_controller", "speed_limit"})
"""Effects of cars that take a speed as command."""

KNOWN = {**PLANT, **SENSORS}
CATALOGUE: tuple[str, ...] = tuple(
    name for name in KNOWN if name not in (*OUTSIDE, *REFINED, "speed_limit", "steer_resonance")
)
"""What an ordinary search can find, each alone."""
TYRE_EFFECTS = frozenset(
    {
        "understeer",
        "tyre_saturation",
        "tyre_relaxation",
        "load_transfer",
        "steer_compliance",
        "roll_dynamics",
        "yaw_inertia",
    }
)
"""Effects that need slip angles: with one of them the body is a dynamic bicycle, else a kinematic one."""


@dataclass(frozen=True)
class TruthCar:
    """The car of the blind cases, and its stiffness where an effect leaves that open. SI units."""

    wheelbase: float = 2.45
    cg_to_front_axle: float = 1.15
    mass: float = 1150.0
    yaw_inertia: float = 1400.0
    # N/rad of a whole axle, for effects that only show on tyres that slip; b/Cf = a/Cr, so that they steer neutrally
    stiffness_front: float = 104_000.0
    stiffness_rear: float = 92_000.0
    # 1/rad, stiffness over load of axles that hardly slip: the dynamic car that comes nearest to a kinematic one. How
    # rigid that is, is a convention, the same as in the baseline of who diagnoses
    rigid: float = 48.0

    def rigid_axles(self) -> tuple[float, float]:
        """Stiffness of front and rear axle [N/rad] that hardly slip, and steer neutrally."""
        load = self.mass * 9.80665 / self.wheelbase
        a = self.cg_to_front_axle
        return self.rigid * load * (self.wheelbase - a), self.rigid * load * a


INDEX: dict[tuple[str, str], int] = {
    pair: k for k, pair in enumerate((name, key) for name, keys in PLANT.items() for key in keys)
}
N_EFFECT = len(INDEX)
# behind the effects: the car
(C_L, C_A, C_M, C_I, C_CF, C_CR, C_DYNAMIC, C_SPEED_MODE) = range(N_EFFECT, N_EFFECT + 8)


def typical(name: str) -> dict[str, float]:
    """A plain value of every key of an effect, well inside its range."""
    return {key: middle for key, (_, middle, _) in KNOWN[name].items()}


def checked(effects: Effects) -> dict[str, dict[str, float]]:
    """The effects with all their keys. Raises ValueError on a name or key that nobody knows."""
    full: dict[str, dict[str, float]] = {}
    for name, given in effects.items():
        if name not in KNOWN:
            raise ValueError(f"no truth effect called {name!r}; known: {', '.join(sorted(KNOWN))}")
        for key in given:
            if key not in KNOWN[name]:
                raise ValueError(f"{name} has no key {key!r}; it has {', '.join(KNOWN[name])}")
        full[name] = {key: float(given.get(key, off)) for key, (off, _, _) in KNOWN[name].items()}
    return full


def stiffnesses(car: TruthCar, effects: Effects) -> tuple[float, float]:
    """Cornering stiffness of front and rear axle [N/rad].

    Given K, the steady state decides: K = m/L (b/Cf - a/Cr); the stiffer axle is nearly rigid. Effects of how tyres
    work get tyres that slip; the others hang on nearly rigid ones, so that nothing else is hidden with them.
    """
    a, b = car.cg_to_front_axle, car.wheelbase - car.cg_to_front_axle
    front, rear = car.rigid_axles()
    if "understeer" in effects:
        k = effects["understeer"]["K"] * car.wheelbase / car.mass
        if k > 0.0:
            return b / (k + a / rear), rear
        return front, a / (b / front - k)
    if {"load_transfer", "tyre_relaxation", "yaw_inertia"} & set(effects):
        return car.stiffness_front, car.stiffness_rear
    return front, rear


def parameters(car: TruthCar, effects: Effects) -> FloatArray:
    """Everything the integrator needs as one array (effects at INDEX, the car at C_...)."""
    p = np.empty(N_EFFECT + 8)
    for (name, key), k in INDEX.items():
        p[k] = effects[name][key] if name in effects else PLANT[name][key][0]
    p[C_L], p[C_A], p[C_M] = car.wheelbase, car.cg_to_front_axle, car.mass
    p[C_I] = car.yaw_inertia
    p[C_CF], p[C_CR] = stiffnesses(car, effects)
    p[C_DYNAMIC] = float(bool(TYRE_EFFECTS & set(effects)))
    p[C_SPEED_MODE] = float(bool(SPEED_MODE & set(effects)))
    return p
