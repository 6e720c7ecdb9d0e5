"""The kernel's step as plain Python functions: wishes, tyres, friction and motion.

The lateral motion is held against the single-track equations integrated in small steps: what the kernel's rule leaves
over must shrink with the square of the step, which it does only with every term of its Jacobian.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from plain_effects import Applied, bus

from vehicle.model.bus import GRAVITY
from vehicle.model.effects.cornering_drag import cornering_drag
from vehicle.model.effects.drive_lag import drive_lag
from vehicle.model.effects.gyro_bias import gyro_bias
from vehicle.model.kernel import ACCELERATION, COMMAND_COLUMNS, DYNAMIC, IMPOSED, KINEMATIC, PEDALS, SPEED

L, A, B, M, INERTIA = 2.8, 1.2, 1.6, 1600.0, 2500.0
CF, CR = 60e3, 80e3
STIFF = {"stiffness_front": CF, "stiffness_rear": CR, "steer_scale": 1.0, "mass_ref": M}
NAN = math.nan

Plain = Callable[..., Any]


@pytest.mark.parametrize(
    ("mode", "accel"), [(ACCELERATION, -1.5), (PEDALS, 0.25 * 4.0 - 0.5 * 8.0), (SPEED, 0.0), (IMPOSED, 0.0)]
)
def test_each_kind_of_input_wants_its_acceleration(plain: Plain, mode: int, accel: float) -> None:
    x = bus(accel_cmd=-1.5, throttle_cmd=0.25, brake_cmd=0.5, accel_lead=9.0, accel_jump=9.0)
    plain("_wish")(x, mode)
    assert (x.accel, x.accel_lead, x.accel_jump) == (accel, 0.0, 0.0)


@pytest.mark.parametrize(("throttle", "brake", "accel"), [(1.5, -1.0, 4.0), (-1.0, 1.5, -8.0)])
def test_pedals_end_at_their_stops(plain: Plain, throttle: float, brake: float, accel: float) -> None:
    x = bus(throttle_cmd=throttle, brake_cmd=brake)
    plain("_wish")(x, PEDALS)
    assert x.accel == accel


def test_a_steering_input_has_a_scale_and_a_zero(plain: Plain) -> None:
    """0.01 + 0.5 x 0.4 rad; that moves on by 0.5 x 0.02 rad begins half of it below its mean."""
    x = bus(steer_cmd=0.4, steer_scale=0.5, steer_zero=0.01, steer_slope=0.02, steer_glides=9.0)
    plain("_wish")(x, ACCELERATION)
    assert (x.steer, x.steer_lead, x.steer_glides) == pytest.approx((0.21, -0.005, 1.0))
    x = bus(steer_cmd=0.4, steer_scale=0.5, steer_glides=9.0)
    plain("_wish")(x, ACCELERATION)
    assert (x.steer, abs(x.steer_lead), x.steer_glides) == (0.2, 0.0, 0.0)


def test_tyres_slip_by_the_direction_of_their_axles(plain: Plain) -> None:
    x = bus(vx=10.0, vy=0.3, yaw_rate=0.2, steer=0.1, **STIFF)
    plain("_tyres")(x)
    front, rear = 0.1 - math.atan((0.3 + A * 0.2) / 10.0), -math.atan((0.3 - B * 0.2) / 10.0)
    assert (x.slip_front, x.slip_rear) == pytest.approx((front, rear))
    assert (x.fy_front, x.fy_rear, x.tangent_front, x.tangent_rear) == pytest.approx((CF * front, CR * rear, CF, CR))


@pytest.mark.parametrize("speed", [1.0, 0.5, -3.0])
def test_a_car_that_moves_without_slip_has_the_forces_of_its_path(plain: Plain, speed: float) -> None:
    """Its centre of gravity turns with v r, and the axles share m v r as they share the weight."""
    x = bus(vx=speed, vy=0.3, yaw_rate=0.2, steer=0.1, **STIFF)
    plain("_tyres")(x)
    front, rear = M * B / L * speed * 0.2, M * A / L * speed * 0.2
    assert (x.fy_front, x.fy_rear, x.tangent_front, x.tangent_rear) == pytest.approx((front, rear, 0.0, 0.0))
    assert (x.slip_front, x.slip_rear) == pytest.approx((front / CF, rear / CR))


@pytest.mark.parametrize(
    ("kind", "speed", "share"),
    [(DYNAMIC, 0.5, 0.0), (DYNAMIC, 1.0, 0.0), (DYNAMIC, 1.25, 0.15625), (DYNAMIC, 1.5, 0.5), (DYNAMIC, 2.0, 1.0),
     (DYNAMIC, 9.0, 1.0), (KINEMATIC, 9.0, 0.0)],
)  # fmt: skip
def test_tyres_come_in_smoothly_between_the_slow_speed_and_twice_that(
    plain: Plain, kind: int, speed: float, share: float
) -> None:
    assert plain("_blend")(bus(vx=speed), kind) == pytest.approx(share)


def test_gravity_pulls_by_the_sine_of_a_slope(plain: Plain) -> None:
    assert [plain("_pull")(slope) for slope in (0.0, 0.1, -0.1)] == pytest.approx(
        [0.0, -GRAVITY * math.sin(0.1), GRAVITY * math.sin(0.1)]
    )


def held(plain: Plain, kind: int = DYNAMIC, **fields: float) -> Any:
    """A bus of which a road of friction 0.5 took what it does not hold."""
    x = bus(road_friction=0.5, tangent_front=CF, tangent_rear=CR, **fields)
    plain("hold_along")(x)
    if kind == DYNAMIC:
        plain("hold_across")(x)
    plain("hold_path")(x, plain("left_across")(x))
    return x


HOLD = 0.5 * GRAVITY  # m/s^2 on level ground


def test_a_road_holds_friction_times_weight_along(plain: Plain) -> None:
    """Turning parts count with the mass; resistance takes its part of braking."""
    most = HOLD * (M + 100.0)
    assert held(plain, traction=1e5, rotating_mass=100.0).traction == pytest.approx(most)
    assert held(plain, traction=2e3).traction == 2e3
    assert held(plain, brake=1e5, resistance=500.0, rotating_mass=100.0).brake == pytest.approx(most - 500.0)
    assert held(plain, brake=1e5, resistance=1e5).brake == 0.0
    assert held(plain, brake=1e3).brake == 1e3


def test_a_slope_takes_weight_from_the_wheels(plain: Plain) -> None:
    assert held(plain, traction=1e5, grade=0.3).traction == pytest.approx(HOLD * math.cos(0.3) * M)


def across(share: float) -> float:
    """What is left across of the friction circle."""
    return HOLD * max(math.sqrt(1.0 - share * share), 0.05)


@pytest.mark.parametrize("share", [0.0, 0.6, -0.6, 1.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_across_the_road_holds_what_is_left_of_the_friction_circle(plain: Plain, share: float, side: float) -> None:
    force = share * HOLD * M
    left = across(share)
    fields = {"traction": max(force, 0.0), "brake": max(-force, 0.0), "vx": 20.0}
    x = held(plain, curvature=side * 0.05, fy_front=side * 4e3, fy_rear=side * 3e3, **fields)
    assert x.curvature == pytest.approx(side * left / 400.0)
    for found, tangent, was, slope, most in (
        (x.fy_front, x.tangent_front, 4e3, CF, left * M * B / L), (x.fy_rear, x.tangent_rear, 3e3, CR, left * M * A / L)
    ):  # fmt: skip
        assert found == pytest.approx(side * most * math.tanh(was / most))
        assert tangent == pytest.approx(slope * (1.0 - math.tanh(was / most) ** 2), abs=1e-6)


def test_a_curve_that_the_road_holds_stays(plain: Plain) -> None:
    assert held(plain, vx=20.0, curvature=0.01).curvature == 0.01
    x = held(plain, KINEMATIC, vx=20.0, curvature=0.01, fy_front=4e3)
    assert (x.fy_front, x.tangent_front) == (4e3, CF)


@pytest.mark.parametrize(
    ("fields", "speed"),
    [
        ({"traction": 3400.0}, 10.2),  # 0.1 s x 3400 N / 1700 kg
        ({"drag": -340.0}, 9.98),
        ({"brake": 1700.0, "resistance": 170.0}, 10.0 - 0.11),
        ({"brake": 1e6}, 0.0),  # dry friction stops the car and does not push it back
        ({"grade": 0.1}, 10.0 - 0.1 * M * GRAVITY * math.sin(0.1) / 1700.0),
        ({"vx": -10.0, "resistance": 170.0}, -9.99),
        ({"vx": -10.0, "brake": 1e6}, 0.0),
        ({"vx": 0.0, "drag": -340.0, "resistance": 340.0}, 0.0),
        ({"vx": 0.0, "drag": -680.0, "resistance": 340.0}, -0.02),
    ],
)
def test_speed_changes_by_forces_over_mass_and_turning_parts(
    plain: Plain, fields: dict[str, float], speed: float
) -> None:
    x = bus(**{"vx": 10.0, "rotating_mass": 100.0, **fields})
    assert plain("_along")(x, 0.0, ACCELERATION) == pytest.approx(speed)


def test_a_car_with_tyres_feels_them_along_too(plain: Plain) -> None:
    """m r vy - F_yf sin d, as far as it blends in."""
    x = bus(vx=10.0, yaw_rate=0.3, vy=0.5, fy_front=3e3, steer=0.1)
    gain = 0.1 * (0.3 * 0.5 - 3e3 * math.sin(0.1) / M)
    assert plain("_along")(x, 1.0, ACCELERATION) == pytest.approx(10.0 + gain)
    assert plain("_along")(x, 0.4, ACCELERATION) == pytest.approx(10.0 + 0.4 * gain)


def test_an_imposed_speed_is_the_one_asked_for(plain: Plain) -> None:
    assert plain("_along")(bus(vx=3.0, v_cmd=8.0, brake=1e6), 0.0, IMPOSED) == 8.0


def test_without_tyres_the_car_rolls_along_the_middle_of_its_curve(plain: Plain) -> None:
    """2 to 3 m/s in 0.1 s on a curvature of 0.2 1/m: the heading turns by 0.25 m of way."""
    x = bus(x=1.0, y=2.0, yaw=0.5, vx=2.0, yaw_rate=0.4, vy=0.64, curvature=0.2)
    plain("_move")(x, 0.0, 3.0, ACCELERATION)
    middle = 0.5 + 0.5 * 0.25 * 0.2
    assert (x.x, x.y, x.yaw) == pytest.approx(
        (1.0 + 0.25 * math.cos(middle), 2.0 + 0.25 * math.sin(middle), 0.5 + 0.05)
    )
    assert (x.vx, x.yaw_rate, x.vy, x.vy_rear) == pytest.approx((3.0, 0.6, 0.6 * B, 0.0))
    assert (x.ax, x.ay) == pytest.approx((10.0, 0.5 * 2.5))


def test_what_slides_sideways_moves_and_is_felt(plain: Plain) -> None:
    """The rear axle drifts at 0.4 m/s and stops within the step: half of it to the left, felt as -4 m/s^2."""
    x = bus(vx=2.0, vy_rear=0.4, grade=0.1, bank=-0.2)
    plain("_move")(x, 0.0, 2.0, ACCELERATION)
    assert (x.x, x.y) == pytest.approx((0.2 * math.cos(0.1), 0.02 * math.cos(0.2)))  # of the map
    assert (x.ax, x.ay) == pytest.approx((GRAVITY * math.sin(0.1), -4.0 - GRAVITY * math.sin(0.2)))


def single_track(state: Sequence[float], steer: float, *, accel: float, bank: float) -> np.ndarray:
    """Rates of x, y, yaw, v, vy, r: Rajamani, eqs. 2.24 to 2.31, slip angles as arc tangents; x, y, yaw in a map."""
    _, _, yaw, v, vy, r = state
    front = CF * (steer - math.atan((vy + A * r) / v))
    rear = -CR * math.atan((vy - B * r) / v)
    along = accel + r * vy - front * math.sin(steer) / M
    aside = (front * math.cos(steer) + rear) / M - GRAVITY * math.sin(bank) - v * r
    turn = (A * front * math.cos(steer) - B * rear + 300.0) / INERTIA
    side = (vy - B * r) * math.cos(bank)
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([v * c - side * s, v * s + side * c, r * math.cos(bank), along, aside, turn])


STATE = (0.0, 0.0, 0.4, 12.0, 0.2, 0.1)
STEER, ACCEL, BANK = 0.06, 1.5, 0.05


def exact(seconds: float) -> np.ndarray:
    """Runge and Kutta's rule of fourth order in steps of 1 ms."""
    state, h = np.array(STATE), 1e-3
    for _ in range(round(seconds / h)):
        k1 = single_track(state, STEER, accel=ACCEL, bank=BANK)
        k2 = single_track(state + 0.5 * h * k1, STEER, accel=ACCEL, bank=BANK)
        k3 = single_track(state + 0.5 * h * k2, STEER, accel=ACCEL, bank=BANK)
        k4 = single_track(state + h * k3, STEER, accel=ACCEL, bank=BANK)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return state


def moved(plain: Plain, dt: float, steps: int) -> Any:
    tyres, along, move = (plain(name) for name in ("_tyres", "_along", "_move"))
    motion = dict(zip(("x", "y", "yaw", "vx", "vy", "yaw_rate"), STATE, strict=True))
    side = STATE[4] - B * STATE[5]
    x = bus(dt=dt, **motion, vy_rear=side, steer=STEER, traction=M * ACCEL, bank=BANK, yaw_moment=300.0, **STIFF)
    for _ in range(steps):
        tyres(x)
        move(x, 1.0, along(x, 1.0, ACCELERATION), ACCELERATION)
    return x


def test_motion_with_tyres_is_of_second_order(plain: Plain) -> None:
    """A quarter of the step, a sixteenth of the error of heading, drift and yaw rate; position and speed are near."""
    reference = exact(0.4)
    errors = []
    for steps in (20, 80):
        x = moved(plain, 0.4 / steps, steps)
        errors.append(np.abs(np.array([x.x, x.y, x.yaw, x.vx, x.vy, x.yaw_rate]) - reference))
        assert x.vy_rear == pytest.approx(x.vy - B * x.yaw_rate)
    assert (errors[0][:2] < 2e-5).all()  # m, of 4.9
    assert errors[0][3] < 5e-5  # m/s: the rule leaves out by how much the slip changes with the speed
    turning = [2, 4, 5]
    assert (errors[0][turning] < 2e-4).all()
    assert (errors[1][turning] < errors[0][turning] / 11.0).all(), errors[0] / errors[1]


def test_accelerations_felt_at_the_rear_axle_are_those_of_the_motion(plain: Plain) -> None:
    """v' - r vy and vy' + r v there, and what holds the car on the bank, in the middle of the step."""
    dt = 1e-3
    x = moved(plain, dt, 1)
    before, after = exact(0.0), exact(dt)
    side = [state[4] - B * state[5] for state in (before, after)]
    middle = 0.5 * (before + after)
    assert x.ax == pytest.approx((after[3] - before[3]) / dt - middle[5] * 0.5 * sum(side), rel=1e-3)
    assert x.ay == pytest.approx((side[1] - side[0]) / dt + middle[5] * middle[3] + GRAVITY * math.sin(BANK), rel=1e-3)


def test_the_step_tells_by_how_much_motion_changed_the_slip(plain: Plain) -> None:
    """Of drift and yaw rate, at the speed it began with."""
    x = moved(plain, 1e-3, 1)
    vy, r, v = STATE[4], STATE[5], STATE[3]
    front = math.atan((vy + A * r) / v) - math.atan((x.vy + A * x.yaw_rate) / v)
    rear = math.atan((vy - B * r) / v) - math.atan((x.vy - B * x.yaw_rate) / v)
    assert (x.slip_change_front, x.slip_change_rear) == pytest.approx((front, rear), rel=1e-2)
    plain("_move")(x, 0.0, x.vx, ACCELERATION)
    assert (x.slip_change_front, x.slip_change_rear) == (0.0, 0.0)


@pytest.mark.parametrize("blend", [0.1, 0.5, 0.9])
def test_slip_fades_into_the_kinematic_motion(plain: Plain, blend: float) -> None:
    """With a time constant of 20 ms in the middle of the blend: share dt (1 - b) / (dt (1 - b) + b 20 ms)."""

    def after(share: float) -> Any:
        x = bus(dt=0.01, vx=1.5, vy=0.1, yaw_rate=0.2, vy_rear=0.1 - B * 0.2, steer=0.1, curvature=0.15, **STIFF)
        plain("_tyres")(x)
        plain("_move")(x, share, 1.5, IMPOSED)
        return x

    full, x = after(1.0), after(blend)
    fade = 0.01 * (1.0 - blend) / (0.01 * (1.0 - blend) + blend * 0.02)
    kinematic = 1.5 * 0.15
    assert x.yaw_rate == pytest.approx(full.yaw_rate + fade * (kinematic - full.yaw_rate))
    assert x.vy == pytest.approx(full.vy + fade * (kinematic * B - full.vy))


def test_lateral_motion_changes_no_imposed_speed_and_starts_no_standing_car(plain: Plain) -> None:
    for mode, v1 in ((IMPOSED, 12.0), (ACCELERATION, 0.0)):
        x = bus(vx=12.0, vy=0.2, yaw_rate=0.1, steer=0.1, **STIFF)
        plain("_tyres")(x)
        plain("_move")(x, 1.0, v1, mode)
        assert x.vx == v1


def test_instruments_show_the_motion_at_the_start_of_a_step(plain: Plain) -> None:
    """Without tyres: r = v tan d / L, v r across, and the speed's change along; levers and lead count."""
    x = bus(x=1.0, y=2.0, yaw=0.3, vx=5.0, steer=0.1, steer_lead=0.02, grade=0.05, bank=0.04, lean_y=0.2, ax_x=1.5)
    plain("_look")(x, 0.0, 5.3)
    r = 5.0 * math.tan(0.12) / L
    assert (x.meas_x, x.meas_y, x.meas_yaw, x.meas_v, x.meas_yaw_rate) == pytest.approx((1.0, 2.0, 0.3, 5.0, r))
    assert x.meas_ay == pytest.approx(5.0 * r + GRAVITY * math.sin(0.04) + 0.2)
    assert x.meas_ax == pytest.approx(3.0 - 1.5 * r * r + GRAVITY * math.sin(0.05))


def test_instruments_of_a_car_with_tyres_feel_its_forces(plain: Plain) -> None:
    """The force of both axles over mass, and the turn with the lever of the instrument from the centre of gravity; of
    the kinematic part v r, and with the lever from the rear axle r' = v' tan d / L + v d' / (L cos^2 d)."""
    forces = {"fy_front": 3e3, "fy_rear": 2e3, "tangent_front": CF, "yaw_moment": 400.0, "turning_inertia": INERTIA}
    x = bus(vx=10.0, yaw_rate=0.3, vy_rear=0.2, steer=0.1, steer_lead=0.01, ay_x=2.0, **forces)
    plain("_look")(x, 1.0, 10.1)
    front = (3e3 + CF * 0.01) * math.cos(0.11)
    turn = (A * front - B * 2e3 + 400.0) / INERTIA
    assert x.meas_yaw_rate == pytest.approx(0.3)
    assert x.meas_ay == pytest.approx((front + 2e3) / M + (2.0 - B) * turn)
    assert x.meas_ax == pytest.approx(1.0 - 0.3 * 0.2)
    half = bus(vx=10.0, yaw_rate=0.3, vy_rear=0.2, steer=0.1, steer_lead=0.01, ay_x=2.0, **forces)
    plain("_look")(half, 0.5, 10.1)
    kinematic = 10.0 * math.tan(0.11) / L
    assert half.meas_yaw_rate == pytest.approx(0.5 * (0.3 + kinematic))
    turning = (1.0 * math.tan(0.11) - 10.0 * (0.02 / 0.1) / math.cos(0.11) ** 2) / L
    assert half.meas_ay == pytest.approx(0.5 * (x.meas_ay + 10.0 * kinematic + 2.0 * turning))
    assert half.meas_ax == pytest.approx(1.0 - 0.5 * half.meas_yaw_rate * 0.2)


@pytest.mark.parametrize(
    ("vx", "lead", "v1", "shown"),
    [(5.0, 0.6, 5.1, 1.0 + 0.6 * 1500.0 / 1700.0), (0.0, 0.6, 0.1, 1.0 + 0.6 * 1500.0 / 1700.0), (0.0, -3.0, 0.1, 0.0),
     (5.0, 0.6, 0.0, -50.0), (0.0, 9.0, 0.0, 0.0)],
)  # fmt: skip
def test_an_acceleration_is_shown_as_it_begins(plain: Plain, vx: float, lead: float, v1: float, shown: float) -> None:
    """The mean and its lead, of the reference mass over that of car and turning parts; brakes push no standing car."""
    x = bus(vx=vx, accel_lead=lead, rotating_mass=100.0)
    plain("_look")(x, 0.0, v1)
    assert x.meas_ax == pytest.approx(shown)


MOTION = {"x": 1.0, "y": 2.0, "yaw": 0.3, "vx": 4.0, "vy_rear": 0.2, "yaw_rate": 0.5, "curvature": 0.1}


def test_a_restart_takes_the_whole_state(plain: Plain) -> None:
    x = bus(**MOTION)
    plain("_restart")(x, np.array([10.0, 20.0, 1.0, 8.0, 0.7, 0.9]))
    assert (x.x, x.y, x.yaw, x.vx, x.vy_rear, x.yaw_rate) == (10.0, 20.0, 1.0, 8.0, 0.7, 0.9)
    assert x.vy == pytest.approx(0.7 + B * 0.9)
    assert (x.old_x, x.old_y, x.old_yaw, x.moved) == (1.0, 2.0, 0.3, 1.0)


def test_what_a_restart_does_not_know_runs_on(plain: Plain) -> None:
    x = bus(**MOTION)
    plain("_restart")(x, np.full(6, NAN))
    assert {name: getattr(x, name) for name in MOTION} == MOTION


def test_of_a_state_only_what_is_known_is_taken(plain: Plain) -> None:
    x = bus(**MOTION)
    plain("_restart")(x, np.array([NAN, NAN, NAN, NAN, 0.7, NAN]))
    assert (x.vy_rear, x.yaw_rate) == (0.7, 0.5)
    assert x.vy == pytest.approx(0.7 + B * 0.5)
    x = bus(**MOTION)
    plain("_restart")(x, np.array([NAN, 20.0, NAN, NAN, NAN, 0.9]))
    assert (x.x, x.y, x.yaw, x.vy_rear, x.yaw_rate) == (1.0, 20.0, 0.3, 0.2, 0.9)
    x = bus(**MOTION)
    plain("_restart")(x, np.array([10.0, NAN, 1.0, NAN, NAN, NAN]))
    assert (x.x, x.y, x.yaw, x.vx) == (10.0, 2.0, 1.0, 4.0)


def test_lateral_motion_runs_on_in_proportion_to_the_speed(plain: Plain) -> None:
    x = bus(**MOTION)
    plain("_restart")(x, np.array([NAN, NAN, NAN, 6.0, NAN, NAN]))
    assert (x.vx, x.yaw_rate, x.vy_rear, x.vy) == pytest.approx((6.0, 0.75, 0.3, 0.3 + B * 0.75))
    x = bus(**{**MOTION, "vx": 1.0})  # slow: as the wheels roll
    plain("_restart")(x, np.array([NAN, NAN, NAN, 6.0, NAN, NAN]))
    assert (x.vx, x.yaw_rate, x.vy_rear) == pytest.approx((6.0, 0.6, 0.0))


def test_the_twin_steps_and_writes_each_so_many(plain: Plain) -> None:
    """Two commands of four steps of 0.1 s, a row each second step: 1 m/s^2, then none; the sensor shows its bias."""
    x, trace = bus(vx=5.0, z=0.7, t=3.0, t_start=3.0, steer_scale=1.0), np.zeros((9, 12))
    x.mass_ref = M
    commands = np.zeros((2, 6))
    commands[:, :2] = [[0.05, 1.0], [0.05, 0.0]]
    rows = plain("run", Applied(gyro_bias, b=0.02))(
        [x], KINEMATIC, ACCELERATION, None, None, None, None, commands, 4, 2, True, trace
    )
    assert (rows, x.count, x.t) == (4, 8.0, pytest.approx(3.8))
    assert trace[:4, 0] == pytest.approx([3.2, 3.4, 3.6, 3.8])
    assert trace[:4, 5] == pytest.approx([5.2, 5.4, 5.4, 5.4])
    assert trace[:4, 8] == pytest.approx([v * math.tan(0.05) / L + 0.02 for v in (5.2, 5.4, 5.4, 5.4)])
    assert trace[:4, 3] == pytest.approx([0.7] * 4)
    assert trace[:4, 11] == pytest.approx([0.05] * 4)
    bare = np.zeros((9, 12))
    plain("run", Applied(gyro_bias, b=0.02))(
        [x], KINEMATIC, ACCELERATION, None, None, None, None, commands[1:], 2, 2, False, bare
    )
    assert bare[0, 8] == pytest.approx(5.4 * math.tan(0.05) / L)


def test_brakes_hold_a_standing_car_until_the_drive_arrives(plain: Plain) -> None:
    """A command from -1 to 3 m/s^2 within the step: it holds until the drive has come, and then that pushes alone."""
    x = bus(accel_cmd=1.0, vx=0.0)
    x.mass_ref = M

    class Change(Applied):
        def __call__(self, on: Any) -> Any:
            on.accel, on.accel_lead, on.accel_jump, on.accel_arrived = 1.0, -2.0, -2.0, 3.0
            return on

    act = plain("_act", Change(drive_lag))
    act(x, KINEMATIC, ACCELERATION, [x], None, None, None, None)
    assert x.accel == pytest.approx(0.5 * 3.0)  # half of the step had the brake
    assert x.accel + x.accel_lead == pytest.approx(-1.0)
    assert (x.traction, x.brake) == (pytest.approx(1.5 * M), 0.0)
    rolling = bus(accel_cmd=1.0, vx=0.1)
    act(rolling, KINEMATIC, ACCELERATION, [rolling], None, None, None, None)
    assert rolling.accel == 1.0


@pytest.mark.parametrize(("accel", "traction", "brake"), [(2.0, 3000.0, 0.0), (-2.0, 0.0, 3000.0)])
def test_a_wanted_acceleration_is_a_force_of_the_reference_mass(
    plain: Plain, accel: float, traction: float, brake: float
) -> None:
    x = bus(
        accel_cmd=accel, vx=5.0, road_grade=0.02, road_bank=0.03, steer_cmd=0.1, steer_scale=1.0, drag=9.0, lean_y=9.0
    )
    plain("_act")(x, KINEMATIC, ACCELERATION, [x], None, None, None, None)
    assert (x.traction, x.brake, x.grade, x.bank, x.drag, x.lean_y) == (traction, brake, 0.02, 0.03, 0.0, 0.0)
    assert x.curvature == pytest.approx(math.tan(0.1) / L)


@pytest.mark.parametrize(
    ("kind", "speed", "curvature"),
    [
        (DYNAMIC, 10.0, 0.03),
        (DYNAMIC, 2.5, 0.12),
        (DYNAMIC, 2.0, math.tan(0.1) / L),
        (KINEMATIC, 10.0, math.tan(0.1) / L),
    ],
)
def test_forces_see_the_curve_that_is_driven_and_that_of_the_wheels_where_there_are_no_tyres(
    plain: Plain, kind: int, speed: float, curvature: float
) -> None:
    """Tyres count fully from 2 m/s on. The drag of a curve is c m v^2 k; it turns by 0.3 rad/s, steered 0.1 rad."""
    x = bus(vx=speed, yaw_rate=0.3, steer_cmd=0.1, steer_scale=1.0)
    plain("_act", Applied(cornering_drag, c=0.05))(x, kind, ACCELERATION, [x], None, None, None, None)
    assert x.resistance == pytest.approx(0.05 * M * speed**2 * curvature)
    assert x.curvature == pytest.approx(math.tan(0.1) / L)


def test_instruments_without_errors_write_what_the_car_does(plain: Plain) -> None:
    x = bus(**MOTION, ax=0.7, ay=-0.6, steer=0.2, t=3.0, z=0.9)
    plain("_show")(x, 0.4)
    true, shown = np.full(12, NAN), np.full(12, NAN)
    plain("_write")(true, x, False)
    plain("_write")(shown, x, True)
    assert true.tolist() == shown.tolist() == [3.0, 1.0, 2.0, 0.9, 0.3, 4.0, 4.0, 0.2, 0.5, 0.7, -0.6, 0.2]


def test_instruments_ahead_of_the_rear_axle_feel_the_turning(plain: Plain) -> None:
    """A rigid body: - r^2 along and r' across for each metre. It turned by 0.4 rad/s 0.01 s ago, by 0.5 now."""
    x = bus(**MOTION, ax=0.7, ay=-0.6, dt=0.01, ax_x=1.5, ay_x=1.2)
    plain("_show")(x, 0.4)
    assert (x.meas_ax, x.meas_ay) == pytest.approx((0.7 - 1.5 * 0.25, -0.6 + 1.2 * 10.0))
    assert (x.ax, x.ay) == (0.7, -0.6)


def test_each_column_of_commands_is_what_its_name_says(plain: Plain) -> None:
    x, given = bus(vx=5.0), 0.1 * np.arange(1.0, 7.0)
    plain("run")([x], KINEMATIC, IMPOSED, None, None, None, None, given[None], 1, 1, False, np.zeros((1, 12)))
    assert [getattr(x, name) for name in COMMAND_COLUMNS] == given.tolist()
    assert x.vx == given[COMMAND_COLUMNS.index("v_cmd")]
