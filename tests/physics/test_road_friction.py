"""Friction of the road against closed forms: braking distance, start, circle, and the friction circle of both."""

from __future__ import annotations

import math

import pytest
from vehicle_models import plant

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
    """a = mu g cos(slope) - g sin(slope)."""
    slope = -0.1
    a = 0.4 * G * math.cos(slope) + G * math.sin(slope)
    assert stopped(15.0, 0.4, 8.0, grade=slope) == pytest.approx(15.0**2 / (2.0 * a), rel=2e-4)


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
