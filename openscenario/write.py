"""Writing a scenario: model -> valid, runnable `.xosc` of version 1.3; read(write(s)) == s.

Parameters keep their declarations with the values in force; where they were used, the values stand. Catalogue entries
stand in the file itself, so that it needs no catalogue.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from openscenario.model.declarations import FileHeader
from openscenario.model.distributions import DistributionFile, ScenarioFile
from openscenario.model.kinds import Element
from openscenario.model.scenario import LogicFile, Scenario
from openscenario.plan import FieldPlan, plan_of, tag_path
from openscenario.values import spelled
from openscenario.xml import Node, write_xml

WRITTEN_MINOR = 3  # the one version that has all elements: catalogues may be newer than the scenario they serve


def write_scenario(scenario: Scenario, path: str | os.PathLike[str]) -> None:
    """Writes a scenario that reads back equal; the file appears whole or not at all.

    The road is referred to by its path from the new file's folder; reading needs the road's folder as a library.

    Raises:
        OSError: the file cannot be written.
    """
    target = Path(path)
    write_xml(scenario_node(scenario, target.absolute().parent), target)


def write_distribution(file: DistributionFile, path: str | os.PathLike[str]) -> None:
    """The same for a parameter value distribution; its scenario is referred to by its path from the new file's folder.

    Raises:
        OSError: the file cannot be written.
    """
    _write_one(file.file_header, file.distribution, Path(path))


def _write_one(header: FileHeader, element: Element, target: Path) -> None:
    writer = _Writer(target.absolute().parent)
    root = Node("OpenSCENARIO", 0, {}, "", None)
    writer.element(header, "FileHeader", root)
    writer.element(element, type(element).__name__, root)
    write_xml(root, target)


def scenario_node(scenario: Scenario, folder: Path) -> Node:
    """The scenario as a tree of nodes, for a file in `folder`."""
    writer = _Writer(folder)
    root = Node("OpenSCENARIO", 0, {}, "", None)
    writer.element(scenario.file_header, "FileHeader", root)
    for tag, rows in (
        ("ParameterDeclarations", scenario.parameter_declarations),
        ("VariableDeclarations", scenario.variable_declarations),
        ("MonitorDeclarations", scenario.monitor_declarations),
    ):
        if rows:
            writer.rows(rows, tag, root)
    _child("CatalogLocations", root)
    writer.element(scenario.road_network, "RoadNetwork", root)
    entities = _child("Entities", root)
    for thing in (*scenario.entities, *scenario.entity_selections):
        writer.element(thing, type(thing).__name__, entities)
    writer.element(scenario.storyboard, "Storyboard", root)
    return root


class _Writer:
    __slots__ = ("folder",)

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def rows(self, rows: Sequence[Element], tag: str, parent: Node) -> None:
        group = _child(tag, parent)
        for row in rows:
            self.element(row, type(row).__name__, group)

    def element(self, element: Element, tag: str, parent: Node) -> None:
        node = _child(tag, parent)
        wrappers: dict[tuple[str, ...], Node] = {(): node}
        plan = plan_of(type(element))
        # the schemas want the declarations first; the other fields stand in the model as the schemas order them
        for field in sorted(plan.fields, key=lambda field: field.name != "parameter_declarations"):
            value = getattr(element, field.name)
            if field.text:
                node.text = value
            elif field.attribute:
                self._attribute(element, field, value, node)
            elif field.many:
                for item in value:
                    self._item(item, field, wrappers)
            elif value is not None:
                self._item(value, field, wrappers)

    def _attribute(self, element: Element, field: FieldPlan, value: Any, node: Node) -> None:
        if value is None or (value == field.default and not field.required):
            return
        text = spelled(value)
        if isinstance(element, LogicFile | ScenarioFile) and element.path is not None:
            text = Path(os.path.relpath(element.path, os.path.realpath(self.folder))).as_posix()
        elif isinstance(element, FileHeader) and field.name == "rev_minor":
            text = str(WRITTEN_MINOR)
        node.attributes[field.attribute] = text

    def _item(self, item: Element, field: FieldPlan, wrappers: dict[tuple[str, ...], Node]) -> None:
        path = field.path
        if field.union:
            place = wrappers[()]
            for step in (*path, *tag_path(type(item))[:-1]):
                place = _child(step, place)
            self.element(item, tag_path(type(item))[-1], place)
            return
        for depth in range(1, len(path)):
            if path[:depth] not in wrappers:
                wrappers[path[:depth]] = _child(path[depth - 1], wrappers[path[: depth - 1]])
        self.element(item, path[-1], wrappers[path[:-1]])


def _child(tag: str, parent: Node) -> Node:
    node = Node(tag, 0, {}, "", parent)
    parent.children.append(node)
    return node
