"""Shapes of trajectories, routes."""

from __future__ import annotations

from collections.abc import Sequence

from openscenario.model.kinds import Element
from openscenario.model.positions import Clothoid, Nurbs, Polyline, Route
from openscenario.read.checks.registry import check
from openscenario.read.context import Context


@check(Polyline)
def polyline(shape: Polyline, context: Context) -> None:
    """Two vertices make a line; time never runs back."""
    _at_least(2, shape.vertices, shape, context, "Vertex")
    previous: float | None = None
    for vertex in shape.vertices:
        if vertex.time is not None:
            if previous is not None and vertex.time < previous:
                context.error(
                    "value.out_of_range",
                    vertex.at,
                    "@time",
                    "time runs back along the trajectory",
                    found=f"{vertex.time:g}",
                    allowed=f">= {previous:g} s",
                )
            previous = vertex.time


@check(Nurbs)
def nurbs(shape: Nurbs, context: Context) -> None:
    """As many knots as control points plus order, never falling; at least `order` control points."""
    if shape.order < 2:
        context.error(
            "value.out_of_range", shape.at, "@order", "the order is too low", found=str(shape.order), allowed=">= 2"
        )
        return
    _at_least(shape.order, shape.control_points, shape, context, "ControlPoint")
    needed = len(shape.control_points) + shape.order
    if len(shape.knots) != needed:
        context.error(
            "value.out_of_range",
            shape.at,
            "",
            "wrong number of knots",
            found=str(len(shape.knots)),
            allowed=f"{needed}: control points plus order",
        )
    for before, knot in zip(shape.knots, shape.knots[1:], strict=False):
        if knot.value < before.value:
            context.error(
                "value.out_of_range",
                knot.at,
                "@value",
                "knots never fall",
                found=f"{knot.value:g}",
                allowed=f">= {before.value:g}",
            )


@check(Clothoid)
def clothoid(shape: Clothoid, context: Context) -> None:
    """Refuse a clothoid that ends before it starts."""
    if shape.start_time is not None and shape.stop_time is not None and shape.stop_time < shape.start_time:
        context.error(
            "value.out_of_range",
            shape.at,
            "@stopTime",
            "the clothoid ends before it starts",
            found=f"{shape.stop_time:g}",
            allowed=f">= {shape.start_time:g} s",
        )


@check(Route)
def route(element: Route, context: Context) -> None:
    """Refuse a route with fewer than two waypoints."""
    _at_least(2, element.waypoints, element, context, "Waypoint")


def _at_least(count: int, items: Sequence[Element], element: Element, context: Context, tag: str) -> None:
    if len(items) < count:
        context.error(
            "xml.missing_element", element.at, "", f"too few <{tag}>", found=str(len(items)), allowed=f">= {count}"
        )
