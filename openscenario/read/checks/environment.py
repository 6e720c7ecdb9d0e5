"""Environment: the sun."""

from __future__ import annotations

from openscenario.model.environment import Sun
from openscenario.read.checks.registry import check
from openscenario.read.context import Context


@check(Sun)
def in_radians(sun: Sun, context: Context) -> None:
    """The standard's range; of a sun whose height is beyond it nothing but degrees makes sense."""
    if sun.in_degrees:
        context.warning(
            "value.out_of_range",
            sun.at,
            "@elevation",
            "azimuth and elevation of the sun are taken for degrees: radians are meant",
            found=f"{sun.elevation:g}",
            allowed="-pi to pi rad",
        )
