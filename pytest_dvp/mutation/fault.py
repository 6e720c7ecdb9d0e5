"""A fault: what becomes of an observation on its way to the stack, or of a command on its way to the car."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable
from typing import Any, Literal, TypeAlias

from vehicle.messages import Command, Observation

Where: TypeAlias = Literal["observation", "command", "time", "task", "map", "source"]
Seen: TypeAlias = Callable[[Observation, "Memory"], Observation]
Mapped: TypeAlias = Callable[[Any], Any]
Sent: TypeAlias = Callable[[Command, "Memory"], Command]


@dataclasses.dataclass
class Memory:
    """What a fault keeps from tick to tick: messages seen, commands sent (the last 64), how many ticks there were, and
    fields that are frozen; messages: how many of the field that a fault counts."""

    observations: deque[Observation] = dataclasses.field(default_factory=lambda: deque(maxlen=64))
    commands: deque[Command] = dataclasses.field(default_factory=lambda: deque(maxlen=64))
    tick: int = 0
    kept: dict[str, object] = dataclasses.field(default_factory=dict)
    messages: int = 0


@dataclasses.dataclass(frozen=True)
class Fault:
    """One fault. sees: what it does to an observation; sends: to a command; maps: to the map that the stack is made
    with; asks: what a scenario needs for it to matter (`needs.py`); of: the sensors that it changes, by the names of
    `Observation`: a stack that reads none of them does not notice."""

    name: str
    where: Where
    sees: Seen | None = None
    sends: Sent | None = None
    asks: str = ""
    maps: Mapped | None = None
    of: tuple[str, ...] = ()


def unchanged(observation: Observation, memory: Memory) -> Observation:
    """No fault of the observation."""
    return observation
