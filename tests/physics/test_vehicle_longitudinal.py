"""Motion along the road against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from vehicle_models import plant

from vehicle.messages import VehicleState
from vehicle.model.open_loop import Replay
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import VehicleModel

G = 9.80665


def test_constant_acceleration_gives_v_at_and_half_a_t_squared() -> None:
    car = plant()
    car.command(0.0, accel=1.5)
    rows = car.advance(4000)
    assert rows[-1, 5] == pytest.approx(6.0, abs=1e-9)
    assert rows[-1, 1] == pytest.approx(12.0, abs=1e-9)


@pytest.mark.parametrize("tau", [0.05, 0.3, 0.8])
def test_drive_lag_follows_the_first_order_step_response(tau: float) -> None:
    car = plant(effects={"drive_lag": {"tau": tau}})
    car.command(0.0, accel=2.0)
    rows = car.advance(2000)
    t = rows[:, 0]
    v = 2.0 * (t - tau * (1.0 - np.exp(-t / tau)))
    assert np.abs(rows[:, 5] - v).max() < 1e-9


@pytest.mark.parametrize("tau", [0.002, 0.04])
def test_a_force_rises_from_nought_where_brakes_held_the_car(tau: float) -> None:
    """They held it with no force at all, so nothing of them is left to fade."""
    car = plant(effects={"force_rise": {"tau": tau}})
    car.command(0.0, accel=-3.0)
    assert car.advance(500)[-1, 5] == 0.0
    car.command(0.0, accel=2.0)
    rows = car.advance(1000)
    t = rows[:, 0] - 0.5
    assert np.abs(rows[:, 5] - 2.0 * (t - tau * (1.0 - np.exp(-t / tau)))).max() < 1e-9


@pytest.mark.parametrize("delay", [0.05, 0.1234, 0.5])
def test_drive_delay_holds_the_command_back_by_exactly_its_dead_time(delay: float) -> None:
    car = plant(effects={"drive_delay": {"T": delay}})
    car.command(0.0, accel=2.0)
    rows = car.advance(1500)
    v = 2.0 * np.maximum(rows[:, 0] - delay, 0.0)
    late = rows[:, 0] > delay + 2e-3
    assert np.abs(rows[late, 5] - v[late]).max() < 1e-9


def test_dead_time_of_a_fraction_of_a_coarse_step_is_exact_too() -> None:
    car = plant(effects={"drive_delay": {"T": 0.033}}, dt=0.02)
    car.command(0.0, accel=1.0)
    assert car.advance(50)[-1, 5] == pytest.approx(1.0 - 0.033, abs=1e-12)


def test_brake_lag_delays_the_brake_but_not_the_drive() -> None:
    braked, driven = plant(effects={"brake_lag": {"tau": 0.4}}, v=20.0), plant(effects={"brake_lag": {"tau": 0.4}})
    braked.command(0.0, accel=-3.0)
    driven.command(0.0, accel=3.0)
    lost = 20.0 - braked.advance(1000)[-1, 5]
    assert lost == pytest.approx(3.0 * (1.0 - 0.4 * (1.0 - math.exp(-1.0 / 0.4))), abs=1e-9)
    assert driven.advance(1000)[-1, 5] == pytest.approx(3.0, abs=1e-9)


def test_a_drive_that_lags_leaves_its_brake_alone_where_that_is_apart() -> None:
    """From 2 m/s^2 the command turns to -3: the brake acts at once, while the drive fades with tau."""
    tau = 0.4
    car = plant(effects={"drive_lag": {"tau": tau, "brakes": 0.0}}, v=20.0)
    car.command(0.0, accel=2.0)
    before = car.advance(5000)[-1, 5]
    car.command(0.0, accel=-3.0)
    gained = car.advance(800)[-1, 5] - before
    assert gained == pytest.approx(-3.0 * 0.8 + 2.0 * tau * (1.0 - math.exp(-0.8 / tau)), abs=1e-5)


def test_a_brake_that_is_released_gradually_acts_beside_the_drive() -> None:
    """After 1 s of braking the brake stands at b = 3 (1 - e^(-1/tau)); it fades with r tau while the drive pushes."""
    tau, r = 0.4, 0.5
    car = plant(effects={"brake_lag": {"tau": tau, "release": r}}, v=20.0)
    car.command(0.0, accel=-3.0)
    before = car.advance(1000)[-1, 5]
    car.command(0.0, accel=1.0)
    gained = car.advance(600)[-1, 5] - before
    b = 3.0 * (1.0 - math.exp(-1.0 / tau))
    assert gained == pytest.approx(0.6 - b * r * tau * (1.0 - math.exp(-0.6 / (r * tau))), abs=1e-9)


def test_brake_limit_caps_the_deceleration() -> None:
    car = plant(effects={"brake_limit": {"limit": 4.0}}, v=20.0)
    car.command(0.0, accel=-9.0)
    assert car.advance(1000)[-1, 5] == pytest.approx(16.0, abs=1e-9)


def test_coast_down_with_rolling_resistance_and_drag_is_the_tangent_law() -> None:
    c, k, v0 = 0.15, 0.003, 25.0
    car = plant(effects={"rolling_resistance": {"c": c}, "aero_drag": {"k": k}}, v=v0)
    rows = car.advance(10_000)
    t = rows[:, 0]
    v = math.sqrt(c / k) * np.tan(math.atan(v0 * math.sqrt(k / c)) - math.sqrt(c * k) * t)
    assert np.abs(rows[:, 5] - v).max() < 2e-3  # first order in the step of 1 ms


def test_power_limited_acceleration_follows_the_square_root_law() -> None:
    car = plant(effects={"power_limit": {"limit": 10.0}}, v=5.0)
    car.command(0.0, accel=9.0)
    rows = car.advance(5000)
    v = np.sqrt(25.0 + 2.0 * 10.0 * rows[:, 0])
    assert np.abs(rows[:, 5] - v).max() < 2e-3


MOTOR = {"torque": 128.0, "corner_speed": 52.36, "power": 29500.0, "rated_speed": 261.8, "max_speed": 575.96}


@pytest.mark.parametrize(
    ("rpm", "torque"),
    [(100.0, 128.0), (500.0, 128.0), (1500.0, 120.34), (2500.0, 112.68), (4000.0, 70.43), (5600.0, 0.0)],
)
def test_motor_torque_meets_the_data_sheet_of_the_tabby(rpm: float, torque: float) -> None:
    turning = rpm * 2.0 * math.pi / 60.0
    v = turning * 0.3 / 6.0
    car = plant(effects={"motor_torque": MOTOR}, v=v)
    car.command(0.0, accel=50.0)
    gained = (car.advance(1)[0, 5] - v) / 1e-3
    assert gained == pytest.approx(torque * 6.0 / 0.3 / 1000.0, rel=2e-3, abs=1e-9)


def test_motor_inertia_takes_its_share_of_the_force() -> None:
    car = plant(effects={"motor_inertia": {"J": 0.5}})
    car.command(0.0, accel=2.0)
    extra = 0.5 * (6.0 / 0.3) ** 2
    assert car.advance(1000)[-1, 5] == pytest.approx(2.0 * 1000.0 / (1000.0 + extra), abs=1e-9)


def test_motor_damping_at_zero_throttle_decays_exponentially() -> None:
    car = plant(effects={"motor_damping": {"zero": 0.5, "full": 0.0}}, v=10.0)
    rows = car.advance(2000)
    rate = 0.5 * (6.0 / 0.3) ** 2 / 1000.0
    assert np.abs(rows[:, 5] - 10.0 * np.exp(-rate * rows[:, 0])).max() < 1e-3


def test_an_idling_gearbox_pushes_a_car_that_rolls_back_down_a_hill_as_one_that_stands() -> None:
    car = plant(effects={"creep": {"a": 0.5, "v0": 2.0}, "road_grade": {"slope": 0.1}})
    assert car.advance(4000)[-1, 5] == pytest.approx((0.5 - G * math.sin(0.1)) * 4.0, rel=1e-6)


def test_grade_pulls_back_with_g_sin_theta_and_turns_sign_with_the_heading() -> None:
    slope = {"road_grade": {"slope": 0.05, "heading": 0.0}}
    up, down = plant(effects=slope, v=10.0), plant(effects=slope, v=10.0, yaw=math.pi)
    assert up.advance(1000)[-1, 5] == pytest.approx(10.0 - G * math.sin(0.05), abs=1e-6)
    assert down.advance(1000)[-1, 5] == pytest.approx(10.0 + G * math.sin(0.05), abs=1e-6)


def test_accelerometer_reads_gravity_when_held_on_a_slope() -> None:
    car = plant(effects={"road_grade": {"slope": 0.08}})
    car.command(0.0, accel=-3.0)
    row = car.advance(100)[-1]
    assert row[9] == pytest.approx(G * math.sin(0.08), abs=1e-9)


def test_braking_ends_at_zero_and_never_rolls_backward() -> None:
    car = plant(v=5.0)
    car.command(0.0, accel=-6.0)
    rows = car.advance(3000)
    assert rows[:, 5].min() == 0.0
    assert rows[-1, 1] == pytest.approx(25.0 / 12.0, abs=1e-3)


def test_a_braked_car_stands_still_on_a_slope_to_the_last_bit() -> None:
    car = plant(effects={"road_grade": {"slope": 0.08}})
    car.command(0.0, accel=-1.0)
    before = car.row()
    after = car.advance(10_000)[-1]
    assert (after[1:6] == before[1:6]).all()


def test_a_brake_too_weak_for_the_slope_slides() -> None:
    car = plant(effects={"road_grade": {"slope": 0.2}})
    car.command(0.0, accel=-1.0)
    assert car.advance(1000)[-1, 5] == pytest.approx(-(G * math.sin(0.2) - 1.0), abs=1e-6)


def test_rolling_backward_is_braked_to_a_halt_not_pushed_forward() -> None:
    car = plant(v=-2.0)
    car.command(0.0, accel=-4.0)
    rows = car.advance(1000)
    assert rows[:, 5].max() == 0.0
    assert rows[-1, 5] == 0.0


def test_acceleration_controller_shrinks_a_disturbance_by_one_plus_kp() -> None:
    effects = {"road_grade": {"slope": 0.05}, "accel_controller": {"kp_drive": 1.5}}
    car = plant(effects=effects, v=10.0)
    car.command(0.0, accel=1.0)
    car.advance(2000)
    before = car.state.v
    gained = car.advance(1000)[-1, 5] - before
    assert gained == pytest.approx(1.0 - G * math.sin(0.05) / 2.5, abs=1e-3)


def test_speed_controller_settles_exponentially() -> None:
    car = Plant(asked_for_speed({}, kp=2.0), every=1)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    car.command(0.0, speed=5.0)
    rows = car.advance(3000)
    assert np.abs(rows[:, 5] - 5.0 * (1.0 - np.exp(-2.0 * rows[:, 0]))).max() < 5e-3


def test_a_heavier_car_gets_less_from_the_same_pedal() -> None:
    heavy = Plant(plant().model.with_car({"mass": 2000.0}))
    heavy.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    heavy.command(0.0, accel=2.0)
    assert heavy.advance(1000)[-1, 5] == pytest.approx(1.0, abs=1e-9)


def asked_for_speed(effects: dict[str, dict[str, float]], **controller: float) -> VehicleModel:
    """A car that takes a speed as command."""
    found = plant(effects={"speed_controller": controller, **effects}).model
    return replace(found, inputs=replace(found.inputs, longitudinal=("speed_cmd",)))


@pytest.mark.parametrize("ratio", [0.9, 1.1])
def test_a_controller_of_wheels_with_another_radius_settles_where_they_show_its_command(ratio: float) -> None:
    """e = w - k v: from standstill, k v = w (1 - exp(-kp k t)), in a twin and in a replay of its log."""
    car = Plant(asked_for_speed({"wheel_radius": {"ratio": ratio}}, kp=2.0), every=1)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    car.command(0.0, speed=5.0)
    rows = car.advance(3000)
    assert np.abs(ratio * rows[:, 5] - 5.0 * (1.0 - np.exp(-2.0 * ratio * rows[:, 0]))).max() < 0.02
    assert car.shown_row()[5] == pytest.approx(5.0, abs=0.03)
    t = np.arange(0.0, 8.0, 0.02)
    shown = Replay(car.model, t, {"steer_cmd": 0.0 * t, "speed_cmd": 0.0 * t + 5.0}).run()
    assert np.abs(shown[:, 3] - 5.0 * (1.0 - np.exp(-2.0 * ratio * t))).max() < 0.03
    assert shown[-1, 0] - shown[-51, 0] == pytest.approx(5.0 / ratio, rel=1e-4)  # in the last second


@pytest.mark.parametrize(
    ("effects", "steer", "gain"),
    [
        ({"wheel_radius": {"ratio": 0.9}, "drive_delay": {"T": 0.3}, "drive_lag": {"tau": 0.2}}, 0.0, 0.9),
        ({"front_wheel_speed": {"share": 1.0}, "drive_delay": {"T": 0.3}}, 0.4, 1.0 / math.cos(0.4)),
    ],
)
def test_a_controller_asks_for_nothing_where_the_wheels_show_its_command(
    effects: dict[str, dict[str, float]], steer: float, gain: float
) -> None:
    """From the first row on: what is on its way to the drive when a log begins was asked for by the same measure."""
    t = np.arange(0.0, 4.0, 0.02)
    replay = Replay(
        asked_for_speed(effects, kp=2.0, ki=0.5), t, {"steer_cmd": 0.0 * t + steer, "speed_cmd": 0.0 * t + 6.0}
    )
    shown = replay.run(starts=np.array([0]), states=np.array([[0.0, 0.0, 0.0, 6.0 / gain, math.nan, math.nan]]))
    assert shown[:, 3] == pytest.approx(6.0, abs=1e-9)
    assert shown[:, 5] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("kp", [0.5, 5.0])
def test_a_controller_takes_the_slip_of_its_wheels_for_speed(kp: float) -> None:
    """Uphill the drive holds g sin(slope): kp (w - v (1 + c g sin(slope))) = g sin(slope), without swinging."""
    slope, c = 0.1, 0.02
    pull = G * math.sin(slope)
    t = np.arange(0.0, 30.0, 0.02)
    model = asked_for_speed({"wheel_slip": {"c_drive": c}, "road_grade": {"slope": slope}}, kp=kp)
    shown = Replay(model, t, {"steer_cmd": 0.0 * t, "speed_cmd": 0.0 * t + 15.0}).run()
    assert shown[-200:, 3] == pytest.approx(15.0 - pull / kp, rel=1e-3)
