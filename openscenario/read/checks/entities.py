"""Entities and declarations: names, axles, trailers, distributions of traffic."""

from __future__ import annotations

import math
from typing import Any

from openscenario.model.declarations import MonitorDeclaration, ParameterDeclaration, VariableDeclaration
from openscenario.model.entities import Axle, Axles, EntitySelection, ScenarioObject, Trailer
from openscenario.model.traffic import Range, TrafficArea
from openscenario.read.checks.registry import check, exactly_one
from openscenario.read.context import Context


@check(Axles)
def wheelbase(axles: Axles, context: Context) -> None:
    """The front axle lies before the rear axle: all vehicle models divide by the distance."""
    front, rear = axles.front_axle, axles.rear_axle
    if front is not None and front.position_x <= rear.position_x:
        context.error(
            "value.out_of_range",
            front.at,
            "@positionX",
            "the wheelbase is not positive",
            found=f"{front.position_x:g}",
            allowed=f"> {rear.position_x:g} m, the position of the rear axle",
        )


@check(Axle)
def steering(axle: Axle, context: Context) -> None:
    """The standard's range; files with degrees are common, and nothing here divides by it."""
    if axle.max_steering > math.pi:
        text = "no wheel turns so far: radians are meant"
        found, allowed = f"{axle.max_steering:g}", "0 to pi rad"
        context.warning("value.out_of_range", axle.at, "@maxSteering", text, found=found, allowed=allowed)


@check(ScenarioObject, EntitySelection, ParameterDeclaration, VariableDeclaration, MonitorDeclaration)
def has_a_name(element: Any, context: Context) -> None:
    """Nothing could refer to it."""
    if not element.name.strip():
        context.error("name.empty", element.at, "@name", "the name is empty", found="nothing", allowed="a name")


@check(Trailer)
def one_trailer(trailer: Trailer, context: Context) -> None:
    """Refuse a trailer that is neither described nor named, or both."""
    exactly_one(trailer, context, "", Trailer=trailer.trailer, TrailerRef=trailer.trailer_ref)


@check(EntitySelection)
def some_members(selection: EntitySelection, context: Context) -> None:
    """Refuse a selection without members."""
    if not selection.members:
        context.error(
            "xml.missing_element", selection.selected.at, "", "the selection is empty", allowed="EntityRef, ByType"
        )


@check(Range)
def limits_in_order(limits: Range, context: Context) -> None:
    """Refuse a range whose upper limit lies below its lower one."""
    if limits.upper_limit < limits.lower_limit:
        context.error(
            "value.out_of_range",
            limits.at,
            "@upperLimit",
            "the upper limit lies below the lower",
            found=f"{limits.upper_limit:g}",
            allowed=f">= {limits.lower_limit:g}",
        )


@check(TrafficArea)
def some_area(area: TrafficArea, context: Context) -> None:
    """Refuse a traffic area with neither a polygon nor roads."""
    if area.polygon is None and not area.road_ranges:
        context.error("xml.missing_element", area.at, "", "the area is empty", allowed="Polygon, RoadRange")
