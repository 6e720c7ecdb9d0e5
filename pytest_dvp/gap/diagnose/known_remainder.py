"""What a twin is known not to explain: measured when it is extended, and expected again when it is diagnosed.

A twin of a real car never reaches the noise of the sensors. Asked again when nothing new is wrong, a diagnosis would
try to explain the old remainder with fragments of effects. So a channel's noise is taken together with the remainder
that the model file states for the regimes in which this log drives: what is no larger is nothing new.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from pytest_dvp.gap.compare.regimes import REGIMES, regimes
from pytest_dvp.gap.compare.segments import CHANNELS, filled
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.remainder import Remainder

MARGIN = 1.5  # of the remainder that is expected: another drive of the same car may leave that much more; a new effect
# below it is not seen
LEAST = 0.1  # of the noise's square: a smaller remainder is none, for the noise itself is known to some per cent only;
# with 0.3, as MISFIT of the search, a drive with better sensors showed a remainder that the file did not tell
FEWEST = 100  # samples of a regime, from which its remainder is taken
_DIGITS = 3  # of a remainder in the model file: it is known to some per cent
_POSITION = ("x", "y")


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Left:
    """What a model leaves of one log: measured (n, 8), rest (n, 8) measured - model (NaN: not compared), noise (8,) in
    the channels' units, and the channels that are judged."""

    log: Log
    measured: FloatArray
    rest: FloatArray
    noise: FloatArray
    channels: Sequence[str]


def regimes_of(log: Log, measured: FloatArray) -> dict[str, BoolArray]:
    """Masks (n,) of the driving regimes of a log whose channels are measured (n, 8), in channel units."""
    whole = filled(log.t, measured)
    v, rate = np.ascontiguousarray(whole[:, 3]), np.ascontiguousarray(whole[:, 4])
    return regimes(log.t, v, rate, log.columns.get("accel_cmd"))


def expected(remainder: Remainder, log: Log, measured: FloatArray) -> FloatArray:
    """Root mean square (8,) by channel that the known remainder leaves on this log, in the channels' units.

    Each sample counts with the largest remainder of the regimes that it is in; a regime that the model file does not
    name leaves nothing.
    """
    if not remainder:
        return np.zeros(len(CHANNELS))
    return np.asarray(np.sqrt(np.mean(by_row(remainder, CHANNELS, regimes_of(log, measured)) ** 2, axis=0)))


def by_row(told: Remainder, names: Sequence[str], masks: Mapping[str, BoolArray]) -> FloatArray:
    """What a model file tells by name and regime, as (n, len(names)) by row: the largest of the regimes that hold, 0
    where none is told. masks: (n,) by regime."""
    found = np.zeros((len(next(iter(masks.values()))), len(names)))
    for name, by_regime in told.items():
        k = names.index(name)
        for regime, value in by_regime.items():
            found[:, k] = np.where(masks[regime], np.maximum(found[:, k], value), found[:, k])
    return found


def measured_remainder(groups: Iterable[Sequence[Left]]) -> Remainder:
    """The remainder of a model on groups of logs (those fitted on, those held out).

    Of each channel and regime the largest root mean square beyond the noise that one of the groups shows; x and y are
    one channel, for another drive turns the map.
    """
    return largest(map(_of_group, groups), CHANNELS)


def largest(groups: Iterable[Mapping[tuple[str, str], float]], names: Iterable[str]) -> Remainder:
    """The largest value of the groups by name and regime, in the order of `names` and REGIMES. groups: (name, regime)
    -> value."""
    found: dict[tuple[str, str], float] = {}
    for group in groups:
        for key, value in group.items():
            found[key] = max(found.get(key, 0.0), value)
    told = {name: {regime: found[name, regime] for regime in REGIMES if (name, regime) in found} for name in names}
    return {name: by_regime for name, by_regime in told.items() if by_regime}


def _of_group(group: Sequence[Left]) -> dict[tuple[str, str], float]:
    sums: dict[tuple[str, str], list[float]] = {}
    for left in group:
        masks = regimes_of(left.log, left.measured)
        for channel in left.channels:
            k = CHANNELS.index(channel)
            rest, noise = left.rest[:, k], float(left.noise[k])
            known = np.isfinite(rest)
            for regime, mask in masks.items():
                inside = rest[known & mask]
                pair = sums.setdefault((_POSITION[0] if channel in _POSITION else channel, regime), [0.0, 0.0, 0.0])
                pair[0] += float(inside @ inside)
                pair[1] += noise * noise * len(inside)
                pair[2] += len(inside)
    found = {}
    for (channel, regime), (square, noise, count) in sums.items():
        if count >= FEWEST and square - noise > LEAST * noise:
            value = float(f"{np.sqrt((square - noise) / count):.{_DIGITS}g}")
            for name in _POSITION if channel in _POSITION else (channel,):
                found[name, regime] = value
    return found
