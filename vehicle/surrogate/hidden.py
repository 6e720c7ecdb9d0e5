"""What is hidden in the surrogate: the TOML file that says so, read with errors that help.

    [hidden.steer_delay]
    T = 0.2
    [car]                 # other numbers of the car, see vehicle.surrogate.car
    cg_height = 0.55
    [sensors]
    noise = "low"         # none, low, mid, high
    [reference]
    unit = "ideal"        # what measures the motion of logs of pe and rw, see vehicle.surrogate.reference

Source of the effects' names and keys: the project's catalogue; the physics behind them here is the surrogate's own.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from vehicle.surrogate.car import Car
from vehicle.surrogate.reference import UNITS, USUAL, Reference, reference_of
from vehicle.toml_file import TomlError, read_toml


@dataclass(frozen=True)
class Bound:
    """A key of a hidden effect: its unit, its range, and the value at which nothing is hidden."""

    unit: str
    low: float
    high: float
    neutral: float


EFFECTS: dict[str, dict[str, Bound]] = {
    "drive_delay": {"T": Bound("s", 0.0, 1.0, 0.0)},
    "drive_lag": {"tau": Bound("s", 0.0, 2.0, 0.0)},
    "brake_lag": {"tau": Bound("s", 0.0, 2.0, 0.0)},
    "drive_gain": {"g": Bound("-", 0.2, 2.0, 1.0)},
    "brake_gain": {"g": Bound("-", 0.2, 2.0, 1.0)},
    "mass": {"ratio": Bound("-", 0.5, 2.0, 1.0)},
    "jerk_limit": {"limit": Bound("m/s^3", 0.1, math.inf, math.inf)},
    "power_limit": {"limit": Bound("W/kg", 0.5, math.inf, math.inf)},
    "brake_limit": {"limit": Bound("m/s^2", 0.3, math.inf, math.inf)},
    "drive_torque_limit": {"limit": Bound("m/s^2", 0.3, math.inf, math.inf)},
    "brake_fade": {"k": Bound("s^2/m^2", 0.0, 0.1, 0.0), "tau": Bound("s", 1.0, 3600.0, 120.0)},
    "pedal_deadband": {"width": Bound("m/s^2", 0.0, 1.0, 0.0)},
    "lift_off_braking": {"a": Bound("m/s^2", 0.0, 2.0, 0.0)},
    "rolling_resistance": {"c": Bound("m/s^2", 0.0, 1.0, 0.0)},
    "viscous_resistance": {"c": Bound("1/s", 0.0, 1.0, 0.0)},
    "aero_drag": {"k": Bound("1/m", 0.0, 0.05, 0.0)},
    "road_grade": {"slope": Bound("rad", -0.2, 0.2, 0.0), "heading": Bound("rad", -3.2, 3.2, 0.0)},
    "road_bank": {"slope": Bound("rad", -0.35, 0.35, 0.0), "heading": Bound("rad", -3.2, 3.2, 0.0)},
    "road_profile": {
        "height": Bound("m", -20.0, 20.0, 0.0),
        "x": Bound("m", -1e5, 1e5, 0.0),
        "y": Bound("m", -1e5, 1e5, 0.0),
        "length": Bound("m", 2.0, 1e3, 30.0),
    },
    "headwind": {
        "speed": Bound("m/s", -20.0, 20.0, 0.0),
        "k": Bound("1/m", 0.0, 0.05, 0.0),
        "heading": Bound("rad", -3.2, math.inf, math.inf),
    },
    "steer_delay": {"T": Bound("s", 0.0, 1.0, 0.0)},
    "steer_lag": {"tau": Bound("s", 0.0, 2.0, 0.0)},
    "steer_rate_limit": {"limit": Bound("rad/s", 0.01, math.inf, math.inf)},
    "steer_angle_limit": {"limit": Bound("rad", 0.02, math.inf, math.inf)},
    "steer_stiction": {"width": Bound("rad", 0.0, 0.1, 0.0)},
    "steer_sticking": {"width": Bound("rad", 0.0, 0.3, 0.0)},
    "steer_backlash": {"half_width": Bound("rad", 0.0, 0.1, 0.0)},
    "steer_ratio": {"g": Bound("-", 0.3, 2.0, 1.0)},
    "steer_assist": {"g": Bound("-", -0.8, 2.0, 0.0), "v0": Bound("m/s", 0.1, 50.0, 8.0)},
    "steer_asymmetry": {"g_left": Bound("-", 0.3, 2.0, 1.0), "g_right": Bound("-", 0.3, 2.0, 1.0)},
    "steer_offset": {"offset": Bound("rad", -0.1, 0.1, 0.0)},
    "steer_compliance": {"c": Bound("rad/kN", 0.0, 0.03, 0.0)},
    "understeer": {"K": Bound("rad s^2/m", -0.001, 0.02, 0.0)},
    "tyre_saturation": {"limit": Bound("m/s^2", 1.0, math.inf, math.inf)},
    "tyre_relaxation": {"length": Bound("m", 0.0, 3.0, 0.0)},
    "roll_dynamics": {"gain": Bound("-", 0.0, 0.5, 0.0)},
    "yaw_inertia": {"ratio": Bound("-", 0.3, 3.0, 1.0)},
    "wheel_radius": {"ratio": Bound("-", 0.5, 1.5, 1.0)},
    "gyro_bias": {"b": Bound("rad/s", -0.2, 0.2, 0.0)},
    "yaw_rate_latency": {"T": Bound("s", 0.0, 0.9, 0.0)},
    "accelerometer_bias": {"b": Bound("m/s^2", -2.0, 2.0, 0.0)},
    "imu_misalignment": {"angle": Bound("rad", -0.5, 0.5, 0.0)},
    "pitch": {"gain": Bound("-", -0.5, 1.0, 0.0)},
    "roll": {"gain": Bound("-", -0.5, 1.0, 0.0)},
    "heading_bias": {"b": Bound("rad", -0.3, 0.3, 0.0)},
    "gnss_latency": {"T": Bound("s", 0.0, 0.9, 0.0)},
    "gnss_lever_arm": {"x": Bound("m", -5.0, 5.0, 0.0), "y": Bound("m", -5.0, 5.0, 0.0)},
    "detection_latency": {"T": Bound("s", 0.0, 2.0, 0.0)},
    "detection_offset": {"x": Bound("m", -5.0, 5.0, 0.0), "y": Bound("m", -5.0, 5.0, 0.0)},
    "detection_range": {"R": Bound("m", 1.0, math.inf, math.inf)},
    "detection_misses": {
        "rate": Bound("-", 0.0, 1.0, 0.0),
        "slope": Bound("1/m", 0.0, 1.0, 0.0),
        "pedestrian": Bound("-", 0.0, 1.0, 0.0),
        "bicycle": Bound("-", 0.0, 1.0, 0.0),
    },
    "detection_size": {"length_ratio": Bound("-", 0.1, 10.0, 1.0), "width_ratio": Bound("-", 0.1, 10.0, 1.0)},
    "detection_yaw": {"b": Bound("rad", -1.6, 1.6, 0.0)},
    "detection_occlusion": {"share": Bound("-", 0.0, 1.0, 1.0)},
    "detection_false": {"rate": Bound("1/s", 0.0, 10.0, 0.0)},
    "detection_noise": {"sigma0": Bound("m", 0.0, 2.0, 0.0), "slope": Bound("-", 0.0, 0.2, 0.0)},
}
"""Effects that can be hidden, by the catalogue's names. An effect left out, or with a key left out, is neutral."""

PERCEPTION = tuple(name for name in EFFECTS if name.startswith("detection_"))
"""Those of what it makes of its LiDAR and camera: only a car on a wire has these."""

SECTIONS = ("hidden", "car", "sensors", "reference")
NOISE_LEVELS = ("none", "low", "mid", "high")


class HiddenError(ValueError):
    """A file about hidden effects that cannot be used; one line, with file, line and the nearest name."""


@dataclass(frozen=True)
class Hidden:
    """A car, the effects hidden in it (name -> key -> value), the noise of its sensors, and its reference system."""

    car: Car = field(default_factory=Car)
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    noise: str = "mid"
    reference: Reference = field(default_factory=lambda: UNITS[USUAL])

    def value(self, name: str, key: str) -> float:
        """Value of a key; neutral if the effect is not hidden."""
        return self.effects.get(name, {}).get(key, EFFECTS[name][key].neutral)


def _near(name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, list(known), 1, 0.5)
    return f"; did you mean {close[0]}?" if close else f"; known: {', '.join(known)}"


def _line(text: str, word: str) -> int:
    for number, line in enumerate(text.splitlines(), 1):
        if re.search(rf"\b{re.escape(word)}\b", line):
            return number
    return 1


def _number(value: Any, what: str, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        raise HiddenError(f"{where}: {what} is {value!r}; a number is needed")
    return float(value)


def check_effects(given: Mapping[str, Any], file: str = "hidden", text: str = "") -> dict[str, dict[str, float]]:
    """The effects as numbers. Raises HiddenError on unknown names and keys and on values out of range."""
    effects: dict[str, dict[str, float]] = {}
    for name, keys in given.items():
        where = f"{file}:{_line(text, name)}"
        if name not in EFFECTS:
            raise HiddenError(f"{where}: no hidden effect {name!r}{_near(name, EFFECTS)}")
        if not isinstance(keys, Mapping):
            raise HiddenError(f"{where}: {name} needs a table of keys ({', '.join(EFFECTS[name])}), found {keys!r}")
        effects[name] = {}
        for key, raw in keys.items():
            if key not in EFFECTS[name]:
                raise HiddenError(f"{where}: {name} has no key {key!r}{_near(key, EFFECTS[name])}")
            bound = EFFECTS[name][key]
            value = _number(raw, f"{name}.{key}", where)
            if not bound.low <= value <= bound.high:
                allowed = f"{bound.low:g} to {bound.high:g} {bound.unit}"
                raise HiddenError(f"{where}: {name}.{key} = {value:g} is out of range, allowed is {allowed}")
            effects[name][key] = value
    return effects


def read_hidden(path: Path) -> Hidden:
    """Read a file of hidden effects. Raises HiddenError with file and line."""
    try:
        data, text = read_toml(path)
    except TomlError as error:
        text = f"cannot be read: {error}" if error.kind == "unreadable" else str(error)
        raise HiddenError(f"{error.at(path)}: {text}") from None
    for section, content in data.items():
        if section not in SECTIONS:
            raise HiddenError(f"{path}:{_line(text, section)}: no section {section!r}{_near(section, SECTIONS)}")
        if not isinstance(content, Mapping):
            raise HiddenError(f"{path}:{_line(text, section)}: {section} must be a table, as in [{section}]")
    numbers: dict[str, float] = {}
    known = [f.name for f in fields(Car)]
    for name, raw in data.get("car", {}).items():
        where = f"{path}:{_line(text, name)}"
        if name not in known:
            raise HiddenError(f"{where}: the car has no {name!r}{_near(name, known)}")
        numbers[name] = _number(raw, f"car.{name}", where)
        if math.isinf(numbers[name]):
            raise HiddenError(f"{where}: car.{name} is {raw!r}; a finite number is needed")
    sensors = data.get("sensors", {})
    for name in sensors:
        if name != "noise":
            raise HiddenError(f"{path}:{_line(text, name)}: sensors have no {name!r}; known: noise")
    noise = sensors.get("noise", "mid")
    if noise not in NOISE_LEVELS:
        where = f"{path}:{_line(text, 'noise')}"
        raise HiddenError(f"{where}: noise is {noise!r}; known: {', '.join(NOISE_LEVELS)}")
    try:
        reference = reference_of(data.get("reference", {}))
    except ValueError as error:
        raise HiddenError(f"{path}:{_line(text, 'reference')}: {error}") from error
    try:
        car = Car(**numbers)
    except ValueError as error:
        raise HiddenError(f"{path}:{_line(text, 'car')}: {error}") from error
    return Hidden(car, check_effects(data.get("hidden", {}), str(path), text), noise, reference)
