"""Values that a model needs so that its own run shows what the car's log shows.

The detections of a run are what a tracker makes of what the sensors saw. Both runs pass the same tracker, so what it
does to both is taken out: the difference, or for what a tracker lets through only in part, the ratio, is the model's.
One that the tracker dampens comes closer with each drive of the extended model that is diagnosed again.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from math import hypot, isfinite, isinf, sqrt
from typing import TYPE_CHECKING

from pytest_dvp.gap.perception.noise_levels import SIGMA0, SLOPE, noise_needed
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Key
    from vehicle.model.vehicle_model import VehicleModel

GREATEST_STEP = 5.0  # a ratio by which one diagnosis changes a value at most


def on_top(found: Perceived, twin: Perceived, model: VehicleModel) -> Perceived:
    """`found` in a car's log with its values as `model` needs them, whose own run shows `twin`.

    A value that only one of both tells stays as it is.
    """
    from vehicle.model.effect_catalogue import catalogue

    values = dict(found.values)
    for (name, key), (value, low, high) in found.values.items():
        if (name, key) not in twin.values:
            continue
        shown, shown_low, shown_high = twin.values[name, key]
        declared = catalogue()[name].key(key)
        given = model.value(name, key)
        base = declared.neutral if given is None else given
        take = _RULES.get((name, key), _difference)
        needed = take(value, shown, base, declared)
        wide = (hypot(value - low, shown - shown_low), hypot(high - value, shown_high - shown))
        allowed = min(max(needed, declared.minimum), declared.maximum) if isfinite(needed) else needed
        values[name, key] = (allowed, allowed - wide[0], allowed + wide[1])
    if found.levels is not None and twin.levels is not None:
        _place_noise(values, found.levels, twin.levels, model)
    return dataclasses.replace(found, values=values)


def _place_noise(
    values: dict[tuple[str, str], tuple[float, float, float]], found: FloatArray, twin: FloatArray, model: VehicleModel
) -> None:
    """Noise by its levels (bands, 2) [m] nearby, with intervals as wide as those of its two values."""
    from vehicle.model.effect_catalogue import catalogue

    declared = {key: catalogue()[key[0]].key(key[1]) for key in (SIGMA0, SLOPE)}
    sigma0, slope = (model.value(*key) or 0.0 for key in (SIGMA0, SLOPE))
    rule = functools.partial(_variance, declared=declared[SIGMA0])
    levels = noise_needed(found, twin, (sigma0, slope), rule)
    for key, needed in zip((SIGMA0, SLOPE), levels, strict=True):
        value, low, high = values[key]
        allowed = min(needed, declared[key].maximum)
        values[key] = (allowed, max(allowed - (value - low), 0.0), allowed + (high - value))


def _difference(value: float, shown: float, base: float, declared: Key) -> float:
    """What adds up: a dead time, an offset."""
    return base + value - shown


def _border(value: float, shown: float, base: float, declared: Key) -> float:
    """A border beyond which nothing is seen: the sensors have one, too, which is none of the model's."""
    if isinf(value):
        return declared.neutral
    return value if base == declared.neutral or isinf(shown) else base + value - shown


def _share_missed(value: float, shown: float, base: float, declared: Key) -> float:
    """Shares that are lost one after the other: what is seen multiplies."""
    return 1.0 - (1.0 - base) * (1.0 - value) / max(1.0 - shown, 1e-3)


def _dampened(value: float, shown: float, base: float, declared: Key) -> float:
    """What a tracker lets through in part: once the model has it, its own run shows which part."""
    moved, asked = shown - declared.neutral, value - declared.neutral
    if base == declared.neutral or moved * (base - declared.neutral) <= 0.0 or abs(moved) < 0.5 * declared.least:
        return base + value - shown
    ratio = min(max(asked / moved, -GREATEST_STEP), GREATEST_STEP)
    return declared.neutral + (base - declared.neutral) * ratio


def _variance(value: float, shown: float, base: float, declared: Key) -> float:
    """Independent noises: their variances add up, and a tracker lets through a part of each at most.

    Of the difference and the ratio that which moves farther is taken: while that part is below 1, neither goes too far.
    """
    added = sqrt(max(base**2 + value**2 - shown**2, 0.0))
    grown = base * min(value / shown, GREATEST_STEP) if shown > 0.0 else base
    return max(added, grown) if value >= shown else min(added, grown)


_RULES: dict[tuple[str, str], Callable[[float, float, float, Key], float]] = {
    ("detection_range", "R"): _border,
    ("detection_misses", "rate"): _share_missed,
    ("detection_false", "rate"): _dampened,
    ("detection_yaw", "b"): _dampened,
    ("detection_size", "length_ratio"): _dampened,
    ("detection_size", "width_ratio"): _dampened,
    ("detection_noise", "sigma0"): _variance,
    ("detection_noise", "slope"): _variance,
}
DAMPENED = frozenset(key for key, rule in _RULES.items() if rule in (_dampened, _variance))
"""Values that a tracker dampens: what is found first is not only unsure, but wrong to one side."""
