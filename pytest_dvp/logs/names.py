"""Column names: header text -> name and unit; common other names of the signals."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from pytest_dvp.logs.units import LETTERS, SUFFIXES
from pytest_dvp.signals import SIGNALS

_ALIASES = {
    "t": "time timestamp timestamps stamp elapsed_time",
    "x": "pos_x position_x x_pos east easting px",
    "y": "pos_y position_y y_pos north northing py",
    "z": "pos_z position_z z_pos altitude",
    "yaw": "heading psi yaw_angle theta orientation_yaw heading_angle",
    "v": "speed velocity vehicle_speed ego_speed velo veh_speed",
    "vx": "v_x vel_x velocity_x longitudinal_velocity v_long vlon",
    "vy": "v_y vel_y velocity_y lateral_velocity v_lat vlat",
    "yaw_rate": "yawrate psi_dot psidot gyro_z wz omega_z angular_velocity_z yaw_velocity",
    "ax": "a_x acc_x accel_x acceleration_x longitudinal_acceleration a_long along imu_ax",
    "ay": "a_y acc_y accel_y acceleration_y lateral_acceleration a_lat alat imu_ay",
    "steer": "steering steering_angle delta road_wheel_angle wheel_angle front_wheel_angle steer_angle",
    "steer_cmd": "steering_cmd steer_command steering_command delta_cmd steer_request steering_angle_cmd",
    "accel_cmd": "acc_cmd acceleration_cmd accel_command acceleration_command ax_cmd a_cmd accel_request",
    "throttle_cmd": "throttle_command gas_cmd accelerator_cmd throttle_request",
    "brake_cmd": "brake_command brake_request",
    "speed_cmd": "v_cmd speed_command velocity_cmd target_velocity_cmd speed_request",
    "wheel_speed_fl": "wheel_fl wheelspeed_fl ws_fl",
    "wheel_speed_fr": "wheel_fr wheelspeed_fr ws_fr",
    "wheel_speed_rl": "wheel_rl wheelspeed_rl ws_rl",
    "wheel_speed_rr": "wheel_rr wheelspeed_rr ws_rr",
}

ALIASES: Mapping[str, str] = MappingProxyType(
    {other: name for name, others in _ALIASES.items() for other in others.split()}
)
"""Other name -> name of the signal table. Hand-wheel angles are none: they need a ratio, so a mapping."""

_BRACKETED = re.compile(r"^\s*(?P<name>.*?)\s*[\[(<](?P<unit>[^\])>]*)[\])>]\s*$")


class Header(NamedTuple):
    """A column's header: its own `text`, `name` without unit, and `unit` (None: a bare name)."""

    text: str
    name: str
    unit: str | None


def parse_header(text: str) -> Header:
    """`v [m/s]`, `v (m/s)` or `v_mps` -> name and unit. A name alone has unit None."""
    bracketed = _BRACKETED.match(text)
    if bracketed is not None and bracketed["name"]:
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


def canonical(name: str) -> str:
    """The signal that `name` means, or `name` itself."""
    if name in SIGNALS:
        return name
    word = re.sub(r"[\s.\-/]+", "_", name.strip()).lower().strip("_")
    if word in SIGNALS and word == name.lower():
        return word
    return ALIASES.get(word, name)
