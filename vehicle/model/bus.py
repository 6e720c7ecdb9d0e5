"""The bus: every quantity of one simulation step, by name, that effects read and change.

One flat record of doubles in memory. The kernel fills it slot by slot; an effect gets it as `x`.
This module imports nothing heavy, so that model files can be checked without a compiler.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, NamedTuple, Protocol, get_args, get_type_hints

GRAVITY = 9.80665  # m/s^2, CGPM 1901
BLEND_TIME = 0.02  # s, time constant with which slip fades in the middle of the blend of `vehicle.model.kernel`


class Bus(Protocol):
    """Fields of the bus in the order of their place in memory. SI units; frames as in `vehicle.messages`."""

    # Time
    t: Annotated[float, "s", "at the start of the step; of a sensor, of the row"]
    t_start: Annotated[float, "s", "at reset"]
    count: Annotated[float, "-", "steps since reset (twin)"]
    dt: Annotated[float, "s", "length of the step"]

    # The car: constant during a run
    wheelbase: Annotated[float, "m", "front axle to rear axle"]
    cg_front: Annotated[float, "m", "centre of gravity to front axle"]
    cg_rear: Annotated[float, "m", "centre of gravity to rear axle"]
    cg_height: Annotated[float, "m", "centre of gravity above ground"]
    mass: Annotated[float, "kg", "as driven"]
    mass_ref: Annotated[float, "kg", "the mass for which commanded accelerations (and effects in m/s^2) hold"]
    yaw_inertia: Annotated[float, "kg m^2", "about z at the centre of gravity"]
    stiffness_front: Annotated[float, "N/rad", "cornering stiffness of the whole front axle"]
    stiffness_rear: Annotated[float, "N/rad", "cornering stiffness of the rear axle"]
    wheel_radius: Annotated[float, "m", "rolling radius"]
    gear_ratio: Annotated[float, "-", "motor turns per wheel turn"]
    full_throttle: Annotated[float, "m/s^2", "asked for by throttle 1"]
    full_brake: Annotated[float, "m/s^2", "asked for by brake 1"]
    steer_scale: Annotated[float, "rad", "at the road wheel per unit of the steering input"]
    steer_zero: Annotated[float, "rad", "at the road wheel at steering input 0"]
    track: Annotated[float, "m", "between the wheels of an axle"]
    ax_x: Annotated[float, "m", "point ahead of the rear axle whose ax is shown"]
    ay_x: Annotated[float, "m", "point ahead of the rear axle whose ay is shown"]
    slow: Annotated[float, "m/s", "kinematic below, tyres in full at twice that"]

    # What drives it: held from one command to the next
    steer_cmd: Annotated[float, "rad", "at the road wheel"]
    steer_slope: Annotated[float, "rad", "change of steer_cmd over the step, nought for a command that is held"]
    accel_cmd: Annotated[float, "m/s^2", "asked acceleration; that of an imposed speed"]
    throttle_cmd: Annotated[float, "-", "0..1"]
    brake_cmd: Annotated[float, "-", "0..1"]
    speed_cmd: Annotated[float, "m/s", "asked speed; speed_limit cuts it"]
    v_cmd: Annotated[float, "m/s", "imposed speed (inputs.longitudinal = 'v')"]
    speed_gain: Annotated[
        float,
        "-",
        "shown over true speed at the last row: an imposed speed is divided by it, a controller sees v times it",
    ]
    road_grade: Annotated[float, "rad", "of the world's road under the car, > 0 uphill"]
    road_bank: Annotated[float, "rad", "of the world's road, > 0 left side up"]
    road_friction: Annotated[float, "-", "coefficient of the world's road; 0: as much as the tyres need"]
    wind_x: Annotated[float, "m/s", "velocity of the world's air, along the world's x"]
    wind_y: Annotated[float, "m/s", "the same, along the world's y"]
    wind_drag: Annotated[float, "1/m", "force of the wind along, over mass_ref and squared speed"]
    wind_side: Annotated[float, "1/m", "the same across, over the sine of the angle of the air"]
    still_drag: Annotated[float, "1/m", "drag that the model has in still air, of which a tail wind takes away"]

    # Slots command and actuator: first the wish, after both the produced value (mean over the step)
    accel: Annotated[float, "m/s^2", "mean over the step"]
    steer: Annotated[float, "rad", "at the road wheel, mean over the step"]
    accel_lead: Annotated[float, "m/s^2", "value at the start of the step minus its mean: nought while it is constant"]
    steer_lead: Annotated[float, "rad", "the same; a gain may leave both alone: half a step is lost in what is logged"]
    steer_glides: Annotated[float, "-", "1 if the angle moves on straight within the step, 0 if it jumps"]
    accel_jump: Annotated[float, "m/s^2", "accel_lead as a dead time made it: nought where none did"]
    accel_arrived: Annotated[float, "m/s^2", "value that the dead time lets through by the end of the step"]
    accel_brakes: Annotated[float, "m/s^2", "<= 0: only below it brakes come in, down to it a motor slows the car"]
    settle: Annotated[float, "-", "1 in the long steps that bring actuators to rest before a log begins, else 0"]

    # Slot force
    traction: Annotated[float, "N", "along the wheels, >= 0 drives forward"]
    brake: Annotated[float, "N", ">= 0, opposes motion and holds at standstill"]
    resistance: Annotated[float, "N", ">= 0, opposes motion and holds at standstill (dry friction)"]
    drive_drag: Annotated[float, "N", "part of resistance with which the drive holds its wheels back"]
    drag: Annotated[float, "N", "along x, signed, depends smoothly on speed"]
    push: Annotated[
        float,
        "N",
        "of wind and steered_pull across, at the centre of gravity, > 0 to the left",
    ]
    steered_pull: Annotated[float, "N", "part of push that steered wheels make which drive or brake"]
    rotating_mass: Annotated[float, "kg", "that turning parts add to the mass"]

    # Slot body
    curvature: Annotated[float, "1/m", "of the kinematic path; in the slot force that of the path driven now"]
    slip_front: Annotated[float, "rad", "slip angle of the front axle"]
    slip_rear: Annotated[float, "rad", "slip angle of the rear axle"]
    fy_front: Annotated[float, "N", "lateral force of the front axle"]
    fy_rear: Annotated[float, "N", "lateral force of the rear axle"]
    tangent_front: Annotated[float, "N/rad", "slope of fy_front over slip_front"]
    tangent_rear: Annotated[float, "N/rad", "slope of fy_rear over slip_rear"]
    load_front: Annotated[float, "-", "load of the front axle over its static one, as far as tyre forces follow it"]
    load_rear: Annotated[float, "-", "the same of the rear axle"]
    tyre_limit: Annotated[float, "m/s^2", "what tyres hold across over mass where the road cuts side forces, else inf"]
    fy_front_lead: Annotated[float, "N", "fy_front at the start of the step minus what mean and steer_lead give for it"]
    fy_rear_lead: Annotated[float, "N", "fy_rear at the start of the step minus its mean"]
    yaw_moment: Annotated[float, "N m", "added"]
    turning_inertia: Annotated[float, "kg m^2", "about z"]
    slip_change_front: Annotated[float, "rad", "by which motion alone changed slip_front in the last step"]
    slip_change_rear: Annotated[float, "rad", "the same of the rear axle"]
    lean_y: Annotated[float, "m/s^2", "that a leaning body adds to what its accelerometer shows across"]

    # Slot road
    grade: Annotated[float, "rad", "> 0 uphill"]
    bank: Annotated[float, "rad", "> 0 left side up"]

    # Motion, after integration
    x: Annotated[float, "m", "of the rear axle"]
    y: Annotated[float, "m", "of the rear axle"]
    z: Annotated[float, "m", "of the ground"]
    yaw: Annotated[float, "rad", "unwrapped"]
    vx: Annotated[float, "m/s", "along the body"]
    vy: Annotated[float, "m/s", "at the centre of gravity"]
    vy_rear: Annotated[float, "m/s", "at the rear axle"]
    yaw_rate: Annotated[float, "rad/s", "counter-clockwise"]
    ax: Annotated[float, "m/s^2", "specific force along, at the rear axle"]
    ay: Annotated[float, "m/s^2", "specific force across"]

    # A replay may put the car elsewhere: where it was before, for sensors that show the past
    moved: Annotated[float, "-", "1 in the first sensor call after that, else 0"]
    old_x: Annotated[float, "m", "rear axle, before"]
    old_y: Annotated[float, "m", "before"]
    old_yaw: Annotated[float, "rad", "before"]
    old_vx: Annotated[float, "m/s", "before"]

    # Slot sensor: what a log of this car would show
    meas_x: Annotated[float, "m", "shown position"]
    meas_y: Annotated[float, "m", "shown position"]
    meas_yaw: Annotated[float, "rad", "shown heading"]
    meas_v: Annotated[float, "m/s", "shown speed"]
    meas_yaw_rate: Annotated[float, "rad/s", "shown yaw rate"]
    meas_ax: Annotated[float, "m/s^2", "shown by the accelerometer along"]
    meas_ay: Annotated[float, "m/s^2", "shown across"]


BUS_FIELDS: tuple[str, ...] = tuple(Bus.__annotations__)


class BusField(NamedTuple):
    """One field of the bus as a table shows it."""

    name: str
    unit: str
    meaning: str


_GROUPS: Mapping[str, str] = {  # first field of a group -> its title
    "t": "time, to be read",
    "wheelbase": "the car, constant during a run, to be read",
    "steer_cmd": "what drives it, held from one command to the next, to be read",
    "accel": "changed in the slots command and actuator: first the wish, after both what is produced",
    "traction": "changed in the slot force",
    "curvature": "changed in the slot body (forces and slip of a car with tyres only)",
    "grade": "changed in the slot road",
    "x": "motion at the start of the step, to be read",
    "moved": "where the car was before a replay put it elsewhere, to be read by sensors that show the past",
    "meas_x": "changed in the slot sensor: what a log of this car would show",
}


def bus_table() -> dict[str, list[BusField]]:
    """The fields by group, in the order of the slots: title -> fields, each with unit and meaning."""
    hints = get_type_hints(Bus, include_extras=True)
    found: dict[str, list[BusField]] = {}
    title = ""
    for name in BUS_FIELDS:
        title = _GROUPS.get(name, title)
        _, unit, meaning = get_args(hints[name])
        found.setdefault(title, []).append(BusField(name, unit, meaning))
    return found
