"""What an entity may do along its way: the limits of an action beside those of the vehicle's Performance."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from openscenario import model
    from openscenario.storyboard.entity import Entity


class Limits(NamedTuple):
    """Magnitudes, infinite where there is no limit: speed [m/s]; acceleration upwards and downwards [m/s^2], and how
    fast it may rise and fall [m/s^3]. A speed that falls is braked, be it to go backwards."""

    speed: float = math.inf
    up: float = math.inf
    down: float = math.inf
    rise: float = math.inf
    fall: float = math.inf

    @property
    def smooth(self) -> bool:
        """Whether the acceleration may not jump."""
        return self.rise < math.inf or self.fall < math.inf

    def eased(self, now: float, wanted: float, dt: float) -> float:
        """The wanted acceleration [m/s^2], or as near to it as it can come from the present one in `dt` [s].

        For controllers of a distance: what is limited is how fast they accelerate or brake harder. Going back towards
        no acceleration is free, as in esmini: a spring that may not let go swings.
        """
        if wanted < min(now, 0.0):
            return max(wanted, now - self.fall * dt)
        if wanted >= 0.0 and wanted > now:
            return min(wanted, now + self.rise * dt)
        return wanted


def performance(entity: Entity) -> Limits:
    """What the entity itself can do."""
    return Limits(
        entity.max_speed,
        entity.max_acceleration,
        entity.max_deceleration,
        entity.max_acceleration_rate,
        entity.max_deceleration_rate,
    )


def given(constraints: model.DynamicConstraints | None) -> Limits:
    """What an action allows."""
    if constraints is None:
        return Limits()
    return Limits(
        *(
            math.inf if limit is None else limit
            for limit in (
                constraints.max_speed,
                constraints.max_acceleration,
                constraints.max_deceleration,
                constraints.max_acceleration_rate,
                constraints.max_deceleration_rate,
            )
        )
    )


def both(one: Limits, other: Limits) -> Limits:
    """The narrower of each."""
    return Limits(*map(min, one, other))


def first(one: Limits, other: Limits) -> Limits:
    """Those of `one`, and of `other` where `one` has none."""
    return Limits(*(mine if mine < math.inf else its for mine, its in zip(one, other, strict=True)))
