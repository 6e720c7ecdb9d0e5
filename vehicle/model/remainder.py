"""What a twin is known not to explain: the table [remainder] of a model file, by channel and driving regime.

    [remainder]
    yaw_rate.turn_in = 0.012  # rad/s
    ax.braking = 0.21  # m/s^2

Each number is the root mean square of measured - model beyond the sensor noise, in the channel's unit, on the logs that
the twin was extended on and judged by. It is not an error bound: another drive may leave more.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from types import MappingProxyType
from typing import Any, TypeAlias

from vehicle.model.errors import ModelError, nearest_name

CHANNEL_UNITS: Mapping[str, str] = MappingProxyType({
    "x": "m", "y": "m", "yaw": "rad", "v": "m/s", "yaw_rate": "rad/s", "ax": "m/s^2", "ay": "m/s^2", "steer": "rad",
})  # fmt: skip
"""Channels that a comparison judges, with their units."""

REGIME_NAMES = ("launch", "cruise", "lift_off", "braking", "standstill", "turn_in", "steady_turn", "reverse")
"""Driving regimes that a comparison tells apart."""

Remainder: TypeAlias = Mapping[str, Mapping[str, float]]
"""channel -> regime -> root mean square beyond the noise, in the channel's unit, 0 or more."""


def read_remainder(
    table: Mapping[str, Any], units: Mapping[str, str] = CHANNEL_UNITS, what: str = "channel"
) -> Remainder:
    """The checked table of a model file. units: the names that it may have, with their units; what: what these are.
    Raises ModelError whose key is the path inside the table."""
    found: dict[str, dict[str, float]] = {}
    for channel, regimes in table.items():
        _known(channel, channel, tuple(units), what)
        if not isinstance(regimes, Mapping):
            raise ModelError("must be a table of driving regimes", key=channel, found=repr(regimes))
        for regime, value in regimes.items():
            where = f"{channel}.{regime}"
            _known(regime, where, REGIME_NAMES, "driving regime")
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise ModelError("must be a number", key=where, found=repr(value))
            if not (isfinite(value) and value >= 0.0):
                allowed = f"0 {units[channel]} or more"
                raise ModelError("value not allowed", key=where, found=f"{value:g}", allowed=allowed)
            found.setdefault(channel, {})[regime] = float(value)
    return found


def remainder_text(remainder: Remainder) -> str:
    """The table of a model file, empty if there is nothing to say."""
    lines = [
        f"{channel}.{regime} = {value!r}  # {CHANNEL_UNITS[channel]}"
        for channel in CHANNEL_UNITS
        for regime, value in ordered(remainder.get(channel, {}))
    ]
    head = ["# What this twin is known not to explain: root mean square beyond the noise", "[remainder]"]
    return "\n".join([*head, *lines]) + "\n" if lines else ""


def ordered(regimes: Mapping[str, float]) -> list[tuple[str, float]]:
    """Regimes in the order of REGIME_NAMES."""
    return [(name, regimes[name]) for name in REGIME_NAMES if name in regimes]


def _known(name: str, where: str, known: tuple[str, ...], what: str) -> None:
    if name not in known:
        near = nearest_name(name, known)
        raise ModelError(f"unknown {what}", key=where, found=name, allowed=", ".join(known), nearest=near)
