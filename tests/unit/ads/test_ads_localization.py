"""EKF: consistency, latency, outliers, outage. The truth is integrated by the test itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2

from ads.localization import EkfLocalizer
from vehicle.messages import GnssFix, Imu, Observation, Odometry, VehicleDescription

CAR = VehicleDescription(
    length=3.03, width=1.488, height=1.38, wheelbase=2.36, center_x=1.18, max_steer=0.35, max_speed=30.0,
    max_acceleration=2.5, max_deceleration=8.0, mass=730.0, gnss_x=0.18, imu_x=1.0,
)  # fmt: skip
STEP = 0.01


def truth(duration: float) -> np.ndarray:
    """Rows t, x, y, yaw, v, w, a at 100 Hz: a winding drive with changing speed (midpoint rule, 10 substeps)."""
    rows, x, y, yaw = [], 0.0, 0.0, 0.3
    for k in range(round(duration / STEP) + 1):
        t = k * STEP
        v, a = 5.0 + 2.0 * math.sin(0.3 * t), 0.6 * math.cos(0.3 * t)
        w = 0.2 * math.sin(0.25 * t)
        rows.append((t, x, y, yaw, v, w, a))
        for i in range(10):
            m = t + (i + 0.5) * STEP / 10
            turn = 0.2 * math.sin(0.25 * m)
            speed = 5.0 + 2.0 * math.sin(0.3 * m)
            yaw += 0.5 * turn * STEP / 10
            x, y = x + speed * math.cos(yaw) * STEP / 10, y + speed * math.sin(yaw) * STEP / 10
            yaw += 0.5 * turn * STEP / 10
    return np.array(rows)


class Sensors:
    """Noisy sensors on the truth: GNSS 10 Hz, odometry 50 Hz, IMU 100 Hz, each delivered after its latency."""

    def __init__(self, rows: np.ndarray, seed: int, gnss_latency: float = 0.1, heading: bool = False) -> None:
        rng = np.random.default_rng(seed)
        self.queue: list[tuple[float, object]] = []
        bias = 0.005 * rng.standard_normal()
        for k, (t, x, y, yaw, v, w, a) in enumerate(rows):
            n = rng.standard_normal(8)
            if k % 10 == 0:
                fix = GnssFix(
                    t, x + CAR.gnss_x * math.cos(yaw) + 0.1 * n[0], y + CAR.gnss_x * math.sin(yaw) + 0.1 * n[1], 0.1,
                    yaw + 0.01 * n[2] if heading else None, 0.01 if heading else 0.0,
                )  # fmt: skip
                self.queue.append((t + gnss_latency, fix))
            if k % 2 == 0:
                steer = math.atan(w * CAR.wheelbase / v) + 0.002 * n[3]
                self.queue.append((t + 0.01, Odometry(t, v + 0.03 * n[4], steer)))
            self.queue.append((t, Imu(t, a - w * w * CAR.imu_x + 0.05 * n[5], v * w, w + bias + 0.005 * n[6])))
        self.queue.sort(key=lambda item: item[0])
        self.at = 0

    def until(self, t: float, keep=lambda message: True) -> Observation:
        got: dict[type, list] = {GnssFix: [], Odometry: [], Imu: []}
        while self.at < len(self.queue) and self.queue[self.at][0] <= t + 1e-9:
            message = self.queue[self.at][1]
            if keep(message):
                got[type(message)].append(message)
            self.at += 1
        return Observation(t, tuple(got[GnssFix]), tuple(got[Odometry]), tuple(got[Imu]))


def localize(rows: np.ndarray, sensors: Sensors, keep=lambda message: True):
    """Estimates at 20 Hz with their truth: list of (estimate, covariance, truth row)."""
    localizer = EkfLocalizer(CAR, lambda x, y: 0.3)
    found = []
    for k in range(0, len(rows), 5):
        estimate = localizer.update(sensors.until(k * STEP, keep))
        if estimate is not None:
            found.append((estimate, localizer.covariance.copy(), rows[k]))
    return localizer, found


def test_nees_of_the_pose_lies_within_95_percent_bounds_over_50_seeds():
    rows = truth(30.0)
    runs, values = 50, []
    for seed in range(runs):
        _, found = localize(rows, Sensors(rows, seed))
        estimate, p, true = found[-1]
        e = np.array([estimate.x - true[1], estimate.y - true[2], estimate.yaw - true[3]])
        values.append(e @ np.linalg.solve(p[:3, :3], e))
    low, high = chi2.ppf((0.025, 0.975), 3 * runs) / runs
    # an honest filter may be cautious (its noise is that of real sensors), but not overconfident
    assert 0.5 * low < np.mean(values) < high


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.3])
def test_late_fixes_take_their_place_in_time(latency):
    rows = truth(30.0)
    _, found = localize(rows, Sensors(rows, 1, gnss_latency=latency))
    errors = [math.hypot(e.x - r[1], e.y - r[2]) for e, _, r in found[100:]]
    assert np.sqrt(np.mean(np.square(errors))) < 0.15  # at 7 m/s, 0.3 s late is 2.1 m


def test_a_jump_of_50_m_is_rejected():
    rows = truth(20.0)
    sensors = Sensors(rows, 2)
    spoilt = []
    for arrival, message in sensors.queue:
        if isinstance(message, GnssFix) and 10.0 <= message.t < 11.0:
            message = GnssFix(message.t, message.x + 50.0, message.y, message.sigma)
        spoilt.append((arrival, message))
    sensors.queue = spoilt
    localizer, found = localize(rows, sensors)
    assert max(math.hypot(e.x - r[1], e.y - r[2]) for e, _, r in found[100:]) < 0.5
    assert localizer.rejected == 10


def test_thirty_seconds_without_gnss_drift_less_than_1_percent_of_the_distance():
    rows = truth(60.0)
    _, found = localize(
        rows, Sensors(rows, 3, heading=True), keep=lambda m: not (isinstance(m, GnssFix) and 20.0 < m.t < 50.0)
    )
    at = next(i for i, (e, _, _) in enumerate(found) if e.t >= 50.0)
    e, _, true = found[at]
    assert math.hypot(e.x - true[1], e.y - true[2]) < 0.01 * 5.0 * 30.0


def test_a_filter_that_is_lost_comes_back_to_fixes_that_agree():
    rows = truth(30.0)
    sensors = Sensors(rows, 4)
    sensors.queue = [
        (a, GnssFix(m.t, m.x + 8.0, m.y, m.sigma) if isinstance(m, GnssFix) and m.t > 5.0 else m)
        for a, m in sensors.queue
    ]
    _, found = localize(rows, sensors)
    e, _, true = found[-1]
    assert e.x - true[1] == pytest.approx(8.0, abs=0.5)


def test_nothing_is_known_before_the_first_fix():
    localizer = EkfLocalizer(CAR, lambda x, y: 0.0)
    assert localizer.update(Observation(0.0, odometry=(Odometry(0.0, 5.0, 0.0),))) is None
    estimate = localizer.update(Observation(0.1, gnss=(GnssFix(0.1, CAR.gnss_x, 0.0, 0.1),)))
    assert (estimate.x, estimate.y, estimate.v) == pytest.approx((0.0, 0.0, 5.0))


def test_the_covariance_stays_symmetric_and_positive():
    rows = truth(30.0)
    _, found = localize(rows, Sensors(rows, 5))
    for _, p, _ in found:
        assert np.allclose(p, p.T, atol=1e-9)
        assert np.linalg.eigvalsh(p).min() > 0.0
