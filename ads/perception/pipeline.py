"""Perception: from LiDAR scans and camera frames to tracked objects in the map."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from ads.localization import Estimate
from ads.parameters import Parameters
from ads.perception.camera import SEEN, camera_objects
from ads.perception.fusion import fuse
from ads.perception.lidar import BOX, lidar_boxes
from ads.perception.track import (
    AP,
    CP,
    HITS,
    ID,
    SCORE,
    TL,
    TRACK,
    TW,
    TX,
    TY,
    TYAW,
    UNSEEN,
    VX,
    VY,
    axis_unknown,
    sight,
    track_kind,
    turn_track,
    unknown_middle,
)
from ads.perception.tracking import CONFIRM, MOST_TRACKS, predict_tracks, update_tracks
from ads.transforms import Pose
from vehicle.messages import (
    OBJECT_KINDS,
    CameraFrame,
    Detection,
    FloatArray,
    LidarScan,
    Observation,
    VehicleDescription,
)

CAMERA_MEMORY = 0.15  # s; a camera frame older than this is not paired with a scan
LOST = 1.5  # s unseen until an object is not reported any more; its score falls to 0 on the way
LIDAR_SILENCE = 0.25  # s without a scan until camera frames are tracked on their own


class Perception(Protocol):
    """Turns observations into detections in the map frame, moved to the time of the tick."""

    def update(self, observation: Observation, estimate: Estimate) -> tuple[Detection, ...]:
        """Objects known at `observation.t`."""


class LidarDetector(Protocol):
    """Finds objects in one scan; whoever has a better one gives it to TrackingPerception."""

    def boxes(self, scan: LidarScan) -> FloatArray:
        """Boxes (k, BOX) in the base frame, in SI units."""


class ClusterDetector:
    """The reference: crop, ground removal, clusters, L-shapes (ads.perception.lidar)."""

    def __init__(self, parameters: Parameters, car: VehicleDescription) -> None:
        self._parameters, self._car = parameters, car

    def boxes(self, scan: LidarScan) -> FloatArray:
        """Boxes (k, BOX) in the base frame, in SI units, of the clusters of a scan."""
        p, car = self._parameters, self._car
        points = scan.points
        if car.lidar_yaw != 0.0:  # into a frame at the sensor that looks ahead
            points = points.copy()
            points[:, :2] = Pose(0.0, 0.0, car.lidar_yaw).apply(points[:, :2])
        found: FloatArray = lidar_boxes(points, car.lidar_x, car.lidar_z, p.LIDAR_x_max, p.LIDAR_abs_y_max)
        found[:, 1] += car.lidar_y
        return found


class TrackingPerception:
    """LiDAR clusters and camera boxes, late fusion, tracking.

    `heading_hint(x, y)` gives the direction of traffic [rad] at a place, None off the road: a face does not show which
    way a car points. Without it, objects are taken to point as the car does. `detector` finds the boxes in a scan.
    """

    def __init__(
        self,
        parameters: Parameters,
        car: VehicleDescription,
        heading_hint: Callable[[float, float], float | None] | None = None,
        detector: LidarDetector | None = None,
    ) -> None:
        self._detector: LidarDetector = detector or ClusterDetector(parameters, car)
        self._hint = heading_hint
        self._parameters = parameters
        self._car = car
        self._tracks = np.zeros((MOST_TRACKS, TRACK))
        self._n = 0
        self._next_id = 1
        self._t = -math.inf  # time that the tracks are at
        self._lidar = Pose(car.lidar_x, car.lidar_y, 0.0)
        self._sensor = (0.0, 0.0, 0.0)
        self._last_scan = -math.inf
        self._seen = np.zeros((0, SEEN))
        self._seen_t = -math.inf
        self._seen_pose = (0.0, 0.0, 0.0)
        self._no_boxes = np.zeros((0, BOX))
        self._nothing = np.zeros((0, SEEN))

    def update(self, observation: Observation, estimate: Estimate) -> tuple[Detection, ...]:
        """See Perception."""
        if observation.camera is not None:
            self._take_camera(observation.camera, estimate)
        if observation.lidar is not None:
            self._take_scan(observation.lidar, estimate)
        elif observation.camera is not None and observation.t - self._last_scan > LIDAR_SILENCE:
            self._fuse(self._no_boxes, self._seen_pose, self._seen_t)
        return self._detections(observation.t)

    def _take_camera(self, frame: CameraFrame, estimate: Estimate) -> None:
        self._seen = camera_objects(frame, self._car)
        self._seen_t = frame.t
        self._seen_pose = estimate.pose_at(frame.t)

    def _take_scan(self, scan: LidarScan, estimate: Estimate) -> None:
        boxes = self._detector.boxes(scan)
        self._last_scan = scan.t
        self._fuse(boxes, estimate.pose_at(scan.t), scan.t)

    def _fuse(self, boxes: FloatArray, pose: tuple[float, float, float], t: float) -> None:
        seen = self._seen if abs(t - self._seen_t) <= CAMERA_MEMORY else self._nothing
        rows = fuse(boxes, pose, seen, self._seen_pose, self._parameters.FUSION_min_dist)
        self._seen, self._seen_t = self._nothing, -math.inf  # a frame counts once
        if t > self._t:
            if self._n:
                self._n = predict_tracks(self._tracks, self._n, t - self._t)
            self._t = t
        at = Pose(*pose).then(self._lidar)
        self._sensor = sensor = (at.x, at.y, pose[2])
        if len(rows) or self._n:
            self._n, self._next_id = update_tracks(self._tracks, self._n, rows, sensor, self._next_id)
            if self._hint is not None:
                self._turn_tracks(self._hint, sensor[0], sensor[1])

    def _turn_tracks(self, hint: Callable[[float, float], float | None], sensor_x: float, sensor_y: float) -> None:
        for i in range(self._n):
            track = self._tracks[i]
            if axis_unknown(track):
                heading = hint(float(track[TX]), float(track[TY]))
                if heading is not None:
                    turn_track(track, heading, sensor_x, sensor_y)

    def _detections(self, t: float) -> tuple[Detection, ...]:
        found = []
        dt = t - self._t if self._n else 0.0
        for i in range(self._n):
            track = self._tracks[i]
            row = track.tolist()
            if row[HITS] < CONFIRM or row[UNSEEN] + dt > LOST:
                continue
            found.append(
                Detection(
                    t,
                    OBJECT_KINDS[track_kind(track)],
                    row[TX] + row[VX] * dt,
                    row[TY] + row[VY] * dt,
                    row[TYAW],
                    row[TL],
                    row[TW],
                    row[VX],
                    row[VY],
                    row[SCORE] * max(1.0 - (row[UNSEEN] + dt) / LOST, 0.0),
                    max(row[AP], row[CP]),
                    int(row[ID]),
                    self._covariance(row, unknown_middle(track)),
                )
            )
        return tuple(found)

    def _covariance(self, row: list[float], unsure: float) -> tuple[float, float, float]:
        """Covariance xx, xy, yy [m^2] of a track's middle from its variances along and across the line of sight.

        unsure: variance [m^2] along the object itself, of a vehicle whose length was not seen.
        """
        c, s = sight(row[TX] - self._sensor[0], row[TY] - self._sensor[1])
        along, across = row[AP], row[CP]
        ux, uy = math.cos(row[TYAW]), math.sin(row[TYAW])
        return (
            c * c * along + s * s * across + ux * ux * unsure,
            c * s * (along - across) + ux * uy * unsure,
            s * s * along + c * c * across + uy * uy * unsure,
        )
