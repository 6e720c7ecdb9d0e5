"""Perception: each step against geometry of the test's own."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from ads_loop import TABBY
from scipy.optimize import linear_sum_assignment

from ads.localization import Estimate
from ads.parameters import Parameters
from ads.perception.assignment import assign
from ads.perception.camera import SEEN, camera_objects
from ads.perception.fusion import BOTH, CAMERA, LIDAR, VEHICLE, fuse
from ads.perception.lidar import ground_plane, lidar_boxes
from ads.perception.pipeline import ClusterDetector, TrackingPerception
from ads.perception.track import AA, CC, TRACK, TYAW, VX, begin, correct_track
from ads.transforms import Pose, sensor_frames
from vehicle.messages import CameraBox, CameraFrame, LidarScan, Observation
from vehicle.sensors import Mount, default_sensors

FOCAL, HEIGHT = TABBY.camera_focal, TABBY.camera_z


def faces(x: float, y: float, yaw: float, length: float, width: float, pitch: float = math.radians(0.5)) -> np.ndarray:
    """Points that a scanner at the origin sees of a box: nearest hit of each ray, at three heights above ground."""
    c, s = math.cos(yaw), math.sin(yaw)
    points = []
    for k in range(round(2 * math.pi / pitch)):
        a = k * pitch - math.pi
        d = np.array([math.cos(a), math.sin(a)])
        o = np.array([-(c * x + s * y), s * x - c * y])
        r = np.array([c * d[0] + s * d[1], -s * d[0] + c * d[1]])
        near, far = 0.0, math.inf
        for i, half in enumerate((length / 2, width / 2)):
            if abs(r[i]) < 1e-12:
                if abs(o[i]) > half:
                    near = math.inf
                continue
            t = sorted(((-half - o[i]) / r[i], (half - o[i]) / r[i]))
            near, far = max(near, t[0]), min(far, t[1])
        if near <= far and near < math.inf:
            points += [(near * d[0], near * d[1], z) for z in (0.5, 0.8, 1.1)]
    return np.array(points)


def scan(*objects: tuple[float, float, float, float, float]) -> np.ndarray:
    """Points in the sensor frame of TABBY's LiDAR of boxes given relative to the sensor."""
    points = np.vstack([faces(*o) for o in objects])
    points[:, 2] -= TABBY.lidar_z
    return points


def boxes_of(points: np.ndarray, x_max: float = 50.0, y_max: float = 20.0) -> np.ndarray:
    return lidar_boxes(points, TABBY.lidar_x, TABBY.lidar_z, x_max, y_max)


class TestLidar:
    @pytest.mark.parametrize("yaw_deg", [0, 40, 75, 130])
    def test_the_l_shape_has_the_angle_and_size_of_the_car(self, yaw_deg):
        yaw = math.radians(yaw_deg)
        (box,) = boxes_of(scan((12.0, 5.0, yaw, 4.4, 1.8)))
        assert math.sin(2 * (box[2] - yaw)) == pytest.approx(0.0, abs=math.sin(math.radians(6)))
        assert sorted(box[3:5]) == pytest.approx([1.8, 4.4], abs=0.6)  # rays hit the ends by chance
        assert box[0:2] == pytest.approx([12.0 + TABBY.lidar_x, 5.0], abs=0.3)

    def test_two_cars_side_by_side_are_two(self):
        assert len(boxes_of(scan((15.0, 2.5, 0.0, 4.4, 1.8), (15.0, -2.5, 0.0, 4.4, 1.8)))) == 2

    def test_what_lies_outside_the_crop_is_not_there(self):
        points = scan((20.0, 0.0, 0.0, 4.4, 1.8), (10.0, 8.0, 0.0, 0.5, 0.5))
        assert len(boxes_of(points)) == 2
        assert len(boxes_of(points, x_max=15.0)) == 1
        assert len(boxes_of(points, y_max=5.0)) == 1

    def test_ground_is_removed_also_on_a_slope(self):
        rng = np.random.default_rng(0)
        xy = rng.uniform((-20, -8), (20, 8), (600, 2))
        ground = np.column_stack((xy, 0.04 * xy[:, 0] + 0.01 * rng.standard_normal(600) - TABBY.lidar_z))
        car = scan((12.0, 0.0, 0.3, 4.4, 1.8))
        car[:, 2] += 0.04 * car[:, 0]
        boxes = boxes_of(np.vstack((ground, car)))
        assert len(boxes) == 1

    def test_the_plane_is_the_least_squares_one(self):
        rng = np.random.default_rng(1)
        xy = rng.uniform((-20, -8), (20, 8), (300, 2))
        z = 0.05 + 0.01 * xy[:, 0] - 0.005 * xy[:, 1] + 0.01 * rng.standard_normal(300)
        expected, *_ = np.linalg.lstsq(np.column_stack((np.ones(300), xy)), z, rcond=None)
        assert ground_plane(np.column_stack((xy, z))) == pytest.approx(tuple(expected), abs=1e-9)

    def test_an_empty_scan_shows_nothing(self):
        assert len(boxes_of(np.zeros((0, 3)))) == 0


def image_box(x: float, y: float, width: float, height: float, kind: str = "vehicle") -> CameraBox:
    """Pinhole image of a flat board standing on the ground, relative to the camera."""
    u, v = 640.0 - FOCAL * y / x, 360.0 + FOCAL * HEIGHT / x
    half = 0.5 * FOCAL * width / x
    return CameraBox(u - half, v - FOCAL * height / x, u + half, v, kind, 0.9)  # type: ignore[arg-type]


class TestCamera:
    @pytest.mark.parametrize(("x", "y"), [(8.0, 1.0), (25.0, -3.0), (60.0, 10.0)])
    def test_projects_back_to_where_the_board_stands(self, x, y):
        (row,) = camera_objects(CameraFrame(0.0, (image_box(x, y, 1.8, 1.5),)), TABBY)
        assert row[:3] == pytest.approx([x + TABBY.camera_x, y, 1.8])

    def test_range_is_the_less_certain_the_farther(self):
        near, far = camera_objects(CameraFrame(0.0, (image_box(10, 0, 1, 1), image_box(40, 0, 1, 1))), TABBY)
        assert far[5] / near[5] == pytest.approx(16.0)

    def test_what_stands_above_the_horizon_is_left_out(self):
        assert len(camera_objects(CameraFrame(0.0, (CameraBox(600, 100, 700, 350, "misc", 0.9),)), TABBY)) == 0

    def test_a_box_cut_off_below_is_near(self):
        (row,) = camera_objects(CameraFrame(0.0, (CameraBox(300, 100, 900, 720, "vehicle", 0.9),)), TABBY)
        assert row[0] - TABBY.camera_x < FOCAL * HEIGHT / 360.0

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_a_car_that_leaves_the_image_sideways_does_not_drift_into_the_lane(self, side):
        """Cut off at a side, less and less of it is in sight; its middle is taken from the edge in sight."""
        for x in (8.0, 7.0, 6.5):
            whole = image_box(x, side * 6.0, 2.8, 1.5)
            cut = CameraBox(max(whole.u_min, 0.0), whole.v_min, min(whole.u_max, 1280.0), whole.v_max, "vehicle", 0.9)
            assert cut != whole
            (row,) = camera_objects(CameraFrame(0.0, (cut,)), TABBY)
            assert row[1] == pytest.approx(side * 6.0, abs=0.05)
            assert row[6] > 1.0


class TestMounting:
    """A sensor beside the middle that looks askew sees the same world."""

    CAR = msgspec.structs.replace(TABBY, lidar_y=0.4, lidar_yaw=0.5, camera_y=-0.3, camera_yaw=0.6)

    def test_lidar(self):
        car = self.CAR
        at = Pose(car.lidar_x, car.lidar_y, car.lidar_yaw).inverse()
        x, y, yaw = at.then(Pose(14.0, 2.0, 0.7))
        (box,) = ClusterDetector(Parameters(), car).boxes(LidarScan(0.0, scan((x, y, yaw, 4.4, 1.8))))
        assert box[:2] == pytest.approx([14.0, 2.0], abs=0.3)
        assert math.sin(2 * (box[2] - 0.7)) == pytest.approx(0.0, abs=math.sin(math.radians(6)))

    def test_camera(self):
        car = self.CAR
        at = Pose(car.camera_x, car.camera_y, car.camera_yaw).inverse()
        x, y, _ = at.then(Pose(20.0, 9.0, 0.0))
        (row,) = camera_objects(CameraFrame(0.0, (image_box(x, y, 1.8, 1.5),)), car)
        assert row[:2] == pytest.approx([20.0, 9.0])

    def test_the_car_tells_its_stack_where_its_sensors_sit(self):
        suite = default_sensors()
        suite = replace(
            suite,
            lidar=replace(suite.lidar, mount=Mount(1.0, 0.4, 1.6, 0.5)),
            camera=replace(suite.camera, mount=Mount(0.9, -0.3, 1.3, 0.6)),
            gnss=replace(suite.gnss, mount=Mount(0.2, 0.5, 1.5)),
        )
        frames = sensor_frames(suite.describe(TABBY))
        assert frames["lidar"] == Pose(1.0, 0.4, 0.5)
        assert frames["camera"] == Pose(0.9, -0.3, 0.6)
        assert frames["gnss"] == Pose(0.2, 0.5, 0.0)


class TestAssignment:
    @pytest.mark.parametrize("shape", [(1, 1), (3, 5), (5, 3), (6, 6), (0, 3), (3, 0)])
    def test_costs_as_little_as_scipys(self, shape):
        rng = np.random.default_rng(sum(shape))
        for _ in range(20):
            cost = rng.uniform(0, 10, shape)
            pairs = assign(cost)
            rows, columns = linear_sum_assignment(cost)
            mine = [(i, j) for i, j in enumerate(pairs) if j >= 0]
            assert len(mine) == len(rows)
            assert sum(cost[p] for p in mine) == pytest.approx(cost[rows, columns].sum())

    def test_forbidden_pairs_are_never_made(self):
        cost = np.array([[1e6, 2.0], [1e6, 1.0]])
        assert assign(cost).tolist() == [-1, 1]


class TestFusion:
    BOX = np.array([[20.0, 0.0, 0.0, 0.1, 1.8, -1.0, 0.9]])

    def fuse(self, seen, boxes=BOX, min_dist=4.5):
        pose = (100.0, 50.0, math.pi / 2)
        rows = np.array([(*row, 0.0) for row in seen]).reshape(-1, SEEN)
        return fuse(boxes, pose, rows, pose, min_dist)

    def test_a_pair_takes_place_from_the_lidar_and_kind_from_the_camera(self):
        (row,) = self.fuse([(18.5, 0.2, 1.8, 1.0, 0.8, 0.4)])
        assert row[0:2] == pytest.approx([100.0, 70.0])
        assert (row[5], row[8]) == (1.0, BOTH)

    def test_what_only_one_sensor_sees_stays(self):
        rows = self.fuse([(60.0, 5.0, 1.8, 0.0, 0.8, 3.0)])
        assert sorted(rows[:, 8]) == [LIDAR, CAMERA]

    def test_farther_than_fusion_min_dist_is_not_one(self):
        seen = [(14.5, 0.0, 1.8, 0.0, 0.8, 0.1)]
        assert len(self.fuse(seen, min_dist=4.5)) == 1
        assert len(self.fuse(seen, min_dist=2.5)) == 2

    def test_a_pedestrian_beside_a_car_is_not_the_car(self):
        assert len(self.fuse([(20.0, 3.0, 0.5, 1.0, 0.8, 0.1)])) == 2

    def test_a_far_camera_object_is_sure_across_and_unsure_along(self):
        (row,) = self.fuse([(60.0, 5.0, 1.8, 0.0, 0.8, 3.0)], boxes=np.zeros((0, 7)))
        assert row[7] > 5.0 > 0.1 > row[9]


class Run:
    """Feeds a perception at 20 Hz with scans at 10 Hz of moving boxes; the car stands at the origin."""

    def __init__(self, **more):
        self.perception = TrackingPerception(Parameters(), TABBY, **more)
        self.t = 0.0

    def tick(self, *objects, camera=()):
        k = round(self.t / 0.05)
        seen = [(x - TABBY.lidar_x, *rest) for x, *rest in objects]
        points = scan(*seen) if seen else np.zeros((0, 3))
        boxes = tuple(image_box(x - TABBY.camera_x, y, w, 1.5, kind) for x, y, w, kind in camera)
        observation = Observation(
            self.t,
            lidar=LidarScan(self.t, points) if k % 2 == 0 else None,
            camera=CameraFrame(self.t, boxes) if k % 2 == 0 else None,
        )
        found = self.perception.update(observation, Estimate(self.t, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.01))
        self.t += 0.05
        return found


class TestTracking:
    def test_a_walking_pedestrian_has_its_velocity(self):
        run, found = Run(), ()
        for k in range(40):
            y = -4.0 + 2.0 * 0.05 * k
            found = run.tick((12.0, y, 0.0, 0.5, 0.5), camera=[(11.75, y, 0.5, "pedestrian")])
        (d,) = found
        assert d.kind == "pedestrian"
        assert (d.vx, d.vy) == pytest.approx((0.0, 2.0), abs=0.25)
        assert (d.x, d.y) == pytest.approx((12.0, y), abs=0.3)

    def test_a_car_seen_from_behind_is_where_its_middle_is(self):
        run, found = Run(), ()
        for _ in range(10):
            found = run.tick((20.0, 0.0, 0.0, 4.0, 1.8), camera=[(18.0, 0.0, 1.8, "vehicle")])
        (d,) = found
        assert (d.x, d.y) == pytest.approx((20.0, 0.0), abs=0.3)
        assert (d.length, d.width) == pytest.approx((4.0, 1.8), abs=0.2)

    def test_the_covariance_lies_along_the_line_of_sight_of_a_camera(self):
        """Far away a camera is sure of the side and unsure of the distance: here along the diagonal."""
        perception, found = TrackingPerception(Parameters(), TABBY), ()
        estimate = Estimate(0.0, 0.0, 0.0, math.pi / 4, 0.0, 0.0, 0.0, 0.1, 0.01)
        for k in range(10):
            frame = CameraFrame(0.1 * k, (image_box(45.0, 0.0, 1.8, 1.5),))
            found = perception.update(Observation(0.1 * k, camera=frame), estimate._replace(t=0.1 * k))
        (d,) = found
        values, axes = np.linalg.eigh(np.array([d.covariance[:2], d.covariance[1:]]))
        assert abs(axes[:, 1] @ (math.sqrt(0.5), math.sqrt(0.5))) == pytest.approx(1.0, abs=0.01)
        assert values[1] > 5.0 * values[0] > 0.0
        assert values[1] == pytest.approx(d.position_variance + 0.25**2)  # and half of a length of 0.5 m, sigma

    def test_a_car_of_which_only_the_rear_was_seen_is_as_far_off_as_it_states(self):
        """Lengths from 3.5 to 5.1 m: the rear tells none of them, so the middle is off by half of the difference."""
        off = []
        for length in (3.5, 3.9, 4.3, 4.7, 5.1):
            run, found = Run(), ()
            for _ in range(40):
                rear = 20.0 - 0.5 * length
                found = run.tick((20.0, 0.0, 0.0, length, 1.8), camera=[(rear, 0.0, 1.8, "vehicle")])
            (d,) = found
            e = np.array([d.x - 20.0, d.y])
            off.append(float(e @ np.linalg.solve(np.array([d.covariance[:2], d.covariance[1:]]), e)))
        assert max(off) < 6.0  # chi-square of two, 95 %
        assert 0.3 < np.mean(off) < 2.0  # 11 before half of the unknown length was stated

    def test_the_map_says_which_way_a_face_points(self):
        run, found = Run(heading_hint=lambda x, y: math.pi / 2), ()
        for _ in range(10):
            found = run.tick((20.0, 0.0, math.pi / 2, 1.8, 1.8), camera=[(19.1, 0.0, 1.8, "vehicle")])
        assert math.cos(found[0].yaw - math.pi / 2) == pytest.approx(1.0, abs=0.02)

    def test_a_track_keeps_its_number_through_half_a_second_of_occlusion(self):
        run, found, number = Run(), (), None
        for k in range(60):
            hidden = 30 <= k < 40
            x = 14.0 + 3.0 * 0.05 * k
            found = run.tick(*(() if hidden else ((x, 2.0, 0.0, 4.0, 1.8),)))
            if k >= 20:
                number = number or found[0].track
                assert [d.track for d in found] == [number]
        assert found[0].vx == pytest.approx(3.0, abs=0.5)

    def test_what_is_gone_for_2_s_is_forgotten(self):
        run = Run()
        for _ in range(20):
            run.tick((14.0, 0.0, 0.0, 4.0, 1.8))
        for _ in range(40):
            found = run.tick()
        assert found == ()

    def test_one_glance_is_not_believed(self):
        run = Run()
        assert run.tick((14.0, 0.0, 0.0, 4.0, 1.8)) == ()

    def test_a_passing_car_stays_one_object(self):
        run, numbers = Run(), set()
        for k in range(100):
            x = 28.0 - 5.0 * 0.05 * k
            found = run.tick((x, 3.5, math.pi, 4.4, 1.8))
            assert len(found) <= 1
            numbers |= {d.track for d in found}
        assert len(numbers) == 1
        assert found[0].vx == pytest.approx(-5.0, abs=0.4)

    def test_a_bus_beside_the_camera_is_a_vehicle_of_its_length(self):
        run, found = Run(), ()
        for _ in range(10):
            found = run.tick((3.0, 3.5, 0.0, 12.0, 2.55))
        (d,) = found
        assert d.kind == "vehicle"
        assert d.length == pytest.approx(12.0, abs=0.5)
        assert (d.x, d.y) == pytest.approx((3.0, 3.5), abs=0.5)

    def test_a_fast_car_is_known_within_half_a_second(self):
        run, found = Run(), ()
        for k in range(10):
            found = run.tick((10.0 + 33.0 * 0.05 * k, 3.5, 0.0, 4.4, 1.8))
        (d,) = found
        assert d.vx == pytest.approx(33.0, abs=3.0)

    def test_without_sensors_there_is_nothing(self):
        perception = TrackingPerception(Parameters(), TABBY)
        assert perception.update(Observation(0.0), Estimate(0.0, 0, 0, 0, 0, 0, 0, 0.1, 0.01)) == ()


def test_a_track_turns_round_without_lying_across_the_road() -> None:
    """A camera's ranges may show a parked car moving towards the ego for a second. A body that points the other way is
    turned round at once: turned step by step it would stay across the road where the motion proves to be none."""
    row = np.array([30.0, 0.0, 0.0, 4.0, 1.75, VEHICLE, 0.9, 0.5, CAMERA, 0.06])
    track = np.zeros(TRACK)
    begin(track, row, (0.0, 0.0, 0.0), 1)
    track[[VX, AA, CC]] = -6.0, 0.5, 0.1
    yaws = []
    for _ in range(10):
        correct_track(track, row, 0.0, 0.0)
        yaws.append(track[TYAW])
    assert math.cos(yaws[0]) < -0.99  # it did take the motion for true
    assert np.abs(np.sin(yaws)).max() < 0.2


def test_a_return_without_a_height_does_not_hide_the_rest_of_the_scan() -> None:
    ring = np.array([(x, y, -TABBY.lidar_z) for x in np.arange(-8.0, 7.5, 0.5) for y in np.arange(-6.0, 6.5, 0.5)])
    points = np.vstack([scan((10.0, 0.0, 0.0, 4.0, 1.8)), ring])
    spoilt = points.copy()
    spoilt[-1, 2] = math.nan
    assert len(boxes_of(points)) == 1
    assert boxes_of(spoilt) == pytest.approx(boxes_of(points), abs=1e-6)
