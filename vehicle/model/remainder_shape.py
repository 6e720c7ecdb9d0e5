"""How the known remainder of a twin repeats itself in time, and which values of effects it imitates.

    [remainder.memory]
    yaw_rate = 0.16  # s
    [remainder.anew]
    ax = 2.2  # chi^2/N
    [remainder.imitates]
    drive_gain.g = 0.0052  # -
    [remainder.limits]
    jerk_limit.limit = 13.0  # m/s^3
    [remainder.unseen]
    power_limit.limit = 17.2  # W/kg
    [remainder.wanders]
    along.cruise = 0.025  # m
    [remainder.sensors]
    heading_bias.b = 0.0005  # rad
    [remainder.road]
    slopes = 0.06  # m/s^2

All of it is measured on the drives from which the twin was learnt, on which nothing is hidden. Memory is the time after
which two samples of the remainder are alike to 1/e only. Anew is what level and memory do not foresee of the remainder,
where it is more than the noise. What is imitated is the root mean square of the values (as differences from the true
ones) that a diagnosis would find for an effect. Limits are the lowest that it would find of what has no limit, if no
other of these drives refutes them. Unseen are limits that none of these drives would have noticed, down to the value: a
power that was never asked for. What wanders is the error of position and heading beside dead reckoning, root mean
square of a step of one second: how well the car's own sensors agree. Sensors are values of their effects that this
imitates. The road has slopes of this spread (gravity along it), which differ along a drive and are no error of the
twin; 0: all roads were flat; where nothing is told, a log may tell.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from types import MappingProxyType
from typing import Any

from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import WHERE, catalogue
from vehicle.model.errors import ModelError, is_misspelt, nearest_name
from vehicle.model.remainder import CHANNEL_UNITS, Remainder, ordered, read_remainder

STEEPEST = 5.0  # m/s^2, half of gravity: no car goes up that
TABLES = ("memory", "anew", "imitates", "limits", "unseen", "wanders", "sensors", "road")

WANDERING: Mapping[str, str] = MappingProxyType({"along": "m", "across": "m", "yaw": "rad"})
"""What wanders beside dead reckoning, and in what its step of one second is told: position along and across the car,
and heading."""


@dataclass(frozen=True, slots=True)
class RemainderShape:
    """memory: channel -> s, more than 0. anew: channel -> chi^2/N, 1 where it is not told. imitates, sensors: effect ->
    key -> value in the unit of the key, 0 or more. limits, unseen: effect -> key -> value in the unit of the key, more
    than 0. wanders: name of WANDERING -> driving regime -> m or rad. slopes: m/s^2, 0 to STEEPEST, None if not told."""

    memory: Mapping[str, float] = field(default_factory=dict)
    imitates: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    anew: Mapping[str, float] = field(default_factory=dict)
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    unseen: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    wanders: Remainder = field(default_factory=dict)
    sensors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    slopes: float | None = None


def channels_of(table: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a model file's [remainder] that is told by channel. Raises ModelError, with the name as its key, on a
    name that is neither a channel nor one of TABLES."""
    names = (*CHANNEL_UNITS, *TABLES)
    for name in table:
        if name not in names:
            raise ModelError("unknown channel or table", key=name, found=name, allowed=", ".join(names),
                             nearest=nearest_name(name, names))  # fmt: skip
    return {name: value for name, value in table.items() if name not in TABLES}


def read_shape(table: Mapping[str, Any], extra: Mapping[str, Effect] | None = None) -> RemainderShape:
    """The checked tables of a model file below [remainder]; extra: a user's own effects. Raises ModelError whose key is
    the path inside. An effect that is not known and looks like none is kept: a twin may have learnt beside effects that
    are not loaded now."""
    known = {**catalogue(), **(extra or {})}
    return RemainderShape(
        memory=_by_channel(table, "memory", "s"),
        anew=_by_channel(table, "anew", "chi^2/N"),
        imitates=_by_effect(table, "imitates", known),
        limits=_by_effect(table, "limits", known, more_than_0=True),
        unseen=_by_effect(table, "unseen", known, more_than_0=True),
        wanders=_wanders(table),
        sensors=_by_effect(table, "sensors", known),
        slopes=_slopes(table),
    )


def _by_channel(table: Mapping[str, Any], name: str, unit: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for channel, value in _table(table, name).items():
        where = f"{name}.{channel}"
        if channel not in CHANNEL_UNITS:
            raise ModelError("unknown channel", key=where, found=channel, allowed=", ".join(CHANNEL_UNITS),
                             nearest=nearest_name(channel, tuple(CHANNEL_UNITS)))  # fmt: skip
        found[channel] = _more_than_0(_number(value, where), where, f" {unit}")
    return found


def _by_effect(
    table: Mapping[str, Any], name: str, known: Mapping[str, Effect], *, more_than_0: bool = False
) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for effect, keys in _table(table, name).items():
        near = "" if effect in known else nearest_name(effect, tuple(known))
        if near and is_misspelt(effect, near):
            raise ModelError("unknown effect", key=f"{name}.{effect}", found=effect, allowed=WHERE, nearest=near)
        if not isinstance(keys, Mapping):
            raise ModelError("must be a table of the effect's keys", key=f"{name}.{effect}", found=repr(keys))
        allowed = [key.name for key in known[effect].parameters] if effect in known else [*keys]
        for key in keys:
            if key not in allowed:
                raise ModelError("unknown key", key=f"{name}.{effect}.{key}", found=key, allowed=", ".join(allowed),
                                 nearest=nearest_name(key, allowed))  # fmt: skip
        found[effect] = {key: _number(value, f"{name}.{effect}.{key}") for key, value in keys.items()}
        for key, value in found[effect].items() if more_than_0 else ():
            _more_than_0(value, f"{name}.{effect}.{key}")
    return found


def _wanders(table: Mapping[str, Any]) -> Remainder:
    told = _table(table, "wanders")
    try:
        return read_remainder(told, WANDERING, "direction")
    except ModelError as error:
        raise error.at("", None, f"wanders.{error.key}") from error


def _slopes(table: Mapping[str, Any]) -> float | None:
    told = _table(table, "road")
    for key in told:
        if key != "slopes":
            raise ModelError("unknown key", key=f"road.{key}", found=key, allowed="slopes",
                             nearest=nearest_name(key, ("slopes",)))  # fmt: skip
    if not told:
        return None
    value = _number(told["slopes"], "road.slopes")
    if value > STEEPEST:
        raise ModelError("value not allowed", key="road.slopes", found=f"{value:g}", allowed=f"0 to {STEEPEST:g} m/s^2")
    return value


def _more_than_0(value: float, where: str, unit: str = "") -> float:
    if value == 0.0:
        raise ModelError("value not allowed", key=where, found="0", allowed=f"more than 0{unit}")
    return value


def shape_text(shape: RemainderShape) -> str:
    """The tables of a model file, empty if there is nothing to say."""
    lines = []
    if shape.memory:
        lines += ["[remainder.memory]", *(f"{c} = {value!r}  # s" for c, value in shape.memory.items())]
    if shape.anew:
        lines += ["[remainder.anew]", *(f"{c} = {value!r}  # chi^2/N" for c, value in shape.anew.items())]
    for name, effects in (("imitates", shape.imitates), ("limits", shape.limits), ("unseen", shape.unseen)):
        if effects:
            lines += [f"[remainder.{name}]"]
            lines += [f"{e}.{key} = {value!r}" for e, keys in effects.items() for key, value in keys.items()]
    if shape.sensors:
        lines += ["[remainder.sensors]"]
        lines += [f"{e}.{key} = {value!r}" for e, keys in shape.sensors.items() for key, value in keys.items()]
    if shape.wanders:
        lines += ["[remainder.wanders]"]
        lines += [
            f"{name}.{regime} = {value!r}  # {unit}"
            for name, unit in WANDERING.items()
            for regime, value in ordered(shape.wanders.get(name, {}))
        ]
    if shape.slopes is not None:
        lines += ["[remainder.road]", f"slopes = {shape.slopes!r}  # m/s^2"]
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
