"""Positions whose attributes exclude each other."""

from __future__ import annotations

from openscenario.model.positions import GeoPosition, RelativeLanePosition
from openscenario.read.checks.registry import check, exactly_one
from openscenario.read.context import Context


@check(RelativeLanePosition)
def one_distance(position: RelativeLanePosition, context: Context) -> None:
    exactly_one(position, context, "", ds=position.ds, dsLane=position.ds_lane)


@check(GeoPosition)
def one_notation(position: GeoPosition, context: Context) -> None:
    """Degrees since 1.2, radians before; not a bit of both."""
    exactly_one(position, context, "", latitudeDeg=position.latitude_deg, latitude=position.latitude)
    exactly_one(position, context, "", longitudeDeg=position.longitude_deg, longitude=position.longitude)
