"""The bus: every quantity of one simulation step, by name, that effects read and change.

One flat record of doubles in memory. The kernel fills it slot by slot; an effect gets it as `x`.
This module imports nothing heavy, so that model files can be checked without a compiler.
"""

from __future__ import annotations

from typing import Protocol

GRAVITY = 9.80665  # m/s^2, CGPM 1901


class Bus(Protocol):
    """Fields of the bus in the order of their place in memory. SI units; frames as in `vehicle.messages`."""

    # Time
    t: float  # s, at the start of the step
    t_start: float  # s, at reset
    count: float  # steps since reset
    dt: float  # s, length of the step

    # The car: constant during a run
    wheelbase: float  # m
    cg_front: float  # m, centre of gravity to front axle
    cg_rear: float  # m, centre of gravity to rear axle
    cg_height: float  # m
    mass: float  # kg
    mass_ref: float  # kg, the mass for which commanded accelerations (and effects in m/s^2) hold
    yaw_inertia: float  # kg m^2
    stiffness_front: float  # N/rad, cornering stiffness of the whole axle
    stiffness_rear: float  # N/rad
    wheel_radius: float  # m
    gear_ratio: float  # motor turns per wheel turn
    full_throttle: float  # m/s^2 asked for by throttle 1
    full_brake: float  # m/s^2 asked for by brake 1
    steer_scale: float  # rad at the road wheel per unit of the steering input
    steer_zero: float  # rad at the road wheel at steering input 0
    track: float  # m, between the wheels of an axle
    ax_x: float  # m, point ahead of the rear axle whose ax is shown
    ay_x: float  # m, the same of ay
    slow: float  # m/s, kinematic below, tyres in full at twice that

    # What drives it: held from one command to the next
    steer_cmd: float  # rad at the road wheel
    steer_slope: float  # change of steer_cmd over the step, nought for a command that is held
    accel_cmd: float  # m/s^2
    throttle_cmd: float  # 0..1
    brake_cmd: float  # 0..1
    speed_cmd: float  # m/s
    v_cmd: float  # m/s, imposed speed (inputs.longitudinal = "v")
    road_grade: float  # rad, of the world's road under the car, > 0 uphill
    road_bank: float  # rad, of the world's road, > 0 left side up

    # Slots command and actuator: first the wish, after both the produced value (mean over the step)
    accel: float  # m/s^2
    steer: float  # rad
    accel_lead: float  # m/s^2, value at the start of the step minus its mean: nought while it is constant
    steer_lead: float  # rad, the same; a gain may leave both alone at the price of half a step in what is logged
    settle: float  # 1 in the long steps that bring actuators to rest before a log begins, else 0

    # Slot force
    traction: float  # N along the wheels, >= 0 drives forward
    brake: float  # N, >= 0, opposes motion and holds at standstill
    resistance: float  # N, >= 0, opposes motion and holds at standstill (dry friction)
    drag: float  # N along x, signed, depends smoothly on speed
    rotating_mass: float  # kg that turning parts add to the mass

    # Slot body
    curvature: float  # 1/m of the kinematic path of the rear axle
    slip_front: float  # rad, slip angle of the axle
    slip_rear: float  # rad
    fy_front: float  # N, lateral force of the axle
    fy_rear: float  # N
    tangent_front: float  # N/rad, slope of fy_front over slip_front
    tangent_rear: float  # N/rad
    yaw_moment: float  # N m, added
    turning_inertia: float  # kg m^2 about z
    slip_change_front: float  # rad, by which motion alone changed the slip angle in the last step
    slip_change_rear: float  # rad
    lean_y: float  # m/s^2 that a leaning body adds to what its accelerometer shows across

    # Slot road
    grade: float  # rad, > 0 uphill
    bank: float  # rad, > 0 left side up

    # Motion, after integration
    x: float  # m, rear axle
    y: float  # m
    z: float  # m
    yaw: float  # rad, unwrapped
    vx: float  # m/s along the body
    vy: float  # m/s at the centre of gravity
    vy_rear: float  # m/s at the rear axle
    yaw_rate: float  # rad/s
    ax: float  # m/s^2, specific force at the rear axle
    ay: float  # m/s^2

    # A replay may put the car elsewhere: where it was before, for sensors that show the past
    moved: float  # 1 in the first sensor call after that, else 0
    old_x: float  # m
    old_y: float  # m
    old_yaw: float  # rad

    # Slot sensor: what a log of this car would show
    meas_x: float
    meas_y: float
    meas_yaw: float
    meas_v: float
    meas_yaw_rate: float
    meas_ax: float
    meas_ay: float


BUS_FIELDS: tuple[str, ...] = tuple(Bus.__annotations__)
