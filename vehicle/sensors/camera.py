"""Camera with an object detector: image boxes with class and score."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from vehicle.messages import OBJECT_KINDS, CameraBox, CameraFrame, FloatArray, Surroundings
from vehicle.model.errors import ModelError
from vehicle.sensors.air import camera_range
from vehicle.sensors.camera_view import view
from vehicle.sensors.common import Clock, Line, Mount, Noise, Timing, check_sigma
from vehicle.sensors.light import blinded, lit_range


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera along its mount's x axis, and the detector behind it.

    `focal`, `width`, `height` [px], principal point in the middle. The detector sees what is at least `least_visible`
    (share of the object) and `least_height` [px], up to `reach` [m]; it misses a share `misses` of them, calls a share
    `confusions` by a wrong class, and adds `false_boxes` per frame. Box edges carry noise `sigma` [px].
    Scores fall with the visible share and scatter by `score_sigma`. What reaches beside or behind the camera, as a long
    vehicle next to it does, is not found, but it hides what is behind it.
    """

    mount: Mount
    timing: Timing
    focal: float = 800.0
    width: int = 1280
    height: int = 720
    reach: float = 80.0
    least_visible: float = 0.3
    least_height: float = 10.0
    sigma: float = 1.5
    misses: float = 0.02
    confusions: float = 0.0
    false_boxes: float = 0.0
    score_sigma: float = 0.03

    def __post_init__(self) -> None:
        check_sigma("sigma", self.sigma)
        check_sigma("score_sigma", self.score_sigma)
        for name in ("misses", "confusions", "false_boxes", "least_visible"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ModelError("value not allowed", key=name, found=f"{value:g}", allowed="0 to 1")
        if not (self.focal > 0.0 and self.width > 0 and self.height > 0):
            raise ModelError("value not allowed", key="focal", found=f"{self.focal:g}", allowed="more than 0 px")
        if not self.reach > 0.0:
            raise ModelError("value not allowed", key="reach", found=f"{self.reach:g}", allowed="more than 0 m")

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningCamera:
        """The camera at work from `t` [s]."""
        return RunningCamera(self, t, seed)


class RunningCamera:
    """A camera at work."""

    def __init__(self, camera: Camera, t: float, seed: np.random.SeedSequence) -> None:
        self._camera, self._clock, self._noise = camera, Clock(camera.timing, t), Noise(seed)
        self._line: Line[CameraFrame] = Line(camera.timing)
        self._out: FloatArray = np.empty((16, 6))

    def measure(self, t: float, x: float, y: float, z: float, yaw: float, surroundings: Surroundings) -> None:
        """Take a frame from the reference point's pose if it is time [s, m, rad]."""
        if not self._clock.due(t):
            return
        camera, mount = self._camera, self._camera.mount
        boxes = surroundings.boxes
        if len(boxes) > len(self._out):
            self._out = np.empty((2 * len(boxes), 6))
        c, s = cos(yaw), sin(yaw)
        place = x + c * mount.x - s * mount.y, y + s * mount.x + c * mount.y, z + mount.z
        count = view(
            boxes,
            *place,
            yaw + mount.yaw,
            camera.focal,
            float(camera.width),
            float(camera.height),
            lit_range(camera_range(camera.reach, surroundings.extinction), surroundings.light),
            self._out,
        )
        blind = blinded(boxes, place, surroundings.light, surroundings.extinction)
        rows = [row for row in self._out[:count].tolist() if not blind[int(row[0])]]
        found = self._detect(rows, surroundings)
        if self._noise.uniform() >= camera.timing.dropout:
            self._line.send(t, CameraFrame(t, found))

    def _detect(self, rows: list[list[float]], surroundings: Surroundings) -> tuple[CameraBox, ...]:
        camera, normal, uniform = self._camera, self._noise.normal, self._noise.uniform
        found = []
        for index, u_min, v_min, u_max, v_max, visible in rows:
            if visible < camera.least_visible or v_max - v_min < camera.least_height:
                continue
            missed, confused, score = uniform(), uniform(), camera.score_sigma * normal()
            e1, e2, e3, e4 = normal(), normal(), normal(), normal()
            if missed < camera.misses:
                continue
            kind = OBJECT_KINDS[int(surroundings.kinds[int(index)])]
            if confused < camera.confusions:
                others = [k for k in OBJECT_KINDS if k != kind]
                kind = others[int(confused / camera.confusions * len(others))]
            u1, u2 = self._edges(u_min, u_max, e1, e2, float(camera.width))
            v1, v2 = self._edges(v_min, v_max, e3, e4, float(camera.height))
            found.append(CameraBox(u1, v1, u2, v2, kind, min(max(0.5 + 0.45 * visible + score, 0.05), 1.0)))
        if camera.false_boxes > 0.0 and uniform() < camera.false_boxes:
            found.append(self._false_box())
        return tuple(found)

    def _edges(self, low: float, high: float, e1: float, e2: float, size: float) -> tuple[float, float]:
        """Edges with noise, in order and inside the image; an edge cut by the image stays there."""
        sigma = self._camera.sigma
        if low > 0.0:
            low = min(max(low + sigma * e1, 0.0), size - 1.0)
        if high < size:
            high = min(max(high + sigma * e2, 1.0), size)
        return low, max(high, low + 1.0)

    def _false_box(self) -> CameraBox:
        camera, uniform = self._camera, self._noise.uniform
        w, h = 20.0 + 100.0 * uniform(), 20.0 + 100.0 * uniform()
        u, v = uniform() * max(camera.width - w, 1.0), uniform() * max(camera.height - h, 1.0)
        kind = OBJECT_KINDS[int(uniform() * len(OBJECT_KINDS))]
        return CameraBox(u, v, u + w, v + h, kind, 0.3 + 0.3 * uniform())

    def arrived(self, t: float) -> CameraFrame | None:
        """The newest frame that has arrived since the last call, if any."""
        frames = self._line.arrived(t)
        return frames[-1] if frames else None
