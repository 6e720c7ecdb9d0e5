"""Faults of the map and the route: the map that a stack is made with, changed on its way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.mutation.fault import Fault, Mapped, Memory, Seen
from pytest_dvp.mutation.needs import CROSSWALK, GOAL, LIGHT, PASSED, ROUTE
from vehicle.messages import Observation

SHIFT = 0.5  # m to the left
LATE = 40  # ticks, 2 s


class ChangedMap:
    """The map `inner` with some of its attributes others; all else is its own."""

    def __init__(self, inner: Any, **others: Any) -> None:
        self._inner, self._others = inner, others

    def __getattr__(self, name: str) -> Any:
        return self._others[name] if name in self._others else getattr(self._inner, name)


def _things(name: str, change: Callable[[Any], Any]) -> Mapped:
    """Each crosswalk or signal changed; None leaves it out."""

    def maps(network: Any) -> ChangedMap:
        changed = (change(thing) for thing in getattr(network, name))
        return ChangedMap(network, **{name: tuple(thing for thing in changed if thing is not None)})

    return maps


def _shifted(network: Any) -> ChangedMap:
    """Lanes that lie SHIFT to the left of where they are."""

    def lane_pose(road: str, lane: int, s: float, offset: float = 0.0) -> Any:
        sign = 1.0 if network.driving_sign(road, lane, s) > 0 else -1.0
        return network.lane_pose(road, lane, s, offset + sign * SHIFT)

    def centreline(route: Any, step: float = 0.5) -> Any:
        line = np.array(network.centreline(route, step))
        line[:, 0] -= SHIFT * np.sin(line[:, 2])
        line[:, 1] += SHIFT * np.cos(line[:, 2])
        return line

    return ChangedMap(network, lane_pose=lane_pose, centreline=centreline)


def _narrow(network: Any) -> ChangedMap:
    return ChangedMap(network, lane_width=lambda *where: 0.7 * network.lane_width(*where))


def _task(change: Callable[[Any], Any]) -> Seen:
    def sees(observation: Observation, memory: Memory) -> Observation:
        task = observation.task
        return observation if task is None else msgspec.structs.replace(observation, task=change(task))

    return sees


def _goal(ds: float) -> Callable[[Any], Any]:
    def change(task: Any) -> Any:
        if task.goal is None:
            return task
        return msgspec.structs.replace(task, goal=task.goal._replace(s=max(task.goal.s + ds, 0.0)))

    return change


def _late(observation: Observation, memory: Memory) -> Observation:
    """The task comes LATE ticks after it was given."""
    if observation.task is not None:
        memory.kept["given at"], memory.kept["task"] = memory.tick, observation.task
    task: Any = memory.kept["task"] if memory.kept.get("given at") == memory.tick - LATE else None
    return msgspec.structs.replace(observation, task=task)


def _moved_light(signal: Any) -> Any:
    return msgspec.structs.replace(signal, s=signal.s + 5.0)


def _moved_crosswalk(crosswalk: Any) -> Any:
    outline = np.array(crosswalk.outline)
    return crosswalk._replace(
        s=crosswalk.s + 5.0, s_from=crosswalk.s_from + 5.0, s_to=crosswalk.s_to + 5.0, outline=outline
    )


MAP_FAULTS: tuple[Fault, ...] = (
    Fault("map_without_lights", "map", maps=_things("signals", lambda s: None), asks=LIGHT),
    Fault("map_lights_5m_late", "map", maps=_things("signals", _moved_light), asks=LIGHT),
    Fault("map_without_crosswalks", "map", maps=_things("crosswalks", lambda c: None), asks=CROSSWALK),
    Fault("map_crosswalks_5m_late", "map", maps=_things("crosswalks", _moved_crosswalk), asks=CROSSWALK),
    Fault("map_lanes_half_m_left", "map", maps=_shifted),
    Fault("map_lanes_70_percent_wide", "map", maps=_narrow, asks=PASSED),
    Fault("task_goal_5m_short", "task", sees=_task(_goal(-5.0)), asks=GOAL),
    Fault("task_without_route", "task", sees=_task(lambda t: msgspec.structs.replace(t, route=())), asks=ROUTE),
    Fault("task_2s_late", "task", sees=_late),
)
"""In the order of the report."""
