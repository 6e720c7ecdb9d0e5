"""One step of each effect, as plain Python on a bus of a few fields: the numbers are arithmetic on its equation.

The figures of the catalogue's own pages come from runs; here a step is small enough to reckon by hand. Lags are asked
over a step as long as their time constant, after which 1/e of the way is left.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from vehicle.model.bus import GRAVITY
from vehicle.model.effect_catalogue import find_effect

LEFT = math.exp(-1.0)  # of the way, after one time constant
HALF_PI = 0.5 * math.pi


def step(name: str, p: dict[str, Any], bus: dict[str, Any], memory: dict[str, Any] | None = None) -> tuple[Any, Any]:
    x, m = SimpleNamespace(**{**QUIET, **bus}), SimpleNamespace(**(memory or {}))
    find_effect(name).function(x, SimpleNamespace(**p), m)
    return x, m


Row = tuple[str, dict[str, Any], dict[str, Any], dict[str, Any]]
QUIET_FIELDS = """bank steer_lead resistance drive_drag rotating_mass accel_brakes steered_pull steer road_friction
push"""
QUIET = dict.fromkeys(QUIET_FIELDS.split(), 0.0)  # if not in a case
MOTOR = {"torque": 100.0, "corner_speed": 200.0, "rated_speed": 400.0, "max_speed": 800.0, "power": 2e4}
PULL = {
    "traction": 5000.0,
    "accel_lead": 0.5,
    "gear_ratio": 8.0,
    "wheel_radius": 0.4,
}  # 20 turns of the motor per metre of road
DAMPING = {"zero": 0.1, "full": 0.3}  # N m s
TURN = {"fy_front": 1000.0, "fy_rear": 800.0, "tangent_front": 2.5e5, "tangent_rear": 2e5}
CAR = {"mass": 1000.0, "wheelbase": 2.5, "cg_front": 1.0, "cg_rear": 1.25}  # 400 kg/m: 500 and 400 kg on the axles

PLAIN: tuple[Row, ...] = (
    ("accelerometer_bias", {"b": 0.2}, {"meas_ax": 1.0}, {"meas_ax": 1.2}),
    ("lateral_accelerometer_bias", {"b": 0.2}, {"meas_ay": 1.0}, {"meas_ay": 1.2}),
    ("gyro_bias", {"b": -0.2}, {"meas_yaw_rate": 1.0}, {"meas_yaw_rate": 0.8}),
    ("heading_bias", {"b": 0.2}, {"meas_yaw": 1.0}, {"meas_yaw": 1.2}),
    ("pitch", {"gain": 0.25}, {"meas_ax": 2.0}, {"meas_ax": 2.5}),
    ("roll", {"gain": 0.25}, {"meas_ay": 2.0}, {"meas_ay": 2.5}),
    ("wheel_radius", {"ratio": 1.1}, {"meas_v": 10.0}, {"meas_v": 11.0}),
    ("yaw_inertia", {"ratio": 1.5}, {"turning_inertia": 2000.0}, {"turning_inertia": 3000.0}),
    ("rolling_resistance", {"c": 0.2}, {"resistance": 10.0, "mass": 1000.0}, {"resistance": 210.0}),
    ("viscous_resistance", {"c": 0.1}, {"drag": 5.0, "mass_ref": 1000.0, "vx": -2.0}, {"drag": 205.0}),
    ("aero_drag", {"k": 0.001}, {"drag": 0.0, "mass_ref": 1000.0, "vx": 10.0}, {"drag": -100.0}),
    ("aero_drag", {"k": 0.001}, {"drag": 7.0, "mass_ref": 1000.0, "vx": -10.0}, {"drag": 107.0}),
    ("cornering_drag", {"c": 0.1}, {"resistance": 1.0, "mass": 1000.0, "vx": 10.0, "curvature": -0.02},
     {"resistance": 201.0}),
    ("headwind", {"k": 0.001, "speed": 5.0, "heading": math.inf}, {"drag": 0.0, "mass_ref": 1000.0, "vx": 10.0,
                                                              "yaw": 1.0}, {"drag": -125.0}),
    ("headwind", {"k": 0.001, "speed": 5.0, "heading": 0.0}, {"drag": 0.0, "mass_ref": 1000.0, "vx": 10.0,
                                                            "yaw": math.pi}, {"drag": 75.0}),  # from behind
    ("headwind", {"k": 0.001, "speed": 5.0, "heading": 1.0}, {"drag": 0.0, "mass_ref": 1000.0, "vx": -2.0, "yaw": 1.0},
     {"drag": -13.0}),
    ("road_grade", {"slope": 0.1, "heading": 1.0}, {"grade": 0.2, "yaw": 1.0 + math.pi / 3.0}, {"grade": 0.25}),
    ("road_bank", {"slope": 0.1, "heading": 1.0}, {"bank": 0.2, "yaw": 1.0 - math.pi / 3.0}, {"bank": 0.25}),
    ("gnss_lever_arm", {"x": 2.0, "y": 1.0}, {"meas_x": 5.0, "meas_y": 6.0, "meas_yaw": HALF_PI},
     {"meas_x": 4.0, "meas_y": 8.0}),
    ("imu_misalignment", {"angle": HALF_PI}, {"meas_ax": 2.0, "meas_ay": 3.0}, {"meas_ax": 3.0, "meas_ay": -2.0}),
    ("front_wheel_speed", {"share": 0.5}, {"meas_v": 1.0, "vx": 10.0, "vy_rear": 0.5, "wheelbase": 2.5,
                                           "meas_yaw_rate": 0.4, "steer": HALF_PI}, {"meas_v": -3.25}),  # 1.5 instead
    ("wheel_slip", {"c_drive": 0.01, "c_brake": 0.02}, {"meas_v": -10.0, "vx": -10.0, "traction": 2000.0,
                                                         "brake": 500.0, "mass_ref": 1000.0}, {"meas_v": -9.7}),
    ("wheel_slip", {"c_drive": 0.01, "c_brake": 0.02}, {"meas_v": 10.0, "vx": 10.0, "traction": 2000.0, "brake": 500.0,
                                                         "mass_ref": 1000.0}, {"meas_v": 10.1}),
    # inertias
    ("gear_inertia", {"share": 0.2, "v1": 10.0}, {"rotating_mass": 1.0, "mass_ref": 1000.0, "vx": 10.0},
     {"rotating_mass": 201.0}),
    ("gear_inertia", {"share": 0.2, "v1": 10.0}, {"rotating_mass": 1.0, "mass_ref": 1000.0, "vx": -20.0},
     {"rotating_mass": 51.0}),
    ("motor_inertia", {"J": 0.5}, {**PULL, "rotating_mass": 1.0}, {"rotating_mass": 201.0}),
    # motor and pedals
    ("motor_damping", DAMPING, {**PULL, "accel": 1.0, "full_throttle": 2.0, "vx": 10.0, "resistance": 1.0},
     {"resistance": 801.0, "drive_drag": 800.0}),
    ("motor_damping", DAMPING, {**PULL, "accel": 3.0, "full_throttle": 2.0, "vx": -10.0},
     {"resistance": 1200.0, "drive_drag": 1200.0}),
    ("motor_damping", DAMPING, {**PULL, "accel": -1.0, "full_throttle": 2.0, "vx": 10.0},
     {"resistance": 400.0, "drive_drag": 400.0}),
    ("motor_torque", MOTOR, {**PULL, "vx": 0.0}, {"traction": 2000.0}),
    ("motor_torque", MOTOR, {**PULL, "vx": 10.0}, {"traction": 2000.0}),
    ("motor_torque", MOTOR, {**PULL, "vx": 15.0}, {"traction": 1500.0}),  # half way from 100 to 50 N m
    ("motor_torque", MOTOR, {**PULL, "vx": 20.0}, {"traction": 1000.0, "accel_lead": 0.0}),  # a limit has no lead
    ("motor_torque", MOTOR, {**PULL, "vx": 40.0}, {"traction": 500.0}),
    ("motor_torque", MOTOR, {**PULL, "vx": 40.01}, {"traction": 0.0}),
    ("motor_torque", MOTOR, {**PULL, "vx": 20.0, "traction": 900.0}, {"traction": 900.0, "accel_lead": 0.5}),
    ("motor_torque", {**MOTOR, "power": 1e6}, {**PULL, "vx": 15.0}, {"traction": 2000.0}),
    ("power_limit", {"limit": 20.0}, {"traction": 2000.0, "vx": 10.0, "mass_ref": 1000.0, "accel_lead": 0.5},
     {"traction": 2000.0, "accel_lead": 0.5}),
    ("power_limit", {"limit": 20.0}, {"traction": 2500.0, "vx": 10.0, "mass_ref": 1000.0, "accel_lead": 0.5},
     {"traction": 2000.0, "accel_lead": 0.0}),
    ("pedal_deadband", {"width": 0.1}, {"accel": 0.1, "accel_lead": 0.3}, {"accel": 0.1, "accel_lead": 0.3}),
    ("pedal_deadband", {"width": 0.1}, {"accel": -0.09, "accel_lead": 0.3}, {"accel": 0.0, "accel_lead": 0.0}),
    ("drive_gain", {"g": 1.5}, {"accel": 2.0, "accel_lead": 1.0}, {"accel": 3.0, "accel_lead": 1.5}),
    ("drive_gain", {"g": 1.5}, {"accel": -2.0, "accel_lead": 1.0}, {"accel": -2.0, "accel_lead": 1.0}),
    ("brake_gain", {"g": 1.5, "motor": 0.0}, {"accel": -2.0, "accel_lead": 1.0}, {"accel": -3.0, "accel_lead": 1.5}),
    ("brake_gain", {"g": 1.5, "motor": 0.0}, {"accel": 2.0, "accel_lead": 1.0}, {"accel": 2.0, "accel_lead": 1.0}),
    # a motor takes over 1.5 m/s^2: 1 m/s^2 does not come to the brakes, of 2 m/s^2 they have 0.5, and in a step from
    # 1 to 3 m/s^2 they have 1.5 at its end
    ("brake_gain", {"g": 1.5, "motor": 1.5}, {"accel": -1.0, "accel_lead": 0.0}, {"accel": -1.0, "accel_lead": 0.0}),
    ("brake_gain", {"g": 1.5, "motor": 1.5}, {"accel": -2.0, "accel_lead": 0.0}, {"accel": -2.25, "accel_lead": 0.0}),
    ("brake_gain", {"g": 1.5, "motor": 1.5}, {"accel": -2.0, "accel_lead": 1.0},
     {"accel": -2.375, "accel_lead": 1.375}),
    # of 500 N of resistance the drive makes 200 N; the rest goes with the weight
    ("mass", {"ratio": 2.0}, {"traction": 900.0, "accel_lead": 0.6, "brake": 800.0, "drag": -60.0, "resistance": 500.0,
                              "drive_drag": 200.0, "rotating_mass": 50.0},
     {"traction": 450.0, "accel_lead": 0.3, "brake": 400.0, "drag": -30.0, "resistance": 400.0, "drive_drag": 100.0,
      "rotating_mass": 25.0}),
    ("brake_limit", {"limit": 4.0}, {"accel": -3.5, "accel_lead": 0.5}, {"accel": -3.5, "accel_lead": 0.5}),
    ("brake_limit", {"limit": 4.0}, {"accel": -4.0, "accel_lead": 0.5}, {"accel": -3.75, "accel_lead": 0.25}),
    ("brake_limit", {"limit": 4.0}, {"accel": -4.0, "accel_lead": -0.5}, {"accel": -3.75, "accel_lead": -0.25}),
    ("drive_torque_limit", {"limit": 4.0}, {"accel": 3.5, "accel_lead": 0.5}, {"accel": 3.5, "accel_lead": 0.5}),
    ("drive_torque_limit", {"limit": 4.0}, {"accel": 4.0, "accel_lead": 0.5}, {"accel": 3.75, "accel_lead": 0.25}),
    ("drive_torque_limit", {"limit": 4.0}, {"accel": 4.0, "accel_lead": -0.5}, {"accel": 3.75, "accel_lead": -0.25}),
    ("speed_limit", {"limit": 5.0}, {"speed_cmd": 6.0}, {"speed_cmd": 5.0}),
    ("speed_limit", {"limit": 5.0}, {"speed_cmd": -6.0}, {"speed_cmd": -5.0}),
    # steering
    ("steer_offset", {"offset": 0.1}, {"steer": 0.2}, {"steer": 0.3}),
    ("steer_ratio", {"g": 1.5}, {"steer": 0.2, "steer_lead": 0.4}, {"steer": 0.3, "steer_lead": 0.6}),
    ("steer_asymmetry", {"g_left": 2.0, "g_right": 3.0}, {"steer": 0.1, "steer_lead": 1.0},
     {"steer": 0.2, "steer_lead": 2.0}),
    ("steer_asymmetry", {"g_left": 2.0, "g_right": 3.0}, {"steer": 0.0, "steer_lead": 1.0},
     {"steer": 0.0, "steer_lead": 3.0}),
    ("steer_assist", {"g": 0.5, "v0": 10.0}, {"steer": 0.4, "steer_lead": 0.8, "vx": -10.0},
     {"steer": 0.5, "steer_lead": 1.0}),
    ("steer_angle_limit", {"limit": 0.5}, {"steer": 0.25, "steer_lead": 0.25}, {"steer": 0.25, "steer_lead": 0.25}),
    ("steer_angle_limit", {"limit": 0.5}, {"steer": 0.45, "steer_lead": 0.1}, {"steer": 0.425, "steer_lead": 0.075}),
    ("steer_angle_limit", {"limit": 0.5}, {"steer": -0.45, "steer_lead": 0.1}, {"steer": -0.425, "steer_lead": 0.075}),
    # tyres
    ("understeer", {"K": 0.002}, {**CAR, **TURN}, {**TURN, "fy_front": 500.0, "tangent_front": 1.25e5}),
    ("understeer", {"K": -0.002}, {**CAR, **TURN}, {**TURN, "fy_rear": 400.0, "tangent_rear": 1e5}),
    ("cornering_compliance", {"D": 0.002}, {**CAR, **TURN},
     {"fy_front": 500.0, "tangent_front": 1.25e5, "fy_rear": 400.0, "tangent_rear": 1e5}),
    ("load_transfer", {"c": 0.8}, {**TURN, "vx": 10.0, "yaw_rate": -0.05 * GRAVITY},
     {"fy_front": 800.0, "fy_rear": 640.0, "tangent_front": 2e5, "tangent_rear": 1.6e5}),
    ("load_transfer", {"c": 0.8}, {**TURN, "vx": 10.0, "yaw_rate": 0.2 * GRAVITY},
     {"fy_front": 200.0, "fy_rear": 160.0, "tangent_front": 5e4, "tangent_rear": 4e4}),
    # a wind that pushes by half the weight is held by the tyres as a curve of that
    ("load_transfer", {"c": 0.8}, {**TURN, **CAR, "vx": 10.0, "yaw_rate": 0.0, "push": 500.0 * GRAVITY},
     {"fy_front": 800.0, "fy_rear": 640.0, "tangent_front": 2e5, "tangent_rear": 1.6e5}),
    ("axle_load_shift", {"c": 1.0}, {**CAR, **TURN, "traction": 0.0, "brake": 100.0 * GRAVITY,
                                     "vx": 1.0},
     {"fy_front": 1200.0, "tangent_front": 3e5, "fy_rear": 600.0, "tangent_rear": 1.5e5}),
    ("axle_load_shift", {"c": 1.0}, {**CAR, **TURN, "traction": 0.0, "brake": 100.0 * GRAVITY,
                                     "vx": -1.0},
     {"fy_front": 800.0, "tangent_front": 2e5, "fy_rear": 1000.0, "tangent_rear": 2.5e5}),
    ("axle_load_shift", {"c": 1.0}, {**CAR, **TURN, "traction": 1000.0 * GRAVITY, "brake": 0.0,
                                     "vx": 1.0},
     {"fy_front": 200.0, "tangent_front": 5e4, "fy_rear": 1440.0, "tangent_rear": 3.6e5}),
    ("tyre_saturation", {"limit": 0.5},
     {**CAR, **TURN, "fy_front": 250.0, "fy_rear": -200.0, "load_front": 1.0, "load_rear": 1.0},
     {"fy_front": 250.0 * math.tanh(1.0), "tangent_front": 2.5e5 * (1.0 - math.tanh(1.0) ** 2),
      "fy_rear": -200.0 * math.tanh(1.0), "tangent_rear": 2e5 * (1.0 - math.tanh(1.0) ** 2)}),
    ("tyre_saturation", {"limit": math.inf}, {**CAR, **TURN}, TURN),
    ("steered_wheel_forces", {"drive": 0.6, "brake": 0.7},
     {"vx": 1.0, "traction": 1000.0, "brake": 200.0, "steer": math.pi / 6.0, "cg_front": 1.5, "push": 1.0,
      "yaw_moment": 2.0},  # 600 - 140 N ahead along the wheels, half of it across
     {"traction": 1000.0 - 600.0 * (1.0 - math.cos(math.pi / 6.0)),
      "brake": 200.0 - 140.0 * (1.0 - math.cos(math.pi / 6.0)), "push": 231.0, "steered_pull": 230.0,
      "yaw_moment": 347.0}),
    ("steered_wheel_forces", {"drive": 0.6, "brake": 0.7},
     {"vx": -1.0, "traction": 1000.0, "brake": 200.0, "steer": math.pi / 6.0, "cg_front": 1.5, "push": 1.0,
      "yaw_moment": 2.0}, {"push": 371.0, "yaw_moment": 557.0}),
    ("steered_wheel_forces", {"drive": 0.6, "brake": 0.7},
     {"vx": 0.0, "traction": 1000.0, "brake": 200.0, "steer": 0.5, "cg_front": 1.5, "push": 1.0, "yaw_moment": 2.0},
     {"traction": 1000.0, "brake": 200.0, "push": 1.0, "yaw_moment": 2.0}),
    # a hill of 1 m, 10 m wide, with its top at (3, 4)
    ("road_profile", {"height": 1.0, "length": 10.0, "x": 3.0, "y": 4.0},
     {"x": 13.0, "y": 4.0, "yaw": 0.0, "grade": 0.0, "bank": 0.0},
     {"grade": -math.atan(0.1 * math.exp(-0.5)), "bank": 0.0}),
    ("road_profile", {"height": 1.0, "length": 10.0, "x": 3.0, "y": 4.0},
     {"x": 13.0, "y": 4.0, "yaw": HALF_PI, "grade": 0.5, "bank": 0.5},
     {"grade": 0.5, "bank": 0.5 + math.atan(0.1 * math.exp(-0.5))}),
    ("road_profile", {"height": 1.0, "length": 10.0, "x": 3.0, "y": 4.0},
     {"x": 3.0, "y": -6.0, "yaw": 0.0, "grade": 0.0, "bank": 0.0},
     {"grade": 0.0, "bank": math.atan(0.1 * math.exp(-0.5))}),
    ("road_profile", {"height": 0.0, "length": 10.0, "x": 3.0, "y": 4.0},
     {"x": 3.0, "y": -6.0, "yaw": 0.0, "grade": 0.1, "bank": 0.2}, {"grade": 0.1, "bank": 0.2}),
)  # fmt: skip


@pytest.mark.parametrize(("name", "p", "bus", "after"), PLAIN, ids=[f"{i}-{row[0]}" for i, row in enumerate(PLAIN)])
def test_a_step_without_memory(name: str, p: dict[str, Any], bus: dict[str, Any], after: dict[str, Any]) -> None:
    x, _ = step(name, p, bus)
    assert {field: getattr(x, field) for field in after} == pytest.approx(after, rel=1e-12, abs=1e-12)


BRAKED = {"accel": -4.0, "accel_lead": 0.4, "settle": 0.0, "vx": -3.0, "dt": 1.0}
LOOP = {"kp_drive": 0.5, "ki_drive": 0.1, "kp_brake": 0.2, "ki_brake": 0.3}
RELEASE = {"a": 0.5, "rise": 0.02, "fade": 5.0, "lag": 0.0, "braking": 0.25, "drive": 0.0, "blend": 0.0}
ROLLS = {"accel": 0.0, "accel_lead": 0.0, "vx": 20.0, "resistance": 1.0, "mass_ref": 1000.0, "dt": 0.1}
STICKS = {"vx": 0.0, "settle": 0.0, "steer_glides": 0.0, "steer_lead": 0.0}
HELD = {"stood": 1.0, "stuck": 1.0, "d": 0.0}

Remembered = tuple[str, dict[str, Any], dict[str, Any], dict[str, Any], dict[str, Any], dict[str, Any]]
LASTING: tuple[Remembered, ...] = (
    # brakes
    ("brake_fade", {"k": 0.1, "tau": 1.0}, BRAKED, {"heat": 10.0}, {"accel": -2.0, "accel_lead": 0.2},
     {"heat": 10.0 * LEFT + 4.0 * (1.0 - LEFT)}),  # 3 to 1 m/s are 4 J/kg
    ("brake_fade", {"k": 0.1, "tau": 1.0}, {**BRAKED, "vx": 1.0}, {"heat": 10.0}, {"accel": -2.0},
     {"heat": 10.0 * LEFT + 0.5 * (1.0 - LEFT)}),  # it stops within the step
    ("brake_fade", {"k": 0.1, "tau": 1.0}, {**BRAKED, "accel": 0.5}, {"heat": 10.0}, {"accel": 0.5, "accel_lead": 0.4},
     {"heat": 10.0 * LEFT}),
    # half of 4 m/s^2 is a motor's and does not fade; discs that give 1 of 3 m/s^2 get a third of 4.5 - 2.7^2/2 J/kg
    ("brake_fade", {"k": 0.1, "tau": 1.0}, {**BRAKED, "vx": 3.0, "dt": 0.1, "accel_brakes": -2.0}, {"heat": 10.0},
     {"accel": -3.0, "accel_lead": 0.2},
     {"heat": 10.0 * math.exp(-0.1) + 0.5 * (9.0 - 2.7**2) / 3.0 * (1.0 - math.exp(-0.1)) / 0.1}),
    ("brake_fade", {"k": 0.0, "tau": 1.0}, BRAKED, {"heat": 10.0}, {"accel": -4.0}, {"heat": 10.0}),
    ("brake_fade", {"k": 0.1, "tau": 1.0}, {**BRAKED, "settle": 1.0}, {"heat": 10.0}, {"accel": -4.0}, {"heat": 10.0}),
    ("brake_lag", {"tau": 0.1, "release": 2.0}, {"accel": -2.0, "accel_lead": 0.0, "dt": 0.1}, {"a": 0.0},
     {"accel": -2.0 * LEFT, "accel_lead": 2.0 * LEFT}, {"a": -2.0 * (1.0 - LEFT)}),
    ("brake_lag", {"tau": 0.05, "release": 2.0}, {"accel": 1.0, "accel_lead": 0.3, "dt": 0.1}, {"a": -2.0},
     {"accel": 1.0 - 2.0 * (1.0 - LEFT), "accel_lead": 0.3 - 2.0 * LEFT}, {"a": -2.0 * LEFT}),
    ("brake_lag", {"tau": 0.05, "release": 0.0}, {"accel": 1.0, "accel_lead": 0.3, "dt": 0.1}, {"a": -2.0},
     {"accel": 1.0, "accel_lead": 0.3}, {"a": 0.0}),
    ("brake_lag", {"tau": 0.0, "release": 2.0}, {"accel": -1.0, "accel_lead": 0.3, "dt": 0.1}, {"a": -2.0},
     {"accel": -1.0, "accel_lead": 0.3}, {"a": 0.0}),
    # drive; the ramp is from -0.8 to -1.2, answered from 1: k = -0.4 a step
    ("drive_lag", {"tau": 0.1, "brakes": 0.25}, {"accel": -4.0, "accel_lead": 0.8, "dt": 0.1}, {"a": 1.0},
     {"accel": -3.0 - 0.8 + 1.8 * (1.0 - LEFT) - 0.4 * (0.5 - LEFT),
      "accel_lead": 0.6 + 1.0 - (-0.8 + 1.8 * (1.0 - LEFT) - 0.4 * (0.5 - LEFT))},
     {"a": -0.8 + 1.8 * LEFT - 0.4 * LEFT}),
    ("drive_lag", {"tau": 0.1, "brakes": 0.25}, {"accel": 2.0, "accel_lead": 0.0, "dt": 0.1}, {"a": 1.0},
     {"accel": 1.0 + LEFT, "accel_lead": -LEFT}, {"a": 2.0 - LEFT}),
    ("drive_lag", {"tau": 0.1, "brakes": 1.0}, {"accel": -2.0, "accel_lead": 0.0, "dt": 0.1}, {"a": -1.0},
     {"accel": -1.0 - LEFT, "accel_lead": LEFT}, {"a": -2.0 + LEFT}),
    ("drive_lag", {"tau": 0.0, "brakes": 0.5}, {"accel": 2.0, "accel_lead": 0.5, "dt": 0.1}, {"a": 9.0},
     {"accel": 2.0, "accel_lead": 0.5}, {"a": 1.5}),
    ("force_rise", {"tau": 0.1}, {"accel": 2.0, "accel_lead": 0.0, "dt": 0.1, "vx": 0.0}, {"a": -2.0},
     {"accel": 2.0 * LEFT, "accel_lead": -2.0 * LEFT}, {"a": 2.0 - 2.0 * LEFT}),
    ("force_rise", {"tau": 0.1}, {"accel": 2.0, "accel_lead": 0.0, "dt": 0.1, "vx": -1.0}, {"a": -2.0},
     {"accel": -2.0 + 4.0 * LEFT, "accel_lead": -4.0 * LEFT}, {"a": 2.0 - 4.0 * LEFT}),
    ("force_rise", {"tau": 0.0}, {"accel": 2.0, "accel_lead": 0.5, "dt": 0.1, "vx": 1.0}, {"a": 0.0},
     {"accel": 2.0, "accel_lead": 0.5}, {"a": 1.5}),
    ("jerk_limit", {"limit": 10.0}, {"accel": 2.0, "accel_lead": 0.0, "dt": 0.1}, {"a": 0.0},
     {"accel": 0.5, "accel_lead": -0.5}, {"a": 1.0}),
    ("jerk_limit", {"limit": 10.0}, {"accel": -2.0, "accel_lead": 0.0, "dt": 0.1}, {"a": 0.0},
     {"accel": -0.5, "accel_lead": 0.5}, {"a": -1.0}),
    ("jerk_limit", {"limit": 10.0}, {"accel": 0.5, "accel_lead": 0.0, "dt": 0.1}, {"a": 0.0},
     {"accel": 0.375, "accel_lead": -0.375}, {"a": 0.5}),  # half of the step on the way, at 0.25 in the mean
    ("jerk_limit", {"limit": math.inf}, {"accel": 2.0, "accel_lead": 0.5, "dt": 0.1}, {"a": 0.0},
     {"accel": 2.0, "accel_lead": 0.5}, {"a": 1.5}),
    # controllers; the measured acceleration is 1 m/s^2, filtered from 0.5 over two time constants
    ("accel_controller", LOOP, {"settle": 0.0, "moved": 0.0, "vx": 2.0, "accel": 2.0, "dt": 0.1},
     {"v": 1.9, "a": 0.5, "sum": 0.2, "dt": 0.1},
     {"accel": 2.2 + 0.51 * (1.0 + 0.5 * LEFT**2)},
     {"v": 2.0, "a": 1.0 - 0.5 * LEFT**2, "sum": 0.2 + 0.01 * (1.0 + 0.5 * LEFT**2)}),
    ("accel_controller", LOOP, {"settle": 0.0, "moved": 0.0, "vx": 2.0, "accel": -2.0, "dt": 0.1},
     {"v": 1.9, "a": 1.0, "sum": 0.2, "dt": 0.1},
     {"accel": -1.8 - 0.23 * 3.0}, {"a": 1.0, "sum": 0.2 - 0.09}),
    ("accel_controller", LOOP, {"settle": 0.0, "moved": 0.0, "vx": 0.0, "accel": 0.0, "dt": 0.1},
     {"v": 0.0, "a": 0.0, "sum": 0.2, "dt": 0.1},
     {"accel": 0.0}, {"sum": 0.0}),
    ("accel_controller", LOOP, {"settle": 1.0, "moved": 0.0, "vx": 2.0, "accel": 3.0, "dt": 0.1},
     {"v": 0.0, "a": 0.0, "sum": 0.2, "dt": 0.1},
     {"accel": 3.0}, {"v": 2.0, "a": 3.0, "sum": 0.2}),
    # put elsewhere by a replay nothing was accelerated; after a step of 0.2 s the change counts for that
    ("accel_controller", LOOP, {"settle": 0.0, "moved": 1.0, "old_vx": 2.1, "vx": 5.0, "accel": 2.0, "dt": 0.1},
     {"v": 1.9, "a": 2.0, "sum": 0.0, "dt": 0.1}, {"accel": 2.0}, {"v": 5.0, "a": 2.0, "sum": 0.0}),
    ("accel_controller", LOOP, {"settle": 0.0, "moved": 0.0, "vx": 2.4, "accel": 2.0, "dt": 0.1},
     {"v": 2.0, "a": 2.0, "sum": 0.0, "dt": 0.2}, {"accel": 2.0}, {"v": 2.4, "a": 2.0, "sum": 0.0, "dt": 0.1}),
    ("speed_controller", {"kp": 1.25, "ki": 0.5},  # wheels that turn by a fifth too slowly show 5 m/s
     {"speed_cmd": 7.0, "vx": 6.25, "speed_gain": 0.8, "dt": 0.5, "settle": 0.0, "accel": 0.1, "accel_lead": 0.2},
     {"sum": 0.2}, {"accel": 2.26, "accel_lead": 0.74}, {"sum": 0.592}),  # 2.7/1.25 = 2.16; 0.2 + 0.25 (2 - 0.432)
    ("speed_controller", {"kp": 1.0, "ki": 0.5},
     {"speed_cmd": 7.0, "vx": 5.0, "speed_gain": 1.0, "dt": 0.5, "settle": 1.0, "accel": 0.0, "accel_lead": 0.0},
     {"sum": 0.2},
     {"accel": 1.76, "accel_lead": 0.44}, {"sum": 0.2}),
    # a released pedal
    ("lift_off_braking", RELEASE, ROLLS, {"a": 0.0},
     {"resistance": 701.0, "drive_drag": 700.0, "accel": 0.0, "accel_lead": 0.0}, {"a": 0.7}),
    ("lift_off_braking", RELEASE, {**ROLLS, "vx": -20.0}, {"a": 0.0}, {"resistance": 701.0}, {"a": 0.7}),
    ("lift_off_braking", RELEASE, {**ROLLS, "vx": 2.5}, {"a": 0.0}, {"resistance": 176.0}, {"a": 0.175}),
    ("lift_off_braking", {**RELEASE, "a": 0.1}, {**ROLLS, "vx": 1.0}, {"a": 0.5}, {"resistance": 1.0}, {"a": 0.0}),
    ("lift_off_braking", RELEASE, {**ROLLS, "accel": 0.05}, {"a": 0.0}, {"resistance": 1.0, "accel": 0.05}, {"a": 0.0}),
    ("lift_off_braking", RELEASE, {**ROLLS, "accel": -0.04}, {"a": 0.0}, {"resistance": 701.0, "accel": -0.04}, {}),
    ("lift_off_braking", RELEASE, {**ROLLS, "accel": -0.05}, {"a": 0.0}, {"accel": 0.0, "accel_lead": 0.0}, {}),
    ("lift_off_braking", {**RELEASE, "drive": 0.5}, {**ROLLS, "accel": -0.05}, {"a": 0.0},
     {"accel": 0.2375, "accel_lead": 0.0}, {}),
    ("lift_off_braking", RELEASE, {**ROLLS, "accel": -1.0}, {"a": 0.0}, {"accel": -0.475, "accel_lead": 0.0}, {}),
    ("lift_off_braking", {**RELEASE, "lag": 0.1}, {**ROLLS, "accel": -1.0}, {"a": 0.0},
     {"resistance": 1.0 + 700.0 * LEFT, "accel": -1.0 + 0.525 * LEFT, "accel_lead": -0.525 * LEFT},
     {"a": 0.7 * (1.0 - LEFT)}),
    ("lift_off_braking", {**RELEASE, "blend": 0.4}, {**ROLLS, "accel": 0.15}, {"a": 0.0},
     {"resistance": 526.0, "accel": 0.15}, {"a": 0.525}),  # a quarter of the way to the pedal's 0.45 m/s^2
    ("lift_off_braking", {**RELEASE, "blend": 0.4}, {**ROLLS, "accel": 0.45}, {"a": 0.0}, {"resistance": 1.0}, {}),
    ("lift_off_braking", {**RELEASE, "blend": 0.4}, {**ROLLS, "accel": 0.04}, {"a": 0.0}, {"resistance": 701.0}, {}),
    # steering
    ("steer_lag", {"tau": 0.1}, {"steer": 0.4, "steer_lead": 0.0, "dt": 0.1, "steer_glides": 0.0}, {"d": 0.2},
     {"steer": 0.2 + 0.2 * LEFT, "steer_lead": -0.2 * LEFT, "steer_glides": 1.0}, {"d": 0.4 - 0.2 * LEFT}),
    ("steer_lag", {"tau": 0.0}, {"steer": 0.4, "steer_lead": 0.1, "dt": 0.1, "steer_glides": 0.0}, {"d": 0.2},
     {"steer": 0.4, "steer_lead": 0.1, "steer_glides": 0.0}, {"d": 0.3}),
    ("steer_rate_limit", {"limit": 1.0}, {"steer": 0.5, "steer_lead": 0.0, "dt": 0.1, "steer_glides": 0.0}, {"d": 0.2},
     {"steer": 0.25, "steer_lead": -0.05, "steer_glides": 1.0}, {"d": 0.3}),
    ("steer_rate_limit", {"limit": math.inf}, {"steer": 0.5, "steer_lead": 0.1, "dt": 0.1, "steer_glides": 0.0},
     {"d": 0.2}, {"steer": 0.5, "steer_lead": 0.1, "steer_glides": 0.0}, {"d": 0.4}),
    ("steer_backlash", {"half_width": 0.1}, {"steer": 0.05, "steer_lead": 0.0}, {"d": 0.0},
     {"steer": 0.0, "steer_lead": 0.0}, {"d": 0.0}),
    ("steer_backlash", {"half_width": 0.1}, {"steer": -0.3, "steer_lead": 0.0}, {"d": 0.0},
     {"steer": -0.2, "steer_lead": 0.0}, {"d": -0.2}),
    ("steer_backlash", {"half_width": 0.1}, {"steer": 0.3, "steer_lead": -0.2}, {"d": 0.05},
     {"steer": 0.225, "steer_lead": -0.175}, {"d": 0.4}),  # from 0.05, which 0.1 leaves alone, to 0.5 - 0.1
    ("steer_backlash", {"half_width": 0.0}, {"steer": 0.3, "steer_lead": -0.2}, {"d": 0.0},
     {"steer": 0.3, "steer_lead": -0.2}, {"d": 0.5}),
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.05}, {"stood": 0.0, "stuck": 0.0, "d": 0.0},
     {"steer": 0.0, "steer_lead": 0.0}, {"stood": 1.0, "stuck": 1.0, "d": 0.0}),
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.05, "vx": 0.05}, {"stood": 1.0, "stuck": 0.0, "d": 0.0},
     {"steer": 0.05}, {"stood": 0.0, "stuck": 0.0, "d": 0.05}),
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.05}, {"stood": 1.0, "stuck": 0.0, "d": 0.0},
     {"steer": 0.05}, {"stood": 1.0, "stuck": 0.0, "d": 0.05}),
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.1}, HELD, {"steer": 0.1}, {"stuck": 0.0, "d": 0.1}),
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.15, "steer_lead": -0.1}, HELD,
     {"steer": 0.125, "steer_lead": -0.125}, {"stuck": 0.0, "d": 0.25}),  # half of the step at 0.25
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.15, "steer_lead": -0.1, "steer_glides": 1.0}, HELD,
     {"steer": 0.13125, "steer_lead": -0.13125}, {"stuck": 0.0, "d": 0.25}),  # 3/4 of the step, from 0.1 to 0.25
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": -0.15, "steer_lead": 0.1, "steer_glides": 1.0}, HELD,
     {"steer": -0.13125, "steer_lead": 0.13125}, {"stuck": 0.0, "d": -0.25}),
    ("steer_sticking", {"width": 0.0}, {**STICKS, "steer": 0.05, "steer_lead": 0.01}, HELD, {"steer": 0.05},
     {"stuck": 1.0, "d": 0.04}),
    ("steer_sticking", {"width": 0.1}, {**STICKS, "steer": 0.05, "settle": 1.0}, HELD, {"steer": 0.05}, {"d": 0.05}),
    ("steer_stiction", {"width": 0.1}, {"steer": 0.05, "steer_lead": 0.0, "steer_glides": 0.0}, {"d": 0.0},
     {"steer": 0.0, "steer_lead": 0.0}, {"d": 0.0}),
    ("steer_stiction", {"width": 0.1}, {"steer": -0.1, "steer_lead": 0.0, "steer_glides": 0.0}, {"d": 0.0},
     {"steer": -0.1, "steer_lead": 0.0}, {"d": -0.1}),
    ("steer_stiction", {"width": 0.1}, {"steer": 0.1, "steer_lead": -0.1, "steer_glides": 0.0}, {"d": 0.0},
     {"steer": 0.1, "steer_lead": -0.1}, {"d": 0.2}),
    ("steer_stiction", {"width": 0.1}, {"steer": 0.125, "steer_lead": -0.125, "steer_glides": 1.0}, {"d": 0.0},
     {"steer": 0.08, "steer_lead": -0.08}, {"d": 0.2}),  # jumps at 0.4 and 0.8 of the step: 0.06 + 0.02
    ("steer_stiction", {"width": 0.0}, {"steer": 0.125, "steer_lead": -0.125, "steer_glides": 1.0}, {"d": 0.0},
     {"steer": 0.125, "steer_lead": -0.125}, {"d": 0.25}),
    # bodies: a quarter of a period without damping turns a distance into a rate
    ("body_pitch", {"frequency": 0.25, "damping": 0.0, "gain": 0.5}, {"meas_ax": 3.0, "dt": 1.0},
     {"begun": 1.0, "nod": 0.0, "rate": 0.0, "push": 1.0}, {"meas_ax": 3.5},
     {"nod": 1.0, "rate": HALF_PI, "push": 3.0}),
    ("body_pitch", {"frequency": 0.3125, "damping": 0.6, "gain": 0.5}, {"meas_ax": 3.0, "dt": 1.0},
     {"begun": 1.0, "nod": 0.0, "rate": 0.5, "push": 1.0},  # w = 1.25 pi/2, 0.8 w = pi/2, 0.6 w = 0.75 pi/2
     {"meas_ax": 3.5 + 0.5 * math.exp(-0.75 * HALF_PI) * (0.5 / HALF_PI - 0.75)},
     {"rate": math.exp(-0.75 * HALF_PI) * (1.5625 * HALF_PI - 0.375), "push": 3.0}),
    ("body_pitch", {"frequency": 1.0, "damping": 0.5, "gain": 0.5}, {"meas_ax": 2.0, "dt": 0.3},
     {"begun": 0.0, "nod": 0.0, "rate": 0.0, "push": 0.0}, {"meas_ax": 3.0}, {"begun": 1.0, "nod": 2.0, "rate": 0.0}),
    ("body_roll", {"frequency": 0.3125, "damping": 0.6, "gain": 0.5, "lead": 0.25, "inertia": 0.0},
     {"fy_front": 600.0, "fy_rear": 400.0, "mass": 1000.0, "vx": 2.0, "slow": 1.0, "dt": 1.0, "lean_y": 0.1},
     {"begun": 1.0, "sway": 0.0, "rate": 0.5}, {"lean_y": 0.225},
     {"sway": 1.0 + math.exp(-0.75 * HALF_PI) * (0.5 / HALF_PI - 0.75),
      "rate": math.exp(-0.75 * HALF_PI) * (1.5625 * HALF_PI - 0.375)}),
    ("body_roll", {"frequency": 0.5 / math.pi, "damping": 0.5, "gain": 0.0, "lead": 0.0, "inertia": 2.0},
     {"fy_front": 1000.0, "fy_rear": 400.0, "steer": math.pi / 3.0, "steered_pull": 100.0, "push": 700.0,
      "mass": 1000.0, "vx": 2.0, "slow": 1.0, "dt": 1.0, "lean_y": 0.0},
     {"begun": 1.0, "sway": 0.25, "rate": 0.5}, {"lean_y": 0.5}, {}),  # w = 1: 1 - 0.25 - 0.5
    ("body_roll", {"frequency": 1.0, "damping": 0.5, "gain": 0.5, "lead": 0.25, "inertia": 3.0},
     {"fy_front": 600.0, "fy_rear": 400.0, "mass": 1000.0, "vx": 1.0, "slow": 1.0, "curvature": 0.5, "dt": 0.1,
      "lean_y": 0.0}, {"begun": 0.0, "sway": 0.0, "rate": 0.0}, {"lean_y": 0.25}, {"begun": 1.0, "sway": 0.5}),
    ("roll_dynamics", {"gain": 0.1, "tau": 0.1},
     {"vx": GRAVITY, "yaw_rate": 1.0, "dt": 0.1, "steer": 0.5, "slip_front": 0.3, "fy_front": 100.0,
      "tangent_front": 1000.0}, {"begun": 1.0, "phi": 0.0},
     {"steer": 0.5 - 0.1 * LEFT, "slip_front": 0.3 - 0.1 * LEFT, "fy_front": 100.0 - 100.0 * LEFT},
     {"phi": 1.0 - LEFT}),
    ("roll_dynamics", {"gain": 0.1, "tau": 0.1},
     {"vx": GRAVITY, "yaw_rate": 2.0, "dt": 0.1, "steer": 0.5, "slip_front": 0.3, "fy_front": 100.0,
      "tangent_front": 1000.0}, {"begun": 0.0, "phi": 0.0}, {"steer": 0.3}, {"begun": 1.0, "phi": 2.0}),
    ("roll_dynamics", {"gain": 0.1, "tau": 0.0},
     {"vx": GRAVITY, "yaw_rate": 2.0, "dt": 0.1, "steer": 0.5, "slip_front": 0.3, "fy_front": 100.0,
      "tangent_front": 1000.0}, {"begun": 1.0, "phi": 0.0}, {"steer": 0.3}, {}),
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "p", "bus", "memory", "after", "left"), LASTING, ids=[f"{i}-{row[0]}" for i, row in enumerate(LASTING)]
)
def test_a_step_with_a_memory(
    name: str,
    p: dict[str, Any],
    bus: dict[str, Any],
    memory: dict[str, Any],
    after: dict[str, Any],
    left: dict[str, Any],
) -> None:
    x, m = step(name, p, bus, memory)
    assert {field: getattr(x, field) for field in after} == pytest.approx(after, rel=1e-12, abs=1e-12)
    assert {field: getattr(m, field) for field in left} == pytest.approx(left, rel=1e-12, abs=1e-12)


# --- effects that need more than one step, or an equation of their own


@pytest.mark.parametrize("share", [1.0, 0.5])
@pytest.mark.parametrize(("vy", "yaw_rate", "steer"), [(1.0, 1.0, 0.3), (-0.5, 0.8, -0.2), (2.0, -1.0, 0.4)])
def test_parallel_wheels_work_against_each_other(vy: float, yaw_rate: float, steer: float, share: float) -> None:
    """Each wheel has half the axle's stiffness, moves along its own direction and pulls at half the track."""
    speed, track, stiffness, cg_front = 10.0, 0.2, 1e5, 1.5  # so narrow that the wheels' directions are near each other
    bus = {"vx": speed, "slow": 1.0, "vy": vy, "yaw_rate": yaw_rate, "track": track, "cg_front": cg_front,
           "steer": steer, "tangent_front": stiffness, "yaw_moment": 0.0, "slip_front": 0.0,
           "fy_front": 0.0}  # fmt: skip
    x, _ = step("parallel_steering", {"share": share}, bus)
    across = vy + cg_front * yaw_rate
    left, middle, right = (math.atan(across / (speed - yaw_rate * y)) for y in (0.5 * track, 0.0, -0.5 * track))
    pair = 0.5 * track * math.sin(steer) * 0.5 * stiffness * (right - left)
    assert x.yaw_moment == pytest.approx(share * pair, rel=1e-3)
    assert x.slip_front == pytest.approx(share * (middle - 0.5 * (left + right)), rel=1e-3)
    assert x.fy_front == pytest.approx(stiffness * x.slip_front, rel=1e-12)


def test_a_slow_car_turns_its_wheels_as_at_the_lowest_speed() -> None:
    bus = {"vx": 0.5, "slow": 2.0, "vy": 0.0, "yaw_rate": 1.0, "track": 2.0, "cg_front": 2.0, "steer": HALF_PI,
           "tangent_front": 1e3, "yaw_moment": 0.0, "slip_front": 0.0, "fy_front": 0.0}  # fmt: skip
    x, _ = step("parallel_steering", {"share": 1.0}, bus)
    assert x.yaw_moment == pytest.approx(-0.5 * 0.5 * 1.0 * 0.5 * 1e3 * 2.0)  # apart 0.5, across 1


@pytest.mark.parametrize("slip", [0.05, -0.05, 0.15])
def test_a_soft_linkage_with_bent_tyres(slip: float) -> None:
    """F = M tanh(K (a - c F)/M): the force that is in balance with what it turns the wheels by."""
    most, stiff, c = 5000.0, 1e5, 5e-6
    level = math.tanh(stiff * slip / most)
    bus = {"slip_front": slip, "steer": 0.2, "fy_front": most * level, "tangent_front": stiff - stiff * level**2}
    x, _ = step("steer_compliance", {"c": 1e3 * c}, bus)
    balance = most * math.tanh(stiff * (slip - c * x.fy_front) / most)
    assert x.fy_front == pytest.approx(balance, rel=1e-6)
    assert x.slip_front == pytest.approx(slip - c * x.fy_front)
    assert x.steer == pytest.approx(0.2 - c * x.fy_front)
    slope = stiff * (1.0 - (x.fy_front / most) ** 2)
    assert x.tangent_front == pytest.approx(slope / (1.0 + c * slope), rel=1e-5)


@pytest.mark.parametrize("slip", [0.0, 0.011])
def test_a_soft_linkage_with_straight_tyres(slip: float) -> None:
    bus = {"slip_front": slip, "steer": 0.2, "fy_front": 1100.0, "tangent_front": 1e5}
    x, _ = step("steer_compliance", {"c": 0.001}, bus)
    assert (x.fy_front, x.tangent_front) == pytest.approx((1000.0, 1e5 / 1.1))
    assert (x.slip_front, x.steer) == pytest.approx((slip - 0.001, 0.199))


def relaxed(p: float, memory: dict[str, float], **changes: float) -> tuple[Any, Any]:
    bus = {"fy_front": 1000.0, "fy_rear": 500.0, "tangent_front": 1e5, "tangent_rear": 2e5, "vx": 10.0, "slow": 1.0,
           "dt": 0.02, "slip_change_front": 0.01, "slip_change_rear": 0.02, "yaw_rate": 0.1, "steer_lead": 0.0,
           **CAR}  # fmt: skip
    begun = {"begun": 0.0, "front": 0.0, "rear": 0.0, "front_steady": 0.0, "rear_steady": 0.0, "gone": 0.0}
    return step("tyre_relaxation", {"length": p}, bus | changes, begun | memory)


def test_forces_of_tyres_begin_as_they_are_and_then_follow_late() -> None:
    """0.2 m in a step with a length of 0.2 m: a whole constant of the way, so 1/e is left at its end."""
    x, m = relaxed(0.2, {})
    assert (m.front, m.rear, m.begun) == (1000.0, 500.0, 1.0)
    assert (x.fy_front, x.fy_rear) == (1000.0, 500.0)
    assert (m.gone, m.follow) == pytest.approx((1.0 - LEFT, LEFT))
    assert (x.tangent_front, x.tangent_rear) == pytest.approx((1e5 * (1.0 - 2.0 * LEFT), 2e5 * (1.0 - 2.0 * LEFT)))


def test_forces_of_tyres_go_on_from_the_last_step() -> None:
    last = {"begun": 1.0, "front": 200.0, "rear": 100.0, "front_steady": 600.0, "rear_steady": 300.0, "gone": 0.5,
            "follow": 0.25, "front_tangent": 4e4, "rear_tangent": 2e4}  # fmt: skip
    x, m = relaxed(0.2, last)
    assert (m.front, m.rear) == pytest.approx((200.0 + 200.0 + 100.0, 100.0 + 100.0 + 100.0))
    assert (m.front_steady, m.rear_steady, m.front_tangent, m.rear_tangent) == (1000.0, 500.0, 1e5, 2e5)
    assert x.fy_front == pytest.approx(1000.0 - 500.0 * (1.0 - LEFT))  # the mean over the step
    assert x.fy_rear == pytest.approx(500.0 - 200.0 * (1.0 - LEFT))


def test_forces_of_tyres_over_two_constants_of_the_way() -> None:
    """0.2 m with a length of 0.1 m: of 200 N that are missing, (1 - e^-2)/2 come in the mean of the step."""
    last = {"begun": 1.0, "front": 800.0, "rear": 500.0}
    x, m = relaxed(0.1, last)
    share = (1.0 - LEFT**2) / 2.0
    assert (m.gone, m.follow) == pytest.approx((2.0 * share, 1.0 - share))
    assert x.fy_front == pytest.approx(1000.0 - 200.0 * share)
    assert x.tangent_front == pytest.approx(1e5 * share)  # 1 - 2 (1 - share)/2


@pytest.mark.parametrize(("vx", "front", "rear"), [(2.0, 200.0, 100.0), (1.5, 137.5, 80.0), (1.0, 50.0, 40.0)])
def test_a_slow_car_has_the_forces_of_its_path(vx: float, front: float, rear: float) -> None:
    """m v r/L = 40 N/m times the speed: 50 N at the front and 40 N at the rear at 1 m/s; 0.02 s take half of the way
    at 1.5 m/s, where the blend is at its middle, and all of it where the car moves without slip."""
    last = {"begun": 1.0, "front": 200.0, "rear": 100.0}
    _, m = relaxed(0.2, last, vx=vx)
    assert (m.front, m.rear) == pytest.approx((front, rear))


def test_without_a_length_tyres_follow_at_once() -> None:
    x, m = relaxed(0.0, {"begun": 1.0, "front": 200.0, "rear": 100.0, "gone": 0.5, "follow": 0.5, "front_tangent": 0.0,
                         "rear_tangent": 0.0})  # fmt: skip
    assert (x.fy_front, x.fy_rear, m.front, m.rear, m.gone) == (1000.0, 500.0, 1000.0, 500.0, 0.0)
