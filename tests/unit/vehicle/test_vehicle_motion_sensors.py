"""GNSS, odometry and IMU: what they say of a known motion, and when."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest

from vehicle.messages import Observation, no_surroundings
from vehicle.model.errors import ModelError
from vehicle.sensors import Gnss, InertialUnit, Mount, SensorSuite, Timing, WheelOdometry, default_sensors

EMPTY = no_surroundings()


def _row(t: float, **motion: float) -> list[float]:
    names = ("x", "y", "z", "yaw", "v", "vx", "vy", "yaw_rate", "ax", "ay", "steer")
    return [t, *(motion.get(name, 0.0) for name in names)]


def _watch(suite: SensorSuite, seconds: float, seed: int = 1, **motion: float) -> list[Observation]:
    """Observations at 20 Hz of a car whose motion stays as given."""
    running = suite.start(_row(0.0, **motion), seed)
    seen = [running.observe(0.0, EMPTY)]
    for tick in range(1, round(seconds * 20) + 1):
        running.feed([_row((5 * (tick - 1) + i) / 100, **motion) for i in range(1, 6)])
        seen.append(running.observe(tick / 20, EMPTY))
    return seen


SILENT_GNSS = Gnss(Mount(x=1.0, y=0.5), Timing(10.0), sigma=0.0, drift=0.0, yaw_sigma=0.0)
SILENT_IMU = InertialUnit(Mount(), Timing(100.0), accel_sigma=0.0, accel_bias=0.0, gyro_sigma=0.0, gyro_bias=0.0)


def test_gnss_gives_the_antenna_not_the_reference_point() -> None:
    fix = _watch(SensorSuite(gnss=SILENT_GNSS), 0.0, x=10.0, y=20.0, yaw=pi / 6)[0].gnss[0]
    assert fix.x == pytest.approx(10.0 + cos(pi / 6) - 0.5 * sin(pi / 6))
    assert fix.y == pytest.approx(20.0 + sin(pi / 6) + 0.5 * cos(pi / 6))
    assert fix.yaw == pytest.approx(pi / 6)


def test_single_antenna_has_no_heading() -> None:
    single = replace(SILENT_GNSS, yaw_sigma=None)
    assert _watch(SensorSuite(gnss=single), 0.0)[0].gnss[0].yaw is None


@pytest.mark.parametrize("rate", [1.0, 5.0, 10.0, 12.5])
def test_messages_come_at_their_rate(rate: float) -> None:
    seen = _watch(SensorSuite(gnss=replace(SILENT_GNSS, timing=Timing(rate))), 8.0)
    times = [fix.t for o in seen for fix in o.gnss]
    assert len(times) == round(8.0 * rate) + 1
    assert np.diff(times) == pytest.approx(1.0 / rate)


def test_latency_delays_the_delivery_not_the_stamp() -> None:
    seen = _watch(SensorSuite(gnss=replace(SILENT_GNSS, timing=Timing(10.0, latency=0.12))), 2.0)
    for observation in seen:
        for fix in observation.gnss:
            assert fix.t + 0.12 <= observation.t + 1e-9 < fix.t + 0.12 + 0.05


def test_each_message_is_delivered_once_and_in_order() -> None:
    seen = _watch(SensorSuite(imu=replace(SILENT_IMU, timing=Timing(100.0, latency=0.033))), 2.0)
    times = [m.t for o in seen for m in o.imu]
    assert times == sorted(set(times))


def test_dropout_loses_its_share() -> None:
    seen = _watch(SensorSuite(imu=replace(SILENT_IMU, timing=Timing(100.0, dropout=0.3))), 100.0)
    share = 1.0 - sum(len(o.imu) for o in seen) / 10_001
    assert share == pytest.approx(0.3, abs=4.0 * (0.3 * 0.7 / 10_000) ** 0.5)


def test_gnss_noise_has_its_standard_deviation_and_no_mean() -> None:
    noisy = replace(SILENT_GNSS, sigma=0.5, yaw_sigma=0.1)
    fixes = [f for o in _watch(SensorSuite(gnss=noisy), 400.0) for f in o.gnss]
    x = np.array([f.x for f in fixes]) - 1.0
    yaw = np.array([f.yaw for f in fixes])
    assert abs(x.mean()) < 4.0 * 0.5 / len(x) ** 0.5
    assert x.std() == pytest.approx(0.5, rel=0.06)
    assert yaw.std() == pytest.approx(0.1, rel=0.06)
    assert fixes[0].sigma == pytest.approx(0.5)


def test_gnss_drift_is_slow_and_has_its_size() -> None:
    slow = replace(SILENT_GNSS, drift=1.0, drift_time=5.0)
    x = np.array([f.x for o in _watch(SensorSuite(gnss=slow), 2000.0) for f in o.gnss]) - 1.0
    assert x.std() == pytest.approx(1.0, rel=0.2)
    lag = np.corrcoef(x[:-10], x[10:])[0, 1]  # 1 s apart
    assert lag == pytest.approx(np.exp(-1.0 / 5.0), abs=0.05)


def test_odometry_scale_and_offset() -> None:
    wheels = WheelOdometry(Timing(50.0), scale=1.02, sigma=0.0, steer_sigma=0.0, steer_offset=0.01)
    message = _watch(SensorSuite(odometry=wheels), 0.0, v=5.0, steer=0.1)[0].odometry[0]
    assert message.v == pytest.approx(5.1)
    assert message.steer == pytest.approx(0.11)


def test_odometry_reads_exactly_zero_at_standstill() -> None:
    wheels = WheelOdometry(Timing(50.0), sigma=0.5)
    assert {m.v for o in _watch(SensorSuite(odometry=wheels), 2.0) for m in o.odometry} == {0.0}


def test_imu_away_from_the_reference_point_feels_the_centripetal_force() -> None:
    unit = replace(SILENT_IMU, mount=Mount(x=2.0, y=-0.5))
    message = _watch(SensorSuite(imu=unit), 1.0, yaw_rate=0.6, ax=0.1, ay=3.0)[-1].imu[-1]
    assert message.ax == pytest.approx(0.1 - 0.36 * 2.0)
    assert message.ay == pytest.approx(3.0 + 0.36 * 0.5)
    assert message.yaw_rate == pytest.approx(0.6)


def test_imu_away_from_the_reference_point_feels_yaw_acceleration() -> None:
    running = SensorSuite(imu=replace(SILENT_IMU, mount=Mount(x=2.0))).start(_row(0.0), 1)
    running.feed([_row(0.01, yaw_rate=0.03)])
    message = running.observe(0.05, EMPTY).imu[-1]
    assert message.ay == pytest.approx(3.0 * 2.0)


def test_imu_mounted_turned_by_90_degrees_swaps_its_axes() -> None:
    unit = replace(SILENT_IMU, mount=Mount(yaw=pi / 2))
    message = _watch(SensorSuite(imu=unit), 0.0, ax=1.0, ay=2.0)[0].imu[0]
    assert (message.ax, message.ay) == pytest.approx((2.0, -1.0))


def test_imu_bias_is_constant_in_a_run_and_differs_between_seeds() -> None:
    unit = replace(SILENT_IMU, accel_bias=0.1)
    biases = []
    for seed in range(200):
        values = {m.ax for o in _watch(SensorSuite(imu=unit), 0.1, seed=seed) for m in o.imu}
        assert len(values) == 1
        biases += values
    assert np.std(biases) == pytest.approx(0.1, rel=0.2)


def test_a_sensor_of_its_own_generator_does_not_move_the_others() -> None:
    noisy = replace(SILENT_GNSS, sigma=0.5)
    alone = _watch(SensorSuite(gnss=noisy), 2.0)
    together = _watch(SensorSuite(gnss=noisy, imu=SILENT_IMU, odometry=WheelOdometry(Timing(50.0))), 2.0)
    assert [o.gnss for o in alone] == [o.gnss for o in together]


@pytest.mark.parametrize(
    ("sensor", "rate", "allowed"),
    [("gnss", 101.0, 100), ("odometry", 200.0, 100), ("imu", 200.0, 100), ("lidar", 30.0, 20), ("camera", 30.0, 20)],
)
def test_a_rate_that_cannot_be_kept_is_refused(sensor: str, rate: float, allowed: int) -> None:
    """Motion is known at 100 Hz, and the surroundings at 20 Hz; as often, a sensor may measure."""
    found = getattr(default_sensors(), sensor)
    SensorSuite(**{sensor: replace(found, timing=Timing(float(allowed)))})
    with pytest.raises(ModelError, match=f"{sensor} rate.*{rate:g}.*to {allowed} Hz"):
        SensorSuite(**{sensor: replace(found, timing=Timing(rate))})


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Timing(0.0),
        lambda: Timing(10.0, latency=-1.0),
        lambda: Timing(10.0, dropout=1.5),
        lambda: Timing(float("nan")),
        lambda: replace(SILENT_GNSS, sigma=-1.0),
        lambda: replace(SILENT_GNSS, drift_time=0.0),
        lambda: replace(SILENT_GNSS, drift_time=float("nan")),
        lambda: replace(SILENT_IMU, gyro_sigma=float("nan")),
    ],
)
def test_impossible_figures_are_refused(wrong: object) -> None:
    with pytest.raises(ModelError):
        wrong()  # type: ignore[operator]
