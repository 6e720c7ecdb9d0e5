"""The scenario as a whole."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from openscenario.model.declarations import (
    FileHeader,
    MonitorDeclaration,
    ParameterDeclaration,
    VariableDeclaration,
)
from openscenario.model.entities import Entities, EntitySelection, ScenarioObject
from openscenario.model.kinds import Element, xml
from openscenario.model.positions import Position
from openscenario.model.storyboard import Storyboard
from openscenario.model.traffic import TrafficSignalController


@dataclass(frozen=True, slots=True)
class LogicFile(Element):
    """`filepath` as written; `path` what it leads to, inside the allowed folders."""

    filepath: str = field(compare=False)
    path: Path | None = field(default=None, metadata={"xml": None})


@dataclass(frozen=True, slots=True)
class SceneGraphFile(Element):
    filepath: str


@dataclass(frozen=True, slots=True)
class UsedArea(Element):
    positions: tuple[Position, ...] = field(metadata=xml("Position"))


@dataclass(frozen=True, slots=True)
class RoadNetwork(Element):
    logic: LogicFile | None = field(metadata=xml("LogicFile"), default=None)
    scene_graph_file: SceneGraphFile | None = None
    traffic_signals: tuple[TrafficSignalController, ...] = field(
        metadata=xml("TrafficSignals/TrafficSignalController"), default=()
    )
    used_area: UsedArea | None = None

    @property
    def logic_file(self) -> Path | None:
        """The road's file, inside the allowed folders; None: the scenario names none."""
        return None if self.logic is None else self.logic.path


@dataclass(frozen=True, slots=True)
class Scenario(Element):
    """A scenario file with catalogue entries in their places and all parameters and expressions computed.

    `sha256` covers every file that was read for it (scenario and catalogues, not the road).
    """

    file_header: FileHeader
    road_network: RoadNetwork
    entities: tuple[ScenarioObject, ...]
    storyboard: Storyboard
    entity_selections: tuple[EntitySelection, ...] = ()
    parameter_declarations: tuple[ParameterDeclaration, ...] = ()
    variable_declarations: tuple[VariableDeclaration, ...] = ()
    monitor_declarations: tuple[MonitorDeclaration, ...] = ()
    path: Path = field(default=Path(), compare=False)
    sha256: str = field(default="", compare=False)


__all__ = [
    "Entities",
    "LogicFile",
    "RoadNetwork",
    "Scenario",
    "SceneGraphFile",
    "UsedArea",
]
