"""The faults that are tried. Each is of a kind that has been seen in driving stacks, sensors or buses."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.mutation.fault import Fault, Memory, Seen, Sent
from pytest_dvp.mutation.map_faults import MAP_FAULTS
from pytest_dvp.mutation.needs import BEND, GOAL, LIGHT, OTHERS, PEDESTRIAN, SPEED, STOP
from vehicle.messages import CameraFrame, Command, GnssFix, Imu, LidarScan, Observation, Odometry

TICKS = 20  # a second, at 20 Hz
INSTANT = (100, 110)  # ticks of a fault that lasts half a second, 5 s after the start
WHILE = (100, 340)  # of one that lasts 12 s
FAR, NEAR = 15.0, 30.0  # m, of a band of range

replace = msgspec.structs.replace


def _each(field: str, change: Callable[[Any], Any]) -> Seen:
    """A change of each message of a field that holds several."""

    def sees(observation: Observation, memory: Memory) -> Observation:
        messages = tuple(change(message) for message in getattr(observation, field))
        return replace(observation, **{field: tuple(m for m in messages if m is not None)})

    return sees


def _between(first: int, last: int, sees: Seen) -> Seen:
    return lambda observation, memory: sees(observation, memory) if first <= memory.tick < last else observation


def _every(n: int, field: str, sees: Seen) -> Seen:
    """A change of each n-th message of a field, which not every tick has one of."""

    def seen(observation: Observation, memory: Memory) -> Observation:
        if not getattr(observation, field):
            return observation
        memory.messages += 1
        return sees(observation, memory) if memory.messages % n == 0 else observation

    return seen


def _old(field: str, ticks: int) -> Seen:
    """A field as it was some ticks ago, with its own stamps: late on the wire."""

    def sees(observation: Observation, memory: Memory) -> Observation:
        past = memory.observations
        return replace(observation, **{field: getattr(past[-1 - ticks] if len(past) > ticks else past[0], field)})

    return sees


def _frozen(field: str) -> Seen:
    """A field that stays as it was 5 s after the start: its last message comes again and again."""

    def sees(observation: Observation, memory: Memory) -> Observation:
        if memory.tick < INSTANT[0] or not getattr(observation, field):
            return observation
        memory.kept.setdefault(field, getattr(observation, field))
        return replace(observation, **{field: memory.kept[field]})

    return sees


def _points(change: Callable[[np.ndarray[Any, Any]], np.ndarray[Any, Any]]) -> Seen:
    """A change of the points of the LiDAR, (n, 3) or more columns, x forward, y left [m]."""

    def sees(observation: Observation, memory: Memory) -> Observation:
        scan = observation.lidar
        return (
            observation if scan is None else replace(observation, lidar=LidarScan(scan.t, change(scan.points.copy())))
        )

    return sees


def _range(points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return np.asarray(np.hypot(points[:, 0], points[:, 1]))


def _ghost(points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """A box of 2 m, 25 m ahead."""
    side = np.linspace(-1.0, 1.0, 12)
    y, z = (grid.ravel() for grid in np.meshgrid(side, np.linspace(0.3, 1.5, 6)))
    ghost = np.zeros((len(y), points.shape[1]))
    ghost[:, 0], ghost[:, 1], ghost[:, 2] = 25.0, y, z
    return np.concatenate([points, ghost])


def _moved(points: np.ndarray[Any, Any], dx: float, dy: float) -> np.ndarray[Any, Any]:
    points[:, 0] += dx
    points[:, 1] += dy
    return points


def _mirrored(points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    points[:, 1] *= -1.0
    return points


def _not_a_number(points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    far = _range(points)
    points[(far > FAR) & (far < NEAR), :2] = math.nan
    return points


def _boxes(change: Callable[[Any], Any]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        frame = observation.camera
        if frame is None:
            return observation
        kept = tuple(box for box in map(change, frame.boxes) if box is not None)
        return replace(observation, camera=CameraFrame(frame.t, kept))

    return sees


def _lost(*fields: str) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        none: Mapping[str, Any] = {"gnss": (), "odometry": (), "imu": (), "lidar": None, "camera": None, "signals": ()}
        return replace(observation, **{field: none[field] for field in fields})

    return sees


def _doubled(field: str) -> Seen:
    return lambda observation, memory: replace(observation, **{field: getattr(observation, field) * 2})


def _fix(**change: Callable[[GnssFix], Any]) -> Seen:
    return _each("gnss", lambda fix: replace(fix, **{name: make(fix) for name, make in change.items()}))


def _wheel(**change: Callable[[Odometry], Any]) -> Seen:
    return _each("odometry", lambda one: replace(one, **{name: make(one) for name, make in change.items()}))


def _inertial(**change: Callable[[Imu], Any]) -> Seen:
    return _each("imu", lambda one: replace(one, **{name: make(one) for name, make in change.items()}))


def _heading(fix: GnssFix, change: Callable[[float], float]) -> float | None:
    return None if fix.yaw is None else change(fix.yaw)


def _noisy(observation: Observation, memory: Memory) -> Observation:
    """Wheel speed that jumps by 0.5 m/s to and fro, as if its noise were 50 times larger."""
    sign = 1.0 if memory.tick % 2 else -1.0
    return replace(observation, odometry=tuple(replace(one, v=one.v + 0.5 * sign) for one in observation.odometry))


def _stamps(shift: float) -> Seen:
    """Stamps of all sensors moved [s]; what they hold is as it was."""

    def sees(observation: Observation, memory: Memory) -> Observation:
        def later(one: Any) -> Any:
            return None if one is None else replace(one, t=one.t + shift)

        return replace(
            observation, gnss=tuple(map(later, observation.gnss)), odometry=tuple(map(later, observation.odometry)),
            imu=tuple(map(later, observation.imu)), lidar=later(observation.lidar), camera=later(observation.camera),
        )  # fmt: skip

    return sees


def _signal(change: Callable[[Any], Any]) -> Seen:
    return _each("signals", change)


def _speed_asked(observation: Observation, memory: Memory) -> Observation:
    task = observation.task
    return (
        observation
        if task is None or task.set_speed is None
        else replace(observation, task=replace(task, set_speed=1.2 * task.set_speed))
    )


def _goal_beyond(observation: Observation, memory: Memory) -> Observation:
    task = observation.task
    if task is None or task.goal is None:
        return observation
    return replace(observation, task=replace(task, goal=task.goal._replace(s=task.goal.s + 3.0)))


def _command(**change: Callable[[Command], float]) -> Sent:
    return lambda command, memory: replace(command, **{name: make(command) for name, make in change.items()})


def _late(ticks: int) -> Sent:
    def sends(command: Command, memory: Memory) -> Command:
        past = memory.commands
        old = past[-1 - ticks] if len(past) > ticks else past[0]
        return replace(old, t=command.t)

    return sends


def _stale(n: int) -> Sent:
    def sends(command: Command, memory: Memory) -> Command:
        past = memory.commands
        return replace(past[-2], t=command.t) if memory.tick % n == n - 1 and len(past) > 1 else command

    return sends


def _for(first: int, last: int, sends: Sent) -> Sent:
    return lambda command, memory: sends(command, memory) if first <= memory.tick < last else command


def _steps(size: float) -> Sent:
    return _command(steer=lambda c: size * round(c.steer / size))


_DEGREE = math.pi / 180.0
GNSS, ODOMETRY, IMU, LIDAR, CAMERA = ("gnss",), ("odometry",), ("imu",), ("lidar",), ("camera",)

FAULTS: tuple[Fault, ...] = (
    Fault("gnss_frozen", "observation", of=GNSS, sees=_frozen("gnss")),
    Fault("gnss_late_200ms", "observation", of=GNSS, sees=_old("gnss", 4)),
    Fault("gnss_offset_1m", "observation", of=GNSS, sees=_fix(y=lambda f: f.y + 1.0)),
    Fault("gnss_scaled", "observation", of=GNSS, sees=_fix(x=lambda f: 1.002 * f.x, y=lambda f: 1.002 * f.y)),
    Fault("gnss_lost_5s", "observation", of=GNSS, sees=_between(100, 200, _lost("gnss"))),
    Fault("gnss_doubled", "observation", of=GNSS, sees=_doubled("gnss")),
    Fault("gnss_swapped_axes", "observation", of=GNSS, sees=_between(*INSTANT, _fix(x=lambda f: f.y, y=lambda f: f.x))),
    Fault("gnss_nan", "observation", of=GNSS, sees=_between(*INSTANT, _fix(x=lambda f: math.nan))),
    Fault("gnss_jump_3m", "observation", of=GNSS, sees=_between(*INSTANT, _fix(x=lambda f: f.x + 3.0))),
    Fault("heading_bias_3deg", "observation", of=GNSS, asks=BEND,
          sees=_fix(yaw=lambda f: _heading(f, lambda y: y + 3.0 * _DEGREE))),
    Fault("heading_compass", "observation", of=GNSS,
          sees=_between(*INSTANT, _fix(yaw=lambda f: _heading(f, lambda y: 0.5 * math.pi - y)))),
    Fault("sigma_too_small", "observation", of=GNSS, sees=_fix(sigma=lambda f: 0.1 * f.sigma)),
    Fault("wheel_speed_plus_5_percent", "observation", of=ODOMETRY, sees=_wheel(v=lambda o: 1.05 * o.v)),
    Fault("wheel_speed_frozen", "observation", of=ODOMETRY, sees=_frozen("odometry")),
    Fault("wheel_speed_lost", "observation", of=ODOMETRY, sees=_between(*WHILE, _lost("odometry"))),
    Fault("wheel_speed_noise", "observation", of=ODOMETRY, sees=_noisy),
    Fault("wheel_speed_kmh", "observation", of=ODOMETRY, sees=_between(*INSTANT, _wheel(v=lambda o: 3.6 * o.v))),
    Fault("steer_report_offset", "observation", of=ODOMETRY, sees=_wheel(steer=lambda o: o.steer + 0.02)),
    Fault("yaw_rate_bias", "observation", of=IMU, sees=_inertial(yaw_rate=lambda i: i.yaw_rate + 0.03)),
    Fault("yaw_rate_sign", "observation", of=IMU, sees=_inertial(yaw_rate=lambda i: -i.yaw_rate), asks=BEND),
    Fault("imu_lost", "observation", of=IMU, sees=_lost("imu")),
    Fault("lidar_lost_2s", "observation", of=LIDAR, sees=_between(100, 140, _lost("lidar")), asks=OTHERS),
    Fault("lidar_blind_beyond_15m", "observation", of=LIDAR, sees=_points(lambda p: p[_range(p) < FAR]), asks=OTHERS),
    Fault("lidar_blind_below_10m", "observation", of=LIDAR, sees=_points(lambda p: p[_range(p) > 10.0]), asks=OTHERS),
    Fault("lidar_nan_in_a_band", "observation", of=LIDAR, sees=_points(_not_a_number), asks=OTHERS),
    Fault("lidar_mirrored", "observation", of=LIDAR, sees=_points(_mirrored), asks=OTHERS),
    Fault("lidar_offset_1m_ahead", "observation", of=LIDAR, sees=_points(lambda p: _moved(p, 1.0, 0.0)), asks=OTHERS),
    Fault("lidar_offset_half_m_left", "observation", of=LIDAR, asks=OTHERS,
          sees=_points(lambda p: _moved(p, 0.0, 0.5))),
    Fault("lidar_ghost_12s", "observation", of=LIDAR, sees=_between(*WHILE, _points(_ghost))),
    Fault("lidar_late_200ms", "observation", of=LIDAR, sees=_old("lidar", 4), asks=OTHERS),
    Fault("lidar_every_second", "observation", of=LIDAR, sees=_every(2, "lidar", _lost("lidar")), asks=OTHERS),
    Fault("camera_lost", "observation", of=CAMERA, sees=_lost("camera"), asks=OTHERS),
    Fault("camera_wrong_class", "observation", of=CAMERA, sees=_boxes(lambda b: replace(b, kind="misc")), asks=OTHERS),
    Fault("camera_no_pedestrians", "observation", of=CAMERA,
          sees=_boxes(lambda b: None if b.kind == "pedestrian" else b), asks=PEDESTRIAN),
    Fault("blind", "observation", of=LIDAR + CAMERA, sees=_lost("lidar", "camera"), asks=OTHERS),
    Fault("signals_lost", "observation", sees=_lost("signals"), asks=LIGHT),
    Fault("signals_all_green", "observation", sees=_signal(lambda s: replace(s, state="green")), asks=LIGHT),
    Fault("task_faster_by_20_percent", "task", sees=_speed_asked, asks=SPEED),
    Fault("task_goal_3m_beyond", "task", sees=_goal_beyond, asks=GOAL),
    Fault("stamps_100ms_old", "time", sees=_stamps(-0.1)),
    Fault("stamps_100ms_ahead", "time", sees=_stamps(0.1)),
    Fault("clock_jumps", "time", sees=_between(*INSTANT, _stamps(1.0))),
    Fault("command_late_100ms", "command", sends=_late(2)),
    Fault("command_late_300ms", "command", sends=_late(6)),
    Fault("command_every_fifth_stale", "command", sends=_stale(5)),
    Fault("steer_in_steps_of_2deg", "command", sends=_steps(2.0 * _DEGREE), asks=BEND),
    Fault("steer_gain_80_percent", "command", sends=_command(steer=lambda c: 0.8 * c.steer), asks=BEND),
    Fault("steer_offset_1deg", "command", sends=_command(steer=lambda c: c.steer + _DEGREE)),
    Fault("steer_sign_for_an_instant", "command", asks=BEND,
          sends=_for(*INSTANT, _command(steer=lambda c: -c.steer))),
    Fault("steer_dropped", "command", sends=_for(*INSTANT, _command(steer=lambda c: 0.0)), asks=BEND),
    Fault("steer_limited_10deg", "command",
          sends=_command(steer=lambda c: min(max(c.steer, -10.0 * _DEGREE), 10.0 * _DEGREE)), asks=BEND),
    Fault("brake_half", "command", asks=STOP,
          sends=_command(brake=lambda c: 0.5 * c.brake, accel=lambda c: c.accel if c.accel > 0.0 else 0.5 * c.accel)),
    Fault("brake_dropped", "command", asks=STOP,
          sends=_for(*INSTANT, _command(brake=lambda c: 0.0, accel=lambda c: max(c.accel, 0.0)))),
    Fault("no_brake_at_standstill", "command", asks=STOP,
          sends=_command(brake=lambda c: c.brake if c.brake > 0.3 else 0.0,
                         accel=lambda c: c.accel if not -0.5 < c.accel < 0.0 else 0.05)),
    Fault("drive_150_percent", "command",
          sends=_command(throttle=lambda c: min(1.5 * c.throttle, 1.0), accel=lambda c: 1.5 * c.accel)),
    Fault("drive_cut_2s", "command",
          sends=_for(100, 140, _command(throttle=lambda c: 0.0, accel=lambda c: min(c.accel, 0.0)))),
    *MAP_FAULTS,
)  # fmt: skip
"""In the order of the report."""


def known_faults() -> dict[str, Fault]:
    """The faults by name."""
    return {fault.name: fault for fault in FAULTS}
