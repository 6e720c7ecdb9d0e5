"""Reading a scenario file as a whole: root, header, declarations, catalogues, road network, entities, storyboard."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, TypeVar

from openscenario.catalogs import KINDS, Catalogs
from openscenario.commonroad.source import ROOT as COMMONROAD
from openscenario.commonroad.source import read as read_commonroad
from openscenario.commonroad.story import openscenario as commonroad_story
from openscenario.findings import Findings, ScenarioError, nearest
from openscenario.left_handed import PREFIX, right_handed
from openscenario.model.catalog_file import Catalog, CatalogFile
from openscenario.model.catalogs import CatalogLocations
from openscenario.model.declarations import (
    FileHeader,
    MonitorDeclaration,
    ParameterDeclaration,
    VariableDeclaration,
)
from openscenario.model.entities import Entities
from openscenario.model.kinds import At, Element, RefKind
from openscenario.model.scenario import RoadNetwork, Scenario
from openscenario.model.storyboard import Storyboard
from openscenario.parameters import Given, Scope, declare
from openscenario.paths import PathError, Roots
from openscenario.plan import plan_of
from openscenario.read.context import Context
from openscenario.read.elements import ElementReader
from openscenario.read.endings import check_endings
from openscenario.read.header import read_header
from openscenario.read.references import check_entity_names, check_references, check_types
from openscenario.read.road import check_beside, check_on_road, check_phases, with_road
from openscenario.values import BadValue, check_type, spelled
from openscenario.xml import Document, Node, read_xml

_SECTIONS: Final = (
    "FileHeader",
    "ParameterDeclarations",
    "VariableDeclarations",
    "MonitorDeclarations",
    "CatalogLocations",
    "RoadNetwork",
    "Entities",
    "Storyboard",
)
_REQUIRED: Final = ("CatalogLocations", "RoadNetwork", "Entities", "Storyboard")
_ROOT: Final = "OpenSCENARIO"
_FOREIGN: Final[Mapping[str, str]] = {
    "osm": "lanelet2 or OpenStreetMap: convert the map to OpenDRIVE",
    "OpenDRIVE": "OpenDRIVE: this is a road, name it in the LogicFile of a scenario",
    "net": "a SUMO network: convert it with netconvert",
}
_E = TypeVar("_E", bound=Element)


@dataclass(frozen=True, slots=True)
class Reading:
    """A file under reading."""

    document: Document
    root: Node
    roots: Roots
    context: Context

    @property
    def reader(self) -> ElementReader:
        """A reader of the document's elements that shares the findings of the session."""
        return ElementReader(self.context, self.document.file)

    def at(self, node: Node | None = None, tag: str = "") -> At:
        """Place of a section, or of the root."""
        node = node or self.root
        return At(self.document.file, node.line, f"{_ROOT}/{tag}" if tag else self.root.tag)


def open_reading(path: Path, library: Sequence[Path], rootdir: Path | None, findings: Findings) -> Reading | None:
    """Reads the XML and refuses by name what is no OpenSCENARIO XML; None: findings say why."""
    if path.suffix == ".osc":
        findings.add(
            "format.unsupported",
            str(path),
            1,
            "",
            "OpenSCENARIO DSL is not supported",
            hint="export OpenSCENARIO XML",
        )
        return None
    try:
        document = read_xml(path)
        if document.root.tag == COMMONROAD:
            document = _from_commonroad(document, findings)
    except ScenarioError as error:
        findings.found.extend(error.findings)
        return None
    base = Path(path).absolute().parent
    roots = Roots.of(base, [*([rootdir] if rootdir is not None else []), *library])
    context = Context(findings)
    reading = Reading(document, document.root, roots, context)
    if document.root.tag != _ROOT:
        advice = _FOREIGN.get(document.root.tag, "")
        context.error(
            "format.unsupported" if advice else "xml.root_tag_is_openscenario",
            reading.at(),
            "",
            "not an OpenSCENARIO XML file",
            found=f"<{document.root.tag}>",
            allowed=f"<{_ROOT}>",
            hint=advice or nearest(document.root.tag, [_ROOT]),
        )
        return None
    return reading


def _from_commonroad(document: Document, findings: Findings) -> Document:
    """A CommonRoad file as a scenario; what was read over is a warning."""
    source = read_commonroad(document.root, document.file)
    for tag, count in source.left_out.items():
        line = next((node.line for node in document.root.walk() if node.tag == tag), 1)
        times = f", {count} times, first here" if count > 1 else ""
        findings.add("commonroad.left_out", document.file, line, tag, f"{tag} is read over{times}", severity="warning")
    return replace(document, root=commonroad_story(source, Path(document.file).name))


def read_sections(reading: Reading, given: Mapping[str, str]) -> Scenario | None:
    """The scenario, or None if something is wrong; what, is in the context."""
    context = reading.context
    sections = _sections(reading)
    header = read_header(sections.get("FileHeader"), reading.reader, reading.at())
    if header is None:
        return None
    kind = next((tag for tag in ("ParameterValueDistribution", "Catalog") if reading.root.find(tag) is not None), "")
    if kind:
        text = "a catalogue is no scenario" if kind == "Catalog" else "a parameter distribution is no concrete scenario"
        hint = "" if kind == "Catalog" else "`dvp run` and pytest take it case by case"
        context.error("file.not_a_scenario", reading.at(reading.root.find(kind), kind), "", text, hint=hint)
        return None
    declared, scope = _parameters(reading, sections.get("ParameterDeclarations"), given)
    variables = _variables(reading, sections.get("VariableDeclarations"), scope)
    monitors = _rows(reading, sections.get("MonitorDeclarations"), MonitorDeclaration, scope)
    locations = _section(reading, sections, CatalogLocations, scope) or CatalogLocations()
    context.catalogs = Catalogs.of(locations, reading.roots, reading.roots.base)
    network = with_road(_section(reading, sections, RoadNetwork, scope), reading.roots, context)
    entities = _section(reading, sections, Entities, scope)
    storyboard = _section(reading, sections, Storyboard, scope)
    if header.description.startswith(PREFIX):
        header, network, storyboard = _of_carla(header, network, storyboard, context)
    check_entity_names(context)
    check_references(context)
    types: dict[tuple[RefKind, str], str] = {("parameter", each.name): each.parameter_type for each in declared}
    types.update({("variable", each.name): each.variable_type for each in variables})
    check_types(context, types)
    check_on_road(network, context)
    check_phases(network, context)
    _check_locations(context.catalogs, context)
    if storyboard is not None:
        check_beside(storyboard.init, network, context)
    if context.findings.errors or network is None or entities is None or storyboard is None:
        return None
    check_endings(storyboard, declared, entities.scenario_objects, context)
    return Scenario(
        header,
        network,
        entities.scenario_objects,
        storyboard,
        entities.entity_selections,
        declared,
        variables,
        monitors,
        Path(reading.document.file),
        _hash(reading),
        at=reading.at(),
    )


def _of_carla(
    header: FileHeader, network: RoadNetwork | None, storyboard: Storyboard | None, context: Context
) -> tuple[FileHeader, RoadNetwork | None, Storyboard | None]:
    """The same in the coordinates of the standard, with a warning; without the prefix, as it is no longer true."""
    new = None if network is None else right_handed(network), None if storyboard is None else right_handed(storyboard)
    if new[0] is not network or new[1] is not storyboard:
        context.warning(
            "position.left_handed",
            header.at,
            "@description",
            "taken for the left-handed coordinates of CARLA: y, dy and h of positions and curvatures change their sign",
            found=header.description,
            hint=f"without '{PREFIX}' the positions count as they are written",
        )
    return replace(header, description=header.description.removeprefix(PREFIX)), *new


def declarations_of(reading: Reading, given: Mapping[str, str]) -> tuple[ParameterDeclaration, ...]:
    """The scenario's own parameters, `given` values in place of the declared ones."""
    header = read_header(reading.root.find("FileHeader"), reading.reader, reading.at())
    if header is None:
        return ()
    return _parameters(reading, reading.root.find("ParameterDeclarations"), given)[0]


def read_catalog_file(reading: Reading) -> CatalogFile | None:
    """A catalogue, each entry with the default values of its parameters; None: the context says what is wrong."""
    context = reading.context
    header = read_header(reading.root.find("FileHeader"), reading.reader, reading.at())
    node = reading.root.find("Catalog")
    if header is None or node is None:
        return None
    for second in reading.root.findall("Catalog")[1:]:
        context.error("xml.too_many", reading.at(second, "Catalog"), "", "a file holds one catalogue", found="Catalog")
    seen: dict[str, int] = {}
    for entry in node.children:
        name = entry.get("name")
        if entry.tag in KINDS and name in seen:
            at = At(reading.document.file, entry.line, f"{_ROOT}/Catalog/{entry.tag}")
            hint = f"first used in line {seen[name]}"
            code = "reference_control.uniquely_resolvable_entity_references"
            context.error(code, at, "", "two entries of one name", found=name, hint=hint)
        seen.setdefault(name, entry.line)
    catalog: Catalog | None = reading.reader.read(plan_of(Catalog), node, Scope(), f"{_ROOT}/Catalog")
    if catalog is None or context.findings.errors:
        return None
    return CatalogFile(header, catalog, Path(reading.document.file), reading.document.sha256, at=reading.at())


def _sections(reading: Reading) -> dict[str, Node]:
    sections: dict[str, Node] = {}
    foreign = ("Catalog", "ParameterValueDistribution")
    for child in reading.root.children:
        at = reading.at(child, child.tag)
        if child.tag not in _SECTIONS and child.tag not in foreign:
            reading.context.error(
                "xml.unknown_element",
                at,
                "",
                "unknown element here",
                found=child.tag,
                allowed=", ".join(_SECTIONS),
                hint=nearest(child.tag, _SECTIONS),
            )
        elif child.tag in sections:
            reading.context.error(
                "xml.too_many", at, "", "only one element of its kind may stand here", found=child.tag
            )
        else:
            sections[child.tag] = child
    if "FileHeader" in sections and not any(tag in sections for tag in foreign):
        for tag in _REQUIRED:
            if tag not in sections:
                _missing(reading, sections, tag)
    return sections


def _check_locations(catalogs: Catalogs, context: Context) -> None:
    """A folder that may not be opened, even if nothing of it is used (see `check_scenario`); a missing one is fine."""
    known = {(finding.line, finding.element) for finding in context.findings.found}
    for _, written, at in catalogs.locations:
        if (at.line, f"{at.element}@path") in known:
            continue  # something of it is used
        try:
            catalogs.roots.inside(written, catalogs.base)
        except PathError as error:
            context.warning(error.code, at, "@path", error.text, found=written, allowed=error.allowed, hint=error.hint)


def _missing(reading: Reading, sections: Mapping[str, Node], tag: str) -> None:
    """A missing section is reported where the next one stands in its place, as schema validators do."""
    later = _SECTIONS[_SECTIONS.index(tag) + 1 :]
    following = next((name for name in later if name in sections), "")
    at = reading.at(sections.get(following), following)
    # without catalogues nothing is missing that an actor needs: what refers to one has an error of its own
    note = reading.context.warning if tag == "CatalogLocations" else reading.context.error
    note("xml.valid_schema", at, "", "a required element is missing before this one", allowed=f"<{tag}>")


def _parameters(
    reading: Reading, node: Node | None, given: Mapping[str, str]
) -> tuple[tuple[ParameterDeclaration, ...], Scope]:
    context = reading.context
    raw = _rows(reading, node, ParameterDeclaration, Scope())
    context.names["parameter"] = [(declaration.name, declaration.at) for declaration in raw]
    names = [declaration.name for declaration in raw]
    for name in given:
        if name not in names:
            context.findings.add(
                "param.undefined",
                reading.document.file,
                None if node is None else node.line,
                f"{_ROOT}/ParameterDeclarations",
                "the scenario declares no such parameter",
                found=name,
                allowed=", ".join(names) or "none",
                hint=nearest(name, names),
            )
    return declare(raw, None, {name: Given(value) for name, value in given.items()}, context.findings)


def _variables(reading: Reading, node: Node | None, scope: Scope) -> tuple[VariableDeclaration, ...]:
    variables = _rows(reading, node, VariableDeclaration, scope)
    for variable in variables:
        try:
            check_type(variable.value, variable.variable_type)
        except BadValue as error:
            allowed = f"{error.allowed} ({variable.variable_type})"
            reading.context.error(
                error.code, variable.at, "@value", error.text, found=variable.value or "nothing", allowed=allowed
            )
    return variables


def _rows(reading: Reading, node: Node | None, cls: type[_E], scope: Scope) -> tuple[_E, ...]:
    if node is None:
        return ()
    rows: list[_E] = []
    for child in node.children:
        path = f"{_ROOT}/{node.tag}/{child.tag}"
        if child.tag == cls.__name__:
            row = reading.reader.read(plan_of(cls), child, scope, path)
            if row is not None:
                rows.append(row)
        else:
            at = At(reading.document.file, child.line, path)
            reading.context.error(
                "xml.unknown_element", at, "", "unknown element here", found=child.tag, allowed=cls.__name__
            )
    return tuple(rows)


def _section(reading: Reading, sections: Mapping[str, Node], cls: type[_E], scope: Scope) -> _E | None:
    node = sections.get(cls.__name__)
    if node is None:
        return None
    section: _E | None = reading.reader.read(plan_of(cls), node, scope, f"{_ROOT}/{cls.__name__}")
    return section


def _hash(reading: Reading) -> str:
    catalogs = reading.context.catalogs
    digest = hashlib.sha256(reading.document.sha256.encode())
    for one in catalogs.hashes if catalogs is not None else []:
        digest.update(one.encode())
    return digest.hexdigest()


def texts(values: Mapping[str, str | float | bool]) -> dict[str, str]:
    """Values from outside as a file would spell them."""
    return {name: spelled(value) for name, value in values.items()}
