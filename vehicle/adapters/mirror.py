"""The mirror: where a measured car is now, told from a measurement that is a little old; and parallel execution.

Extrapolation: constant turn rate and acceleration over the latency d. Its error is at most jerk d^3 / 6 along and
v (turn acceleration) d^3 / 6 across, plus what the measurement itself is wrong by: millimetres at 20 ms.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from vehicle.adapter import Vehicle, position_sigma_of
from vehicle.messages import (
    CameraBox,
    CameraFrame,
    Command,
    FloatArray,
    LidarScan,
    Observation,
    Surroundings,
    VehicleDescription,
    VehicleState,
    no_surroundings,
)
from vehicle.sensors.camera import Camera
from vehicle.sensors.common import Mount, Timing
from vehicle.sensors.lidar import Lidar
from vehicle.sensors.perceived import Perceived

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import AppliedEffect

SAME = 1e-6  # s: two stamps this close are one instant
REMEMBERED = 20  # ticks: 1 s, more than any sensor is late
BEARING = np.radians(0.5)  # width of a bearing, in which a real thing hides what is behind it; chosen
_APART = 1e6  # m, more than any return is away: bearing and distance in one number
_ABOVE = 4.0  # rad, more than pi, which two elevations differ by at most: bearing and elevation in one number
OVERLAP = 0.5  # of the union: two image boxes that are one object


def extrapolated(rows: FloatArray, ahead: float) -> FloatArray:
    """Rows of TRACE_COLUMNS (n, 12) as they will be `ahead` [s] later; a braking car stops and does not reverse."""
    if ahead <= SAME or not len(rows):
        return rows
    out = rows.copy()
    yaw, v, vy, rate, ax = rows[:, 4], rows[:, 5], rows[:, 7], rows[:, 8], rows[:, 9]
    later = v + (ax + rate * vy) * ahead  # ax is specific force: dv/dt = ax + rate vy
    later = np.where(v * later < 0.0, 0.0, later)
    later = np.where(np.abs(v) < 1e-3, v, later)  # standing: its brakes hold
    mean, middle = 0.5 * (v + later), yaw + 0.5 * rate * ahead
    out[:, 0] += ahead
    out[:, 1] += (mean * np.cos(middle) - vy * np.sin(middle)) * ahead
    out[:, 2] += (mean * np.sin(middle) + vy * np.cos(middle)) * ahead
    out[:, 4] += rate * ahead
    out[:, 5] = out[:, 6] = later
    return out


class Mirror:
    """Where the car is at each tick, from rows of motion that come late or, of a twin, at once.

    `error` [m] is the distance between the last shown pose whose measurement has come and that measurement; NaN until
    there is one. `latency` [s] is that of the newest row.
    """

    def __init__(self) -> None:
        self._newest: FloatArray = np.zeros((0, 12))
        self._shown: deque[tuple[float, float, float]] = deque(maxlen=REMEMBERED)
        self.error = float("nan")
        self.latency = 0.0

    def show(self, t: float, rows: FloatArray) -> FloatArray:
        """The motion since the last tick as it is at `t` [s]: `rows` (n, 12) moved on by their latency, never empty."""
        for row in rows if self._shown else ():  # of a twin, which is never late, nothing was shown ahead
            while self._shown and self._shown[0][0] < row[0] - SAME:
                self._shown.popleft()
            if self._shown and abs(self._shown[0][0] - row[0]) <= SAME:
                _, x, y = self._shown.popleft()
                self.error = float(np.hypot(x - row[1], y - row[2]))
        if len(rows):
            self._newest = rows[-1:]
        self.latency = max(t - float(self._newest[0, 0]), 0.0)
        moved = extrapolated(rows if len(rows) else self._newest, self.latency)
        if self.latency > SAME:
            self._shown.append((t, float(moved[-1, 1]), float(moved[-1, 2])))
        return moved


class Parallel:
    """A real car among virtual road users: they are rendered into its own sensors' measurements.

    When a scan or an image of the car comes, the virtual objects are rendered as that sensor would have met them at
    its stamp, from the mirrored pose of then, and merged. All real ones stay. `seed` of the rendering's noise.
    `perception` holds the twin's perception effects: what the car's own sensors would make of the virtual objects.
    """

    def __init__(self, vehicle: Vehicle, seed: int = 0, perception: Iterable[AppliedEffect] = ()) -> None:
        self._vehicle, self._seed, self._effects = vehicle, seed, tuple(perception)
        self._rows: FloatArray = np.zeros((0, 12))
        self._begin(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))

    @property
    def description(self) -> VehicleDescription:
        """The car's."""
        return self._vehicle.description

    @property
    def is_real(self) -> bool:
        """The car's."""
        return self._vehicle.is_real

    @property
    def position_sigma(self) -> float:
        """The car's [m]."""
        return position_sigma_of(self._vehicle)

    def reset(self, state: VehicleState) -> None:
        """Reset the car and the rendering."""
        self._vehicle.reset(state)
        self._begin(state)

    def observe(self, surroundings: Surroundings) -> Observation:
        """The car's own sensors, which see nothing of `surroundings`, with these rendered into them."""
        pose = self._mirror.show(self._t, self._rows)[-1]
        self._rows = np.zeros((0, 12))
        x, y, z, yaw = (float(each) for each in pose[1:5])
        surroundings = self._perceived.seen(self._t, x, y, yaw, surroundings, z)
        self._past.append((self._t, (x, y, z, yaw), surroundings))
        seen = self._vehicle.observe(no_surroundings())
        lidar = None if seen.lidar is None else self._merged_scan(seen.lidar)
        camera = None if seen.camera is None else self._merged_frame(seen.camera)
        return msgspec.structs.replace(seen, lidar=lidar, camera=camera, signals=(*seen.signals, *surroundings.signals))

    def apply(self, command: Command) -> None:
        """To the car."""
        self._vehicle.apply(command)

    def step(self, dt: float) -> FloatArray:
        """Let the car go on by `dt` [s]. Returns its rows of TRACE_COLUMNS (k, 12), oldest first."""
        rows = self._vehicle.step(dt)
        self._t += dt
        self._rows = np.concatenate([self._rows, rows])
        return rows

    def stop(self) -> None:
        """To the car."""
        self._vehicle.stop()

    def close(self) -> None:
        """To the car."""
        self._vehicle.close()

    def warm_up(self) -> None:
        """Let what compiles or loads when it is first used do so now."""
        self._begin(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
        box = np.array([[10.0, 0.0, 0.75, 0.0, 4.0, 1.8, 1.5, 0.0, 0.0]])
        self._past.append((0.0, (0.0, 0.0, 0.0, 0.0), Surroundings(box, np.zeros(1, dtype=np.int64), ("a car",))))
        self._merged_scan(LidarScan(0.0, np.array([[0.0, 5.0, 0.0]])))
        self._merged_frame(CameraFrame(0.0, ()))

    def _begin(self, state: VehicleState) -> None:
        car, now = self._vehicle.description, Timing(rate=1000.0)
        lidar = Lidar(Mount(x=car.lidar_x, y=car.lidar_y, z=car.lidar_z, yaw=car.lidar_yaw), now)
        camera = Camera(
            Mount(x=car.camera_x, y=car.camera_y, z=car.camera_z, yaw=car.camera_yaw), now,
            focal=car.camera_focal, width=car.camera_width, height=car.camera_height,
        )  # fmt: skip
        seeds = np.random.SeedSequence(self._seed).spawn(2)
        self._lidar, self._camera = lidar.start(state.t, seeds[0]), camera.start(state.t, seeds[1])
        self._mirror, self._t = Mirror(), state.t
        self._perceived = Perceived(self._effects, self._seed)
        self._past: deque[tuple[float, tuple[float, float, float, float], Surroundings]] = deque(maxlen=REMEMBERED)
        self._rows = np.array(
            [[state.t, state.x, state.y, state.z, state.yaw, state.v, state.vx, 0, 0, 0, 0, 0]], dtype=np.float64
        )

    def _then(self, t: float) -> tuple[tuple[float, float, float, float], Surroundings]:
        """Mirrored pose and virtual objects of the tick nearest to `t` [s]."""
        _, pose, around = min(self._past, key=lambda past: abs(past[0] - t))
        return pose, around

    def _merged_scan(self, real: LidarScan) -> LidarScan:
        pose, around = self._then(real.t)
        self._lidar.measure(real.t, *pose, around.seen_by("lidar").boxes, around.extinction)
        virtual = self._lidar.arrived(real.t)
        return real if virtual is None else LidarScan(real.t, merged_points(real.points, virtual.points))

    def _merged_frame(self, real: CameraFrame) -> CameraFrame:
        pose, around = self._then(real.t)
        self._camera.measure(real.t, *pose, around.seen_by("camera"))
        virtual = self._camera.arrived(real.t)
        return real if virtual is None else CameraFrame(real.t, merged_boxes(real.boxes, virtual.boxes))


class SupervisedParallel(Parallel):
    """Of a car with a driver, who keeps the last word."""

    @property
    def hands(self) -> Any:
        """The driver's, as the car measures them (vehicle.adapter.Hands)."""
        return self._vehicle.hands  # type: ignore[attr-defined]


def in_parallel(vehicle: Vehicle, seed: int = 0, perception: Iterable[AppliedEffect] = ()) -> Parallel:
    """A car among virtual road users; one that tells of its driver's hands still does. Arguments as of `Parallel`."""
    return (SupervisedParallel if hasattr(vehicle, "hands") else Parallel)(vehicle, seed, perception)


def merged_points(real: FloatArray, virtual: FloatArray) -> FloatArray:
    """Real returns (n, 3) [m] in the LiDAR's frame, and those virtual ones (m, 3) [m] that no real thing hides.

    A thing hides what is farther away in its bearing and not higher, seen from the LiDAR: it stands on the ground, of
    which returns therefore hide nothing that stands on it. Limit: what hangs above the road, a bridge say, hides what
    is behind it.
    """
    if not len(real) or not len(virtual):
        return virtual if len(virtual) else real
    own, distance, elevation = _bearing(virtual), *_seen(virtual)
    bearing = _bearing(real)
    beside = np.isin(bearing, own) & real[:, :2].any(axis=1)  # a scanner may fill up its scan with zeros
    bearing, (away, up) = bearing[beside], _seen(real[beside])
    order = np.lexsort((away, bearing))
    place = bearing[order] * _APART + away[order]
    highest = np.maximum.accumulate(bearing[order] * _ABOVE + up[order])  # so far, within a bearing
    nearer = np.searchsorted(place, own * _APART + distance)
    hidden = np.concatenate([[-np.inf], highest])[nearer] >= own * _ABOVE + elevation
    return np.concatenate([real, virtual[~hidden]])


def merged_boxes(real: tuple[CameraBox, ...], virtual: tuple[CameraBox, ...]) -> tuple[CameraBox, ...]:
    """Real image boxes, and those virtual ones that are not the same object as a real one."""
    return (*real, *(box for box in virtual if all(_overlap(box, other) < OVERLAP for other in real)))


def _bearing(points: FloatArray) -> FloatArray:
    cells: FloatArray = np.floor(np.arctan2(points[:, 1], points[:, 0]) / BEARING)
    return cells


def _seen(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distance [m] along the ground, and elevation [rad], of points (n, 3)."""
    away = np.hypot(points[:, 0], points[:, 1])
    return away, np.arctan2(points[:, 2], away)


def _overlap(a: CameraBox, b: CameraBox) -> float:
    """Intersection over union of two image boxes."""
    wide = max(min(a.u_max, b.u_max) - max(a.u_min, b.u_min), 0.0)
    high = max(min(a.v_max, b.v_max) - max(a.v_min, b.v_min), 0.0)
    both = wide * high
    union = (a.u_max - a.u_min) * (a.v_max - a.v_min) + (b.u_max - b.u_min) * (b.v_max - b.v_min) - both
    return both / union if union > 0.0 else 0.0
