"""LiDAR and camera of the surrogate: they look at the boxes it is sent. Code of its own, not the twin's.

LiDAR: 720 x 3 rays about the car, 0.5 to 80 m, range noise 0.02 m. Camera: pinhole, 1280 x 720, focal length 800 px,
a detector that finds what is nearer than 80 m and at least half unhidden, edges with 2 px of noise.
"""

from __future__ import annotations

import numpy as np

from vehicle.messages import OBJECT_KINDS, CameraBox, FloatArray, Surroundings, VehicleDescription

REACH, NEAREST = 80.0, 0.5  # m
RANGE_SIGMA, EDGE_SIGMA = 0.02, 2.0  # m, px
AZIMUTHS = np.linspace(-np.pi, np.pi, 720, endpoint=False)
ELEVATIONS = np.radians([-0.6, -1.8, -4.0])
SMALLEST = 6.0  # px, height of a box that the detector still finds
HALF = 0.5  # share hidden from which on a box is not found


class Scanner:
    """LiDAR and camera with one generator of noise; `car` says where they are mounted."""

    def __init__(self, car: VehicleDescription, seed: int) -> None:
        self._car = car
        self._rng = np.random.default_rng([seed, 815])
        flat = np.stack(np.meshgrid(AZIMUTHS, ELEVATIONS, indexing="ij"), axis=-1).reshape(-1, 2)
        up = np.sin(flat[:, 1])
        level = np.cos(flat[:, 1])
        self._rays = np.column_stack((level * np.cos(flat[:, 0]), level * np.sin(flat[:, 0]), up))

    def points(self, x: float, y: float, yaw: float, around: Surroundings) -> FloatArray:
        """Returns (n, 3) [m] in the frame of the LiDAR, of a car whose rear axle stands at x, y with `yaw`."""
        car, rays = self._car, self._rays
        reach = np.full(len(rays), np.inf)
        for box in around.boxes:
            place = _turned(box[:3] - (x, y, 0.0), -yaw) - (car.lidar_x, 0.0, car.lidar_z)
            if np.hypot(place[0], place[1]) > REACH + 0.5 * box[4]:
                continue
            turn = box[3] - yaw
            origin, way = _turned(-place, -turn), _turned(rays, -turn)
            with np.errstate(divide="ignore", invalid="ignore"):
                first = (-0.5 * box[4:7] - origin) / way
                second = (0.5 * box[4:7] - origin) / way
            near = np.nanmax(np.minimum(first, second), axis=1)
            far = np.nanmin(np.maximum(first, second), axis=1)
            hit = (near <= far) & (near > 0.0)
            reach[hit] = np.minimum(reach[hit], near[hit])
        seen = (reach >= NEAREST) & (reach <= REACH)
        distance = reach[seen] + RANGE_SIGMA * self._rng.standard_normal(int(seen.sum()))
        found: FloatArray = rays[seen] * distance[:, None]
        return found

    def boxes(self, x: float, y: float, yaw: float, around: Surroundings) -> tuple[CameraBox, ...]:
        """What the detector finds in the camera's image, nearest first."""
        car = self._car
        shown: list[tuple[float, FloatArray, int]] = []
        for box, kind in zip(around.boxes, around.kinds.tolist(), strict=True):
            corners = np.array([(a, b, c) for a in (-0.5, 0.5) for b in (-0.5, 0.5) for c in (-0.5, 0.5)]) * box[4:7]
            place = _turned(_turned(corners, box[3]) + box[:3] - (x, y, 0.0), -yaw) - (car.camera_x, 0.0, car.camera_z)
            if place[:, 0].min() < 0.5 or np.hypot(*place[:, :2].mean(axis=0)) > REACH:
                continue
            u = 0.5 * car.camera_width - car.camera_focal * place[:, 1] / place[:, 0]
            v = 0.5 * car.camera_height - car.camera_focal * place[:, 2] / place[:, 0]
            area = np.array([u.min(), v.min(), u.max(), v.max()])
            shown.append((float(place[:, 0].min()), area, kind))
        shown.sort(key=lambda one: one[0])
        found: list[CameraBox] = []
        for rank, (_, area, kind) in enumerate(shown):
            hidden = _hidden(area, [other for _, other, _ in shown[:rank]], car)
            if hidden > HALF or area[3] - area[1] < SMALLEST:
                continue
            size = np.array([car.camera_width, car.camera_height] * 2)
            u1, v1, u2, v2 = np.clip(area + EDGE_SIGMA * self._rng.standard_normal(4), 0.0, size).tolist()
            if u2 - u1 > 1.0 and v2 - v1 > 1.0:
                found.append(CameraBox(u1, v1, u2, v2, OBJECT_KINDS[kind], 0.95 - 0.5 * hidden))
        return tuple(found)


def _turned(points: FloatArray, angle: float) -> FloatArray:
    """Points (..., 3) turned about z by `angle` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    turned: FloatArray = np.stack((c * x - s * y, s * x + c * y, z), axis=-1)
    return turned


def _hidden(area: FloatArray, nearer: list[FloatArray], car: VehicleDescription) -> float:
    """Share of an image rectangle that is outside the image or behind nearer ones, on a grid of 12 x 8 points."""
    u = area[0] + (np.arange(12) + 0.5) / 12.0 * (area[2] - area[0])
    v = area[1] + (np.arange(8) + 0.5) / 8.0 * (area[3] - area[1])
    grid_u, grid_v = np.meshgrid(u, v)
    gone = (grid_u < 0.0) | (grid_u > car.camera_width) | (grid_v < 0.0) | (grid_v > car.camera_height)
    for other in nearer:
        gone |= (grid_u >= other[0]) & (grid_u <= other[2]) & (grid_v >= other[1]) & (grid_v <= other[3])
    return float(gone.mean())
