"""What the reference stack states of its input: age, order, and agreement with its filter."""

from __future__ import annotations

import numpy as np
import pytest

from ads.input_stamps import InputStamps
from ads.localization import EkfLocalizer
from vehicle.messages import GnssFix, Imu, Observation, Odometry, VehicleDescription

CAR = VehicleDescription(
    length=3.03, width=1.488, height=1.38, wheelbase=2.36, center_x=1.18, max_steer=0.35, max_speed=30.0,
    max_acceleration=2.5, max_deceleration=8.0, mass=730.0,
)  # fmt: skip


def test_age_and_order_of_messages() -> None:
    stamps = InputStamps()
    assert stamps.update(Observation(0.0)) == {"disordered": 0.0}
    seen = stamps.update(Observation(1.0, imu=tuple(Imu(t, 0.0, 0.0, 0.0) for t in (0.97, 0.98, 0.99))))
    assert seen == {"age_imu": pytest.approx(0.01), "disordered": 0.0}
    swapped = stamps.update(Observation(1.05, imu=tuple(Imu(t, 0.0, 0.0, 0.0) for t in (1.0, 0.98, 0.99))))
    assert swapped == {"age_imu": pytest.approx(0.05), "disordered": 2.0}
    assert stamps.update(Observation(1.1)) == {"age_imu": pytest.approx(0.1), "disordered": 2.0}


def agreement(wheels: float, turned: float) -> dict[str, float]:
    """Greatest innovation of each sensor over 20 s at 5 m/s; from 10 s on the odometry tells `wheels` [m/s], and the
    receiver a heading `turned` by so much [rad]."""
    rng = np.random.default_rng(2)
    localizer = EkfLocalizer(CAR, lambda x, y: 0.0)
    greatest: dict[str, float] = {}
    for k in range(1, 401):
        t = 0.05 * k
        v, yaw = (wheels, turned) if t > 10.0 else (5.0, 0.0)
        fix = GnssFix(
            t, 5.0 * t + rng.normal(0.0, 0.02), rng.normal(0.0, 0.02), 0.02, yaw + rng.normal(0.0, 0.01), 0.01
        )
        observation = Observation(t, (fix,), (Odometry(t, v + rng.normal(0.0, 0.02), 0.0),), (Imu(t, 0.0, 0.0, 0.0),))
        localizer.update(observation)
        if t > 5.0:  # settled
            for name, value in localizer.consistency.items():
                greatest[name] = max(value, greatest.get(name, 0.0))
    return greatest


def test_sensors_that_disagree_show_in_the_innovation() -> None:
    """Chi-square of one degree of freedom exceeds 37 once in 1e9; standing wheels, then a heading 10 sigma off."""
    sound = agreement(5.0, 0.0)
    assert set(sound) == {"nis_gnss", "nis_heading", "nis_wheels"}
    assert max(sound.values()) < 37.0
    standing, turned = agreement(0.0, 0.0), agreement(5.0, 0.1)
    assert standing["nis_wheels"] > 100.0
    assert turned["nis_heading"] > 37.0
    assert turned["nis_wheels"] < 37.0
