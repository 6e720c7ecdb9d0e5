"""The signal table: unit, frame and meaning of every column a Log may have.

Names carry no unit; this table does. Frames: "map" is that of the OpenDRIVE file, "body" has x forward and y left at
the reference point (ground point under the middle of the rear axle).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType


@dataclasses.dataclass(frozen=True, slots=True)
class Signal:
    """One column: name, SI unit ("-" for none), frame ("map", "body", "wheel" or ""), meaning.

    `held` marks a quantity that keeps its value between two ticks of the driving stack (a command, an ADS internal);
    it is stored once per change.
    """

    name: str
    unit: str
    frame: str
    meaning: str
    keeps_value: bool = False


_EGO = (
    Signal("t", "s", "", "time since the start of the run"),
    Signal("x", "m", "map", "position of the reference point"),
    Signal("y", "m", "map", "position of the reference point"),
    Signal("z", "m", "map", "height of the reference point"),
    Signal("yaw", "rad", "map", "heading, counter-clockwise from the map's x axis, not wrapped"),
    Signal("v", "m/s", "body", "signed speed along the body's x axis"),
    Signal("vx", "m/s", "body", "longitudinal velocity of the reference point"),
    Signal("vy", "m/s", "body", "lateral velocity of the reference point"),
    Signal("yaw_rate", "rad/s", "body", "turn rate about the vertical axis"),
    Signal("ax", "m/s^2", "body", "longitudinal specific force at the reference point, gravity on slopes included"),
    Signal("ay", "m/s^2", "body", "lateral specific force at the reference point, gravity on slopes included"),
    Signal("steer", "rad", "body", "mean road-wheel angle, positive to the left"),
    Signal("wheel_speed_fl", "m/s", "wheel", "circumferential speed of the front left wheel"),
    Signal("wheel_speed_fr", "m/s", "wheel", "circumferential speed of the front right wheel"),
    Signal("wheel_speed_rl", "m/s", "wheel", "circumferential speed of the rear left wheel"),
    Signal("wheel_speed_rr", "m/s", "wheel", "circumferential speed of the rear right wheel"),
    Signal("motor_current", "A", "", "current of the drive motor, negative while it recuperates"),
    Signal("brake_pressure", "Pa", "", "pressure in the brakes"),
    Signal("gear", "-", "", "-1 reverse, 0 neutral, 1 and up forward"),
)
_COMMANDS = (
    Signal("steer_cmd", "rad", "body", "wanted road-wheel angle", keeps_value=True),
    Signal("accel_cmd", "m/s^2", "body", "wanted longitudinal acceleration", keeps_value=True),
    Signal("throttle_cmd", "-", "", "wanted throttle pedal, 0 to 1", keeps_value=True),
    Signal("brake_cmd", "-", "", "wanted brake pedal, 0 to 1", keeps_value=True),
    Signal("speed_cmd", "m/s", "body", "wanted speed", keeps_value=True),
    Signal("engaged", "-", "", "1 while the car obeys its commands, 0 while somebody else drives", keeps_value=True),
)
_WORLD = (
    Signal("on_road", "-", "", "1 while all corners of the ego's box are on a drivable lane, else 0", keeps_value=True),
    Signal("lane_width", "m", "", "width of the lane under the reference point", keeps_value=True),
    Signal("speed_limit", "m/s", "", "speed limit of the lane under the reference point", keeps_value=True),
    Signal("command_age", "s", "", "time of the tick minus the stamp of the stack's command", keeps_value=True),
)
_REFERENCE = (
    Signal(
        "position_sigma", "m", "map",
        "standard deviation of x and of y, as the system that measured them states it", keeps_value=True,
    ),
)  # fmt: skip
_MIRROR = (
    Signal(
        "mirror_error",
        "m",
        "map",
        "distance of the pose shown in the simulator from the measured one",
        keeps_value=True,
    ),
    Signal(
        "mirror_latency", "s", "", "age of the measurement that the shown pose is extrapolated from", keeps_value=True
    ),
)
_GATE = (
    Signal("gate.steer_cmd", "rad", "body", "road-wheel angle that the command gate let out", keeps_value=True),
    Signal("gate.accel_cmd", "m/s^2", "body", "acceleration that the command gate let out", keeps_value=True),
    Signal("gate.throttle_cmd", "-", "", "throttle pedal that the command gate let out", keeps_value=True),
    Signal("gate.brake_cmd", "-", "", "brake pedal that the command gate let out", keeps_value=True),
)
_ARRIVED = (
    Signal("arrived.steer_cmd", "rad", "body", "road-wheel angle that has reached the car", keeps_value=True),
    Signal("arrived.accel_cmd", "m/s^2", "body", "acceleration that has reached the car", keeps_value=True),
    Signal("arrived.throttle_cmd", "-", "", "throttle pedal that has reached the car", keeps_value=True),
    Signal("arrived.brake_cmd", "-", "", "brake pedal that has reached the car", keeps_value=True),
)
_REPLAY = (
    Signal(
        "replay.steer_cmd", "rad", "body", "road-wheel angle asked for when the recording was made", keeps_value=True
    ),
    Signal("replay.accel_cmd", "m/s^2", "body", "acceleration asked for when the recording was made", keeps_value=True),
)
_ADS = (
    Signal("ads.x", "m", "map", "position as the ADS estimates it", keeps_value=True),
    Signal("ads.y", "m", "map", "position as the ADS estimates it", keeps_value=True),
    Signal("ads.yaw", "rad", "map", "heading as the ADS estimates it", keeps_value=True),
    Signal("ads.v", "m/s", "body", "speed as the ADS estimates it", keeps_value=True),
    Signal("ads.path_error", "m", "body", "lateral offset to its path as the ADS sees it", keeps_value=True),
    Signal("ads.target_speed", "m/s", "body", "speed the ADS aims at", keeps_value=True),
    Signal("ads.lane_width", "m", "", "width of its lane as the ADS takes the map to say", keeps_value=True),
    Signal("ads.age_gnss", "s", "", "age of the newest GNSS message that the ADS got", keeps_value=True),
    Signal("ads.age_odometry", "s", "", "age of the newest odometry message that the ADS got", keeps_value=True),
    Signal("ads.age_imu", "s", "", "age of the newest IMU message that the ADS got", keeps_value=True),
    Signal("ads.age_lidar", "s", "", "age of the newest LiDAR scan that the ADS got", keeps_value=True),
    Signal("ads.age_camera", "s", "", "age of the newest camera frame that the ADS got", keeps_value=True),
    Signal("ads.disordered", "-", "", "messages so far that were not newer than those before", keeps_value=True),
    Signal("ads.nis_gnss", "-", "", "normalised squared innovation of its GNSS positions", keeps_value=True),
    Signal("ads.nis_heading", "-", "", "normalised squared innovation of its GNSS headings", keeps_value=True),
    Signal("ads.nis_wheels", "-", "", "normalised squared innovation of its wheel speeds", keeps_value=True),
    Signal("ads.solve_time", "s", "", "CPU time of its solver; only recorded when asked for", keeps_value=True),
)

SIGNALS: Mapping[str, Signal] = MappingProxyType(
    {s.name: s for s in _EGO + _COMMANDS + _WORLD + _REFERENCE + _MIRROR + _GATE + _ARRIVED + _REPLAY + _ADS}
)
"""Every known column by name, in the order in which a table shows them."""

COMMAND_COLUMNS = ("steer_cmd", "accel_cmd", "throttle_cmd", "brake_cmd")
"""The columns that a Command fills, in the order of its fields."""


def describe(name: str) -> Signal:
    """The entry of a column; an unlisted `ads.*` or `*_cmd` column is held, any other one is measured, unit unknown.

    Places of the Petri nets (`ads.net.<net>.<place>`) are 0 or 1.
    """
    known = SIGNALS.get(name)
    if known is not None:
        return known
    if name.startswith("ads.net."):
        return Signal(name, "-", "", "1 while this place of the Petri net holds the token, else 0", keeps_value=True)
    if name.startswith("ads."):
        return Signal(name, "?", "", "internal quantity of the ADS", keeps_value=True)
    return Signal(name, "?", "", "unlisted column", keeps_value=name.endswith("_cmd"))
