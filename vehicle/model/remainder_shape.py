"""How the known remainder of a twin repeats itself in time, and which values of effects it imitates.

    [remainder.memory]
    yaw_rate = 0.16  # s
    [remainder.imitates]
    drive_gain.g = 0.0052  # -

Memory is the time after which two samples of the remainder are alike to 1/e only. What is imitated is the root mean
square of the values (as differences from the true ones) that a diagnosis would find for an effect on the drives from
which the twin was learnt, on which nothing is hidden; in the unit of the key.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from vehicle.model.errors import ModelError, nearest_name
from vehicle.model.remainder import CHANNEL_UNITS

TABLES = ("memory", "imitates")


@dataclass(frozen=True, slots=True)
class RemainderShape:
    """memory: channel -> s, more than 0. imitates: effect -> key -> value in the unit of the key, 0 or more."""

    memory: Mapping[str, float] = field(default_factory=dict)
    imitates: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def read_shape(table: Mapping[str, Any]) -> RemainderShape:
    """The checked tables of a model file below [remainder]. Raises ModelError whose key is the path inside."""
    memory: dict[str, float] = {}
    for channel, value in _table(table, "memory").items():
        where = f"memory.{channel}"
        if channel not in CHANNEL_UNITS:
            raise ModelError("unknown channel", key=where, found=channel, allowed=", ".join(CHANNEL_UNITS),
                             nearest=nearest_name(channel, tuple(CHANNEL_UNITS)))  # fmt: skip
        memory[channel] = _number(value, where)
        if memory[channel] == 0.0:
            raise ModelError("value not allowed", key=where, found="0", allowed="more than 0 s")
    imitates: dict[str, dict[str, float]] = {}
    for effect, keys in _table(table, "imitates").items():
        if not isinstance(keys, Mapping):
            raise ModelError("must be a table of the effect's keys", key=f"imitates.{effect}", found=repr(keys))
        imitates[effect] = {key: _number(value, f"imitates.{effect}.{key}") for key, value in keys.items()}
    return RemainderShape(memory, imitates)


def shape_text(shape: RemainderShape) -> str:
    """The tables of a model file, empty if there is nothing to say."""
    lines = []
    if shape.memory:
        lines += ["[remainder.memory]", *(f"{c} = {value!r}  # s" for c, value in shape.memory.items())]
    if shape.imitates:
        lines += ["[remainder.imitates]"]
        lines += [f"{e}.{key} = {value!r}" for e, keys in shape.imitates.items() for key, value in keys.items()]
    return "\n".join(lines) + "\n" if lines else ""


def _table(table: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = table.get(name, {})
    if not isinstance(found, Mapping):
        raise ModelError(f"must be a table [remainder.{name}]", key=name, found=repr(found))
    return found


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ModelError("must be a number", key=where, found=repr(value))
    if not (isfinite(value) and value >= 0.0):
        raise ModelError("value not allowed", key=where, found=f"{value:g}", allowed="0 or more")
    return float(value)
