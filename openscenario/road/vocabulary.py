"""Vocabulary: which elements and attributes OpenDRIVE 1.4-1.9 knows, so that a slip of the pen is not passed over.

Contents of `userData`, `include` and elements that are not listed are nobody's business here.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import Final

from openscenario.findings import Severity
from openscenario.road.attributes import Attributes, Told
from openscenario.xml import Node

_CODE: Final = "asam.net:xodr:1.0.0:xml.valid_schema"
ALIKE: Final = 0.8  # ratio of equal letters from which a name is taken for a slip of the pen

# tag: children, attributes; the union of all versions and of all places where an element of that name stands
_KNOWN: Final[Mapping[str, tuple[str, str]]] = {
    "access": ("restriction", "restriction rule sOffset"),
    "arc": ("", "curvature"),
    "border": ("cornerReference", "a b c d outlineId sOffset type useCompleteOutline width"),
    "borders": ("border", ""),
    "bridge": ("laneValidity validity", "id length name s type"),
    "center": ("lane", ""),
    "connection": (
        "laneLink predecessor successor",
        "connectingRoad connectionMaster contactPoint id incomingRoad linkedRoad type",
    ),
    "control": ("", "signalID signalId type"),
    "controller": ("control", "ID id name sequence type"),
    "cornerLocal": ("", "height id u v z"),
    "cornerReference": ("", "id"),
    "cornerRoad": ("", "dz height id s t"),
    "CRG": ("", "file hOffset hideRoadSurfaceCRG mode orientation purpose sEnd sOffset sStart tOffset zOffset zScale"),
    "crossfall": ("", "a b c d s side"),
    "dependency": ("", "id type"),
    "elevation": ("", "a b c d s"),
    "elevationProfile": ("elevation", ""),
    "explicit": ("line", ""),
    "geometry": ("arc line paramPoly3 poly3 spiral", "hdg length s x y"),
    "geoReference": ("", ""),
    "header": (
        "defaultRegulations geoReference license offset",
        "date east maxJunc maxPrg maxRoad name north revMajor revMinor south vendor version west",
    ),
    "height": ("", "inner outer sOffset"),
    "junction": (
        "boundary connection controller crossPath elevationGrid planView priority roadSection surface",
        "id mainRoad name orientation sEnd sStart type",
    ),
    "junctionGroup": ("junctionReference", "id name type"),
    "junctionReference": ("", "junction"),
    "lane": (
        "access border height link material roadMark rule speed visibility width",
        "advisory direction dynamicLaneDirection dynamicLaneType id level roadWorks type",
    ),
    "laneLink": ("", "from fromLayer overlapZone to toLayer"),
    "laneOffset": ("", "a b c d s"),
    "lanes": ("laneOffset laneSection", "layer"),
    "laneSection": ("center left right", "length s singleSide"),
    "laneValidity": ("", "fromLane toLane"),
    "lateralProfile": ("crossSectionSurface crossfall shape superelevation", ""),
    "left": ("lane", ""),
    "line": ("", "color length rule sOffset space tOffset width"),
    "link": ("neighbor predecessor successor", ""),
    "marking": (
        "cornerReference",
        "color lineLength side spaceLength startOffset stopOffset type weight width zOffset",
    ),
    "markings": ("marking", ""),
    "material": ("", "friction materialCode roadMarkColor roughness sOffset surface"),
    "neighbor": ("", "direction elementId side"),
    "object": (
        "borders laneValidity markings material outline outlines parkingSpace repeat skeleton surface validity",
        "dynamic hdg height id length name orientation perpToRoad pitch "
        "radius roll s subtype t type validLength width zOffset",
    ),
    "objectReference": ("validity", "id length orientation s t validLength zOffset"),
    "objects": ("bridge object objectReference tunnel", ""),
    "offset": ("", "hdg x y z"),
    "OpenDRIVE": ("controller header junction junctionGroup road station vmsGroup", ""),
    "outline": ("cornerInertial cornerLocal cornerRelative cornerRoad", "closed fillType id laneType outer"),
    "outlines": ("outline", ""),
    "paramPoly3": ("", "aU aV bU bV cU cV dU dV pRange"),
    "parkingSpace": ("marking", "access restrictions"),
    "planView": ("geometry", ""),
    "poly3": ("", "a b c d"),
    "polyline": ("vertexLocal vertexRoad", "id"),
    "positionInertial": ("", "hdg pitch roll x y z"),
    "positionRoad": ("", "hOffset pitch roadId roll s t zOffset"),
    "predecessor": ("", "contactPoint elementDir elementId elementS elementType id layer"),
    "priority": ("", "high low type"),
    "reference": ("", "elementId elementType type"),
    "repeat": (
        "",
        "detachFromReferenceLine distance heightEnd heightStart length lengthEnd lengthStart radiusEnd "
        "radiusStart s tEnd tStart widthEnd widthStart zOffsetEnd zOffsetStart",
    ),
    "right": ("lane", ""),
    "road": (
        "elevationProfile lanes lateralProfile link objects planView railroad signals surface type",
        "id junction length name rule",
    ),
    "roadMark": ("explicit sway type", "color height laneChange material sOffset type weight width"),
    "rule": ("", "sOffset value"),
    "shape": ("", "a b c d s t"),
    "signal": (
        "Validity dependency laneValidity positionInertial positionRoad "
        "reference semantics staticBoard validity vmsBoard",
        "country countryRevision dynamic hOffset height id length name orientation pitch "
        "roll s subtype t text type unit value width zOffset",
    ),
    "signalReference": ("Validity laneValidity validity", "id orientation s t"),
    "signals": ("signal signalReference", ""),
    "skeleton": ("polyline", ""),
    "speed": ("type unit value", "max sOffset unit"),
    "spiral": ("", "curvEnd curvStart"),
    "successor": ("", "contactPoint elementDir elementId elementS elementType id layer"),
    "superelevation": ("", "a b c d s"),
    "surface": ("CRG", ""),
    "sway": ("", "a b c d ds"),
    "tunnel": ("laneValidity validity", "daylight id length lighting name s type"),
    "type": ("line speed", "country name s type width"),
    "validity": ("", "fromLane toLane"),
    "vertexLocal": ("", "id intersectionPoint radius u v z"),
    "vertexRoad": ("", "dz id intersectionPoint radius s t"),
    "visibility": ("", "back forward left right sOffset"),
    "width": ("coefficients", "a b c d sOffset"),
}
# numbers that nothing here reads, and that are to be numbers all the same
_NUMBERS: Final[Mapping[str, tuple[str, ...]]] = {
    "header": ("north", "south", "east", "west"),
    "roadMark": ("width", "height", "sOffset"),
    "line": ("length", "space", "tOffset", "sOffset", "width"),
    "material": ("friction", "roughness", "sOffset"),
    "visibility": ("back", "forward", "left", "right", "sOffset"),
    "access": ("sOffset",),
    "rule": ("sOffset",),
    "bridge": ("s", "length"),
    "tunnel": ("s", "length", "daylight", "lighting"),
    "object": ("pitch", "roll", "validLength"),
    "signal": ("pitch", "roll"),
    "cornerLocal": ("z", "height"),
    "cornerRoad": ("dz", "height"),
    "repeat": ("heightStart", "heightEnd", "zOffsetStart", "zOffsetEnd", "lengthStart", "lengthEnd"),
    "shape": ("s", "t", "a", "b", "c", "d"),
    "crossfall": ("s", "a", "b", "c", "d"),
    "positionRoad": ("s", "t", "zOffset", "hOffset", "pitch", "roll"),
    "positionInertial": ("x", "y", "z", "hdg", "pitch", "roll"),
}
# where a slip of the pen may change where somebody drives; anywhere else, what is not known is left out
OF_THE_WAY: Final = frozenset(
    (
        *("OpenDRIVE", "road", "planView", "geometry", "arc", "spiral", "poly3", "paramPoly3", "link"),
        *("elevationProfile", "elevation", "lateralProfile", "superelevation", "shape", "lanes", "laneOffset"),
        *("laneSection", "left", "center", "right", "lane", "width", "border", "height", "predecessor", "successor"),
        *("junction", "connection", "laneLink", "offset"),
    )
)
_ANYWHERE: Final = ("dataQuality", "include", "userData")  # may stand in every element
CHILDREN: Final = {tag: frozenset((*children.split(), *_ANYWHERE)) for tag, (children, _) in _KNOWN.items()}
ATTRIBUTES: Final = {tag: frozenset(attributes.split()) for tag, (_, attributes) in _KNOWN.items()}


def check_vocabulary(attributes: Attributes, root: Node) -> None:
    """Add a finding for each unknown element or attribute: an error if a known name is near or it is of another format.

    Additions of a tool's own are only a warning: they are left out, as a reader of the standard would.
    """
    stack = [root]
    while stack:
        node = stack.pop()
        children = CHILDREN.get(node.tag)
        if children is None:
            continue  # not ours to judge
        if not node.attributes.keys() <= ATTRIBUTES[node.tag]:
            _attributes(attributes, node)
        for name in _NUMBERS.get(node.tag, ()):
            if node.attributes.get(name):  # an empty one says nothing, and many files have it
                with attributes.repairing("nothing here reads it"):
                    attributes.number(node, name)
        for child in node.children:
            if child.tag in children:
                stack.append(child)
            else:
                _element(attributes, child, children)


def _element(attributes: Attributes, node: Node, known: frozenset[str]) -> None:
    allowed, hint = attributes.advice(node.tag, known)
    # an element with a prefix is of another namespace: a tool's own, unless it stands for a part of the file
    foreign, included = ":" in node.tag, node.tag.endswith(":include")
    wrong = included if foreign else allowed and _slip(node.tag, known)
    severity: Severity = "error" if wrong else "warning"
    text = "unknown element here"
    above = "" if node.parent is None else node.parent.tag
    repair = "" if included or above in OF_THE_WAY else "it is left out"
    details = Told(found=node.tag, allowed=allowed, hint=hint, repair=repair, severity=severity)
    attributes.report(_CODE, node, text, **details)


def _attributes(attributes: Attributes, node: Node) -> None:
    for name in sorted(node.attributes.keys() - ATTRIBUTES[node.tag]):
        absent = ATTRIBUTES[node.tag] - node.attributes.keys()
        allowed, hint = attributes.advice(name, absent)
        severity: Severity = "error" if allowed and _slip(name, absent) else "warning"
        repair = "" if node.tag in OF_THE_WAY else "it is left out"
        details = Told(attribute=name, found=name, allowed=allowed, hint=hint, repair=repair, severity=severity)
        attributes.report(_CODE, node, "unknown attribute", **details)


def _slip(name: str, known: Iterable[str]) -> bool:
    """Whether a name is a known one with a letter or two wrong."""
    return bool(difflib.get_close_matches(name[:80].lower(), [each.lower() for each in known], n=1, cutoff=ALIKE))
