"""Faults made after the gates stood: kinds, places and severities are drawn; none of them was looked at before.

A fault is drawn from five families in equal parts: observations, commands, the map and the route, time stamps, and the
source of the reference stack. `scripts/fault_drives.py` drives them.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.mutation.fault import Fault, Mapped, Memory, Seen, Sent
from pytest_dvp.mutation.map_faults import ChangedMap
from pytest_dvp.mutation.source_mutants import mutants_of
from scripts.fresh_observations import drawn_observation, drawn_when
from vehicle.messages import Observation

replace = msgspec.structs.replace
FAMILIES = ("observation", "command", "map", "time", "source")  # of the last: see `of_the_source`


def modules() -> list[str]:
    """Modules of the reference stack whose source is changed: all of them that run in every drive."""
    root = Path(__file__).parents[1]
    every = [file.relative_to(root).with_suffix("") for file in sorted((root / "ads").rglob("*.py"))]
    return [".".join(file.parts) for file in every if file.stem not in ("__init__", "drawn", "onnx_detector")]


def generated(seed: str, count: int) -> list[tuple[str, Fault]]:
    """Description and fault of each, the same for the same seed."""
    rng = random.Random(int(seed, 16))
    return [FAMILY[FAMILIES[k % len(FAMILIES)]](rng) for k in range(count)]


def of_the_source(seed: str, count: int) -> list[tuple[str, Fault]]:
    """As `generated`, of the source alone: the other families then do not depend on what of it can be changed."""
    rng = random.Random(f"{seed} source")
    return [_source(rng) for _ in range(count)]


# commands -------------------------------------------------------------------------------------------------------------


def _sends(when: Callable[[Memory], bool], change: Sent) -> Sent:
    return lambda command, memory: change(command, memory) if when(memory) else command


def _command(rng: random.Random) -> tuple[str, Fault]:
    kind = rng.choice(
        ["steer gain", "steer noise", "steer lag", "backlash", "rate", "pedals", "weak brake", "hold", "bias"]
    )
    size, noise = rng.random(), rng.randint(0, 2**31)

    def sends(command: Any, memory: Memory) -> Any:
        old = memory.kept.get("sent", command)
        draw = random.Random(noise + memory.tick)
        if kind == "steer gain":
            new = replace(command, steer=command.steer * (0.5 + size if size < 0.4 else 0.7 + size))
        elif kind == "steer noise":
            new = replace(command, steer=command.steer + draw.gauss(0.0, 0.005 + 0.04 * size))
        elif kind == "steer lag":
            share = 0.05 + 0.35 * size
            new = replace(command, steer=old.steer + share * (command.steer - old.steer))  # type: ignore[attr-defined]
        elif kind == "backlash":
            dead = 0.005 + 0.04 * size
            moved = abs(command.steer - old.steer) > dead  # type: ignore[attr-defined]
            new = command if moved else replace(command, steer=old.steer)  # type: ignore[attr-defined]
        elif kind == "rate":
            most = 0.002 + 0.012 * size
            change = min(max(command.steer - old.steer, -most), most)  # type: ignore[attr-defined]
            new = replace(command, steer=old.steer + change)  # type: ignore[attr-defined]
        elif kind == "pedals":
            gain = 0.4 + 0.4 * size if size < 0.5 else 1.2 + size
            new = replace(command, throttle=min(gain * command.throttle, 1.0), accel=gain * command.accel)
        elif kind == "weak brake":
            most = 0.1 + 0.4 * size
            new = replace(command, brake=min(command.brake, most), accel=max(command.accel, -7.0 * most))
        elif kind == "hold":
            every = 2 + int(10 * size)
            new = command if memory.tick % every == 0 else replace(old, t=command.t)  # type: ignore[type-var]
        else:
            new = replace(command, steer=command.steer + (size - 0.5) * 0.06)
        memory.kept["sent"] = new
        return new

    at, when = drawn_when(rng)
    return f"command: {kind} {size:.2f}, {at}", Fault(kind, "command", sends=_sends(when, sends))


# the map and the route ------------------------------------------------------------------------------------------------


def _map(rng: random.Random) -> tuple[str, Fault]:
    kind = rng.choice(["bent", "moved", "turned", "lights", "crosswalks", "widths", "goal", "set speed", "task again"])
    size, sign = rng.random(), rng.choice([-1.0, 1.0])
    maps: Mapped | None = None
    sees: Seen | None = None
    if kind in ("bent", "moved", "turned"):
        maps = _lines(kind, size, sign)
    elif kind == "lights":
        maps = _moved_things("signals", lambda one: replace(one, s=one.s + sign * (2.0 + 18.0 * size)))
    elif kind == "crosswalks":
        far = sign * (2.0 + 18.0 * size)
        maps = _moved_things(
            "crosswalks",
            lambda c: c._replace(s=c.s + far, s_from=c.s_from + far, s_to=c.s_to + far),
        )
    elif kind == "widths":
        gain = 0.5 + 0.4 * size if sign < 0 else 1.2 + size

        def maps(network: Any) -> ChangedMap:
            return ChangedMap(network, lane_width=lambda *where: gain * network.lane_width(*where))

    elif kind == "goal":
        sees = _task(lambda task: task if task.goal is None else replace(
            task, goal=task.goal._replace(s=max(task.goal.s + sign * (1.5 + 8.0 * size), 0.0))))  # fmt: skip
    elif kind == "set speed":
        gain = 0.7 + 0.2 * size if sign < 0 else 1.1 + 0.3 * size
        sees = _task(lambda task: task if task.set_speed is None else replace(task, set_speed=gain * task.set_speed))
    else:
        every = 40 + int(160 * size)

        def sees(observation: Observation, memory: Memory) -> Observation:
            task = observation.task or memory.kept.get("task")
            memory.kept["task"] = task
            return replace(observation, task=task) if memory.tick % every == 0 else observation

    return f"map: {kind} {sign * size:+.2f}", Fault(kind, "map", maps=maps, sees=sees)


def _lines(kind: str, size: float, sign: float) -> Mapped:
    """Centre lines that wave beside the lane, lie beside it, or are turned about their start."""

    def maps(network: Any) -> ChangedMap:
        def centreline(route: Any, step: float = 0.5) -> Any:
            line = np.array(network.centreline(route, step))
            s = step * np.arange(len(line))
            off = sign * {
                "bent": (0.2 + 0.6 * size) * np.sin(2.0 * np.pi * s / 40.0),
                "moved": np.full(len(s), 0.15 + 0.7 * size),
                "turned": (0.002 + 0.01 * size) * s,
            }[kind]  # fmt: skip
            line[:, 0] -= off * np.sin(line[:, 2])
            line[:, 1] += off * np.cos(line[:, 2])
            return line

        return ChangedMap(network, centreline=centreline)

    return maps


def _moved_things(name: str, change: Callable[[Any], Any]) -> Mapped:
    return lambda network: ChangedMap(network, **{name: tuple(change(one) for one in getattr(network, name))})


def _task(change: Callable[[Any], Any]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        return observation if observation.task is None else replace(observation, task=change(observation.task))

    return sees


# time stamps ----------------------------------------------------------------------------------------------------------

_STAMPED = ("gnss", "odometry", "imu", "lidar", "camera")


def _time(rng: random.Random) -> tuple[str, Fault]:
    kind = rng.choice(["shift", "jitter", "drift", "rounded", "late", "frozen", "reordered", "age"])
    fields = rng.sample(_STAMPED, rng.randint(1, 3))
    size, sign, noise = rng.random(), rng.choice([-1.0, 1.0]), rng.randint(0, 2**31)
    late = 1 + int(9 * size)

    def stamp(t: float, memory: Memory) -> float:
        if kind == "shift":
            return t + sign * (0.04 + 0.4 * size)
        if kind == "jitter":
            return t + random.Random(noise + memory.tick).gauss(0.0, 0.02 + 0.15 * size)
        if kind == "drift":
            return t * (1.0 + sign * (0.001 + 0.02 * size))
        step = 0.1 + 0.4 * size
        return step * math.floor(t / step)

    def sees(observation: Observation, memory: Memory) -> Observation:
        past = list(memory.observations)
        if kind == "age":
            return observation
        if kind in ("late", "reordered"):
            swap = kind == "late" or memory.tick % (late + 2) == 0
            old = past[-1 - late] if len(past) > late and swap else observation
            return replace(observation, **{field: getattr(old, field) for field in fields})
        if kind == "frozen":
            kept = memory.kept.setdefault("at", observation) if memory.tick >= 60 + 40 * size else observation
            stuck = 0 < memory.tick - (60 + 40 * size) < 40 + 100 * size
            return replace(observation, **{f: getattr(kept, f) for f in fields}) if stuck else observation

        def one(message: Any) -> Any:
            return None if message is None else replace(message, t=stamp(message.t, memory))

        new = {}
        for field in fields:
            value = getattr(observation, field)
            new[field] = tuple(map(one, value)) if isinstance(value, tuple) else one(value)
        return replace(observation, **new)

    def sends(command: Any, memory: Memory) -> Any:
        return replace(command, t=command.t - (0.02 + 0.2 * size)) if kind == "age" else command

    told = "commands" if kind == "age" else ", ".join(fields)
    return f"stamps of {told}: {kind} {sign * size:+.2f}", Fault(kind, "time", sees=sees, sends=sends)


def _source(rng: random.Random) -> tuple[str, Fault]:
    mutant = rng.choice(mutants_of(rng.choice([m for m in modules() if mutants_of(m)])))
    return mutant.name, Fault(mutant.name, "source")


FAMILY: dict[str, Callable[[random.Random], tuple[str, Fault]]] = {
    "observation": drawn_observation, "command": _command, "map": _map, "time": _time, "source": _source,
}  # fmt: skip
