"""Slipping wheels in the odometry, axle loads that move, forces of steered wheels: closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vehicle.model.bus import GRAVITY
from vehicle.model.model_file import parse_model
from vehicle.model.open_loop import Replay
from vehicle.model.vehicle_model import VehicleModel

V, YAW_RATE = 3, 4
LENGTH, FRONT = 2.5, 1.1


def car(base: str = "kinematic_bicycle") -> VehicleModel:
    stiff = "cornering_stiffness_front = 60000.0\ncornering_stiffness_rear = 60000.0\n" if base[0] == "d" else ""
    return parse_model(
        f'[model]\nbase = "{base}"\n[parameters]\nwheelbase = {LENGTH}\ncg_to_front_axle = {FRONT}\n'
        f"mass = 1200.0\nyaw_inertia = 1500.0\n{stiff}"
    )


def driven(model: VehicleModel, accel: float, steer: float, speed: float, seconds: float) -> np.ndarray:  # type: ignore[type-arg]
    t = np.arange(0.0, seconds, 0.01)
    commands = {"accel_cmd": np.full(len(t), accel), "steer_cmd": np.full(len(t), steer)}
    states = np.array([[0.0, 0.0, 0.0, speed, np.nan, np.nan]])
    return np.asarray(Replay(model, t, commands).run({}, starts=np.array([0]), states=states))


@pytest.mark.parametrize(
    ("accel", "key", "slip"), [(-3.0, "c_brake", -0.03), (2.0, "c_drive", 0.02), (-3.0, "c_drive", 0.0)]
)
def test_the_wheels_show_their_slip_and_the_car_moves_as_before(accel: float, key: str, slip: float) -> None:
    """0.01 s^2/m: one per cent of slip for each m/s^2 by which tyres brake or drive, none of the other sign."""
    plain = driven(car(), accel, 0.0, 15.0, 3.0)
    slipping = driven(car().with_effect("wheel_slip", {key: 0.01}), accel, 0.0, 15.0, 3.0)
    assert slipping[:, V] == pytest.approx((1.0 + slip) * plain[:, V], rel=1e-9)
    assert slipping[:, 0] == pytest.approx(plain[:, 0], rel=1e-9)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_front_wheels_run_faster_in_a_bend_by_the_cosine_of_the_steering(share: float) -> None:
    """Without slip the front axle moves at v/cos(d), the rear one at v."""
    turned = driven(car().with_effect("front_wheel_speed", {"share": share}), 0.0, 0.4, 3.0, 2.0)
    assert turned[50:, V] == pytest.approx(3.0 * (1.0 - share + share / np.cos(0.4)), rel=1e-9)
    straight = driven(car().with_effect("front_wheel_speed", {"share": share}), 0.0, 0.0, 3.0, 2.0)
    assert straight[50:, V] == pytest.approx(3.0, rel=1e-12)


def test_a_braked_car_turns_in_and_a_driven_one_runs_wide() -> None:
    """While the speed is the same, the yaw rate is that of a car whose axles are softer and stiffer by the load."""
    base = car("dynamic_bicycle")
    shifting = base.with_effect("axle_load_shift", {"c": 0.3})
    turn = {}
    for accel in (-2.0, 0.0, 2.0):
        start = 12.0 - 0.5 * accel  # at 12 m/s after half a second
        rows = driven(shifting, accel, 0.06, start, 1.0), driven(base, accel, 0.06, start, 1.0)
        turn[accel] = float(rows[0][50, YAW_RATE] / rows[1][50, YAW_RATE])
    assert turn[0.0] == pytest.approx(1.0, abs=1e-12)
    assert turn[-2.0] > 1.01
    assert turn[2.0] < 0.99


def test_the_shift_is_that_of_the_loads() -> None:
    """Driving by a moves c a L/(g l_r) of the front axle's stiffness: the same as a car with those stiffnesses."""
    c, accel = 0.2, 1.0
    shift = c * accel * LENGTH / GRAVITY
    changed = parse_model(
        f'[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = {LENGTH}\ncg_to_front_axle = {FRONT}\n'
        f"mass = 1200.0\nyaw_inertia = 1500.0\n"
        f"cornering_stiffness_front = {60000.0 * (1.0 - shift / (LENGTH - FRONT))}\n"
        f"cornering_stiffness_rear = {60000.0 * (1.0 + shift / FRONT)}\n"
    )
    moved = driven(car("dynamic_bicycle").with_effect("axle_load_shift", {"c": c}), accel, 0.05, 10.0, 2.0)
    assert moved[:, YAW_RATE] == pytest.approx(driven(changed, accel, 0.05, 10.0, 2.0)[:, YAW_RATE], rel=1e-6)


def test_a_car_driven_by_its_steered_wheels_balances_their_forces() -> None:
    """Once steady, in the frame of the car: m v r = F_yf cos d + F_yr + F_xf sin d, and no moment about its centre."""
    model = parse_model(
        f'[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = {LENGTH}\ncg_to_front_axle = {FRONT}\n'
        f"mass = 1200.0\nyaw_inertia = 1500.0\nay_x = {LENGTH - FRONT}\n"
        "cornering_stiffness_front = 60000.0\ncornering_stiffness_rear = 60000.0\n"
    ).with_effect("steered_wheel_forces", {"drive": 1.0})
    drag = 1.0  # m/s^2, so that a steady speed asks for a force
    rows = driven(model.with_effect("rolling_resistance", {"c": drag}), 1.3, 0.3, 6.0, 6.0)
    v, r, ay = rows[-1, V], rows[-1, YAW_RATE], rows[-1, 6]
    before = rows[-21]
    assert abs(v - before[V]) < 0.05  # steady: what turns the car back takes up the rest of the drive
    front_across = 1200.0 * ay * (LENGTH - FRONT) / LENGTH  # no moment: the front axle carries its share
    assert ay == pytest.approx(v * r, rel=0.02)
    slip = (front_across - 1200.0 * 1.3 * np.sin(0.3)) / np.cos(0.3) / 60000.0
    rear = 1200.0 * ay * FRONT / LENGTH / 60000.0
    assert r == pytest.approx(v / LENGTH * (np.tan(0.3 - slip) + np.tan(rear)), rel=0.01)


def test_an_accelerometer_ahead_of_the_rear_axle_feels_the_turning_grow() -> None:
    """A car that moves without slip and brakes by 3 m/s^2 with tan(d) / L = 0.1: r' = -0.3, 1.5 m ahead -0.45 m/s^2."""
    model = parse_model(f"[parameters]\nwheelbase = {LENGTH}\nay_x = 1.5\n")
    rows = driven(model, -3.0, float(np.arctan(0.1 * LENGTH)), 8.0, 2.0)
    assert rows[50, 6] == pytest.approx(rows[50, V] ** 2 * 0.1 - 0.45, rel=1e-9)


@pytest.mark.parametrize("base", ["kinematic_bicycle", "dynamic_bicycle"])
@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("wheel_radius", {"ratio": 0.9}),
        ("front_wheel_speed", {"share": 1.0}),
        ("wheel_slip", {"c_brake": 0.01, "c_drive": 0.01}),
    ],
)
def test_an_imposed_speed_is_the_one_that_the_wheels_show(base: str, effect: str, values: dict[str, float]) -> None:
    """What a driven car shows drives it the same way again, from its first row on and beyond a restart."""
    t = np.arange(0.0, 8.0, 0.02)
    commands = {"steer_cmd": 0.15 + 0.15 * np.sin(0.7 * t), "accel_cmd": 2.0 * np.sin(0.8 * t)}
    states = np.full((2, 6), np.nan)
    states[0, :4] = 0.0, 0.0, 0.0, 3.0
    starts = np.array([0, 150])
    model = car(base).with_effect(effect, values)
    driven = Replay(model, t, commands).run({}, starts=starts, states=states)
    measured = replace(model, inputs=replace(model.inputs, longitudinal=("v",)))
    states[:, 3] = driven[starts, V]
    told = Replay(measured, t, {"steer_cmd": commands["steer_cmd"], "v": driven[:, V]}).run(
        {}, starts=starts, states=states
    )
    assert told[:, V] == pytest.approx(driven[:, V], abs=0.02)
    assert told[:, YAW_RATE] == pytest.approx(driven[:, YAW_RATE], abs=0.006)  # 0.015 and more with it for the true one
    assert np.hypot(*(told[100] - driven[100])[:2]) < 0.02
    assert np.hypot(*(told[-1] - driven[-1])[:2]) < 0.1


@pytest.mark.parametrize("steer", [0.15, 0.3])
@pytest.mark.parametrize(
    ("name", "values"), [("axle_load_shift", {"c": 0.3}), ("steered_wheel_forces", {"drive": 1.0, "brake": 0.6})]
)
def test_wheels_that_hold_a_speed_through_a_bend_push_against_the_side_force_of_the_front_axle(
    name: str, values: dict[str, float], steer: float
) -> None:
    """m v' = F - F_yf sin(d) + m r v_y: a car that is driven and one of which only that speed is known turn alike."""
    t = np.arange(0.0, 12.0, 0.02)
    commands = {"steer_cmd": steer * np.sin(0.5 * t), "accel_cmd": 0.6 + np.sin(0.8 * t)}
    model = car("dynamic_bicycle").with_effect(name, values)
    start = {"starts": np.array([0]), "states": np.array([[0.0, 0.0, 0.0, 6.0, np.nan, np.nan]])}
    driven = Replay(model, t, commands).run({}, **start)
    told = Replay(
        replace(model, inputs=replace(model.inputs, longitudinal=("v",))),
        t, {"steer_cmd": commands["steer_cmd"], "v": driven[:, V]},
    )  # fmt: skip
    neutral = {(name, key): 0.0 for key in values}
    off = np.abs(told.run(neutral, **start) - driven)[:, YAW_RATE].max()
    assert off > 0.01
    assert np.abs(told.run({}, **start) - driven)[:, YAW_RATE].max() < 0.05 * off


COASTING: tuple[tuple[dict[str, dict[str, float]], float], ...] = (  # and by how much it slows a car at 12 m/s [m/s^2]
    ({"lift_off_braking": {"a": 0.9}}, 0.9),
    ({"motor_damping": {"zero": 0.25, "full": 0.25}}, 0.25 * (5.0 / 0.3) ** 2 * 12.0 / 1200.0),
)


def coasting_or_braked(kind: int, name: str, values: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """A bend of which the middle is at 12 m/s, slowed down by the drive and, as much, by brakes."""
    effects, slows = COASTING[kind]
    base = car("dynamic_bicycle").with_car({"gear_ratio": 5.0, "wheel_radius": 0.3}).with_effect(name, values)
    coasting = base
    for effect, its in effects.items():
        coasting = coasting.with_effect(effect, its)
    start = 12.0 + 0.5 * slows
    return driven(coasting, 0.0, 0.1, start, 1.0), driven(base, -slows, 0.1, start, 1.0)


@pytest.mark.parametrize("kind", [0, 1])
def test_a_drive_that_holds_the_car_back_shifts_load_as_brakes_do(kind: int) -> None:
    coasting, braked = coasting_or_braked(kind, "axle_load_shift", {"c": 0.3})
    even, _ = coasting_or_braked(kind, "axle_load_shift", {"c": 0.0})
    assert coasting[50, YAW_RATE] - even[50, YAW_RATE] > 0.01
    assert coasting[50, YAW_RATE] == pytest.approx(braked[50, YAW_RATE], abs=0.002)


@pytest.mark.parametrize("kind", [0, 1])
def test_steered_wheels_that_the_drive_holds_back_act_as_braked_ones(kind: int) -> None:
    coasting, braked = coasting_or_braked(kind, "steered_wheel_forces", {"drive": 1.0, "brake": 1.0})
    even, _ = coasting_or_braked(kind, "steered_wheel_forces", {"drive": 0.0, "brake": 1.0})
    assert coasting[50, YAW_RATE] - even[50, YAW_RATE] < -0.003
    assert coasting[50, YAW_RATE] == pytest.approx(braked[50, YAW_RATE], abs=0.001)


@pytest.mark.parametrize("kind", [0, 1])
def test_wheels_that_the_drive_holds_back_turn_slower(kind: int) -> None:
    """0.01 s^2/m of what slows the car."""
    coasting, _ = coasting_or_braked(kind, "wheel_slip", {"c_drive": 0.01})
    free, _ = coasting_or_braked(kind, "wheel_slip", {"c_drive": 0.0})
    assert coasting[50, V] == pytest.approx(free[50, V] * (1.0 - 0.01 * COASTING[kind][1]), rel=1e-3)


def test_a_drive_that_must_speed_its_parts_up_slips_and_pulls_by_what_is_left() -> None:
    """Parts of 400 kg beside 1200 kg take a quarter of 2 m/s^2 of traction."""
    parts = {"J": 400.0 / (5.0 / 0.3) ** 2}
    base = car("dynamic_bicycle").with_car({"gear_ratio": 5.0, "wheel_radius": 0.3})
    turning = base.with_effect("motor_inertia", parts)
    rows = driven(turning.with_effect("wheel_slip", {"c_drive": 0.01}), 2.0, 0.0, 10.0, 1.0)
    assert rows[50:, V] == pytest.approx(driven(turning, 2.0, 0.0, 10.0, 1.0)[50:, V] * 1.015, rel=1e-6)
    pulled = driven(turning.with_effect("steered_wheel_forces", {"drive": 1.0}), 2.0, 0.1, 10.0, 1.0)
    less = driven(base.with_effect("steered_wheel_forces", {"drive": 1.0}), 1.5, 0.1, 10.0, 1.0)
    assert pulled[-1, YAW_RATE] == pytest.approx(less[-1, YAW_RATE], abs=1e-3)
