"""What crosses the plug between a vehicle and a driving stack: SI units, frozen, serialisable.

Frames follow ISO 8855 and REP-103: x forward, y left, z up, yaw counter-clockwise. The map frame is that of the
OpenDRIVE file. A vehicle's reference point is the ground point under the middle of its rear axle.
Every message carries `t`, the time [s] at which the quantity was true at its source (not when it arrived).
"""

from __future__ import annotations

import re
from typing import Literal, NamedTuple, TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]

ObjectKind: TypeAlias = Literal["vehicle", "pedestrian", "bicycle", "misc"]
OBJECT_KINDS: tuple[ObjectKind, ...] = ("vehicle", "pedestrian", "bicycle", "misc")

TICK = 0.05  # s, period at which a run asks its stack (20 Hz); until the next one a stack's answer holds

TRACE_COLUMNS: tuple[str, ...] = ("t", "x", "y", "z", "yaw", "v", "vx", "vy", "yaw_rate", "ax", "ay", "steer")
"""Columns of the rows that `Vehicle.step` returns; units and meaning as in VehicleState."""


class RoadPoint(NamedTuple):
    """A place on the map: OpenDRIVE road id, lane id (sign as in the file) and s [m] along the reference line."""

    road: str
    lane: int
    s: float


class VehicleDescription(msgspec.Struct, frozen=True):
    """What a driving stack may know of its own car. Lengths [m], angles [rad], mass [kg]."""

    length: float
    width: float
    height: float
    wheelbase: float
    center_x: float  # from the rear axle forward to the middle of the bounding box
    max_steer: float  # at the road wheel
    max_speed: float  # m/s
    max_acceleration: float  # m/s^2, at low speed
    max_deceleration: float  # m/s^2, positive
    mass: float
    steer_delay: float = 0.0  # s, as the data sheet or an identification says
    drive_delay: float = 0.0
    gnss_x: float = 0.0  # antenna ahead of the reference point
    imu_x: float = 0.0
    lidar_x: float = 0.0
    lidar_z: float = 1.5
    camera_x: float = 0.0
    camera_z: float = 1.4
    camera_focal: float = 800.0  # px
    camera_width: int = 1280  # px
    camera_height: int = 720  # px
    gnss_y: float = 0.0  # antenna left of the middle
    lidar_y: float = 0.0
    lidar_yaw: float = 0.0  # of its x axis, counter-clockwise from ahead
    camera_y: float = 0.0
    camera_yaw: float = 0.0
    imu_y: float = 0.0
    imu_yaw: float = 0.0


class VehicleState(msgspec.Struct, frozen=True):
    """Motion of the reference point. Position [m], angles [rad], speeds [m/s], ax/ay specific force [m/s^2].

    `v` is the signed speed along the body's x axis (equal to `vx`); `steer` the mean road-wheel angle.
    `position_sigma` is the standard deviation of x and of y as whoever measured them states it; 0: not stated.
    """

    t: float
    x: float
    y: float
    yaw: float
    v: float
    z: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    yaw_rate: float = 0.0
    ax: float = 0.0
    ay: float = 0.0
    steer: float = 0.0
    position_sigma: float = 0.0


class GnssFix(msgspec.Struct, frozen=True):
    """Antenna position in the map frame [m] with its standard deviation; heading [rad] if the receiver has one."""

    t: float
    x: float
    y: float
    sigma: float
    yaw: float | None = None
    yaw_sigma: float = 0.0


class Odometry(msgspec.Struct, frozen=True):
    """Speed from the wheels [m/s] and the reported road-wheel angle [rad]."""

    t: float
    v: float
    steer: float


class Imu(msgspec.Struct, frozen=True):
    """Specific force [m/s^2] and yaw rate [rad/s] at the sensor, in its mounting frame."""

    t: float
    ax: float
    ay: float
    yaw_rate: float


class LidarScan(msgspec.Struct, frozen=True):
    """Point cloud in the sensor frame: float64 array (n, 3) of x, y, z [m]; ground returns may be included."""

    t: float
    points: FloatArray


class CameraBox(msgspec.Struct, frozen=True):
    """A detector's box in the image [px] (u right, v down), its class and score in [0, 1]."""

    u_min: float
    v_min: float
    u_max: float
    v_max: float
    kind: ObjectKind
    score: float


class CameraFrame(msgspec.Struct, frozen=True):
    t: float
    boxes: tuple[CameraBox, ...]


class Reading(msgspec.Struct, frozen=True):
    """What a sensor without a message of its own measured; its file says what each of `values` is, and its unit."""

    t: float
    values: tuple[float, ...]


LAMPS = ("red", "amber", "green")  # from top to bottom
_ON, _OFF, _FLASHES = ("on", "true", "1"), ("off", "false", "0", "dark"), ("flashing", "blinking")
_COLOURS = {"red": "red", "amber": "amber", "yellow": "amber", "orange": "amber", "green": "green"}  # in any word
_ORDERS = {"stop": "red", "go": "green"}  # words by themselves


def lit_lamps(state: str) -> frozenset[str]:
    """Which of LAMPS a driver has to heed in the state of a traffic signal: "red", "red;amber", "yellow", "stop", or
    "on;off;off", lamps from top to bottom. Of two lamps without names only the upper one is known: it is red.

    Of lamps that flash, red stops as well, and amber asks for care alone, so it is none here (Vienna Convention on Road
    Signs 1968, art. 23, 1 b).
    """
    lamps = _lamps(state)
    names = LAMPS[:1] if len(lamps) == 2 else (*LAMPS, *LAMPS[2:] * (len(lamps) - 3))
    if _are_places(lamps):
        lit = [(name, lamp in _FLASHES) for name, lamp in zip(names, lamps, strict=False) if lamp not in _OFF]
    else:
        lit = [(name, _flashes(lamp)) for lamp in lamps for name in _named(lamp)]
    return frozenset(name for name, flashes in lit if name != "amber" or not flashes)


def is_known_state(state: str) -> bool:
    """Whether the state of a traffic signal says which lamps are lit, or that none is."""
    lamps = _lamps(state)
    return _are_places(lamps) or all(lamp in _OFF or _flashes(lamp) or _named(lamp) for lamp in lamps)


def _lamps(state: str) -> list[str]:
    return [lamp.strip() for lamp in state.strip().lower().rstrip("; ").split(";")]


def _are_places(lamps: list[str]) -> bool:
    """Whether lamps are told by their places, from top to bottom, and not by their colours."""
    return len(lamps) >= 2 and all(lamp in _ON + _OFF + _FLASHES for lamp in lamps)


def _named(lamp: str) -> set[str]:
    """The lamps that a word names: a colour anywhere in it, as in "TrafficLight_Red"; "stop" and "go" by themselves."""
    words = re.findall("[a-z]+", lamp)
    colours = {name for word, name in _COLOURS.items() if word in lamp}
    return colours | {name for word, name in _ORDERS.items() if word in words}


def _flashes(lamp: str) -> bool:
    return "flash" in lamp or "blink" in lamp


class SignalState(msgspec.Struct, frozen=True):
    """State of a traffic signal of the map, by its OpenDRIVE id: "red", "amber", "green" or the file's own word, of
    which `lit_lamps` makes lamps."""

    id: str
    state: str


class Task(msgspec.Struct, frozen=True):
    """What the ego is asked to do. Without goal and route it keeps its lane."""

    set_speed: float | None = None  # m/s; overrides LQR_v_max
    goal: RoadPoint | None = None
    route: tuple[RoadPoint, ...] = ()


class Observation(msgspec.Struct, frozen=True):
    """All that arrived since the last tick, oldest first. `t` [s] is the time of the tick."""

    t: float
    gnss: tuple[GnssFix, ...] = ()
    odometry: tuple[Odometry, ...] = ()
    imu: tuple[Imu, ...] = ()
    lidar: LidarScan | None = None
    camera: CameraFrame | None = None
    signals: tuple[SignalState, ...] = ()
    task: Task | None = None  # set when it is new
    readings: dict[str, tuple[Reading, ...]] = {}  # of further sensors, by the name of their file


class Command(msgspec.Struct, frozen=True):
    """What the stack asks of the vehicle.

    `steer` road-wheel angle [rad]; `accel` the wanted acceleration [m/s^2] that the pedals are meant to produce;
    `throttle` and `brake` in [0, 1]. Which of `accel` or the pedals drives a vehicle, its model file says in [inputs]:
    the default car, scenarios/models/tabby_evo.toml, is driven by the pedals and ignores `accel`. A brake wins over
    traction of either kind (`brake_first`).
    """

    t: float
    steer: float
    accel: float
    throttle: float
    brake: float


def brake_first(command: Command, max_deceleration: float) -> Command:
    """The command with its brake before all traction, as what carries or obeys only a part of it must see it.

    While the brake is asked for there is no throttle, and the acceleration is at most that of the brake, of which 1
    stands for `max_deceleration` [m/s^2, > 0]. A harder deceleration stays. Without a brake the command is unchanged.
    """
    if command.brake <= 0.0:
        return command
    braking = -min(command.brake, 1.0) * max_deceleration
    return msgspec.structs.replace(command, accel=min(command.accel, braking), throttle=0.0)


class Detection(msgspec.Struct, frozen=True):
    """An oriented box that a perception reports, in the map frame: centre [m], yaw [rad], size [m], velocity [m/s]."""

    t: float
    kind: ObjectKind
    x: float
    y: float
    yaw: float
    length: float
    width: float
    vx: float
    vy: float
    score: float = 1.0
    position_variance: float = 0.0  # m^2, along the axis that is less sure
    track: int = -1
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m^2, of the centre: xx, xy, yy


class Light(msgspec.Struct, frozen=True):
    """Light of the sun: where it stands (clockwise from +y; above the horizon) [rad], and how much falls on a surface
    that faces it, straight from it, and on the road [lx]."""

    azimuth: float
    elevation: float
    direct: float
    on_road: float


SEEING = ("lidar", "camera")  # sensors that see what is around, as scenarios name them


class Surroundings(msgspec.Struct, frozen=True):
    """Everything around the vehicle that its sensors could meet, in the map frame.

    `boxes` is a float64 array (n, 9): centre x, y, z [m], yaw [rad], length, width, height [m], vx, vy [m/s];
    `kinds` an int64 array (n,) of indices into OBJECT_KINDS; `names` the n names. `hidden` names those that a scenario
    hides from sensors (of SEEING); to everything else they are there. `extinction` [1/m] is that of the air: the share
    of light that a metre of fog or rain takes away. `light`: of the sun; None: broad daylight without glare.
    """

    boxes: FloatArray
    kinds: NDArray[np.int64]
    names: tuple[str, ...]
    signals: tuple[SignalState, ...] = ()
    hidden: dict[str, frozenset[str]] = {}
    extinction: float = 0.0
    light: Light | None = None

    def seen_by(self, sensor: str) -> Surroundings:
        """Without what is hidden from that sensor."""
        unseen = self.hidden.get(sensor)
        if not unseen:
            return self
        keep = np.array([name not in unseen for name in self.names], dtype=bool)
        names = tuple(name for name in self.names if name not in unseen)
        return Surroundings(
            self.boxes[keep], self.kinds[keep], names, self.signals, extinction=self.extinction, light=self.light
        )


def no_surroundings() -> Surroundings:
    """An empty world."""
    return Surroundings(boxes=np.zeros((0, 9)), kinds=np.zeros(0, dtype=np.int64), names=())
