"""Control at its limits: no plan around an obstacle, late steering, jerk, stability over speed."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest
from ads_loop import TABBY, Car, drive, new_stack
from ads_plane import PlaneMap
from ads_traffic import SeeingAll, corners, parked, separation
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from ads.control.longitudinal import URGENT_JERK, ComfortSpeedControl
from ads.control.lqr import DT, riccati_gain
from ads.control.mpc import OffsetPlanner
from ads.control.spline import SPEED, spline_path
from ads.localization import Estimate
from ads.parameters import ITERATIONS, preset
from vehicle.messages import RoadPoint, Task

ROAD = [(300.0, 0.0)]
GOAL = Task(goal=RoadPoint("1", -1, 150.0))


def gap_to(obstacle, car) -> float:
    middle = car.x + TABBY.center_x * math.cos(car.yaw), car.y + TABBY.center_x * math.sin(car.yaw)
    return separation(corners(*middle, car.yaw, TABBY.length, TABBY.width), obstacle.corners(0.0))


@pytest.mark.parametrize("solutions", [0, 8])
def test_where_the_mpc_finds_no_plan_the_car_stops_or_keeps_the_last_one(monkeypatch, solutions):
    # Without any, it stands behind the obstacle; after it has swung out, the last plan, which is clear, leads it past.
    solve, left, gaps, obstacle = OffsetPlanner.solve, [solutions], [], parked(70.0)

    def fails(self, *given):
        left[0] -= 1
        return solve(self, *given) if left[0] >= 0 else None

    monkeypatch.setattr(OffsetPlanner, "solve", fails)
    car = Car(TABBY, 5.0, -1.75, 0.0, 5.0)
    stack = new_stack(PlaneMap(ROAD), perception=SeeingAll([obstacle]))
    drive(stack, car, 40.0, GOAL, watch=lambda t, car: gaps.append(gap_to(obstacle, car)))
    assert left[0] < 0
    assert min(gaps) > 0.5
    if solutions == 0:
        assert car.v == 0.0
        assert car.x < 70.0 - 4.4 / 2
    else:
        assert car.x > 70.0 + 4.4 / 2


class LateCar(Car):
    """Steers 0.35 s after the command."""

    def step(self, steer, accel):
        late = self.__dict__.setdefault("late", deque([0.0] * 7))
        late.append(steer)
        super().step(late.popleft(), accel)


def rmse_in_bends(told: float) -> float:
    car = replace(TABBY, steer_delay=told)
    network = PlaneMap([(40.0, 0.0), (25.0, 1 / 25), (30.0, 0.0), (25.0, -1 / 25), (60.0, 0.0)])
    return drive(new_stack(network, car), LateCar(car, 5.0, -1.75, 0.0, 5.5), 40.0).rmse()


def test_a_steering_delay_that_is_told_is_made_up_for():
    assert rmse_in_bends(0.35) < 0.5 * rmse_in_bends(0.0)


@given(stops=st.lists(st.tuples(st.floats(0.0, 80.0), st.floats(0.0, 8.0)), min_size=1, max_size=12))
@settings(deadline=None, max_examples=40)
def test_whatever_limits_come_and_go_jerk_stays_that_of_urgent_braking(stops):
    path = spline_path(np.column_stack((np.arange(0.0, 400.0, 4.0), np.zeros(100))), 1.0)
    path[:, SPEED] = 5.5
    control, v, x, accelerations = ComfortSpeedControl(TABBY, DT), 5.5, 0.0, [0.0]
    for k in range(len(stops) * 20):
        limit = stops[k // 20]
        a, standing = control.step(Estimate(k * DT, x, 0.0, 0.0, v, 0.0, 0.0, 0.1, 0.01), path, int(x), x, [limit], 0.0)
        if standing:  # held by the brake: nothing moves
            break
        accelerations.append(a)
        v = max(v + a * DT, 0.0)
        x += v * DT
        if v < 0.1:
            break  # it stands: the command may fall to that of holding
    assert np.abs(np.diff(accelerations)).max() <= URGENT_JERK * DT + 1e-9


@pytest.mark.parametrize("iteration", ITERATIONS)
def test_steering_is_stable_and_well_damped_at_every_speed_with_every_preset(iteration):
    p = preset(iteration)
    for v in np.arange(0.5, 50.0, 0.5):
        k = np.array([riccati_gain(v, TABBY.wheelbase, p.LQR_q11, p.LQR_q22, p.LQR_r11)])
        a = np.array([[1.0, v * DT], [0.0, 1.0]])
        b = np.array([[0.5 * (v * DT) ** 2 / TABBY.wheelbase], [v * DT / TABBY.wheelbase]])
        poles = np.log(np.linalg.eigvals(a - b @ k).astype(complex)) / DT
        assert poles.real.max() < 0.0
        assert (
            -poles.real / np.abs(poles)
        ).min() > 0.6  # an optimal double integrator has at least 1/sqrt(2) in continuous time
