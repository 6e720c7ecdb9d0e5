"""OpenDRIVE reader: a file of version 1.0-1.9 becomes plain data, or findings with file, line and element."""

from __future__ import annotations

import math
import os
from typing import Literal, cast

import msgspec

from openscenario.commonroad.roads import opendrive as commonroad_roads
from openscenario.commonroad.source import ROOT
from openscenario.commonroad.source import read as read_commonroad
from openscenario.findings import Finding, ScenarioError
from openscenario.road.attributes import Attributes, by_tag
from openscenario.road.contacts import with_contacts
from openscenario.road.elements import (
    Connection,
    Contact,
    Cubic,
    Junction,
    OpenDrive,
    Road,
    RoadLink,
    RoadType,
    Rule,
)
from openscenario.road.lane_reader import read_section, read_speed
from openscenario.road.object_reader import read_objects, read_signals, refer
from openscenario.road.plan_reader import MAX_LENGTH, in_order, read_cubics, read_geometries, read_shapes
from openscenario.road.repairs import LENIENT, Roads, forbids, judged, repaired
from openscenario.road.rules import check_network
from openscenario.road.single_sides import complete_sides
from openscenario.road.vocabulary import check_vocabulary
from openscenario.xml import Node, read_xml

ROAD_TYPES = (
    *("unknown", "rural", "motorway", "town", "lowSpeed", "pedestrian", "bicycle"),
    *("townExpressway", "townCollector", "townArterial", "townPrivate", "townLocal", "townPlayStreet"),
)
_ONCE = ("link", "planView", "elevationProfile", "lateralProfile", "lanes", "objects", "signals")
_TEXTS = frozenset(("geoReference",))  # elements of which the text is read
NEWEST = 9  # the last minor version of OpenDRIVE 1
OTHER_FORMATS = {
    "osm": "a Lanelet2 or OpenStreetMap file",
    "net": "a SUMO network",
    "OpenSCENARIO": "an OpenSCENARIO file",
    "OpenCRG": "an OpenCRG file",
}


def read_opendrive(path: str | os.PathLike[str], roads: Roads = LENIENT) -> OpenDrive:
    """Read a road network file.

    roads: "strict" refuses what breaks a rule of the file's own version; "lenient" repairs what leaves a geometry and
    a route, as a name of a road, lane or signal that is not there in files cut out of larger ones. `OpenDrive.repairs`
    says what was assumed.

    Raises:
        ScenarioError: the file is missing, no XML, no OpenDRIVE, or breaks a rule that cannot be done without; with all
            its findings.
    """
    network, findings = examine_opendrive(path, roads)
    if network is None or any(each.severity == "error" for each in findings):
        raise ScenarioError(findings)
    return network


def examine_opendrive(
    path: str | os.PathLike[str], roads: Roads = "strict"
) -> tuple[OpenDrive | None, tuple[Finding, ...]]:
    """The network (None where it cannot be read at all) and all findings; never raises for a user's file.

    roads: as for `read_opendrive`; a fault that is repaired is a warning.
    """
    attributes = Attributes(os.fspath(path))
    try:
        root = read_xml(path, texts=_TEXTS).root
        if root.tag == ROOT:
            root = commonroad_roads(read_commonroad(read_xml(path).root, attributes.file))
    except ScenarioError as error:
        return None, error.findings
    network = _examine(attributes, root)
    root.release()
    if network is None:
        return None, tuple(attributes.findings)
    version = network.version
    network = msgspec.structs.replace(network, repairs=repaired(attributes.findings, version))
    return network, judged(attributes.findings, version, roads)


def _examine(attributes: Attributes, root: Node) -> OpenDrive | None:
    if root.tag.rpartition(":")[2] != "OpenDRIVE":
        what = OTHER_FORMATS.get(root.tag, "")
        attributes.report(
            "asam.net:xodr:1.0.0:xml.root_tag_is_opendrive",
            root,
            f"this is {what}, not OpenDRIVE" if what else "this is not OpenDRIVE",
            found=root.tag,
            allowed="OpenDRIVE",
            hint="convert the road network to OpenDRIVE, for example with SUMO's netconvert",
        )
        return None
    check_vocabulary(attributes, root)
    parts = by_tag(root)
    _only_one(attributes, parts, ("header",))
    version, geo_reference, geo_offset = _read_header(attributes, root, parts.get("header", []))
    road_nodes, junction_nodes = parts.get("road", []), parts.get("junction", [])
    if not road_nodes:
        attributes.report("xml.valid_schema", root, "a road network needs at least one road")
    roads = tuple(moved(_read_road(attributes, node), geo_offset) for node in road_nodes)
    network = OpenDrive(
        path=attributes.file,
        version=version,
        geo_reference=geo_reference,
        geo_offset=geo_offset,
        roads=refer(attributes, roads, road_nodes),
        junctions=tuple(_read_junction(attributes, node) for node in junction_nodes),
    )
    if not any(forbids(finding, version, LENIENT) for finding in attributes.findings):
        network = msgspec.structs.replace(network, roads=with_contacts(attributes, network.roads, road_nodes))
        check_network(attributes, network, road_nodes)
    return network


def moved(road: Road, offset: tuple[float, float, float, float]) -> Road:
    """The road after the header's offset: turned by hdg [rad] about the file's origin, then shifted by x, y, z [m].

    Source: ASAM OpenDRIVE 1.8, 8.5 (header offset): xWorld = x cos(hdg) - y sin(hdg) + xOffset.
    """
    dx, dy, dz, turn = offset
    if not any(offset):
        return road
    c, sn = math.cos(turn), math.sin(turn)
    geometries = []
    for item in road.geometries:
        x, y = c * item.x - sn * item.y + dx, sn * item.x + c * item.y + dy
        place = {"x": x, "y": y, "hdg": item.hdg + turn}
        geometries.append(msgspec.structs.replace(item, **place))
    elevations = road.elevations
    if not elevations or elevations[0].s > 0.0:  # before the first record the road lies at 0
        elevations = (Cubic(0.0, 0.0, 0.0, 0.0, 0.0), *elevations)
    raised = tuple(msgspec.structs.replace(item, a=item.a + dz) for item in elevations)
    return msgspec.structs.replace(road, geometries=tuple(geometries), elevations=raised)


def _read_header(
    attributes: Attributes, root: Node, headers: list[Node]
) -> tuple[tuple[int, int], str, tuple[float, float, float, float]]:
    if not headers:
        code, text = "asam.net:xodr:1.0.0:xml.version_is_defined", "the header is missing"
        attributes.report(code, root, text, repair="a file of OpenDRIVE 1.4, the first version with these elements")
        return (1, 4), "", (0.0, 0.0, 0.0, 0.0)
    header = headers[0]
    version = (1, 4)
    if not (header.get("revMajor").strip().isdecimal() and header.get("revMinor").strip().isdecimal()):
        attributes.report(
            "asam.net:xodr:1.0.0:xml.version_is_defined",
            header,
            "revMajor and revMinor must say the version",
            found=f"revMajor={header.get('revMajor')!r} revMinor={header.get('revMinor')!r}",
            allowed=f"1.4 to 1.{NEWEST}",
        )
    else:
        version = (int(header.get("revMajor")[:6]), int(header.get("revMinor")[:6]))
        if version[0] != 1:
            attributes.report(
                "asam.net:xodr:1.0.0:xml.version_is_defined",
                header,
                "a version of OpenDRIVE that is not known here",
                attribute="revMajor",
                found=header.get("revMajor"),
                allowed="1",
            )
        elif version[1] > NEWEST:
            attributes.report(
                "asam.net:xodr:1.0.0:xml.version_is_defined",
                header,
                "a version of OpenDRIVE that is not known here",
                attribute="revMinor",
                found=f"1.{header.get('revMinor')}",
                allowed=f"1.4 to 1.{NEWEST}",
            )
    parts = by_tag(header)
    reference = parts["geoReference"][0].text.strip() if "geoReference" in parts else ""
    offset = (0.0, 0.0, 0.0, 0.0)
    if "offset" in parts:
        node = parts["offset"][0]
        x, y, z, hdg = (attributes.number(node, name, 0.0) for name in ("x", "y", "z", "hdg"))
        offset = (x, y, z, hdg)
    return version, reference, offset


def _read_road(attributes: Attributes, node: Node) -> Road:
    _one_layer(attributes, node)
    for lanes_node in node.findall("lanes"):
        complete_sides(lanes_node)
    parts = by_tag(node)
    _only_one(attributes, parts, _ONCE)
    for name in ("planView", "lanes"):
        if name not in parts:
            attributes.report(
                "asam.net:xodr:1.0.0:xml.valid_schema",
                node,
                f"a road needs an element {name}",
                found=", ".join(dict.fromkeys(child.tag for child in node.children)) or "no element",
                allowed=name,
            )
    elevation = by_tag(parts["elevationProfile"][0]) if "elevationProfile" in parts else {}
    lateral = by_tag(parts["lateralProfile"][0]) if "lateralProfile" in parts else {}
    for tag in ("crossfall", "crossSectionSurface"):
        if tag in lateral:
            attributes.report(
                "road.unsupported",
                lateral[tag][0],
                "this part of the surface is not used: heights are those of elevation, superelevation and shape",
                severity="warning",
            )
    lanes = by_tag(parts["lanes"][0]) if "lanes" in parts else {}
    if "lanes" in parts and "laneSection" not in lanes:
        attributes.report("asam.net:xodr:1.0.0:xml.valid_schema", parts["lanes"][0], "a road needs a laneSection")
    sections = sorted((read_section(attributes, n) for n in lanes.get("laneSection", ())), key=lambda item: item.s)
    known = len(attributes.findings)
    length = attributes.number(node, "length")
    if not 0.0 < length <= MAX_LENGTH and len(attributes.findings) == known:
        attributes.report(
            "value.out_of_range",
            node,
            "no road has such a length",
            attribute="length",
            found=node.get("length"),
            allowed=f"above 0 to {MAX_LENGTH:g} m",
        )
    identity = attributes.text(node, "id")
    if not identity.strip() and "id" in node.attributes:
        attributes.report("value.empty", node, "the id is empty", attribute="id", found="nothing", allowed="an id")
    objects = by_tag(parts["objects"][0]) if "objects" in parts else {}
    signals = by_tag(parts["signals"][0]) if "signals" in parts else {}
    types = parts.get("type", [])
    predecessor, successor = _read_links(attributes, parts.get("link", []))
    return Road(
        id=identity,
        name=node.get("name"),
        length=length,
        junction=node.get("junction", "-1"),
        rule=cast(Rule, attributes.choice(node, "rule", ("RHT", "LHT"), "RHT")),
        predecessor=predecessor,
        successor=successor,
        types=in_order(attributes, types, [_read_type(attributes, item) for item in types], "s"),
        geometries=read_geometries(attributes, parts["planView"][0]) if "planView" in parts else (),
        elevations=read_cubics(attributes, elevation.get("elevation", [])),
        superelevations=read_cubics(attributes, lateral.get("superelevation", [])),
        lane_offsets=read_cubics(attributes, lanes.get("laneOffset", [])),
        sections=tuple(sections),
        objects=read_objects(attributes, objects.get("object", [])),
        signals=read_signals(attributes, signals.get("signal", []), identity),
        line=node.line,
        shapes=read_shapes(attributes, lateral.get("shape", [])),
    )


def _one_layer(attributes: Attributes, node: Node) -> None:
    """Leave out the temporary lanes of a road works, which a road of version 1.9 may have beside its permanent ones."""
    temporary = [child for child in node.children if child.tag == "lanes" and child.get("layer") == "temporary"]
    if not temporary or len(temporary) == len(node.findall("lanes")):
        return
    text = "the temporary layer of lanes is not used: vehicles drive on the permanent one"
    for layer in temporary:
        attributes.report("road.unsupported", layer, text, attribute="layer", severity="warning")
        node.children.remove(layer)


def _only_one(attributes: Attributes, parts: dict[str, list[Node]], names: tuple[str, ...]) -> None:
    for name in names:
        for second in parts.get(name, ())[1:]:
            text = "only one element of its kind may stand here"
            attributes.report("asam.net:xodr:1.0.0:xml.valid_schema", second, text, found=name, allowed="one")


def _read_type(attributes: Attributes, node: Node) -> RoadType:
    speeds = node.findall("speed")
    speed = read_speed(attributes, speeds[0]) if speeds else None
    s = attributes.number(node, "s", 0.0)
    with attributes.repairing("a road of unknown type"):
        kind = attributes.choice(node, "type", ROAD_TYPES)
    return RoadType(s, kind, speed)


def _read_links(attributes: Attributes, nodes: list[Node]) -> tuple[RoadLink | None, RoadLink | None]:
    parts = by_tag(nodes[0]) if nodes else {}
    ends = [_read_link(attributes, parts[name][0]) if name in parts else None for name in ("predecessor", "successor")]
    return ends[0], ends[1]


def _read_link(attributes: Attributes, node: Node) -> RoadLink:
    virtual = "elementS" in node.attributes
    return RoadLink(
        kind=cast(Literal["road", "junction"], attributes.choice(node, "elementType", ("road", "junction"), "road")),
        id=attributes.text(node, "elementId"),
        contact=_contact(attributes, node),
        line=node.line,
        s=attributes.number(node, "elementS") if virtual else None,
        direction=node.get("elementDir"),
    )


def _contact(attributes: Attributes, node: Node) -> Contact:
    if node.get("contactPoint") in ("", "none"):
        return ""
    return cast(Contact, attributes.choice(node, "contactPoint", ("start", "end"), ""))


def _read_junction(attributes: Attributes, node: Node) -> Junction:
    connections = []
    for item in node.findall("connection"):
        links = tuple(
            (attributes.integer(link, "from"), attributes.integer(link, "to"))
            for link in item.findall("laneLink")
            if "temporary" not in (link.get("fromLayer"), link.get("toLayer"))
        )
        # a direct junction links the incoming road to another road, without a connecting road between
        connecting = item.get("connectingRoad") or item.get("linkedRoad")
        connections.append(
            Connection(
                item.get("id"), item.get("incomingRoad"), connecting, _contact(attributes, item), links, item.line
            )
        )
    kind = node.get("type") or "default"
    return Junction(attributes.text(node, "id"), node.get("name"), kind, tuple(connections), node.line)
