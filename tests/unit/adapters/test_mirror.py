"""The mirror shows a car where it is now from a measurement 20 ms old; virtual objects never hide real ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle.adapters.mirror import Mirror, extrapolated, merged_boxes, merged_points
from vehicle.messages import CameraBox, FloatArray


def row(t: float, x: float, y: float = 0.0, yaw: float = 0.0, v: float = 0.0, rate: float = 0.0, ax: float = 0.0):
    return np.array([t, x, y, 0.0, yaw, v, v, 0.0, rate, ax, v * rate, 0.0])


def on_circle(t: float, radius: float = 20.0, v: float = 10.0) -> FloatArray:
    angle = v / radius * t
    return row(t, radius * math.sin(angle), radius * (1.0 - math.cos(angle)), angle, v, v / radius)


def test_a_car_on_a_circle_is_where_the_circle_is() -> None:
    shown = extrapolated(on_circle(1.0)[None], 0.02)[0]
    assert shown[[0, 1, 2, 4]] == pytest.approx(on_circle(1.02)[[0, 1, 2, 4]], abs=1e-5)


def test_constant_acceleration_is_exact() -> None:
    """s = v d + a d^2 / 2 = 5 x 0.1 + 2 x 0.01 / 2."""
    shown = extrapolated(row(0.0, 0.0, v=5.0, ax=2.0)[None], 0.1)[0]
    assert (shown[1], shown[5]) == pytest.approx((0.51, 5.2))


def test_a_braking_car_stops_and_does_not_reverse() -> None:
    shown = extrapolated(row(0.0, 0.0, v=0.1, ax=-7.0)[None], 0.1)[0]
    assert shown[5] == 0.0
    assert shown[1] >= 0.0


def test_the_mirror_of_a_twin_is_the_twin() -> None:
    rows = np.stack([on_circle(0.01 * k) for k in range(1, 6)])
    mirror = Mirror()
    assert mirror.show(0.05, rows) is rows
    assert math.isnan(mirror.error)


def test_the_tracking_error_is_the_distance_to_the_measurement_of_that_instant() -> None:
    """At a sudden 7 m/s^2 of braking the mirror runs ahead by a d^2 / 2 = 7 x 0.02^2 / 2 = 1.4 mm."""
    mirror = Mirror()
    mirror.show(0.02, row(0.0, 0.0, v=10.0)[None])
    mirror.show(0.07, row(0.02, 10.0 * 0.02 - 0.0014, v=9.86, ax=-7.0)[None])
    assert mirror.error == pytest.approx(0.0014, abs=1e-9)
    assert mirror.latency == pytest.approx(0.05)


def test_without_a_new_measurement_the_last_one_carries_on() -> None:
    mirror = Mirror()
    mirror.show(0.02, row(0.0, 0.0, v=10.0)[None])
    assert mirror.show(0.07, np.zeros((0, 12)))[-1, 1] == pytest.approx(0.7)


def test_a_real_return_hides_the_virtual_one_of_its_bearing_only() -> None:
    real = np.array([[30.0, 0.1, 0.0]])
    virtual = np.array([[10.0, 0.03, 0.0], [0.0, 10.0, 0.0]])
    assert merged_points(real, virtual).tolist() == [[30.0, 0.1, 0.0], [0.0, 10.0, 0.0]]


def test_a_real_image_box_stands_for_the_virtual_one_on_it() -> None:
    real = CameraBox(100.0, 100.0, 200.0, 200.0, "pedestrian", 0.9)
    same = CameraBox(102.0, 98.0, 201.0, 203.0, "vehicle", 0.9)
    other = CameraBox(400.0, 100.0, 500.0, 200.0, "vehicle", 0.9)
    assert merged_boxes((real,), (same, other)) == (real, other)
