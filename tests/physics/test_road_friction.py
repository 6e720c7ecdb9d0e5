"""Friction of the road against closed forms: braking distance, start, circle, and the friction circle of both."""

from __future__ import annotations

import math

import numpy as np
import pytest
from vehicle_models import plant

from vehicle.model.plant import Plant

G = 9.80665


def stopped(v: float, friction: float | None, asked: float, grade: float = 0.0, **options: object) -> float:
    """Distance [m] in which a car brakes from v [m/s], asked for a deceleration [m/s^2]."""
    car = plant(v=v, **options)  # type: ignore[arg-type]
    car.friction(friction)
    car.road(0.0, grade)
    car.command(0.0, accel=-asked)
    rows = car.advance(60_000)
    assert rows[-1, 5] == 0.0
    return float(rows[-1, 1])


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("base", ["kinematic_bicycle", "dynamic_bicycle"])
def test_the_braking_distance_is_v_squared_over_two_mu_g(friction: float, base: str) -> None:
    assert stopped(15.0, friction, 8.0, base=base) == pytest.approx(15.0**2 / (2.0 * friction * G), rel=2e-4)


def test_weak_brakes_decide_where_the_road_holds_more() -> None:
    assert stopped(15.0, 0.5, 3.0) == pytest.approx(15.0**2 / (2.0 * 3.0), rel=2e-4)
    assert stopped(15.0, None, 20.0) == pytest.approx(15.0**2 / (2.0 * 20.0), rel=2e-3)


def test_downhill_the_weight_pulls_and_presses_less() -> None:
    """a = mu g cos(slope) - g sin(slope) along the slope; a map shows the way from above."""
    slope = -0.1
    a = 0.4 * G * math.cos(slope) + G * math.sin(slope)
    way = stopped(15.0, 0.4, 8.0, grade=slope) / math.cos(slope)
    assert way == pytest.approx(15.0**2 / (2.0 * a), rel=2e-4)


def test_turning_parts_are_braked_by_the_tyres_as_well() -> None:
    """At the limit the car brakes with mu g, whatever turns in it."""
    found = stopped(15.0, 0.3, 8.0, effects={"motor_inertia": {"J": 0.05}})
    assert found == pytest.approx(15.0**2 / (2.0 * 0.3 * G), rel=2e-4)


def test_a_car_starts_with_no_more_than_mu_g() -> None:
    car = plant()
    car.friction(0.2)
    car.command(0.0, accel=5.0)
    assert car.advance(2000)[-1, 5] == pytest.approx(0.2 * G * 2.0, rel=1e-6)


def test_a_car_without_tyres_runs_wide_on_the_circle_that_the_road_holds() -> None:
    """v^2 / R = mu g."""
    car = plant(v=12.0)
    car.friction(0.3)
    car.command(0.4)
    yaw_rate = car.advance(1000)[-1, 8]
    assert yaw_rate == pytest.approx(0.3 * G / 12.0, rel=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("bank", [0.1, -0.1])
def test_a_bank_helps_a_car_without_tyres_through_its_curve_or_takes_its_hold(bank: float, side: float) -> None:
    """v^2 k + g sin(bank) = mu g cos(bank) in a curve to the left: a bank whose left side is up needs tyres itself."""
    car = plant(v=12.0)
    car.friction(0.3)
    car.road(0.0, 0.0, side * bank)
    car.command(side * 0.4)
    row = car.advance(1000)[-1]
    assert side * row[5] * row[8] == pytest.approx(0.3 * G * math.cos(bank) - G * math.sin(bank), rel=1e-4)


@pytest.mark.parametrize("bank", [0.25, -0.25])
@pytest.mark.parametrize("v", [0.0, 0.3, 10.0])
def test_a_car_without_tyres_on_a_bank_that_no_tyre_would_hold_turns_no_more_than_it_is_steered(
    v: float, bank: float
) -> None:
    car = plant(v=v)
    car.friction(0.15)
    car.road(0.0, 0.0, bank)
    car.command(0.2)
    rows = car.advance(200)
    curved = rows[:, 8] * np.sign(rows[:, 5])  # it may roll back, as its wheels are turned uphill
    assert ((curved >= 0.0) & (curved <= np.abs(rows[:, 5]) * math.tan(0.2) / 2.5 + 1e-9)).all()


def test_tyres_hold_no_more_across_than_mu_times_their_load() -> None:
    car = plant("dynamic_bicycle", v=20.0)
    car.friction(0.3)
    car.command(0.2)
    across = abs(car.advance(3000)[:, 10])
    assert (
        across.max() <= 0.3 * G * 1.005
    )  # at the rear axle, while the speed falls; the forces are those of the centre
    assert across[-1] > 0.9 * 0.3 * G


def test_what_brakes_along_is_missing_across() -> None:
    """Friction circle: braking with 0.6 of what the road holds leaves sqrt(1 - 0.36) = 0.8 of it for the curve."""
    car = plant(v=20.0)
    car.friction(0.5)
    car.command(0.4, accel=-0.6 * 0.5 * G)
    row = car.advance(100)[-1]
    assert row[5] * row[8] == pytest.approx(0.8 * 0.5 * G, rel=1e-3)


def test_without_a_stated_friction_nothing_changes() -> None:
    free, told = plant("dynamic_bicycle", v=20.0), plant("dynamic_bicycle", v=20.0)
    told.friction(0.4)
    told.friction(None)
    for car in (free, told):
        car.command(0.15, accel=-4.0)
    assert free.advance(2000).tobytes() == told.advance(2000).tobytes()


@pytest.mark.parametrize(("limit", "friction", "holds"), [(4.0, 0.9, 4.0), (8.0, 0.3, 0.3 * G), (5.0, 0.6, 5.0)])
def test_tyres_of_a_limit_hold_the_lower_one_of_theirs_and_of_the_road(
    limit: float, friction: float, holds: float
) -> None:
    """Both are limits of one force: a car whose tyres hold 5 m/s^2 holds them where the road would hold 5.9."""
    both, one = (plant("dynamic_bicycle", {"tyre_saturation": {"limit": most}}, v=20.0) for most in (limit, holds))
    both.friction(friction)
    for car in (both, one):
        car.command(0.2)
    held, wanted = both.advance(2000), one.advance(2000)
    assert np.abs(wanted[:, 10]).max() > 0.95 * holds
    assert held[:, [7, 8, 10]] == pytest.approx(wanted[:, [7, 8, 10]], abs=1e-9)


def test_tyres_of_a_limit_across_leave_the_brakes_alone_but_for_what_the_road_holds() -> None:
    """Of `tyre_saturation`, which names a limit across, nobody knows what the tyres hold along."""
    car = plant("dynamic_bicycle", {"tyre_saturation": {"limit": 4.0}}, v=20.0)
    car.command(0.0, accel=-7.0)
    assert car.advance(1000)[-1, 5] == pytest.approx(13.0, abs=1e-9)
    assert stopped(
        15.0, 0.5, 8.0, base="dynamic_bicycle", effects={"tyre_saturation": {"limit": 4.0}}
    ) == pytest.approx(15.0**2 / (2.0 * 0.5 * G), rel=2e-4)


ICE = 0.1


def on_ice(effects: dict[str, dict[str, float]], steer: float, accel: float = 0.0, *, v: float = 12.0) -> Plant:
    car = plant("dynamic_bicycle", effects, v=v)
    car.friction(ICE)
    car.command(steer, accel=accel)
    return car


def test_a_body_leans_by_the_side_force_that_the_road_holds() -> None:
    """It adds a fifth of what accelerates the centre of gravity, 1.3 m ahead of the rear axle: at most mu g."""
    car = on_ice({"body_roll": {"gain": 0.2, "frequency": 2.0, "damping": 0.5}}, 0.3)
    before, row = car.advance(2000)[-2:]
    held = row[10] + 1.3 * (row[8] - before[8]) / 1e-3
    shown = car.shown_row()[10]
    assert shown == pytest.approx(row[10] + 0.2 * held, rel=1e-3)
    assert 1.15 * ICE * G < shown < 1.2 * ICE * G


def test_an_elastic_steering_gives_way_by_the_side_force_that_the_road_holds() -> None:
    """The front axle carries 1.3/2.5 of the weight and holds a tenth of that: 510 N, and 0.02 rad/kN give 10 mrad."""
    car = on_ice({"steer_compliance": {"c": 0.02}}, 0.3)
    steer = car.advance(500)[-1, 11]
    assert 0.3 - steer == pytest.approx(0.02e-3 * ICE * 1000.0 * G * 1.3 / 2.5, rel=0.01)


@pytest.mark.parametrize(
    "effects", [{"axle_load_shift": {"c": 0.5}}, {"steered_wheel_forces": {"drive": 0.0, "brake": 0.7}}]
)
def test_what_brakes_beyond_the_road_changes_nothing(effects: dict[str, dict[str, float]]) -> None:
    """Wheels that are asked for 2 and for 8 m/s^2 give the same where the road holds 1 m/s^2."""
    some, more = (on_ice(effects, 0.05, -asked).advance(500) for asked in (2.0, 8.0))
    assert more[-1, [1, 2, 4, 5, 7, 8]] == pytest.approx(some[-1, [1, 2, 4, 5, 7, 8]], abs=1e-12)
    assert (
        math.hypot(more[-1, 9], more[-1, 10]) < 1.01 * ICE * G
    )  # at the rear axle; the forces are those of the centre


def test_curve_resistance_is_that_of_the_curve_that_the_road_holds() -> None:
    """a = -c v r, and v r is mu g at most."""
    car = plant(effects={"cornering_drag": {"c": 0.5}}, v=12.0)
    car.friction(ICE)
    car.command(0.3)
    assert 12.0 - car.advance(1000)[-1, 5] == pytest.approx(0.5 * ICE * G, rel=1e-6)
