"""Faults of observations, drawn: what becomes of a message, and in which ticks."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.mutation.fault import Fault, Memory, Seen
from vehicle.messages import CameraFrame, LidarScan, Observation

replace = msgspec.structs.replace


def drawn_when(rng: random.Random) -> tuple[str, Callable[[Memory], bool]]:
    """In which ticks: always, for a while, now and then by chance, or in bursts; told and asked of a memory."""
    kind = rng.choice(["always", "always", "while", "chance", "bursts"])
    if kind == "while":
        first, long = rng.randint(40, 260), rng.randint(20, 160)
        return f"from {first / 20:.1f} s on for {long / 20:.1f} s", lambda m: first <= m.tick < first + long
    if kind == "chance":
        share, noise = rng.uniform(0.05, 0.5), rng.randint(0, 2**31)
        return f"in {100 * share:.0f} % of the ticks", lambda m: random.Random(noise + m.tick).random() < share
    if kind == "bursts":
        period, long = rng.randint(30, 120), rng.randint(4, 25)
        return f"{long} of every {period} ticks", lambda m: m.tick % period < long
    return "always", lambda m: True


def _sees(when: Callable[[Memory], bool], change: Seen) -> Seen:
    return lambda observation, memory: change(observation, memory) if when(memory) else observation


def drawn_observation(rng: random.Random) -> tuple[str, Fault]:
    """A change of messages, as a description and a fault."""
    kind = rng.choice(sorted(_SEEN))
    told, change = _SEEN[kind](rng)
    at, when = drawn_when(rng)
    return f"{told}, {at}", Fault(f"{kind}", "observation", sees=_sees(when, change))


def _messages(field: str, change: Callable[[Any, Memory], Any]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        changed = (change(one, memory) for one in getattr(observation, field))
        return replace(observation, **{field: tuple(one for one in changed if one is not None)})

    return sees


def _scan(change: Callable[[np.ndarray[Any, Any], Memory], np.ndarray[Any, Any]]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        scan = observation.lidar
        if scan is None:
            return observation
        return replace(observation, lidar=LidarScan(scan.t, change(scan.points.copy(), memory)))

    return sees


def _camera(change: Callable[[Any, Memory], Any]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        frame = observation.camera
        if frame is None:
            return observation
        changed = (change(box, memory) for box in frame.boxes)
        return replace(observation, camera=CameraFrame(frame.t, tuple(box for box in changed if box is not None)))

    return sees


def _gnss_drift(rng: random.Random) -> tuple[str, Seen]:
    rate, way = rng.uniform(0.01, 0.15), rng.uniform(0.0, 2.0 * math.pi)

    def change(fix: Any, memory: Memory) -> Any:
        far = rate * memory.tick / 20.0
        return replace(fix, x=fix.x + far * math.cos(way), y=fix.y + far * math.sin(way))

    return f"fixes drift by {rate:.2f} m/s", _messages("gnss", change)


def _gnss_noise(rng: random.Random) -> tuple[str, Seen]:
    sigma, noise = rng.uniform(0.1, 1.0), rng.randint(0, 2**31)

    def change(fix: Any, memory: Memory) -> Any:
        draw = random.Random(noise + memory.tick)
        return replace(fix, x=fix.x + draw.gauss(0.0, sigma), y=fix.y + draw.gauss(0.0, sigma))

    return f"fixes with {sigma:.2f} m of noise", _messages("gnss", change)


def _gnss_turned(rng: random.Random) -> tuple[str, Seen]:
    angle = math.radians(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 4.0))

    def change(fix: Any, memory: Memory) -> Any:
        first = memory.kept.setdefault("first", (fix.x, fix.y))
        dx, dy = fix.x - first[0], fix.y - first[1]  # type: ignore[index]
        c, s = math.cos(angle), math.sin(angle)
        return replace(fix, x=first[0] + c * dx - s * dy, y=first[1] + s * dx + c * dy)  # type: ignore[index]

    return f"the fixes' frame turned by {math.degrees(angle):.1f} deg about the start", _messages("gnss", change)


def _gnss_rounded(rng: random.Random) -> tuple[str, Seen]:
    step = rng.uniform(0.3, 2.0)
    return f"fixes in steps of {step:.1f} m", _messages(
        "gnss", lambda fix, m: replace(fix, x=step * round(fix.x / step), y=step * round(fix.y / step))
    )


def _heading_wave(rng: random.Random) -> tuple[str, Seen]:
    size, period = math.radians(rng.uniform(1.0, 8.0)), rng.uniform(1.0, 10.0)

    def change(fix: Any, memory: Memory) -> Any:
        sway = size * math.sin(2.0 * math.pi * memory.tick / 20.0 / period)
        return fix if fix.yaw is None else replace(fix, yaw=fix.yaw + sway)

    return f"heading sways by {math.degrees(size):.1f} deg every {period:.1f} s", _messages("gnss", change)


def _wheels_nonlinear(rng: random.Random) -> tuple[str, Seen]:
    share = rng.choice([-1.0, 1.0]) * rng.uniform(0.01, 0.05)
    return f"wheel speed wrong by {share:.3f} v^2", _messages(
        "odometry", lambda one, m: replace(one, v=one.v + share * one.v * abs(one.v) / 2.0)
    )


def _wheels_sticky(rng: random.Random) -> tuple[str, Seen]:
    least = rng.uniform(0.3, 2.0)
    return f"wheel speed below {least:.1f} m/s is told as 0", _messages(
        "odometry", lambda one, m: replace(one, v=one.v if abs(one.v) > least else 0.0)
    )


def _wheels_lagging(rng: random.Random) -> tuple[str, Seen]:
    share = rng.uniform(0.02, 0.2)

    def change(one: Any, memory: Memory) -> Any:
        old = float(memory.kept.get("v", one.v))  # type: ignore[arg-type]
        memory.kept["v"] = old + share * (one.v - old)
        return replace(one, v=memory.kept["v"])

    return f"wheel speed through a low pass of {share:.2f} a message", _messages("odometry", change)


def _steer_report(rng: random.Random) -> tuple[str, Seen]:
    gain = rng.choice([0.0, rng.uniform(0.4, 0.8), rng.uniform(1.2, 2.0), -1.0])
    return f"steering report times {gain:.2f}", _messages(
        "odometry", lambda one, m: replace(one, steer=gain * one.steer)
    )


def _gyro_clipped(rng: random.Random) -> tuple[str, Seen]:
    most = rng.uniform(0.02, 0.15)
    return f"yaw rate clipped at {most:.2f} rad/s", _messages(
        "imu", lambda one, m: replace(one, yaw_rate=min(max(one.yaw_rate, -most), most))
    )


def _gyro_scaled(rng: random.Random) -> tuple[str, Seen]:
    gain = rng.choice([rng.uniform(0.0, 0.6), rng.uniform(1.4, 3.0)])
    return f"yaw rate times {gain:.2f}", _messages("imu", lambda one, m: replace(one, yaw_rate=gain * one.yaw_rate))


def _lidar_tilted(rng: random.Random) -> tuple[str, Seen]:
    angle = math.radians(rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 12.0))

    def change(points: np.ndarray[Any, Any], memory: Memory) -> np.ndarray[Any, Any]:
        x, y = points[:, 0].copy(), points[:, 1].copy()
        points[:, 0] = math.cos(angle) * x - math.sin(angle) * y
        points[:, 1] = math.sin(angle) * x + math.cos(angle) * y
        return points

    return f"LiDAR turned by {math.degrees(angle):.1f} deg", _scan(change)


def _lidar_sector(rng: random.Random) -> tuple[str, Seen]:
    middle, half = math.radians(rng.uniform(-30.0, 30.0)), math.radians(rng.uniform(3.0, 25.0))

    def change(points: np.ndarray[Any, Any], memory: Memory) -> np.ndarray[Any, Any]:
        return points[np.abs(np.arctan2(points[:, 1], points[:, 0]) - middle) > half]

    return f"LiDAR blind {math.degrees(half):.0f} deg about {math.degrees(middle):.0f} deg", _scan(change)


def _lidar_thinned(rng: random.Random) -> tuple[str, Seen]:
    share, noise = rng.uniform(0.5, 0.97), rng.randint(0, 2**31)

    def change(points: np.ndarray[Any, Any], memory: Memory) -> np.ndarray[Any, Any]:
        return points[np.random.default_rng([noise, memory.tick]).random(len(points)) > share]

    return f"{100 * share:.0f} % of the LiDAR's points lost", _scan(change)


def _lidar_scaled(rng: random.Random) -> tuple[str, Seen]:
    gain = rng.choice([rng.uniform(0.8, 0.97), rng.uniform(1.03, 1.25)])

    def change(points: np.ndarray[Any, Any], memory: Memory) -> np.ndarray[Any, Any]:
        points[:, :2] *= gain
        return points

    return f"LiDAR ranges times {gain:.2f}", _scan(change)


def _lidar_noise(rng: random.Random) -> tuple[str, Seen]:
    sigma, noise = rng.uniform(0.1, 0.6), rng.randint(0, 2**31)

    def change(points: np.ndarray[Any, Any], memory: Memory) -> np.ndarray[Any, Any]:
        points[:, :2] += np.random.default_rng([noise, memory.tick]).normal(0.0, sigma, (len(points), 2))
        return points

    return f"LiDAR with {sigma:.2f} m of noise", _scan(change)


def _lidar_echo(rng: random.Random) -> tuple[str, Seen]:
    behind_it, share = rng.uniform(2.0, 12.0), rng.uniform(0.2, 1.0)

    def change(points: np.ndarray[Any, Any], memory: Memory) -> np.ndarray[Any, Any]:
        echo = points[: int(share * len(points))].copy()
        r = np.maximum(np.hypot(echo[:, 0], echo[:, 1]), 0.1)
        echo[:, :2] *= ((r + behind_it) / r)[:, None]
        return np.concatenate([points, echo])

    return f"a second echo {behind_it:.0f} m behind", _scan(change)


def _camera_shifted(rng: random.Random) -> tuple[str, Seen]:
    field, size = rng.choice(["kind", "lost"]), rng.uniform(0.3, 1.0)
    noise = rng.randint(0, 2**31)

    def change(box: Any, memory: Memory) -> Any:
        if random.Random(noise + memory.tick).random() > size:
            return box
        return replace(box, kind="bicycle" if box.kind == "vehicle" else "vehicle") if field == "kind" else None

    return f"camera: {field} wrong in {100 * size:.0f} %", _camera(change)


def _lights_stuck(rng: random.Random) -> tuple[str, Seen]:
    state = rng.choice(["red", "amber", "green", "off"])
    return f"lights always {state}", _messages("signals", lambda one, m: replace(one, state=state))


def _lights_delayed(rng: random.Random) -> tuple[str, Seen]:
    late = rng.randint(10, 80)

    def sees(observation: Observation, memory: Memory) -> Observation:
        past = list(memory.observations)
        old = past[-1 - late] if len(past) > late else None
        return replace(observation, signals=old.signals if old is not None else ())

    return f"lights {late / 20:.1f} s late", sees


_SEEN: dict[str, Callable[[random.Random], tuple[str, Seen]]] = {
    made.__name__[1:]: made
    for made in (
        _gnss_drift, _gnss_noise, _gnss_turned, _gnss_rounded, _heading_wave, _wheels_nonlinear, _wheels_sticky,
        _wheels_lagging, _steer_report, _gyro_clipped, _gyro_scaled, _lidar_tilted, _lidar_sector, _lidar_thinned,
        _lidar_scaled, _lidar_noise, _lidar_echo, _camera_shifted, _lights_stuck, _lights_delayed,
    )
}  # fmt: skip
