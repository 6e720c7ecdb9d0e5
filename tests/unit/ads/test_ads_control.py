"""Control parts against closed forms and independent solvers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ads_loop import SEDAN, TABBY
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_discrete_are

from ads.control.delay_compensation import DelayCompensation
from ads.control.longitudinal import COMFORT_DECELERATION, NOW, ComfortSpeedControl, allowed_speed
from ads.control.lqr import DT, V_0, riccati_gain
from ads.control.mpc import N, OffsetPlanner, offset_at
from ads.control.pedals import PiPedals
from ads.control.speed_profile import LATERAL_ACCELERATION, approach_speed, fill_speed, firmer, stopping_distance
from ads.control.spline import KAPPA, SPEED, YAW, S, X, Y, project, sample, shifted, spline_path
from ads.localization import Estimate


def circle(radius: float, angle: float = math.pi) -> np.ndarray:
    a = np.arange(0.0, angle, 2.0 / radius)
    return spline_path(np.column_stack((radius * np.sin(a), radius * (1 - np.cos(a)))), 0.5)


def straight(length: float = 200.0, speed: float = 5.0) -> np.ndarray:
    path = spline_path(np.column_stack((np.arange(0.0, length + 1, 2.0), np.zeros(int(length / 2) + 1))), 0.5)
    path[:, SPEED] = speed
    return path


def at(v: float, x: float = 0.0) -> Estimate:
    return Estimate(0.0, x, 0.0, 0.0, v, 0.0, 0.0, 0.1, 0.01)


class TestSpline:
    def test_agrees_with_scipys_natural_spline(self):
        rng = np.random.default_rng(0)
        points = np.column_stack((np.arange(0.0, 40.0, 2.0), rng.uniform(-1, 1, 20)))
        path = spline_path(points, 0.5)
        u = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
        expected = CubicSpline(u, points, bc_type="natural")(np.linspace(0.0, u[-1], len(path)))
        assert path[:, X : Y + 1] == pytest.approx(expected, abs=1e-9)

    def test_has_the_curvature_of_a_circle(self):
        path = circle(12.0)
        inner = path[(path[:, S] > 8.0) & (path[:, S] < path[-1, S] - 8.0)]
        assert inner[:, KAPPA] == pytest.approx(1.0 / 12.0, rel=0.01)

    def test_heading_goes_on_beyond_pi(self):
        path = circle(12.0, 2.0 * math.pi)
        assert path[-1, YAW] > 5.5
        assert np.abs(np.diff(path[:, YAW])).max() < 0.1

    @pytest.mark.parametrize(("x", "y"), [(10.2, 1.5), (30.0, -2.0), (-3.0, 0.0)])
    def test_projects_onto_a_line(self, x, y):
        _, along, across = project(straight(), x, y, -1, 0)
        assert (along, across) == pytest.approx((x, y), abs=1e-9)

    def test_sample_interpolates(self):
        x, y, yaw, kappa, speed = sample(straight(), 0, 10.25)
        assert (x, y, yaw, kappa, speed) == pytest.approx((10.25, 0.0, 0.0, 0.0, 5.0), abs=1e-9)

    def test_shifting_a_circle_outwards_widens_it(self):
        path = circle(20.0)
        out = shifted(path, 0, np.full(len(path), -2.0))
        middle = out[20:-20]
        assert np.hypot(middle[:, X], middle[:, Y] - 20.0) == pytest.approx(22.0, abs=0.02)
        assert middle[:, KAPPA] == pytest.approx(1.0 / 22.0, rel=0.03)


class TestSpeedProfile:
    def test_the_law_of_the_radius(self):
        path = circle(20.0)
        fill_speed(path, 5.5, 40.0, 10.0, 10.0)
        assert path[len(path) // 2, SPEED] == pytest.approx(5.5 * math.sqrt(20.0 / 40.0), rel=0.01)

    def test_lateral_acceleration_is_bounded_at_speed(self):
        path = circle(100.0)
        fill_speed(path, 30.0, 40.0, 10.0, 10.0)
        assert path[len(path) // 2, SPEED] == pytest.approx(math.sqrt(LATERAL_ACCELERATION * 100.0), rel=0.01)

    def test_speed_changes_keep_to_the_limits(self):
        path = circle(15.0)
        fill_speed(path, 5.5, 40.0, 1.0, 0.8)
        slope = np.diff(path[:, SPEED] ** 2) / np.diff(path[:, S]) / 2.0
        assert slope.max() <= 1.0 + 1e-9
        assert slope.min() >= -0.8 - 1e-9

    @pytest.mark.parametrize("v", [0.3, 1.0, 3.0, 8.0, 25.0])
    def test_stopping_distance_is_the_integral_of_the_braking_law(self, v):
        speeds = np.linspace(0.0, v, 200_001)
        expected = np.trapezoid(speeds / np.minimum(1.2, 0.15 + 0.7 * speeds), speeds)
        assert stopping_distance(v, 1.2) == pytest.approx(expected, rel=1e-5)

    @pytest.mark.parametrize("v", [0.05, 0.5, 1.4, 5.0, 25.0])
    def test_approach_speed_is_its_inverse(self, v):
        assert approach_speed(stopping_distance(v, 1.0), 1.0) == pytest.approx(v, rel=1e-4)

    @pytest.mark.parametrize("distance", [12.0, 13.0, 15.0])
    def test_a_stop_learnt_late_is_braked_for_evenly_and_no_harder_than_it_needs(self, distance: float) -> None:
        # 5.5 m/s at 1.0 m/s^2, easing out, take 15.5 m
        firm = firmer(5.5, distance, 1.0)
        assert 1.0 < firm < 1.6
        assert stopping_distance(5.5, firm) == pytest.approx(distance, abs=0.05)

    def test_a_stop_learnt_in_time_is_braked_for_as_planned(self) -> None:
        assert firmer(5.5, 16.0, 1.0) == 1.0


class TestLqr:
    @pytest.mark.parametrize("v", [1.0, 5.5, 8.0, 20.0])
    @pytest.mark.parametrize(("q11", "q22", "r11"), [(30.0, 1e-4, 5000.0), (20.0, 100.0, 9000.0)])
    def test_gains_solve_the_riccati_equation(self, v, q11, q22, r11):
        a = np.array([[1.0, v * DT], [0.0, 1.0]])
        b = np.array([[0.5 * (v * DT) ** 2 / 2.36], [v * DT / 2.36]])
        r = np.array([[r11 * max(1.0, v / V_0) ** 4]])
        p = solve_discrete_are(a, b, np.diag([q11, q22]), r)
        expected = np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a).ravel()
        assert riccati_gain(v, 2.36, q11, q22, r11) == pytest.approx(expected, rel=1e-4)

    def test_without_weights_there_is_no_gain(self):
        assert riccati_gain(5.5, 2.36, 0.0, 0.0, 5000.0) == (0.0, 0.0)


class TestMpc:
    def solve(self, low=-10.0, high=10.0, wanted=2.75, start=(0.0, 0.0, 0.0)):
        at_step = np.arange(1, N + 1)
        middle = (at_step >= 7) & (at_step <= 13)
        lows, highs, goal = np.full(N, -10.0), np.full(N, 10.0), np.zeros(N)
        lows[middle], highs[middle], goal[middle] = low, high, wanted
        return OffsetPlanner().solve(start, 3.0, goal, lows, highs, 0.1)

    def test_goes_out_and_comes_back(self):
        pieces = self.solve(low=2.0)
        offsets = [offset_at(pieces, 0.0, 3.0, s)[0] for s in np.arange(0.0, 60.0, 0.5)]
        assert max(offsets) == pytest.approx(2.75, abs=0.4)
        assert offsets[0] == 0.0
        end = offset_at(pieces, 0.0, 3.0, 60.0 - 1e-9)
        assert end == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)

    def test_keeps_clear_of_the_obstacle(self):
        pieces = self.solve(low=2.6, wanted=0.0)
        assert min(offset_at(pieces, 0.0, 3.0, 3.0 * k)[0] for k in range(7, 14)) >= 2.6 - 1e-6

    def test_curvature_stays_in_its_bound(self):
        pieces = self.solve(low=2.6)
        bends = [abs(offset_at(pieces, 0.0, 3.0, 3.0 * k)[2]) for k in range(1, N)]
        assert max(bends) <= 0.1 + 1e-6

    def test_is_smooth_to_the_second_derivative(self):
        pieces = self.solve(low=2.6)
        for k in range(1, N):
            before, after = offset_at(pieces, 0.0, 3.0, 3.0 * k - 1e-9), offset_at(pieces, 0.0, 3.0, 3.0 * k)
            assert after == pytest.approx(before, abs=1e-6)

    def test_starts_where_the_car_is(self):
        pieces = self.solve(start=(0.4, 0.05, 0.01))
        assert offset_at(pieces, 0.0, 3.0, 0.0) == pytest.approx((0.4, 0.05, 0.01))

    def test_what_cannot_be_done_is_no_plan(self):
        assert self.solve(low=3.0, high=2.0) is None
        assert self.solve(low=15.0, high=20.0) is None  # a bend of 10 m radius gains 11 m in 21 m


class TestDelayCompensation:
    def test_predicts_a_circle_with_the_commands_under_way(self):
        radius, v, delay = 10.0, 5.0, 0.2
        steer = math.atan(2.36 / radius)
        compensation = DelayCompensation(delay, 2.36)
        for k in range(10):
            compensation.remember(k * 0.05, steer)
        x, y, yaw, _ = compensation.predict(0.45, 0.0, 0.0, 0.0, v, v / radius, 0.0)
        turn = v * delay / radius
        assert (x, y, yaw) == pytest.approx((radius * math.sin(turn), radius * (1 - math.cos(turn)), turn), abs=2e-3)

    def test_a_command_still_on_its_way_bends_the_end_of_the_prediction(self):
        compensation = DelayCompensation(0.2, 2.36)
        for k in range(10):
            compensation.remember(k * 0.05, 0.0 if k < 8 else 0.1)
        _, y, yaw, _ = compensation.predict(0.45, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0)
        assert 0.0 < yaw < 5.0 * 0.2 * math.tan(0.1) / 2.36
        assert y > 0.0

    def test_without_delay_the_pose_stays(self):
        assert DelayCompensation(0.0, 2.36).predict(0.0, 1.0, 2.0, 0.3, 5.0, 0.1, 0.0) == (1.0, 2.0, 0.3, 5.0)


class TestPedals:
    def test_feed_forward_is_the_share_of_what_the_car_can(self):
        throttle, brake = PiPedals(TABBY).press(1.0, 5.0, False, 0.05)
        assert throttle == pytest.approx((1.0 + 0.12 + 0.45 * 25.0 / 730.0) / 2.5, rel=0.01)
        assert brake == 0.0

    def test_never_both_at_once(self):
        pedals = PiPedals(TABBY)
        for accel in (-3.0, -0.2, 0.0, 0.2, 3.0):
            throttle, brake = pedals.press(accel, 5.0, False, 0.05)
            assert throttle == 0.0 or brake == 0.0

    def test_learns_a_slope(self):
        pedals, v, earlier = PiPedals(TABBY), 5.0, 5.0
        for k in range(600):
            earlier = v if k == 560 else earlier
            throttle, brake = pedals.press(0.0, v, False, 0.05)
            v += (2.5 * throttle - 8.0 * brake - 0.12 - 0.49) * 0.05  # 5 % uphill
        assert abs(v - earlier) < 0.02
        assert throttle == pytest.approx((0.12 + 0.49) / 2.5, abs=0.03)

    def test_does_not_wind_up_at_full_throttle(self):
        pedals = PiPedals(TABBY)
        for _ in range(600):  # a wall: it does not move
            pedals.press(2.5, 0.5, False, 0.05)
        throttle, _ = pedals.press(-1.0, 0.5, False, 0.05)
        assert throttle < 0.7

    def test_holds_a_standing_car(self):
        throttle, brake = PiPedals(TABBY).press(-0.3, 0.0, True, 0.05)
        assert throttle == 0.0
        assert brake > 0.2


class TestSpeedControl:
    def drive(self, limits, brake=0.0, v=5.0, car=TABBY, speed=5.0, duration=30.0):
        control, path = ComfortSpeedControl(car, 0.05), straight(400.0, speed)
        x, rows = 0.0, []
        for _ in range(round(duration / 0.05)):
            a, _ = control.step(at(v, x), path, int(x / 0.5), x, limits(x), brake)
            new = max(v + a * 0.05, 0.0)
            x, v = x + 0.5 * (v + new) * 0.05, new
            rows.append((x, v, a))
        return np.array(rows)

    def test_stops_at_the_stop_without_passing_it(self):
        rows = self.drive(lambda x: [(60.0 - x, 0.0)])
        assert rows[-1, 1] == 0.0
        assert 59.0 < rows[-1, 0] <= 60.1

    def test_jerk_is_bounded_on_the_way(self):
        rows = self.drive(lambda x: [(60.0 - x, 0.0)])
        moving = rows[:-1, 1] > 0.1
        assert np.abs(np.diff(rows[:, 2]))[moving].max() / 0.05 <= 1.0 + 1e-6

    def test_brakes_no_more_than_comfort_needs(self):
        rows = self.drive(lambda x: [(60.0 - x, 0.0)])
        assert rows[:, 2].min() > -1.2

    def test_a_limit_from_now_on_slows_down(self):
        rows = self.drive(lambda x: [(NOW, 3.0)])
        assert rows[-1, 1] == pytest.approx(3.0, abs=0.05)

    def test_an_emergency_brakes_with_what_it_is_told(self):
        rows = self.drive(lambda x: [], brake=6.0, v=16.0, car=SEDAN, speed=16.0, duration=5.0)
        assert rows[:, 2].min() == pytest.approx(-6.0)
        assert rows[-1, 1] == 0.0

    def test_closes_up_and_keeps_the_gap_to_a_slower_vehicle(self):
        gaps = []

        def limits(x):
            t = len(gaps) * 0.05
            gap = 40.0 + 3.0 * t - x
            gaps.append(gap)
            return [(gap - 7.5, 3.0)]

        rows = self.drive(limits, duration=40.0)
        assert rows[-1, 1] == pytest.approx(3.0, abs=0.05)
        assert gaps[-1] == pytest.approx(7.5, abs=1.5)
        assert min(gaps) > 6.0


class TestAllowedSpeed:
    def test_a_stop_ahead_is_met_by_comfortable_braking(self):
        assert allowed_speed(9.0, 5.0, [(10.0, 0.0)]) == pytest.approx(math.sqrt(2 * COMFORT_DECELERATION * 10.0))

    def test_the_lowest_limit_counts(self):
        assert allowed_speed(5.5, 5.0, [(NOW, 4.0), (200.0, 0.0)]) == 4.0

    def test_without_limits_it_is_that_of_the_path(self):
        assert allowed_speed(3.6, 5.0, []) == 3.6
