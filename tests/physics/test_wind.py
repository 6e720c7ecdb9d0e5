"""Wind of the world against closed forms: coasting against, with and without it, and a push from the side."""

from __future__ import annotations

import math

import pytest
from vehicle_models import model, plant

from vehicle.model.wind import DENSITY, DRAG, FRONTAL, SIDE, air_coefficients

K = 0.002  # 1/m


@pytest.mark.parametrize("against", [10.0, 4.0, 0.0])
@pytest.mark.parametrize("yaw", [0.0, 1.0])
def test_coasting_against_the_wind(against: float, yaw: float) -> None:
    """v' = -k (v + w)^2 from v0, so v + w = (v0 + w) / (1 + k (v0 + w) t)."""
    car = plant(v=20.0, yaw=yaw, effects={"aero_drag": {"k": K}})
    car.wind(-against * math.cos(yaw), -against * math.sin(yaw))
    speed = car.advance(10_000)[-1, 5]
    through = 20.0 + against
    assert speed + against == pytest.approx(through / (1.0 + K * through * 10.0), rel=1e-4)


def test_a_tail_wind_as_fast_as_the_car_takes_all_drag_away() -> None:
    car = plant(v=20.0, effects={"aero_drag": {"k": K}})
    car.wind(20.0, 0.0)
    assert car.advance(5000)[-1, 5] == pytest.approx(20.0, abs=1e-9)


@pytest.mark.parametrize("tail", [5.0, 15.0])
@pytest.mark.parametrize(("speed", "yaw"), [(20.0, 0.0), (30.0, 2.0)])
def test_a_tail_wind_pushes_no_car_that_is_faster(tail: float, speed: float, yaw: float) -> None:
    """The model has no drag in still air, of which the wind could take something away."""
    car = plant(v=speed, yaw=yaw)
    car.wind(tail * math.cos(yaw), tail * math.sin(yaw))
    assert car.advance(20_000)[-1, 5] == pytest.approx(speed, abs=1e-9)


@pytest.mark.parametrize("ahead", [1.0, -1.0])
def test_a_tail_wind_pushes_a_slower_car_up_to_its_own_speed(ahead: float) -> None:
    """v' = k (w - v)^2 from standstill, so w - v = w / (1 + k w t); a wind from ahead pushes it backward as much."""
    k, wind = air_coefficients(model())[0], 30.0
    car = plant()
    car.wind(ahead * wind, 0.0)
    rows = car.advance(60_000)
    assert wind - ahead * rows[-1, 5] == pytest.approx(wind / (1.0 + k * wind * 60.0), rel=1e-4)


@pytest.mark.parametrize(("speed", "across"), [(20.0, 10.0), (30.0, -5.0), (10.0, 15.0)])
def test_the_air_from_the_side_pushes_a_car_with_tyres(speed: float, across: float) -> None:
    """At first the tyres do nothing: a = k_side sqrt(v^2 + w^2) w at the centre of gravity, here with m = 1000 kg."""
    car = plant("dynamic_bicycle", v=speed)
    car.wind(0.0, across)
    k = SIDE * 0.5 * DENSITY * FRONTAL * 1.8 * 1.5 / 1000.0
    row = car.advance(1)[-1]
    assert row[7] / 1e-3 == pytest.approx(k * math.hypot(speed, across) * across, rel=0.02)


@pytest.mark.parametrize("across", [10.0, -10.0])
def test_tyres_that_hold_a_car_against_the_wind_drag_and_lean_as_those_that_turn_it(across: float) -> None:
    """What they hold is the push W: c W/m of drag, a load that moves by W/(m g), and a roll that steers by as much."""
    effects = {"cornering_drag": {"c": 0.3}, "aero_drag": {"k": K}}
    with_it, without = (plant(v=20.0, effects=e) for e in (effects, {"aero_drag": {"k": K}}))
    for car in (with_it, without):
        car.wind(0.0, across)
        car.advance(1)
    push = air_coefficients(with_it.model)[1] * math.hypot(20.0, across) * abs(across)
    assert (without.state.v - with_it.state.v) / 1e-3 == pytest.approx(0.3 * push, rel=1e-3)
    rolls = plant("dynamic_bicycle", {"roll_dynamics": {"gain": 0.1, "tau": 0.2}}, v=20.0)
    rolls.wind(0.0, across)
    shown = rolls.advance(1)[-1]
    assert shown[11] == pytest.approx(math.copysign(0.1 * push / 9.80665, across), rel=0.02)


def test_a_car_without_tyres_feels_it_along_only() -> None:
    car = plant(v=20.0)
    car.wind(0.0, 10.0)
    rows = car.advance(2000)
    assert abs(rows[-1, 2]) < 1e-9
    assert rows[-1, 5] < 20.0


def test_the_drag_is_that_of_the_effect_or_of_the_size() -> None:
    assert air_coefficients(model(effects={"aero_drag": {"k": K}}))[0] == K
    assert air_coefficients(model())[0] == pytest.approx(DRAG * 0.5 * DENSITY * FRONTAL * 1.8 * 1.5 / 1000.0)
