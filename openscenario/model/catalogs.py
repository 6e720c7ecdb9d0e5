"""References to catalogue entries, and where catalogues lie. The reader puts the entries in place of the references."""

from __future__ import annotations

from dataclasses import dataclass, field

from openscenario.model.kinds import Element, RawText, xml


@dataclass(frozen=True, slots=True)
class ParameterAssignment(Element):
    parameter_ref: RawText
    value: str


@dataclass(frozen=True, slots=True)
class CatalogReference(Element):
    catalog_name: str
    entry_name: str
    parameter_assignments: tuple[ParameterAssignment, ...] = field(
        metadata=xml("ParameterAssignments/ParameterAssignment"), default=()
    )


@dataclass(frozen=True, slots=True)
class Directory(Element):
    path: str


@dataclass(frozen=True, slots=True)
class CatalogLocation(Element):
    directory: Directory


@dataclass(frozen=True, slots=True)
class CatalogLocations(Element):
    vehicle_catalog: CatalogLocation | None = None
    controller_catalog: CatalogLocation | None = None
    pedestrian_catalog: CatalogLocation | None = None
    misc_object_catalog: CatalogLocation | None = None
    environment_catalog: CatalogLocation | None = None
    maneuver_catalog: CatalogLocation | None = None
    trajectory_catalog: CatalogLocation | None = None
    route_catalog: CatalogLocation | None = None
