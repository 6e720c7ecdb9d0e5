"""More kinds of faults, written after the bounds of commit e7165793 stood: what breaks between car and stack in use.

Drawn as those of scripts/fresh_faults.py, from five families in equal parts: sensors of motion, sensors of the
surroundings, commands, clocks and delivery, map and task. `scripts/fault_drives.py --kinds second` drives them.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.mutation.fault import Fault, Mapped, Memory, Seen
from pytest_dvp.mutation.map_faults import ChangedMap
from scripts.fresh_observations import drawn_when
from vehicle.messages import CameraFrame, LidarScan, Observation, SignalState

replace = msgspec.structs.replace
Drawn = tuple[str, Fault]
Points = np.ndarray[Any, Any]
TICK = 0.05  # s


def generated(seed: str, count: int) -> list[Drawn]:
    """Description and fault of each, the same for the same seed."""
    rng = random.Random(int(seed, 16) + 1)
    return [rng.choice(FAMILIES[k % len(FAMILIES)])(rng) for k in range(count)]


def _fault(told: str, where: str, rng: random.Random, change: Seen) -> Drawn:
    """An observation that is changed in the ticks that are drawn."""
    at, when = drawn_when(rng)
    name = told.split(" by ")[0]

    def sees(observation: Observation, memory: Memory) -> Observation:
        return change(observation, memory) if when(memory) else observation

    return f"{told}, {at}", Fault(name, where, sees=sees)  # type: ignore[arg-type]


def _each(field: str, change: Callable[[Any], Any]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        return replace(observation, **{field: tuple(map(change, getattr(observation, field)))})

    return sees


def _points(change: Callable[[Points, Memory], Points]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        scan = observation.lidar
        return (
            observation if scan is None else replace(observation, lidar=LidarScan(scan.t, change(scan.points, memory)))
        )

    return sees


def _boxes(change: Callable[[Any, random.Random], list[Any]], noise: int) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        frame = observation.camera
        if frame is None:
            return observation
        rng = random.Random(noise + memory.tick)
        return replace(
            observation, camera=CameraFrame(frame.t, tuple(b for box in frame.boxes for b in change(box, rng)))
        )

    return sees


# sensors of motion ----------------------------------------------------------------------------------------------------


def _lever(rng: random.Random) -> Drawn:
    """The antenna stands elsewhere than the data sheet says."""
    ahead, left = rng.uniform(-1.5, 1.5), rng.uniform(-0.8, 0.8)

    def change(fix: Any) -> Any:
        if fix.yaw is None:
            return fix
        c, s = math.cos(fix.yaw), math.sin(fix.yaw)
        return replace(fix, x=fix.x + c * ahead - s * left, y=fix.y + s * ahead + c * left)

    return _fault(f"antenna off by {ahead:.2f}, {left:.2f} m", "observation", rng, _each("gnss", change))


def _multipath(rng: random.Random) -> Drawn:
    dx, dy = rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0)
    change = _each("gnss", lambda fix: replace(fix, x=fix.x + dx, y=fix.y + dy))
    return _fault(f"fixes jump by {dx:.1f}, {dy:.1f} m", "observation", rng, change)


def _proud(rng: random.Random) -> Drawn:
    factor = rng.choice([rng.uniform(0.05, 0.4), rng.uniform(3.0, 20.0)])
    change = _each("gnss", lambda fix: replace(fix, sigma=factor * fix.sigma))
    return _fault(f"sigma of the fixes told by a factor of {factor:.2f}", "observation", rng, change)


def _tyres(rng: random.Random) -> Drawn:
    gain = 1.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.02, 0.15)
    return _fault(
        f"wheel radius by {gain:.3f}", "observation", rng, _each("odometry", lambda o: replace(o, v=gain * o.v))
    )


def _gyro_bias(rng: random.Random) -> Drawn:
    bias = rng.choice([-1.0, 1.0]) * rng.uniform(0.005, 0.1)
    change = _each("imu", lambda one: replace(one, yaw_rate=one.yaw_rate + bias))
    return _fault(f"yaw rate biased by {bias:.3f} rad/s", "observation", rng, change)


def _imu_mount(rng: random.Random) -> Drawn:
    """The IMU is mounted turned about its vertical axis, or upside down."""
    angle = rng.choice([math.pi / 2, -math.pi / 2, math.pi, rng.uniform(-0.5, 0.5)])
    c, s = math.cos(angle), math.sin(angle)
    over = rng.random() < 0.3

    def change(one: Any) -> Any:
        ax, ay = c * one.ax - s * one.ay, s * one.ax + c * one.ay
        return replace(one, ax=ax, ay=-ay if over else ay, yaw_rate=-one.yaw_rate if over else one.yaw_rate)

    told = f"IMU turned by {math.degrees(angle):.0f} deg{', upside down' if over else ''}"
    return _fault(told, "observation", rng, _each("imu", change))


# sensors of the surroundings ------------------------------------------------------------------------------------------


def _fog(rng: random.Random) -> Drawn:
    reach = rng.uniform(5.0, 25.0)
    return _fault(f"LiDAR sees no farther than by {reach:.0f} m", "observation", rng,
                  _points(lambda p, m: p[np.hypot(p[:, 0], p[:, 1]) < reach]))  # fmt: skip


def _near_blind(rng: random.Random) -> Drawn:
    nearest = rng.uniform(3.0, 10.0)
    return _fault(f"LiDAR blind nearer than by {nearest:.1f} m", "observation", rng,
                  _points(lambda p, m: p[np.hypot(p[:, 0], p[:, 1]) > nearest]))  # fmt: skip


def _mirrored(rng: random.Random) -> Drawn:
    return _fault("LiDAR mirrored", "observation", rng, _points(lambda p, m: p * np.array([1.0, -1.0, 1.0])))


def _lifted(rng: random.Random) -> Drawn:
    dz = rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 1.5)
    return _fault(
        f"LiDAR mounted higher by {dz:.1f} m", "observation", rng, _points(lambda p, m: p + np.array([0, 0, dz]))
    )


def _rain(rng: random.Random) -> Drawn:
    count, noise = rng.randint(3, 60), rng.randint(0, 2**31)

    def change(points: Points, memory: Memory) -> Points:
        draw = np.random.default_rng([noise, memory.tick])
        r, a, z = draw.uniform(1.0, 12.0, count), draw.uniform(-1.2, 1.2, count), draw.uniform(-1.0, 1.0, count)
        return np.concatenate([points.reshape(-1, 3), np.column_stack((r * np.cos(a), r * np.sin(a), z))])

    return _fault(f"rain by {count} returns", "observation", rng, _points(change))


def _flipped(rng: random.Random) -> Drawn:
    width = rng.choice([640.0, 1280.0, 1920.0])
    change = _boxes(lambda b, r: [replace(b, u_min=width - b.u_max, u_max=width - b.u_min)], 0)
    return _fault(f"image flipped about by {width:.0f} px", "observation", rng, change)


def _pixels(rng: random.Random) -> Drawn:
    du, dv = rng.uniform(-120.0, 120.0), rng.uniform(-60.0, 60.0)
    change = _boxes(
        lambda b, r: [replace(b, u_min=b.u_min + du, u_max=b.u_max + du, v_min=b.v_min + dv, v_max=b.v_max + dv)], 0
    )
    return _fault(f"camera boxes moved by {du:.0f}, {dv:.0f} px", "observation", rng, change)


def _grown(rng: random.Random) -> Drawn:
    gain = rng.choice([rng.uniform(0.4, 0.85), rng.uniform(1.2, 2.5)])

    def change(b: Any, r: random.Random) -> list[Any]:
        u, v = (b.u_min + b.u_max) / 2, (b.v_min + b.v_max) / 2
        w, h = gain * (b.u_max - b.u_min) / 2, gain * (b.v_max - b.v_min) / 2
        return [replace(b, u_min=u - w, u_max=u + w, v_min=v - h, v_max=v + h)]

    return _fault(f"camera boxes grown by {gain:.2f}", "observation", rng, _boxes(change, 0))


def _pedestrians(rng: random.Random) -> Drawn:
    wrong, share = rng.choice(["vehicle", "misc", "bicycle"]), rng.uniform(0.3, 1.0)

    def change(b: Any, r: random.Random) -> list[Any]:
        return [replace(b, kind=wrong) if b.kind == "pedestrian" and r.random() < share else b]

    return _fault(
        f"pedestrians called {wrong} by {share:.2f}", "observation", rng, _boxes(change, rng.randint(0, 2**31))
    )


def _lights_swapped(rng: random.Random) -> Drawn:
    swap = rng.choice([{"red": "green", "green": "red"}, {"amber": "green"}, {"red": "amber"}, {"amber": "red"}])
    change = _each("signals", lambda one: SignalState(one.id, swap.get(one.state, one.state)))
    return _fault(f"lights swapped by {swap}", "observation", rng, change)


# commands -------------------------------------------------------------------------------------------------------------


def _sent(told: str, rng: random.Random, change: Callable[[Any, Memory], Any], always: bool = False) -> Drawn:
    at, when = ("always", lambda m: True) if always else drawn_when(rng)

    def sends(command: Any, memory: Memory) -> Any:
        new = change(command, memory) if when(memory) else command
        memory.kept["sent"] = new
        return new

    return f"{told}, {at}", Fault(told.split(" by ")[0], "command", sends=sends)


def _late_brake(rng: random.Random) -> Drawn:
    late = rng.randint(2, 16)

    def change(command: Any, memory: Memory) -> Any:
        past = list(memory.commands)
        old = past[-late] if len(past) >= late else None
        brake = old.brake if old is not None else 0.0
        return replace(command, brake=brake, accel=command.accel if command.brake == brake else min(command.accel, 0.0))

    return _sent(f"brake late by {late * TICK:.2f} s", rng, change, always=True)


def _drag(rng: random.Random) -> Drawn:
    drag = rng.uniform(0.02, 0.15)
    return _sent(f"brake drags by {drag:.2f}", rng, lambda c, m: replace(c, brake=max(c.brake, drag)))


def _dead_pedals(rng: random.Random) -> Drawn:
    dead = rng.uniform(0.03, 0.2)
    return _sent(f"pedals dead by {dead:.2f}", rng, lambda c, m: replace(
        c, throttle=c.throttle if c.throttle > dead else 0.0, brake=c.brake if c.brake > dead else 0.0))  # fmt: skip


def _shimmy(rng: random.Random) -> Drawn:
    size, frequency = rng.uniform(0.005, 0.05), rng.uniform(0.3, 4.0)
    return _sent(f"steering sways by {size:.3f} rad at {frequency:.1f} Hz", rng, lambda c, m: replace(
        c, steer=c.steer + size * math.sin(2.0 * math.pi * frequency * m.tick * TICK)))  # fmt: skip


def _stuck_wheel(rng: random.Random) -> Drawn:
    first, long = rng.randint(40, 240), rng.randint(8, 60)

    def change(command: Any, memory: Memory) -> Any:
        old = memory.kept.get("sent", command)
        return replace(command, steer=old.steer) if first <= memory.tick < first + long else command  # type: ignore[attr-defined]

    return _sent(f"steering stuck from {first * TICK:.1f} s by {long * TICK:.1f} s", rng, change, always=True)


def _lock_to_lock(rng: random.Random) -> Drawn:
    most = rng.uniform(0.05, 0.25)
    return _sent(f"steering limited by {most:.2f} rad", rng,
                 lambda c, m: replace(c, steer=min(max(c.steer, -most), most)))  # fmt: skip


def _lossy(rng: random.Random) -> Drawn:
    share, noise = rng.uniform(0.05, 0.6), rng.randint(0, 2**31)

    def change(command: Any, memory: Memory) -> Any:
        old = memory.kept.get("sent", command)
        return old if random.Random(noise + memory.tick).random() < share else command

    return _sent(f"commands lost by {share:.2f}", rng, change, always=True)


# clocks and delivery --------------------------------------------------------------------------------------------------

SENSORS = ("gnss", "odometry", "imu", "lidar", "camera")


def _batches(rng: random.Random) -> Drawn:
    """Messages of a sensor are kept back and handed over together, the newest scan or frame of them."""
    field, every = rng.choice(SENSORS), rng.randint(2, 12)

    def change(observation: Observation, memory: Memory) -> Observation:
        value = getattr(observation, field)
        waiting: Any = memory.kept.get("waiting", () if isinstance(value, tuple) else None)
        waiting = waiting + value if isinstance(value, tuple) else (value or waiting)
        if memory.tick % every:
            memory.kept["waiting"] = waiting
            return replace(observation, **{field: () if isinstance(value, tuple) else None})
        memory.kept["waiting"] = () if isinstance(value, tuple) else None
        return replace(observation, **{field: waiting})

    return f"{field} in batches by {every} ticks, always", Fault("batches", "time", sees=change)


def _thinned(rng: random.Random) -> Drawn:
    field, every = rng.choice(SENSORS), rng.randint(2, 8)
    count: Callable[[Memory], int] = lambda m: int(m.kept.get("count", 0))  # type: ignore[call-overload] # noqa: E731

    def change(observation: Observation, memory: Memory) -> Observation:
        value = getattr(observation, field)
        if not value:
            return observation
        memory.kept["count"] = count(memory) + 1
        if count(memory) % every == 0:
            return observation
        return replace(observation, **{field: () if isinstance(value, tuple) else None})

    return f"{field}: one of {every} deliveries, always", Fault("thinned", "time", sees=change)


def _twice(rng: random.Random) -> Drawn:
    field = rng.choice(SENSORS)

    def change(observation: Observation, memory: Memory) -> Observation:
        value = getattr(observation, field)
        if isinstance(value, tuple):
            return replace(observation, **{field: value + value})
        last: Any = memory.kept.get("last")
        memory.kept["last"] = value or last
        return observation if value is not None else replace(observation, **{field: last})

    return _fault(f"{field} delivered twice", "time", rng, change)


def _arrival(rng: random.Random) -> Drawn:
    """Stamps are those of the arrival instead of the measurement."""
    fields = rng.sample(SENSORS, rng.randint(1, 2))

    def change(observation: Observation, memory: Memory) -> Observation:
        new: dict[str, Any] = {}
        for field in fields:
            value = getattr(observation, field)
            stamp = lambda one: replace(one, t=observation.t)  # noqa: E731
            new[field] = tuple(map(stamp, value)) if isinstance(value, tuple) else value and stamp(value)
        return replace(observation, **new)

    return _fault(f"{', '.join(fields)} stamped at arrival", "time", rng, change)


def _ego_clock(rng: random.Random) -> Drawn:
    """The clock of the stack's computer is off, or jumps by so much at a time."""
    off, start = rng.choice([-1.0, 1.0]) * rng.uniform(0.03, 0.4), rng.choice([0, rng.randint(40, 200)])

    def change(observation: Observation, memory: Memory) -> Observation:
        return replace(observation, t=observation.t + off) if memory.tick >= start else observation

    return f"clock of the stack off by {off:.2f} s from {start * TICK:.1f} s on", Fault("clock", "time", sees=change)


def _backwards(rng: random.Random) -> Drawn:
    field, back, every = rng.choice(("gnss", "odometry", "imu")), rng.uniform(0.02, 0.3), rng.randint(5, 60)

    def change(observation: Observation, memory: Memory) -> Observation:
        if memory.tick % every:
            return observation
        return replace(observation, **{field: tuple(replace(m, t=m.t - back) for m in getattr(observation, field))})

    return f"{field} stamps back by {back:.2f} s every {every} ticks", Fault("backwards", "time", sees=change)


# map and task ---------------------------------------------------------------------------------------------------------


def _on_map(told: str, maps: Mapped) -> Drawn:
    return told, Fault(told.split(" by ")[0], "map", maps=maps)


def _without_light(rng: random.Random) -> Drawn:
    share, noise = rng.uniform(0.3, 1.0), rng.randint(0, 2**31)

    def maps(network: Any) -> ChangedMap:
        draw = random.Random(noise)
        return ChangedMap(network, signals=tuple(s for s in network.signals if draw.random() > share))

    return _on_map(f"lights missing by {share:.2f}", maps)


def _crosswalk_lost(rng: random.Random) -> Drawn:
    return _on_map("no crosswalks", lambda network: ChangedMap(network, crosswalks=()))


def _offset_map(rng: random.Random) -> Drawn:
    """The map lies elsewhere than the positioning says: another datum."""
    dx, dy = rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)

    def maps(network: Any) -> ChangedMap:
        def centreline(route: Any, step: float = 0.5) -> Any:
            line = np.array(network.centreline(route, step))
            line[:, 0] += dx
            line[:, 1] += dy
            return line

        return ChangedMap(network, centreline=centreline)

    return _on_map(f"centre lines elsewhere by {dx:.2f}, {dy:.2f} m", maps)


def _corner_cut(rng: random.Random) -> Drawn:
    """Centre lines are smoothed over so many points, which cuts bends."""
    wide = rng.randint(8, 60)

    def maps(network: Any) -> ChangedMap:
        def centreline(route: Any, step: float = 0.5) -> Any:
            line = np.array(network.centreline(route, step))
            n = min(wide, len(line) // 3)
            if n < 2:
                return line
            kernel = np.ones(n) / n
            for column in (0, 1):
                padded = np.pad(line[:, column], (n // 2, n - 1 - n // 2), mode="reflect", reflect_type="odd")
                line[:, column] = np.convolve(padded, kernel, mode="valid")
            return line

        return ChangedMap(network, centreline=centreline)

    return _on_map(f"centre lines smoothed by {wide} points", maps)


def _slow_task(rng: random.Random) -> Drawn:
    late = rng.randint(5, 80)

    def sees(observation: Observation, memory: Memory) -> Observation:
        if observation.task is not None:
            memory.kept["task"], memory.kept["due"] = observation.task, memory.tick + late
        due: Any = memory.kept["task"] if memory.kept.get("due") == memory.tick else None
        return replace(observation, task=due)

    return f"task late by {late * TICK:.1f} s", Fault("late task", "map", sees=sees)


FAMILIES: tuple[tuple[Callable[[random.Random], Drawn], ...], ...] = (
    (_lever, _multipath, _proud, _tyres, _gyro_bias, _imu_mount),
    (_fog, _near_blind, _mirrored, _lifted, _rain, _flipped, _pixels, _grown, _pedestrians, _lights_swapped),
    (_late_brake, _drag, _dead_pedals, _shimmy, _stuck_wheel, _lock_to_lock, _lossy),
    (_batches, _thinned, _twice, _arrival, _ego_clock, _backwards),
    (_without_light, _crosswalk_lost, _offset_map, _corner_cut, _slow_task),
)
