"""Effects on forces, tyres and road: each equation by numbers that one can work out by hand."""

from __future__ import annotations

import math
from typing import Any

import pytest
from plain_effects import Applied, applied, bus

from vehicle.model.bus import GRAVITY
from vehicle.model.effects.aero_drag import aero_drag
from vehicle.model.effects.axle_load_shift import axle_load_shift
from vehicle.model.effects.body_roll import body_roll
from vehicle.model.effects.cornering_compliance import cornering_compliance
from vehicle.model.effects.cornering_drag import cornering_drag
from vehicle.model.effects.gear_inertia import gear_inertia
from vehicle.model.effects.headwind import headwind
from vehicle.model.effects.load_transfer import load_transfer
from vehicle.model.effects.motor_damping import motor_damping
from vehicle.model.effects.motor_inertia import motor_inertia
from vehicle.model.effects.motor_torque import motor_torque
from vehicle.model.effects.parallel_steering import parallel_steering
from vehicle.model.effects.power_limit import power_limit
from vehicle.model.effects.road_bank import road_bank
from vehicle.model.effects.road_grade import road_grade
from vehicle.model.effects.road_profile import road_profile
from vehicle.model.effects.roll_dynamics import roll_dynamics
from vehicle.model.effects.rolling_resistance import rolling_resistance
from vehicle.model.effects.steer_compliance import steer_compliance
from vehicle.model.effects.steered_wheel_forces import steered_wheel_forces
from vehicle.model.effects.tyre_relaxation import tyre_relaxation
from vehicle.model.effects.tyre_saturation import tyre_saturation
from vehicle.model.effects.understeer import understeer
from vehicle.model.effects.viscous_resistance import viscous_resistance
from vehicle.model.effects.yaw_inertia import yaw_inertia

TYRES = {"fy_front": 3000.0, "fy_rear": 2000.0, "tangent_front": 60e3, "tangent_rear": 80e3}


@pytest.mark.parametrize("speed", [20.0, -20.0])
def test_resistances_are_against_the_motion_on_top_of_what_is_there(speed: float) -> None:
    """Of the reference mass of 1500 kg: k v^2 and c v; dry friction of the 1600 kg that the car has."""
    sign = math.copysign(1.0, speed)
    assert applied(aero_drag, bus(vx=speed, drag=5.0), k=5e-4).drag == pytest.approx(5.0 - sign * 300.0)
    assert applied(viscous_resistance, bus(vx=speed, drag=5.0), c=0.01).drag == pytest.approx(5.0 - sign * 300.0)
    assert applied(rolling_resistance, bus(vx=speed, resistance=5.0), c=0.1).resistance == pytest.approx(165.0)


@pytest.mark.parametrize("curvature", [0.02, -0.02])
def test_a_curve_takes_its_share_of_the_lateral_acceleration(curvature: float) -> None:
    """10^2 x 0.02 = 2 m/s^2, of 1600 kg."""
    x = applied(cornering_drag, bus(vx=10.0, curvature=curvature, resistance=5.0), c=0.05)
    assert x.resistance == pytest.approx(5.0 + 0.05 * 1600.0 * 2.0)


def test_wind_changes_what_the_air_does() -> None:
    """10 m/s into 5 m/s: 15^2 - 10^2; with 15 m/s from behind the air pushes with 5^2, and 10^2 are gone. As all forces
    of the air, it is that of the reference mass of 1500 kg, whatever is loaded."""
    assert applied(headwind, bus(vx=10.0, drag=5.0), speed=5.0, k=1e-3).drag == pytest.approx(5.0 - 1.5 * 125.0)
    assert applied(headwind, bus(vx=10.0), speed=-15.0, k=1e-3).drag == pytest.approx(1.5 * 125.0)


@pytest.mark.parametrize(("yaw", "ahead"), [(0.3, 5.0), (0.3 + math.pi, -5.0), (0.3 + math.pi / 3.0, 2.5)])
def test_wind_with_a_direction_acts_with_its_part_along_the_car(yaw: float, ahead: float) -> None:
    drag = applied(headwind, bus(vx=10.0, yaw=yaw), speed=5.0, k=1e-3, heading=0.3).drag
    assert drag == pytest.approx(-1.5 * ((10.0 + ahead) ** 2 - 100.0))


@pytest.mark.parametrize(("accel", "damping"), [(-3.0, 0.02), (0.0, 0.02), (1.0, 0.035), (4.0, 0.08), (9.0, 0.08)])
def test_a_motor_brakes_by_its_damping(accel: float, damping: float) -> None:
    """Between what it is without and with full throttle (4 m/s^2); gear 9 over 0.3 m makes (30 1/m)^2."""
    for speed in (2.0, -2.0):
        x = applied(motor_damping, bus(accel=accel, vx=speed, resistance=5.0), full=0.08, zero=0.02)
        assert (x.resistance, x.drag) == (pytest.approx(5.0 + damping * 900.0 * 2.0), 0.0)
        assert x.drive_drag == pytest.approx(damping * 900.0 * 2.0)


def test_a_motor_adds_its_inertia_by_the_square_of_the_gear() -> None:
    assert applied(motor_inertia, bus(rotating_mass=5.0), J=0.05).rotating_mass == pytest.approx(50.0)


@pytest.mark.parametrize(("speed", "mass"), [(0.0, 300.0), (-4.0, 300.0), (8.0, 75.0), (-16.0, 18.75)])
def test_an_engine_adds_less_in_higher_gears(speed: float, mass: float) -> None:
    """A fifth of 1500 kg, for which commands hold, up to 4 m/s; twice as fast a half of the ratio, a quarter of it."""
    x = applied(gear_inertia, bus(vx=speed, rotating_mass=5.0), share=0.2, v1=4.0)
    assert x.rotating_mass == pytest.approx(5.0 + mass)


@pytest.mark.parametrize(
    ("speed", "torque"),
    [
        (0.0, 100.0),
        (100.0, 100.0),
        (200.0, 100.0),
        (300.0, 85.0),
        (400.0, 70.0),
        (560.0, 50.0),
        (700.0, 40.0),
        (701.0, 0.0),
    ],
)
def test_a_motor_has_the_torque_of_its_curve(speed: float, torque: float) -> None:
    """100 N m up to 200 rad/s, straight to P / w = 70 N m at 400 rad/s, P / w to 700 rad/s; 30 1/m at the road."""
    curve = {"torque": 100.0, "corner_speed": 200.0, "power": 28e3, "rated_speed": 400.0, "max_speed": 700.0}
    x = applied(motor_torque, bus(vx=speed / 30.0, traction=1e5), **curve)
    assert x.traction == pytest.approx(30.0 * torque)
    assert applied(motor_torque, bus(vx=speed / 30.0, traction=1.0), **curve).traction == (1.0 if torque else 0.0)


def test_a_motor_of_much_power_keeps_its_torque() -> None:
    """1 MW at 400 rad/s would be 2500 N m: it stays at 100 N m, on the way there too."""
    curve = {"torque": 100.0, "corner_speed": 200.0, "power": 1e6, "rated_speed": 400.0, "max_speed": 700.0}
    for speed in (300.0, 400.0, 600.0):
        assert applied(motor_torque, bus(vx=speed / 30.0, traction=1e5), **curve).traction == pytest.approx(3000.0)


def test_a_standing_motor_has_its_torque() -> None:
    assert applied(motor_torque, bus(vx=0.0, traction=1e5), torque=100.0, power=1e3).traction == pytest.approx(3000.0)


def test_power_limits_the_traction_with_speed() -> None:
    """20 W/kg of 1500 kg at 10 m/s: 3000 N; the step has no lead left then."""
    x = applied(power_limit, bus(vx=10.0, traction=4000.0, accel_lead=0.3), limit=20.0)
    assert (x.traction, x.accel_lead) == (pytest.approx(3000.0), 0.0)
    x = applied(power_limit, bus(vx=10.0, traction=2999.0, accel_lead=0.3), limit=20.0)
    assert (x.traction, x.accel_lead) == (2999.0, 0.3)


@pytest.mark.parametrize(
    ("vx", "brake", "traction", "shift"),
    [(9.0, 3200.0, 0.0, -1), (9.0, 0.0, 3200.0, 1), (-9.0, 3200.0, 0.0, 1), (-9.0, 0.0, 3200.0, 1)],
)
def test_a_force_along_shifts_load_between_the_axles(vx: float, brake: float, traction: float, shift: int) -> None:
    """3200 N of 1600 kg, whatever mass commands are for: 2 m/s^2; c 2 / g L over the arm of the other axle, 1.6 and
    1.2 m. Brakes hold back, whichever way the car rolls."""
    x = applied(axle_load_shift, bus(vx=vx, brake=brake, traction=traction, **TYRES), c=0.3)
    moved = shift * 0.3 * 2.0 / GRAVITY * 2.8
    front, rear = 1.0 - moved / 1.6, 1.0 + moved / 1.2
    assert (x.fy_front, x.tangent_front) == pytest.approx((3000.0 * front, 60e3 * front))
    assert (x.fy_rear, x.tangent_rear) == pytest.approx((2000.0 * rear, 80e3 * rear))


def test_load_shifts_by_what_reaches_the_road() -> None:
    """4000 N drive 1600 kg and turning parts of 400 kg against 1000 N of tyres and 600 N of the air: 1.2 m/s^2, for
    which the parts take 480 N; the air pushes in the middle of the car, and the tyres hold 2520 N."""
    forces = {"traction": 4000.0, "resistance": 1000.0, "drag": -600.0, "rotating_mass": 400.0}
    x = applied(axle_load_shift, bus(vx=9.0, **forces, **TYRES), c=0.3)
    assert x.load_front == pytest.approx(1.0 - 0.3 * 2520.0 / 1600.0 / GRAVITY * 2.8 / 1.6)
    still = applied(axle_load_shift, bus(**forces, **TYRES), c=0.3)
    assert still.load_front == pytest.approx(1.0 - 0.3 * 3000.0 / 1600.0 / GRAVITY * 2.8 / 1.6)


@pytest.mark.parametrize(("brake", "front", "rear"), [(1e6, 1.8, 0.2), (-1e6, 0.2, 1.8)])
def test_an_axle_keeps_a_fifth_of_its_load(brake: float, front: float, rear: float) -> None:
    x = applied(axle_load_shift, bus(vx=9.0, brake=brake, **TYRES), c=0.3)
    assert (x.fy_front, x.fy_rear) == pytest.approx((3000.0 * front, 2000.0 * rear))


def test_compliance_adds_the_same_slip_to_both_axles_for_an_acceleration() -> None:
    """F / C + D F / m_axle: the front carries m 1.6 / 2.8, the rear m 1.2 / 2.8."""
    x = applied(cornering_compliance, bus(**TYRES), D=0.01)
    for force, was, tangent, load in (
        (x.fy_front, 3000.0, 60e3, 1600.0 * 1.6 / 2.8),
        (x.fy_rear, 2000.0, 80e3, 1600.0 * 1.2 / 2.8),
    ):
        assert force / tangent + 0.01 * force / load == pytest.approx(was / tangent)
    assert x.tangent_front == pytest.approx(x.fy_front * 60e3 / 3000.0)
    assert x.tangent_rear == pytest.approx(x.fy_rear * 80e3 / 2000.0)


@pytest.mark.parametrize("gradient", [0.01, -0.01])
def test_an_understeer_gradient_softens_one_axle(gradient: float) -> None:
    """K = m/L (b/C_f - a/C_r) (Rajamani, eq. 3.12) grows by K; for K > 0 the rear stays, for K < 0 the front."""
    x = applied(understeer, bus(**TYRES), K=gradient)
    load = 1600.0 / 2.8
    before, after = (load * (1.6 / f - 1.2 / r) for f, r in ((60e3, 80e3), (x.tangent_front, x.tangent_rear)))
    assert after - before == pytest.approx(gradient)
    assert (x.fy_front / x.tangent_front, x.fy_rear / x.tangent_rear) == pytest.approx((0.05, 0.025))
    assert (x.tangent_rear == 80e3, x.tangent_front == 60e3) == (gradient > 0.0, gradient < 0.0)


def test_neutral_steer_changes_nothing() -> None:
    x = applied(understeer, bus(**TYRES))
    assert {key: getattr(x, key) for key in TYRES} == TYRES


@pytest.mark.parametrize(
    ("yaw_rate", "left"),
    [(0.5, 1.0 - 0.2 * (5.0 / GRAVITY) ** 2), (-0.5, 1.0 - 0.2 * (5.0 / GRAVITY) ** 2), (2.0, 0.8)],
)
def test_load_transfer_takes_stiffness_with_the_square_of_lateral_acceleration(yaw_rate: float, left: float) -> None:
    """Beyond 1 g no more: 0.2 of it."""
    x = applied(load_transfer, bus(vx=10.0, yaw_rate=yaw_rate, **TYRES), c=0.2)
    assert {key: getattr(x, key) for key in TYRES} == pytest.approx({key: value * left for key, value in TYRES.items()})


def test_load_moves_by_what_a_bank_makes_tyres_hold_too() -> None:
    """5 m/s^2 of a turn, on a road that sinks to its inside by an eighth: the tyres hold an eighth of g less."""
    x = applied(load_transfer, bus(vx=10.0, yaw_rate=0.5, bank=-math.asin(0.125), **TYRES), c=0.2)
    assert x.fy_front == pytest.approx(TYRES["fy_front"] * (1.0 - 0.2 * (5.0 / GRAVITY - 0.125) ** 2))


def test_tyres_saturate_at_their_share_of_the_load() -> None:
    """6 m/s^2 of 1600 kg, 1.6 / 2.8 of it at the front; F = M tanh(F / M) with the slope 1 - tanh^2."""
    x = applied(tyre_saturation, bus(**TYRES), limit=6.0)
    for force, tangent, was, slope, most in (
        (x.fy_front, x.tangent_front, 3000.0, 60e3, 9600.0 * 1.6 / 2.8),
        (x.fy_rear, x.tangent_rear, 2000.0, 80e3, 9600.0 * 1.2 / 2.8),
    ):
        assert force == pytest.approx(most * math.tanh(was / most))
        assert tangent == pytest.approx(slope * (1.0 - math.tanh(was / most) ** 2))
    assert applied(tyre_saturation, bus(**TYRES)).fy_front == 3000.0


@pytest.mark.parametrize("brake", [0.0, 6000.0])
def test_what_tyres_hold_at_most_follows_the_load(brake: float) -> None:
    """Far beyond their limit both axles hold friction times load. Moments about the contact points of the other axle:
    load = m (g l + a h)/L, here with a centre of gravity 0.5 m high."""
    x = bus(vx=20.0, brake=brake, fy_front=1e7, fy_rear=1e7)
    x = applied(tyre_saturation, applied(axle_load_shift, x, c=0.5 / 2.8), limit=6.0)
    slows = brake / 1600.0
    assert x.fy_front == pytest.approx(6.0 / GRAVITY * 1600.0 * (GRAVITY * 1.6 + slows * 0.5) / 2.8)
    assert x.fy_rear == pytest.approx(6.0 / GRAVITY * 1600.0 * (GRAVITY * 1.2 - slows * 0.5) / 2.8)


def test_relaxation_is_a_lag_over_the_way() -> None:
    """0.6 m at 6 m/s: 0.1 s. Held forces stay; after a change of steady force the first step shows 1 - share of it."""
    relaxing = Applied(tyre_relaxation, length=0.6)
    x = relaxing(bus(vx=6.0, **TYRES))
    assert (x.fy_front, x.fy_rear) == (3000.0, 2000.0)
    gone = 1.0 - math.exp(-1.0)
    mean = 1.0 - 2.0 * (1.0 - gone)
    assert (x.tangent_front, x.tangent_rear) == pytest.approx((60e3 * mean, 80e3 * mean))
    x = relaxing(bus(vx=6.0, fy_front=4000.0, fy_rear=1000.0, tangent_front=60e3, tangent_rear=80e3))
    assert x.fy_front == pytest.approx(4000.0 - 1000.0 * gone)
    assert x.fy_rear == pytest.approx(1000.0 + 1000.0 * gone)
    x = relaxing(bus(vx=6.0, fy_front=4000.0, fy_rear=1000.0, tangent_front=60e3, tangent_rear=80e3))
    assert x.fy_front == pytest.approx(4000.0 - 1000.0 * math.exp(-1.0) * gone)
    assert x.fy_rear == pytest.approx(1000.0 + 1000.0 * math.exp(-1.0) * gone)


def test_slip_that_moved_during_the_last_step_has_moved_the_forces_too() -> None:
    """A steady force that runs up by C da over a step of one time constant has come to C da e^-1 at its end."""
    relaxing, gone = Applied(tyre_relaxation, length=0.6), 1.0 - math.exp(-1.0)
    relaxing(bus(vx=6.0, **TYRES))
    relaxing(bus(vx=6.0, **TYRES, slip_change_front=0.01, slip_change_rear=-0.02))
    assert relaxing.memory.front == pytest.approx(3000.0 + 60e3 * 0.01 * (1.0 - gone))
    assert relaxing.memory.rear == pytest.approx(2000.0 - 80e3 * 0.02 * (1.0 - gone))


def test_relaxing_forces_begin_a_step_as_the_last_one_left_them() -> None:
    """Steered by 0.01 rad more at its start than in its mean, whose tangent counts for that already."""
    relaxing = Applied(tyre_relaxation, length=0.6)
    relaxing(bus(vx=6.0, **TYRES))
    x = relaxing(bus(vx=6.0, steer_lead=0.01, **{**TYRES, "fy_front": 4000.0, "fy_rear": 1000.0}))
    assert x.fy_front + x.fy_front_lead + 0.01 * x.tangent_front == pytest.approx(3000.0)
    assert x.fy_rear + x.fy_rear_lead == pytest.approx(2000.0)
    x = Applied(tyre_relaxation, length=0.0)(bus(vx=6.0, fy_front_lead=5.0, fy_rear_lead=5.0, **TYRES))
    assert (x.fy_front_lead, x.fy_rear_lead) == (0.0, 0.0)


def test_relaxation_counts_no_slower_than_the_slow_speed() -> None:
    relaxing = Applied(tyre_relaxation, length=0.2)
    relaxing(bus(vx=0.1, **TYRES))  # 1 m/s x 0.1 s over 0.2 m
    assert relaxing.memory.gone == pytest.approx(1.0 - math.exp(-0.5))


@pytest.mark.parametrize(("vx", "share"), [(0.8, 1.0), (1.5, 0.8333), (2.5, 0.0)])
def test_a_car_that_moves_without_slip_hands_the_forces_of_its_path_over(vx: float, share: float) -> None:
    """m v r = 1600 x v x 0.3 on the axles by the arms 1.6 and 1.2 of 2.8 m; at 1.5 m/s, half way, a step of
    0.1 s takes 0.1 / (0.1 + 0.02) of them over."""
    relaxing = Applied(tyre_relaxation, length=0.6)
    relaxing(bus(vx=vx, yaw_rate=0.3))
    across = 1600.0 * vx * 0.3 / 2.8
    assert (relaxing.memory.front, relaxing.memory.rear) == pytest.approx(
        (share * 1.6 * across, share * 1.2 * across), rel=1e-4
    )


@pytest.mark.parametrize(("vx", "along"), [(5.0, 0.4 * 3000.0 - 0.7 * 2000.0), (-5.0, 0.4 * 3000.0 + 0.7 * 2000.0)])
def test_the_forces_of_steered_wheels_act_across_by_the_sine_and_along_by_the_cosine(vx: float, along: float) -> None:
    x = applied(
        steered_wheel_forces, bus(vx=vx, steer=0.4, traction=3000.0, brake=2000.0, push=10.0), drive=0.4, brake=0.7
    )
    assert x.push == pytest.approx(10.0 + along * math.sin(0.4))
    assert x.yaw_moment == pytest.approx(1.2 * along * math.sin(0.4))
    assert x.traction == pytest.approx(3000.0 * (0.6 + 0.4 * math.cos(0.4)))
    assert x.brake == pytest.approx(2000.0 * (0.3 + 0.7 * math.cos(0.4)))


def test_brakes_that_hold_a_car_do_not_push_it_aside() -> None:
    x = applied(steered_wheel_forces, bus(vx=0.0, steer=0.4, brake=2000.0), brake=0.7)
    assert (x.push, x.yaw_moment, x.brake) == (0.0, 0.0, 2000.0)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_wheels_that_steer_alike_turn_the_car_back(turn: float) -> None:
    """Both wheels by their own slip angles, as forces on their own places: to a few per cent of a first order."""
    steer, rate, v, track, stiff = 0.4, 0.5 * turn, 4.0, 1.5, 60e3
    q = (0.3 * turn + 1.2 * rate) / v
    given = {"steer": steer * turn, "yaw_rate": rate, "vx": v, "vy": 0.3 * turn, "track": track}
    x = applied(parallel_steering, bus(**given, fy_front=3000.0 * turn, tangent_front=stiff), share=1.0)
    moment = force = 0.0
    for side in (1.0, -1.0):
        beyond = math.atan(q) - math.atan2(q * v, v - side * 0.5 * track * rate)  # of the slip of the axle's middle
        moment += 0.5 * stiff * beyond * math.sin(steer * turn) * side * 0.5 * track
        force += 0.5 * stiff * beyond
    assert x.yaw_moment == pytest.approx(moment, rel=0.03)
    assert x.yaw_moment * turn < 0.0
    assert x.fy_front - 3000.0 * turn == pytest.approx(force, rel=0.03)


def test_without_a_length_forces_are_there_at_once() -> None:
    relaxing = Applied(tyre_relaxation)
    relaxing(bus(vx=6.0, **TYRES))
    x = relaxing(bus(vx=6.0, fy_front=4000.0, fy_rear=1000.0, tangent_front=60e3))
    assert (x.fy_front, x.fy_rear, x.tangent_front, relaxing.memory.gone) == (4000.0, 1000.0, 60e3, 0.0)
    assert (relaxing.memory.front, relaxing.memory.rear) == (4000.0, 1000.0)


@pytest.mark.parametrize("slip", [0.05, -0.05, 0.0])
def test_a_linear_tyre_on_a_compliant_steering(slip: float) -> None:
    """F = C (a - c F): F = C a / (1 + c C), 0.01 rad/kN of 60 kN/rad is 0.6."""
    force = 60e3 * slip
    x = applied(steer_compliance, bus(steer=0.2, slip_front=slip, fy_front=force, tangent_front=60e3), c=0.01)
    assert (x.fy_front, x.tangent_front) == pytest.approx((force / 1.6, 60e3 / 1.6))
    assert (x.steer, x.slip_front) == pytest.approx((0.2 - 1e-5 * force / 1.6, slip - 1e-5 * force / 1.6))


@pytest.mark.parametrize("slip", [0.06, -0.06, 0.15])
@pytest.mark.parametrize("c", [0.002, 0.01])
def test_a_saturating_tyre_on_a_compliant_steering(slip: float, c: float) -> None:
    """F = M tanh(K (a - c F) / M), found by bisection; the slope is that of the tyre over 1 + c times it."""
    most, stiff = 4000.0, 80e3
    level = math.tanh(stiff * slip / most)
    given = {"slip_front": slip, "fy_front": most * level, "tangent_front": stiff * (1.0 - level * level)}
    x = applied(steer_compliance, bus(steer=0.2, **given), c=c)
    low, high = (0.0, most) if slip > 0.0 else (-most, 0.0)
    for _ in range(60):
        force = 0.5 * (low + high)
        low, high = (
            (force, high) if most * math.tanh(stiff * (slip - 1e-3 * c * force) / most) > force else (low, force)
        )
    tangent = stiff * (1.0 - (force / most) ** 2)
    assert x.fy_front == pytest.approx(force, rel=1e-4)
    assert x.tangent_front == pytest.approx(tangent / (1.0 + 1e-3 * c * tangent), rel=1e-3)
    assert (x.steer, x.slip_front) == pytest.approx((0.2 - 1e-3 * c * force, slip - 1e-3 * c * force), rel=1e-4)


def test_yaw_inertia_is_a_ratio() -> None:
    assert applied(yaw_inertia, bus(), ratio=1.2).turning_inertia == pytest.approx(3000.0)


def test_a_body_that_rolls_steers() -> None:
    """5 m/s^2 of lateral acceleration at once, then with a time constant of 0.2 s; all of it takes slip and force."""
    given = 0.02 * 5.0 / GRAVITY
    x = applied(roll_dynamics, bus(vx=10.0, yaw_rate=0.5, steer=0.1, slip_front=0.05, **TYRES), gain=0.02)
    assert (x.steer, x.slip_front, x.fy_front) == pytest.approx((0.1 - given, 0.05 - given, 3000.0 - given * 60e3))
    rolling = Applied(roll_dynamics, gain=0.02, tau=0.2)
    assert rolling(bus(vx=10.0, yaw_rate=0.5, steer=0.1)).steer == pytest.approx(0.1 - given)
    gone = 1.0 - math.exp(-0.5)
    x = rolling(bus(vx=10.0, yaw_rate=0.0, steer=0.1))
    assert x.steer == pytest.approx(0.1 - given * gone / 0.5)
    assert rolling.memory.phi == pytest.approx(5.0 / GRAVITY * (1.0 - gone))


def oscillation(
    start: float, rate: float, goal: float, frequency: float, damping: float, t: float
) -> tuple[float, float]:
    """Value and rate of s'' + 2 D w s' + w^2 (s - goal) = 0 after t, by small steps of the midpoint rule."""
    w, n = 2.0 * math.pi * frequency, 4000
    h = t / n
    for _ in range(n):
        middle = start + 0.5 * h * rate
        turn = rate + 0.5 * h * (w * w * (goal - start) - 2.0 * damping * w * rate)
        start, rate = start + h * turn, rate + h * (w * w * (goal - middle) - 2.0 * damping * w * turn)
    return start, rate


def test_a_swaying_body_is_an_oscillator() -> None:
    """Pushed with 2 m/s^2 it is at rest; then with 5000 N of 1600 kg, and once more."""
    swaying = Applied(body_roll, gain=0.1, frequency=1.2, damping=0.3, lead=0.05, inertia=0.01)
    x = swaying(bus(vx=9.0, fy_front=2000.0, fy_rear=1200.0, lean_y=0.7))
    assert x.lean_y == pytest.approx(0.7 + 0.1 * 2.0)
    sway, rate = 2.0, 0.0
    w, goal = 2.0 * math.pi * 1.2, 5000.0 / 1600.0
    for _ in range(3):
        x = swaying(bus(vx=9.0, fy_front=3000.0, fy_rear=2000.0))
        acceleration = w * w * (goal - sway) - 2.0 * 0.3 * w * rate
        assert x.lean_y == pytest.approx(0.1 * sway + 0.05 * rate + 0.01 * acceleration, rel=1e-4)
        sway, rate = oscillation(sway, rate, goal, 1.2, 0.3, 0.1)


def test_a_slow_car_sways_by_its_kinematic_motion() -> None:
    """1 m/s is slow: v^2 times curvature; at 1.5 m/s half of it, at 2 m/s only what the tyres give."""
    given = 5000.0 / 1600.0
    for speed, pushed in ((1.0, 0.2), (1.5, 0.5 * (0.45 + given)), (2.0, given)):
        x = applied(body_roll, bus(vx=speed, curvature=0.2, fy_front=3000.0, fy_rear=2000.0), gain=0.1)
        assert x.lean_y == pytest.approx(0.1 * pushed)


@pytest.mark.parametrize("effect", [road_grade, road_bank])
@pytest.mark.parametrize(("yaw", "part"), [(0.3, 1.0), (0.3 + math.pi, -1.0), (0.3 + math.pi / 3.0, 0.5)])
def test_a_slope_acts_with_its_part_along_the_car(effect: Any, yaw: float, part: float) -> None:
    x = applied(effect, bus(yaw=yaw, grade=0.01, bank=0.01), slope=0.05, heading=0.3)
    mine, other = (x.grade, x.bank) if effect is road_grade else (x.bank, x.grade)
    assert (mine, other) == (pytest.approx(0.01 + 0.05 * part), 0.01)


@pytest.mark.parametrize("yaw", [0.0, 0.7, math.pi])
def test_a_hill_is_as_steep_as_its_height_falls(yaw: float) -> None:
    """Slopes of h exp(-r^2 / 2 l^2) by differences, ahead and to the left."""

    def height(x: float, y: float) -> float:
        return 3.0 * math.exp(-((x - 10.0) ** 2 + (y + 5.0) ** 2) / (2.0 * 20.0**2))

    at, e = (22.0, 3.0), 1e-5
    c, s = math.cos(yaw), math.sin(yaw)
    ahead = (height(at[0] + e * c, at[1] + e * s) - height(at[0] - e * c, at[1] - e * s)) / (2.0 * e)
    left = (height(at[0] - e * s, at[1] + e * c) - height(at[0] + e * s, at[1] - e * c)) / (2.0 * e)
    x = applied(
        road_profile, bus(x=at[0], y=at[1], yaw=yaw, grade=0.01, bank=0.02), height=3.0, x=10.0, y=-5.0, length=20.0
    )
    assert (x.grade, x.bank) == pytest.approx((0.01 + math.atan(ahead), 0.02 + math.atan(left)))


def test_a_hill_without_height_is_flat() -> None:
    x = applied(road_profile, bus(x=9.0), x=10.0, y=-5.0)
    assert (x.grade, x.bank) == (0.0, 0.0)
