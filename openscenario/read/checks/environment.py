"""Environment: the sun."""

from __future__ import annotations

from openscenario.model.environment import Sun
from openscenario.read.checks.registry import check
from openscenario.read.context import Context


@check(Sun)
def in_radians(sun: Sun, context: Context) -> None:
    """Warn if the elevation is beyond -pi to pi: the standard has radians, and such a value can only be degrees."""
    if sun.in_degrees:
        context.warning(
            "value.out_of_range",
            sun.at,
            "@elevation",
            "azimuth and elevation of the sun are read as degrees, as this is no elevation in radians",
            found=f"{sun.elevation:g}",
            allowed="-pi to pi rad",
        )
