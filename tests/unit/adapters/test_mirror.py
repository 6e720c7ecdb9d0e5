"""The mirror shows a car where it is now from a measurement 20 ms old; all that is real is seen."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle.adapters.mirror import Mirror, Parallel, extrapolated, merged_boxes, merged_points
from vehicle.messages import (
    CameraBox,
    Command,
    FloatArray,
    LidarScan,
    Observation,
    Surroundings,
    VehicleDescription,
    VehicleState,
)


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


def ring(radius: float, height: float) -> FloatArray:
    """Returns all around, 0.2 degrees apart."""
    angle = np.radians(np.arange(-180.0, 180.0, 0.2))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), height)])


def kept(real: FloatArray, virtual: FloatArray) -> list[list[float]]:
    merged = merged_points(real, virtual)
    assert merged[: len(real)].tolist() == real.tolist()
    rest: list[list[float]] = merged[len(real) :].tolist()
    return rest


def test_a_real_return_hides_what_is_behind_it_in_its_bearing() -> None:
    """Both 1 m below the LiDAR; what is nearer, or 90 degrees to the side, is seen."""
    real = np.array([[20.0, 0.1, -0.5]])
    near, beside, behind = [10.0, 0.05, -1.0], [0.0, 30.0, -1.0], [30.0, 0.15, -1.0]
    assert kept(real, np.array([near, beside, behind])) == [near, beside]


def test_what_is_higher_than_the_real_thing_before_it_is_seen_over_it() -> None:
    """A car's roof 0.2 m above a LiDAR, 10 m away: at 30 m it hides what is below 0.6 m."""
    car = ring(10.0, 0.2)
    low, high = [30.0, 0.0, 0.59], [30.0, 0.0, 0.61]
    assert kept(car, np.array([low, high])) == [high]


def test_the_ground_hides_nothing_that_stands_on_it() -> None:
    """A LiDAR at 1.5 m; rings of the ground before, below and behind a car whose rear is 16 m away."""
    ground = np.concatenate([ring(radius, -1.5) for radius in (5.0, 10.0, 15.9, 21.0, 40.0)])
    across = np.linspace(-0.9, 0.9, 40)
    rear = np.concatenate([np.column_stack([np.full(40, 16.0), across, np.full(40, z)]) for z in (-1.4, -0.5, 0.0)])
    assert len(kept(ground, rear)) == len(rear)


def test_the_highest_of_all_real_returns_before_it_counts() -> None:
    """A wall at 8 m, with a kerb before and a low thing behind it, in one bearing; and the bearings next to it."""
    real = np.array([[5.0, 0.02, -1.4], [8.0, 0.03, 2.0], [12.0, 0.05, -1.0]])
    assert kept(real, np.array([[20.0, 0.08, 0.0], [7.9, 0.03, 0.0], [20.0, 0.5, 0.0], [20.0, -0.5, 0.0]])) == [
        [7.9, 0.03, 0.0], [20.0, 0.5, 0.0], [20.0, -0.5, 0.0],
    ]  # fmt: skip


def test_returns_that_a_scanner_fills_up_with_zeros_hide_nothing() -> None:
    assert kept(np.zeros((5, 3)), np.array([[10.0, 0.05, -1.0]])) == [[10.0, 0.05, -1.0]]


class Standing:
    """A car that stands at the origin and sees nothing."""

    description = VehicleDescription(3.0, 1.5, 1.4, 2.0, 1.0, 0.35, 10.0, 3.0, 7.0, 700.0, lidar_x=1.2)
    is_real = False

    def reset(self, state: VehicleState) -> None:
        pass

    def observe(self, surroundings: Surroundings) -> Observation:
        return Observation(0.0, lidar=LidarScan(0.0, np.zeros((0, 3))))

    def apply(self, command: Command) -> None:
        pass

    def step(self, dt: float) -> FloatArray:
        return np.zeros((0, 12))

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


@pytest.mark.parametrize(("visual_range", "seen"), [(math.inf, True), (5.0, False)])
def test_the_virtual_lidar_sees_no_farther_than_the_fog_lets_it(visual_range: float, seen: bool) -> None:
    """A car's rear 18 m away. Of what 5 m of visual range leave, a LiDAR of 80 m reach sees 4.7 m:
    R exp(R ln(20) / 5) = 80."""
    car = Parallel(Standing())
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    box = np.array([[20.0, 0.0, 0.75, 0.0, 4.0, 1.8, 1.5, 0.0, 0.0]])
    around = Surroundings(box, np.zeros(1, dtype=np.int64), ("a",), extinction=math.log(20.0) / visual_range)
    scan = car.observe(around).lidar
    assert scan is not None
    assert (len(scan.points) > 0) == seen


def test_a_real_image_box_stands_for_the_virtual_one_on_it() -> None:
    real = CameraBox(100.0, 100.0, 200.0, 200.0, "pedestrian", 0.9)
    same = CameraBox(102.0, 98.0, 201.0, 203.0, "vehicle", 0.9)
    other = CameraBox(400.0, 100.0, 500.0, 200.0, "vehicle", 0.9)
    assert merged_boxes((real,), (same, other)) == (real, other)
