"""Routes."""

from __future__ import annotations

from dataclasses import dataclass, field

from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.enums import RouteStrategy
from openscenario.model.kinds import Element, xml
from openscenario.model.positions import Position


@dataclass(frozen=True, slots=True)
class Waypoint(Element):
    route_strategy: RouteStrategy
    position: Position


@dataclass(frozen=True, slots=True)
class Route(Element):
    name: str
    closed: bool
    waypoints: tuple[Waypoint, ...]
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )
