"""The ranges in which values are met in practice, for vehicles that are smaller than a car.

The catalogue's ranges are those of cars. Of two bodies of one shape under the same gravity, the smaller one does the
same in a time that goes with the root of its length (Froude's law of similarity): accelerations and angles stay, the
gains of a controller in 1/s^2 grow as lengths shrink.
"""

from __future__ import annotations

import dataclasses
import math

from vehicle.model.effect import Key

SHORTEST_CAR = 1.5  # m of wheelbase; chosen: that of a quadricycle is 1.7 m
_POWERS = {
    "m": 1.0, "s": 0.5, "s^2": 1.0, "m/s": 0.5, "1/s": -0.5, "rad/s": -0.5, "1/s^2": -1.0, "m/s^3": -0.5, "1/m": -1.0,
    "Hz": -0.5, "s^2/m^2": -1.0,
}  # fmt: skip
"""Power of the length by which a value of a unit goes; other units, such as m/s^2 and rad, keep theirs."""


def usual_range(key: Key, wheelbase: float) -> Key:
    """The key with the range that is met on a vehicle of `wheelbase` [m]: wider for one shorter than SHORTEST_CAR, and
    never narrower, as a small robot may have the dead time of a car's."""
    if wheelbase >= SHORTEST_CAR or key.unit not in _POWERS:
        return key
    factor = (wheelbase / SHORTEST_CAR) ** _POWERS[key.unit]
    low, high = min(key.low, factor * key.low), max(key.high, factor * key.high)
    # An effect of one sign stays one, and no range goes beyond what the equation allows
    low = max(low, min(key.minimum, key.low), key.neutral if key.neutral <= key.low else -math.inf)
    high = min(high, max(key.maximum, key.high), key.neutral if key.neutral >= key.high else math.inf)
    return dataclasses.replace(key, low=low, high=high)
