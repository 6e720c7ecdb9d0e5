"""A catalogue file: entries that scenarios refer to."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from openscenario.model.declarations import FileHeader
from openscenario.model.entities import Controller, MiscObject, Pedestrian, Vehicle
from openscenario.model.environment import Environment
from openscenario.model.kinds import Element, xml
from openscenario.model.positions import Route, Trajectory
from openscenario.model.storyboard import Maneuver

CatalogEntry: TypeAlias = Vehicle | Controller | Pedestrian | MiscObject | Environment | Maneuver | Trajectory | Route


@dataclass(frozen=True, slots=True)
class Catalog(Element):
    """Entries with the default values of their parameters."""

    name: str = ""
    entries: tuple[CatalogEntry, ...] = field(metadata=xml(inline=True), default=())


@dataclass(frozen=True, slots=True)
class CatalogFile(Element):
    """`sha256` of the file's bytes."""

    file_header: FileHeader
    catalog: Catalog
    path: Path = field(default=Path(), compare=False)
    sha256: str = field(default="", compare=False)
