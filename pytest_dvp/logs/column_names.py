"""Column names: header text -> name and unit; common other names of the signals."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.units import LETTERS, SUFFIXES

_ASKED = "cmd command commanded request requested req setpoint demand demanded"
"""What says that a quantity is asked for, not measured; before its name or behind it."""

_ALIASES = {
    "t": "time timestamp timestamps stamp elapsed_time time_stamp",
    "x": "pos_x position_x x_pos x_position east easting px",
    "y": "pos_y position_y y_pos y_position north northing py",
    "z": "pos_z position_z z_pos z_position altitude",
    "yaw": "heading psi yaw_angle theta orientation_yaw heading_angle",
    "v": "speed velocity vehicle_speed ego_speed velo veh_speed vehicle_velocity car_speed",
    "vx": "v_x vel_x velocity_x longitudinal_velocity v_long vlon longitudinal_speed",
    "vy": "v_y vel_y velocity_y lateral_velocity v_lat vlat lateral_speed",
    "yaw_rate": "psi_dot gyro_z wz omega_z angular_velocity_z yaw_velocity heading_rate turn_rate rate_of_yaw",
    "ax": "a_x acc_x accel_x acceleration_x longitudinal_acceleration a_long imu_ax long_accel longitudinal_accel",
    "ay": "a_y acc_y accel_y acceleration_y lateral_acceleration a_lat imu_ay lat_accel lateral_accel",
    "steer": "steering steering_angle delta road_wheel_angle wheel_angle front_wheel_angle steer_angle",
    "steer_cmd": "",
    "accel_cmd": "",
    "throttle_cmd": "",
    "brake_cmd": "",
    "speed_cmd": "target_velocity_cmd",
    "wheel_speed_fl": "wheel_fl ws_fl front_left_wheel_speed",
    "wheel_speed_fr": "wheel_fr ws_fr front_right_wheel_speed",
    "wheel_speed_rl": "wheel_rl ws_rl rear_left_wheel_speed",
    "wheel_speed_rr": "wheel_rr ws_rr rear_right_wheel_speed",
    "position_sigma": "position_std pos_std pos_sigma position_stddev horizontal_accuracy",
}
_COMMANDED = {  # quantities that are commands with a word of _ASKED
    "steer_cmd": f"steer {_ALIASES['steer']}",
    "accel_cmd": "accel acc acceleration ax a",
    "throttle_cmd": "throttle gas accelerator",
    "brake_cmd": "brake",
    "speed_cmd": "speed v velocity vehicle_speed",
}


def _compact(name: str) -> str:
    """The letters and digits of a name: case, blanks, hyphens, underscores, dots and slashes do not matter."""
    return re.sub(r"[\s._/-]+", "", name).lower()


def _known() -> dict[str, str]:
    found = {other: name for name, others in _ALIASES.items() for other in others.split()}
    for name, quantities in _COMMANDED.items():
        pairs = [(what, asked) for what in quantities.split() for asked in _ASKED.split()]
        found |= {other: name for what, asked in pairs for other in (f"{what}_{asked}", f"{asked}_{what}")}
    return {other: name for other, name in found.items() if other not in SIGNALS}


ALIASES: Mapping[str, str] = MappingProxyType(_known())
"""Other name -> name of the signal table. Hand-wheel angles are none: they need a ratio, so a mapping."""

_SIGNAL_OF: Mapping[str, str] = MappingProxyType(
    {_compact(other): name for other, name in ALIASES.items()}
    | {_compact(name): name for name in SIGNALS if "." not in name}
)

ALIKE = 0.5  # of the words of a name must be usual ones to be taken for a signal's
_BRACKETED = re.compile(r"^\s*(?P<name>.*?)\s*[\[(<](?P<unit>[^\])>]*)[\])>]\s*$")
_SOURCES = frozenset({
    "imu", "ins", "gps", "gnss", "rtk", "can", "ecu", "ekf", "odom", "odometry", "vicon", "mocap", "optitrack",
    "lidar", "camera", "encoder", "sensor", "measured", "meas", "raw", "filtered", "filt", "smoothed", "estimated",
    "est", "estimate", "true", "truth", "ref", "left", "right", "front", "rear", "fl", "fr", "rl", "rr", "x", "y",
    "z", "body", "world", "global", "local", "map", "vehicle", "car",
})  # fmt: skip
"""Words in round brackets behind a name that are no unit."""


class Header(NamedTuple):
    """A column's header: its own `text`, `name` without unit, and `unit` (None: a bare name)."""

    text: str
    name: str
    unit: str | None


def parse_header(text: str) -> Header:
    """`v [m/s]`, `v (m/s)` or `v_mps` -> name and unit. A name alone has unit None."""
    bracketed = _BRACKETED.match(text)
    if bracketed is not None and bracketed["name"] and not _names_a_source(text, bracketed["unit"]):
        return Header(text, bracketed["name"].strip(), bracketed["unit"].strip() or "-")
    name = text.strip()
    for cut in (2, 1):  # `_m_s2` before `_s2`
        parts = name.rsplit("_", cut)
        if len(parts) != cut + 1:
            continue
        ending = "_".join(parts[1:]).lower()
        unit = SUFFIXES.get(ending)
        if unit is not None and parts[0] and (ending not in LETTERS or canonical(parts[0]) in SIGNALS):
            return Header(text, parts[0], unit)
    return Header(text, name, None)


def _names_a_source(text: str, inside: str) -> bool:
    """True for `acc x (IMU)`, `v (filtered)`: round brackets with where a value comes from, not its unit."""
    return text.rstrip().endswith(")") and inside.strip().lower() in _SOURCES


def canonical(name: str) -> str:
    """The signal that `name` means, or `name` itself."""
    return name if name in SIGNALS else _SIGNAL_OF.get(_compact(name), name)


def resembling(signal: str, names: Iterable[str]) -> str:
    """The name with most words in common with those of `signal`, by their beginnings; "" if there is none."""
    shared = {name: likeness(signal, name) for name in names}
    best = max(shared, key=lambda name: shared[name], default="")
    return best if best and shared[best] >= ALIKE else ""


def likeness(signal: str, name: str) -> float:
    """Share of the words of `name` that names of `signal` have, by their beginnings, 0..1."""
    usual = {word for known in (signal, *(o for o, s in ALIASES.items() if s == signal)) for word in _words(known)}
    return len(_words(name) & usual) / max(len(_words(name)), 1)


def _words(name: str) -> set[str]:
    """First four letters of each word, camel case taken apart; single letters tell nothing."""
    parts = re.split(r"[\W_]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower())
    return {word[:4] for word in parts if len(word) > 1}
