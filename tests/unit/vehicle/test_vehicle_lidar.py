"""The LiDAR's points against geometry done by hand."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians, tan

import numpy as np
import pytest

from vehicle.messages import FloatArray
from vehicle.model.errors import ModelError
from vehicle.sensors import Lidar, Mount, Timing

QUIET = Lidar(Mount(z=1.0), Timing(10.0), azimuths=720, elevations=(0.0,), sigma=0.0)


def _box(
    x: float, y: float, *, yaw: float = 0.0, length: float = 4.0, width: float = 2.0, height: float = 1.6
) -> list[float]:
    return [x, y, height / 2, yaw, length, width, height, 0.0, 0.0]


def _scan(lidar: Lidar, boxes: list[list[float]], *, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> FloatArray:
    running = lidar.start(0.0, np.random.SeedSequence(1))
    running.measure(0.0, x, y, 0.0, yaw, np.array(boxes, dtype=np.float64).reshape(-1, 9))
    scan = running.arrived(lidar.timing.latency)
    assert scan is not None
    return scan.points


def test_points_lie_on_the_face_towards_the_sensor() -> None:
    points = _scan(QUIET, [_box(20.0, 0.0)])
    assert points[:, 0] == pytest.approx(18.0)
    assert np.abs(points[:, 1]).max() <= 1.0 + 1e-9
    assert points[:, 2] == pytest.approx(0.0)


def test_number_of_points_is_the_angle_over_the_resolution() -> None:
    points = _scan(QUIET, [_box(20.0, 0.0)])
    angle = 2.0 * np.arctan(1.0 / 18.0)
    assert len(points) == pytest.approx(angle / radians(0.5), abs=1.0)


def test_points_are_in_the_sensors_frame() -> None:
    moved = replace(QUIET, mount=Mount(x=1.5, y=-0.5, z=1.0, yaw=0.1))
    points = _scan(moved, [_box(5.0, 30.0)], x=5.0, y=2.0, yaw=pi / 2)
    c, s = np.cos(0.1), np.sin(0.1)  # back into the car's frame
    ahead = c * points[:, 0] - s * points[:, 1] + 1.5
    left = s * points[:, 0] + c * points[:, 1] - 0.5
    assert ahead == pytest.approx(27.0)
    assert np.abs(left).max() <= 2.0 + 1e-9


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.2, 2.5, -2.0])
@pytest.mark.parametrize("bearing", [0.0, 1.0, 2.0, 3.1, -3.1, -1.5])
def test_every_point_is_on_the_outline_of_a_turned_box(yaw: float, bearing: float) -> None:
    box = _box(15.0 * np.cos(bearing), 15.0 * np.sin(bearing), yaw=yaw)
    points = _scan(QUIET, [box])
    dx, dy = points[:, 0] - box[0], points[:, 1] - box[1]
    u, v = np.cos(yaw) * dx + np.sin(yaw) * dy, -np.sin(yaw) * dx + np.cos(yaw) * dy
    outside = np.maximum(np.abs(u) / 2.0, np.abs(v) / 1.0)
    assert outside == pytest.approx(1.0)
    assert len(points) >= 8


def _brute(box: list[float], count: int = 720) -> int:
    """Rays that meet the box, by testing each against its four sides."""
    corners = np.array([[2, 1], [-2, 1], [-2, -1], [2, -1]], dtype=float)
    c, s = np.cos(box[3]), np.sin(box[3])
    world = corners @ np.array([[c, s], [-s, c]]) + box[:2]
    hits = 0
    for angle in -pi + 2 * pi / count * np.arange(count):
        ray = np.array([np.cos(angle), np.sin(angle)])
        for a, b in zip(world, np.roll(world, -1, axis=0), strict=True):
            side = b - a
            det = ray[0] * side[1] - ray[1] * side[0]
            t = (a[0] * side[1] - a[1] * side[0]) / det
            share = (a[0] * ray[1] - a[1] * ray[0]) / det
            if t > 0 and 0 <= share <= 1:
                hits += 1
                break
    return hits


@pytest.mark.parametrize("place", [(6.0, 3.3), (-7.0, 0.05), (-3.0, -2.0), (0.3, 4.0)])
def test_no_ray_is_missed_beside_a_brute_force_search(place: tuple[float, float]) -> None:
    box = _box(*place, yaw=0.37)
    assert len(_scan(QUIET, [box])) == _brute(box)


def test_what_stands_behind_is_hidden() -> None:
    front, behind = _box(10.0, 0.0, width=3.0), _box(20.0, 0.0, width=2.0)
    points = _scan(QUIET, [behind, front])
    assert points[:, 0].max() < 12.0


def test_what_looks_out_behind_is_seen_only_there() -> None:
    front, behind = _box(10.0, 0.0), _box(20.0, 2.0, width=6.0)
    points = _scan(QUIET, [front, behind])
    far = points[points[:, 0] > 13.0]
    shadow = 1.0 / 8.0  # slope of the ray past the front box's nearer corner
    assert len(far) > 10
    assert (far[:, 1] / far[:, 0]).min() > shadow - 1e-9


def test_a_low_box_passes_under_a_level_ray() -> None:
    assert len(_scan(QUIET, [_box(10.0, 0.0, height=0.9)])) == 0


def test_a_downward_layer_meets_a_low_box_at_its_face() -> None:
    points = _scan(replace(QUIET, elevations=(radians(-3.0),)), [_box(10.0, 0.0, height=0.9)])
    front = points[np.abs(points[:, 1]) < 0.1]
    assert front[:, 0] == pytest.approx(8.0)
    assert front[:, 2] == pytest.approx(-8.0 * tan(radians(3.0)), rel=1e-3)


def test_ranges_end_where_the_sensor_says() -> None:
    assert len(_scan(replace(QUIET, reach=17.9), [_box(20.0, 0.0)])) == 0
    assert len(_scan(replace(QUIET, reach=18.1), [_box(20.0, 0.0)])) > 0
    assert len(_scan(replace(QUIET, nearest=19.0), [_box(20.0, 0.0)])) == 0


def test_field_of_view_ends_where_the_sensor_says() -> None:
    narrow = replace(QUIET, azimuths=91, field_of_view=radians(90.0))
    points = _scan(narrow, [_box(10.0 * np.cos(b), 10.0 * np.sin(b)) for b in np.arange(0.0, 2 * pi, 0.3)])
    bearing = np.arctan2(points[:, 1], points[:, 0])
    assert np.abs(bearing).max() <= radians(45.0) + 1e-9
    assert np.abs(bearing).max() >= radians(44.0)


def test_ground_returns_form_a_ring_at_the_height_over_the_tangent() -> None:
    points = _scan(replace(QUIET, elevations=(radians(-4.0),), ground=True), [])
    assert len(points) == 720
    assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(1.0 / tan(radians(4.0)))
    assert points[:, 2] == pytest.approx(-1.0)


def test_no_ground_and_no_boxes_give_an_empty_cloud() -> None:
    assert _scan(QUIET, []).shape == (0, 3)


def test_range_noise_has_its_standard_deviation() -> None:
    noisy = replace(QUIET, azimuths=20_000, sigma=0.05, nearest=0.0)
    quiet = _scan(replace(noisy, sigma=0.0), [_box(25.0, 0.0, width=40.0)])
    points = _scan(noisy, [_box(25.0, 0.0, width=40.0)])
    error = np.hypot(points[:, 0], points[:, 1]) - np.hypot(quiet[:, 0], quiet[:, 1])
    assert abs(error.mean()) < 4 * 0.05 / len(error) ** 0.5
    assert error.std() == pytest.approx(0.05, rel=0.05)


def test_latency_delivers_the_old_scan_with_its_own_time() -> None:
    running = replace(QUIET, timing=Timing(10.0, latency=0.1)).start(0.0, np.random.SeedSequence(1))
    boxes = np.array([_box(20.0, 0.0)])
    running.measure(0.0, 0.0, 0.0, 0.0, 0.0, boxes)
    assert running.arrived(0.05) is None
    scan = running.arrived(0.1)
    assert scan is not None
    assert scan.t == 0.0


def test_impossible_scanners_are_refused() -> None:
    with pytest.raises(ModelError, match="reach"):
        replace(QUIET, reach=0.1)
    with pytest.raises(ModelError, match="field_of_view"):
        replace(QUIET, field_of_view=7.0)
    for tilt in (0.5 * pi, float("nan")):
        with pytest.raises(ModelError, match="elevations"):
            replace(QUIET, elevations=(0.0, tilt))


@pytest.mark.parametrize("yaw", [pi / 2, 0.6, -0.6])
@pytest.mark.parametrize("length", [3.0, 12.0])
def test_an_open_field_is_filled_by_what_reaches_beyond_its_ends(length: float, yaw: float) -> None:
    """61 rays over 60 degrees meet a box 2 m ahead where a scanner all around with a ray each degree does."""
    box = _box(2.0, 0.2, yaw=yaw, length=length, width=1.5, height=3.0)
    around = _scan(replace(QUIET, azimuths=360), [box])
    ahead = np.abs(np.arctan2(around[:, 1], around[:, 0])) <= radians(30.0) + 1e-9
    points = _scan(replace(QUIET, azimuths=61, field_of_view=radians(60.0)), [box])
    assert points == pytest.approx(around[ahead], abs=1e-9)


@pytest.mark.parametrize(("degrees", "azimuths"), [(229.0, 2), (300.0, 3), (350.0, 10), (355.2, 36), (120.0, 600)])
def test_an_open_field_has_rays_from_end_to_end_that_all_see(degrees: float, azimuths: int) -> None:
    """Four walls around the sensor, which every ray meets."""
    walls = [_box(x, y, length=60.0 if y else 0.2, width=60.0 if x else 0.2) for x, y in _SIDES]
    points = _scan(replace(QUIET, azimuths=azimuths, field_of_view=radians(degrees)), walls)
    expected = np.linspace(-0.5 * degrees, 0.5 * degrees, azimuths)
    assert np.degrees(np.arctan2(points[:, 1], points[:, 0])) == pytest.approx(expected)


_SIDES = ((20.0, 0.0), (-20.0, 0.0), (0.0, 20.0), (0.0, -20.0))
