"""Effects that change while driving, and limits beside them, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from vehicle_models import plant

from vehicle.messages import VehicleState
from vehicle.model.plant import Plant

G = 9.80665
V, AX, AY = 5, 9, 10  # columns of a row


def _deceleration(car: Plant) -> float:
    """Of the brake, for a command of 3 m/s^2 in the step that comes now."""
    car.command(0.0, accel=-3.0)
    before = car.state.v
    return (before - float(car.advance(1)[0, V])) / 1e-3


def test_a_brake_that_does_not_cool_fades_by_the_energy_of_its_stops() -> None:
    """Each stop from 20 m/s holds v^2/2 = 200 J/kg: after n of them the gain is 1/(1 + 200 n k)."""
    k = 0.001
    car = plant(effects={"brake_fade": {"k": k, "tau": 1e9}}, v=20.0)
    for n in range(4):
        assert _deceleration(car) == pytest.approx(3.0 / (1.0 + 200.0 * n * k), rel=1e-3)
        car.advance(20_000)
        assert car.state.v == 0.0
        car.command(0.0, accel=2.0)
        car.advance(10_000)
        assert car.state.v == pytest.approx(20.0, abs=1e-9)


def test_a_braked_stop_with_fading_takes_the_time_of_the_closed_form() -> None:
    """v' = -a/(1 + k (v0^2 - v^2)/2) takes v0/a + k v0^3/(3 a) to standstill."""
    k, v0 = 0.004, 20.0
    car = plant(effects={"brake_fade": {"k": k, "tau": 1e9}}, v=v0)
    car.command(0.0, accel=-4.0)
    rows = car.advance(10_000)
    stopped = float(rows[np.argmax(rows[:, V] == 0.0), 0])
    assert stopped == pytest.approx(v0 / 4.0 + k * v0**3 / 12.0, abs=0.01)


def test_a_motor_that_brakes_neither_fades_nor_heats_the_discs() -> None:
    """Of 3 m/s^2 it takes over 1: each stop leaves the discs v^2/2 less what 1 m/s^2 does along its way."""
    k, motor = 0.001, 1.0
    car = plant(effects={"brake_fade": {"k": k, "tau": 1e9}, "brake_gain": {"motor": motor}}, v=20.0)
    held = 0.0
    for _ in range(3):
        assert _deceleration(car) == pytest.approx(motor + (3.0 - motor) / (1.0 + k * held), rel=1e-3)
        begun = car.state.x
        car.advance(20_000)
        assert car.state.v == 0.0
        held += 0.5 * 20.0**2 - motor * (car.state.x - begun)
        car.command(0.0, accel=2.0)
        car.advance(10_000)
    car.command(0.0, accel=-motor)
    car.advance(5000)
    assert car.state.v == pytest.approx(15.0, abs=1e-9)


@pytest.mark.parametrize("pause", [10.0, 40.0, 120.0])
def test_a_hot_disc_cools_by_the_exponential_law_standing_or_driving(pause: float) -> None:
    k, tau = 0.01, 40.0
    car = plant(effects={"brake_fade": {"k": k, "tau": tau}}, v=20.0)
    car.command(0.0, accel=-9.0)
    car.advance(1000)
    held = 3.0 / _deceleration(car) - 1.0
    assert held > 0.5
    car.command(0.0, accel=0.0)
    car.advance(round(1000 * pause))
    assert 3.0 / _deceleration(car) - 1.0 == pytest.approx(held * math.exp(-pause / tau), rel=2e-3)


def test_a_brake_held_down_a_slope_settles_where_the_air_takes_what_the_brake_gives() -> None:
    """At constant speed w = a v tau, so the brake gives a with a_c = a (1 + k a v tau)."""
    k, tau, v, slope = 0.002, 20.0, 10.0, -0.05
    a = G * math.sin(-slope)
    effects = {"brake_fade": {"k": k, "tau": tau}, "road_grade": {"slope": slope}}
    car = plant(effects=effects, v=v)
    for _ in range(200):  # a driver who keeps the speed
        asked = -a * (1.0 + k * a * v * tau) - 0.5 * (car.state.v - v)
        car.command(0.0, accel=asked)
        car.advance(1000)
    assert car.state.v == pytest.approx(v, abs=1e-3)


@pytest.mark.parametrize("v", [1.0, 6.0, 20.0])
def test_a_limit_of_torque_caps_the_drive_alike_at_every_speed_and_leaves_the_brake(v: float) -> None:
    car = plant(effects={"drive_torque_limit": {"limit": 1.5}}, v=v)
    car.command(0.0, accel=4.0)
    assert car.advance(1000)[-1, V] == pytest.approx(v + 1.5, abs=1e-9)
    car.command(0.0, accel=-4.0)
    assert car.advance(100)[-1, V] == pytest.approx(v + 1.5 - 0.4, abs=1e-9)


def test_a_lagging_drive_meets_its_torque_limit_when_the_first_order_response_does() -> None:
    tau, wish, limit = 0.5, 4.0, 1.5
    car = plant(effects={"drive_lag": {"tau": tau}, "drive_torque_limit": {"limit": limit}})
    car.command(0.0, accel=wish)
    meets = -tau * math.log(1.0 - limit / wish)
    gained = wish * (meets - tau * limit / wish) + limit * (2.0 - meets)
    assert car.advance(2000)[-1, V] == pytest.approx(gained, abs=1e-5)


@pytest.mark.parametrize(("asked", "reached"), [(5.0, 4.0), (3.0, 3.0)])
def test_a_speed_beyond_the_limit_is_tracked_as_the_limit(asked: float, reached: float) -> None:
    found = plant(effects={"speed_controller": {"kp": 2.0}, "speed_limit": {"limit": 4.0}}).model
    found = replace(found, inputs=replace(found.inputs, longitudinal=("speed_cmd",)))
    car = Plant(found, every=1)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    car.command(0.0, speed=asked)
    rows = car.advance(3000)
    assert np.abs(rows[:, V] - reached * (1.0 - np.exp(-2.0 * rows[:, 0]))).max() < 5e-3


@pytest.mark.parametrize("g", [-0.4, 0.4])
def test_the_scale_of_an_assisted_steering_is_one_at_rest_half_way_at_v0_and_levels_off(g: float) -> None:
    for v, scale in ((0.0, 1.0), (8.0, 1.0 + 0.5 * g), (-8.0, 1.0 + 0.5 * g), (24.0, 1.0 + 0.75 * g)):
        car = plant(effects={"steer_assist": {"g": g, "v0": 8.0}}, v=v)
        car.command(0.1)
        assert float(car.advance(1)[0, 11]) == pytest.approx(0.1 * scale, rel=1e-12)


def _wheel(car: Plant, steer: float, accel: float = 0.0, steps: int = 200) -> float:
    car.command(steer, accel=accel)
    return float(car.advance(steps)[-1, 11])


def test_a_steering_sticks_from_a_standstill_until_it_breaks_away_and_is_free_to_the_next() -> None:
    car = plant(effects={"steer_sticking": {"width": 0.05}}, v=5.0)
    assert _wheel(car, 0.02) == 0.02  # it has not stood yet
    assert _wheel(car, 0.02, accel=-5.0, steps=2000) == 0.02
    assert car.state.v == 0.0
    assert _wheel(car, 0.0601) == 0.02
    assert _wheel(car, 0.0601, accel=2.0, steps=1000) == 0.02  # the start alone does not free it
    assert _wheel(car, -0.0299) == 0.02
    assert _wheel(car, -0.0301) == -0.0301
    assert _wheel(car, -0.029) == -0.029  # and small commands act
    assert _wheel(car, -0.029, accel=-5.0, steps=2000) == -0.029
    assert _wheel(car, 0.01, accel=2.0, steps=1000) == -0.029


def test_a_steering_that_broke_away_at_a_standstill_stays_free_in_it() -> None:
    car = plant(effects={"steer_sticking": {"width": 0.05}})
    assert _wheel(car, 0.04) == 0.0
    assert _wheel(car, 0.06) == 0.06
    assert _wheel(car, 0.04) == 0.04


def test_a_wind_from_the_north_blows_from_ahead_on_the_way_north_only() -> None:
    k, w = 0.004, 8.0
    wind = {"headwind": {"speed": w, "k": k, "heading": math.pi / 2}}

    def lost(yaw: float, effects: dict[str, dict[str, float]]) -> float:
        return 10.0 - float(plant(effects=effects, v=10.0, yaw=yaw).advance(1)[0, V])

    assert lost(math.pi / 2, wind) == pytest.approx(1e-3 * k * (18.0**2 - 100.0), rel=1e-9)
    assert lost(-math.pi / 2, wind) == pytest.approx(1e-3 * k * (2.0**2 - 100.0), rel=1e-9)
    assert lost(0.0, wind) == pytest.approx(0.0, abs=1e-12)
    without = {"headwind": {"speed": w, "k": k}}  # what a file from before the key means: ahead, wherever it drives
    for yaw in (0.0, 1.0, math.pi):
        assert lost(yaw, without) == pytest.approx(1e-3 * k * (18.0**2 - 100.0), rel=1e-9)


HILL = {"road_profile": {"height": 2.0, "x": 0.0, "y": 0.0, "length": 20.0}}


def test_a_hill_gives_back_what_it_took() -> None:
    """Coasting over it: v^2/2 + g z is kept but for the difference of sine and slope, so on top v^2 = v0^2 - 2 g h."""
    car = Plant(plant(effects=HILL).model, dt=1e-3, every=1)
    car.reset(VehicleState(t=0.0, x=-100.0, y=0.0, yaw=0.0, v=12.0))
    rows = car.advance(20_000)
    top = rows[np.argmin(np.abs(rows[:, 1]))]
    assert top[V] == pytest.approx(math.sqrt(144.0 - 2.0 * G * 2.0), abs=0.03)
    far = rows[np.argmin(np.abs(rows[:, 1] - 100.0))]
    assert far[V] == pytest.approx(12.0, abs=1e-3)


@pytest.mark.parametrize(("yaw", "ahead", "left"), [(0.0, 1.0, 0.0), (math.pi, -1.0, 0.0), (math.pi / 2, 0.0, -1.0)])
def test_the_steepest_place_of_a_hill_is_grade_or_bank_by_the_direction_of_travel(
    yaw: float, ahead: float, left: float
) -> None:
    """At x = -l the ground rises eastwards by h/l exp(-1/2)."""
    steepest = math.atan(2.0 / 20.0 * math.exp(-0.5))
    car = Plant(plant(effects=HILL).model, dt=1e-3, every=1)
    car.reset(VehicleState(t=0.0, x=-20.0, y=0.0, yaw=yaw, v=0.0))
    car.command(0.0, accel=-3.0)
    row = car.advance(100)[-1]
    assert row[AX] == pytest.approx(ahead * G * math.sin(steepest), abs=1e-9)
    assert row[AY] == pytest.approx(left * G * math.sin(steepest), abs=1e-9)
