"""Trajectories and their shapes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.enums import ReferenceContext
from openscenario.model.kinds import Count, Curvature, Element, Length, Number, Radian, Scale, Second, xml
from openscenario.model.positions import Position


@dataclass(frozen=True, slots=True)
class Vertex(Element):
    position: Position
    time: Second | None = None


@dataclass(frozen=True, slots=True)
class Polyline(Element):
    vertices: tuple[Vertex, ...]


@dataclass(frozen=True, slots=True)
class Clothoid(Element):
    """`curvature_prime` [1/m^2]: change of curvature along the arc (called curvatureDot in 1.0 and 1.1)."""

    curvature: Curvature
    curvature_prime: Number = field(metadata=xml(former=("curvatureDot",)))
    length: Length
    position: Position
    start_time: Second | None = None
    stop_time: Second | None = None


@dataclass(frozen=True, slots=True)
class ClothoidSplineSegment(Element):
    curvature_start: Curvature
    curvature_end: Curvature
    length: Length
    h_offset: Radian = 0.0
    time_start: Second | None = None
    position_start: Position | None = None


@dataclass(frozen=True, slots=True)
class ClothoidSpline(Element):
    segments: tuple[ClothoidSplineSegment, ...]
    time_end: Second | None = None


@dataclass(frozen=True, slots=True)
class ControlPoint(Element):
    position: Position
    time: Second | None = None
    weight: Number = 1.0


@dataclass(frozen=True, slots=True)
class Knot(Element):
    value: Number


@dataclass(frozen=True, slots=True)
class Nurbs(Element):
    order: Count
    control_points: tuple[ControlPoint, ...]
    knots: tuple[Knot, ...]


Shape: TypeAlias = Polyline | Clothoid | ClothoidSpline | Nurbs


@dataclass(frozen=True, slots=True)
class Trajectory(Element):
    name: str
    closed: bool
    shape: Shape
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class Timing(Element):
    domain_absolute_relative: ReferenceContext
    scale: Scale
    offset: Second


@dataclass(frozen=True, slots=True)
class Untimed(Element):
    """`<TimeReference><None/></TimeReference>`: the time stamps of the trajectory are ignored."""

    XML = "None"


TimeReference: TypeAlias = Timing | Untimed
