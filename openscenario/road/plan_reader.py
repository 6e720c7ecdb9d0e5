"""Reads a road's plan view and its profiles: geometries, elevation, superelevation, lane offset."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal, TypeVar

from openscenario.road.attributes import Attributes, by_tag
from openscenario.road.elements import Cubic, Geometry, RoadType, Shape, SpeedLimit
from openscenario.road.shapes import NODES, WEIGHTS
from openscenario.xml import Node

MAX_LENGTH = 1e7  # m, of one geometry: more is a slip of the pen and would only burn memory
MAX_CURVATURE = 100.0  # 1/m
MAX_COEFFICIENT = 1e6  # of a cubic: no width, height or slope of a road is that large in any unit
MAX_COORDINATE = 1e8  # m; projected coordinates of the whole earth stay below
LENGTH_TOLERANCE = 0.01  # m, of a paramPoly3's length; in the wild it is right to 0.7 mm
LENGTH_SHARE = 1e-4  # of a length, by which stated and measured length may differ; chosen, not measured
PARAM_TOLERANCE = 1e-3  # of the first coefficients of a paramPoly3, which tools write with rounding
SORTED = "the records in the order of their places"
CONSTANT = "the width keeps its first value: such a slope comes from a section of nearly no length"
MAX_SCALE = 0.05  # share by which a curve and its stated length may differ: more, and another curve is meant
MAX_POINT = 1.0  # m, of a road whose only geometry has no length
_PANELS = 8  # of the quadrature along a curve
_KINDS = ("line", "arc", "spiral", "poly3", "paramPoly3")
_Placed = TypeVar("_Placed", Cubic, RoadType, SpeedLimit)
_PARAMS = ("aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV")


def read_cubics(attributes: Attributes, nodes: list[Node], key: str = "s") -> tuple[Cubic, ...]:
    """Cubic records in ascending order of `key` (s or sOffset)."""
    records: list[Cubic] = []
    for node in nodes:
        get = node.get  # "" where missing, which float() refuses
        try:
            record = Cubic(float(get(key, "0")), float(get("a")), float(get("b")), float(get("c")), float(get("d")))
            size = abs(record.a) + abs(record.b) + abs(record.c) + abs(record.d)
            clean = size < MAX_COEFFICIENT and abs(record.s) < MAX_LENGTH  # false for NaN as well
            clean = clean and "_" not in "".join(node.attributes.values())
        except ValueError:
            clean = False
        if not clean:  # the slow way names what is wrong
            s, a, b, c, d = attributes.number(node, key, 0.0), *(attributes.number(node, name) for name in "abcd")
            record = Cubic(s, a, b, c, d)
            for name, value in ((key, s), ("a", a)):
                bounded(attributes, node, name, value, MAX_COEFFICIENT if name != key else MAX_LENGTH)
            with attributes.repairing(CONSTANT if key == "sOffset" else ""):
                known = len(attributes.findings)
                for name, value in (("b", b), ("c", c), ("d", d)):
                    bounded(attributes, node, name, value, MAX_COEFFICIENT)
            if len(attributes.findings) > known:
                record = Cubic(s, a, 0.0, 0.0, 0.0)
        if key == "sOffset" and record.s < 0.0:
            _negative(attributes, node)
        records.append(record)
    return in_order(attributes, nodes, records, key)


def in_order(attributes: Attributes, nodes: list[Node], records: list[_Placed], key: str) -> tuple[_Placed, ...]:
    """The records, read one from each node, in ascending order of s; with a finding at each that begins too early."""
    early = [node for node, (before, record) in zip(nodes[1:], pairwise(records), strict=True) if record.s < before.s]
    for node in early:
        attributes.report(
            "asam.net:xodr:1.4.0:road.profile.elem_asc_order",
            node,
            "records must ascend along the road",
            attribute=key,
            found=node.get(key),
            repair=SORTED,
        )
    return tuple(sorted(records, key=lambda record: record.s) if early else records)


def read_shapes(attributes: Attributes, nodes: list[Node]) -> tuple[Shape, ...]:
    """Records of a road's shape, in ascending order of s, at each s in ascending order of t."""
    records: list[Shape] = []
    for node in nodes:
        values = [attributes.number(node, name) for name in ("s", "t", "a", "b", "c", "d")]
        for name, value in zip(("s", "t", "a", "b", "c", "d"), values, strict=True):
            bounded(attributes, node, name, value, MAX_LENGTH if name in "st" else MAX_COEFFICIENT)
        record = Shape(*values)
        if records and (record.s, record.t) < (records[-1].s, records[-1].t):
            attributes.report(
                "asam.net:xodr:1.4.0:road.profile.elem_asc_order",
                node,
                "records must ascend along the road, and from right to left at each place",
                attribute="s" if record.s < records[-1].s else "t",
                found=node.get("s" if record.s < records[-1].s else "t"),
                repair=SORTED,
            )
        records.append(record)
    return tuple(sorted(records, key=lambda record: (record.s, record.t)))


def _negative(attributes: Attributes, node: Node) -> None:
    found = node.get("sOffset")
    text = "it begins before its lane section"
    attributes.report("value.out_of_range", node, text, attribute="sOffset", found=found, allowed=">= 0 m")


def read_geometries(attributes: Attributes, plan_view: Node) -> tuple[Geometry, ...]:
    """Geometries of a plan view."""
    geometries: list[Geometry] = []
    nodes = by_tag(plan_view).get("geometry", [])
    if not nodes:
        attributes.report("xml.valid_schema", plan_view, "a road needs at least one geometry")
    for node in nodes:
        geometry = _read_geometry(attributes, node)
        if geometry is None:
            continue
        if geometries and geometry.s < geometries[-1].s:
            attributes.report(
                "asam.net:xodr:1.4.0:road.geometry.elem_asc_order",
                node,
                "geometries must ascend along the road",
                found=node.get("s"),
                allowed=f"s >= {geometries[-1].s:g}",
                repair="the geometries in the order of their places",  # a gap that this leaves is found later
            )
        geometries.append(geometry)
    geometries.sort(key=lambda geometry: geometry.s)
    if nodes and not geometries:
        geometries = _point(attributes, plan_view, nodes[0])
    return tuple(geometries)


def _point(attributes: Attributes, plan_view: Node, node: Node) -> list[Geometry]:
    """A straight line in place of geometries without length: converters write a joint of two roads that way."""
    road = plan_view.parent
    length = 0.0 if road is None else attributes.number(road, "length", 0.0)
    assumed = f"a straight line of the road's length, {length:g} m" if 0.0 < length <= MAX_POINT else ""
    text = "a road needs a geometry with a length"
    attributes.report("xml.valid_schema", plan_view, text, allowed="length > 0", repair=assumed)
    if not assumed:
        return []
    s, x, y, hdg = (attributes.number(node, name) for name in ("s", "x", "y", "hdg"))
    return [Geometry(s, x, y, hdg, length, "line", (), False, node.line)]


def _read_geometry(attributes: Attributes, node: Node) -> Geometry | None:
    s, x, y, hdg, length = (attributes.number(node, name) for name in ("s", "x", "y", "hdg", "length"))
    for name, value in (("x", x), ("y", y), ("hdg", hdg)):
        bounded(attributes, node, name, value, MAX_COORDINATE)
    if not 0.0 <= length <= MAX_LENGTH:
        attributes.report(
            "value.out_of_range",
            node,
            "a geometry has no such length",
            attribute="length",
            found=node.get("length"),
            allowed=f"0 to {MAX_LENGTH:g} m",
        )
        return None
    if length == 0.0:
        attributes.report(
            "asam.net:xodr:1.4.0:road.geometry.length",
            node,
            "a geometry without length is left out",
            attribute="length",
            severity="warning",
        )
        return None
    kinds = [(child.tag, child) for child in node.children if child.tag in _KINDS]
    if len(kinds) != 1:
        attributes.report("xml.valid_schema", node, "a geometry is exactly one of these", allowed=", ".join(_KINDS))
        return None
    tag, shape = kinds[0]
    kind: Literal["line", "arc", "spiral", "poly3", "paramPoly3"]
    values: tuple[float, ...] = ()
    normalized = False
    match tag:
        case "line":
            kind = "line"
        case "arc":
            kind, values = "arc", (_curvature(attributes, shape, "curvature"),)
        case "spiral":
            kind = "spiral"
            values = (_curvature(attributes, shape, "curvStart"), _curvature(attributes, shape, "curvEnd"))
        case "poly3":
            kind, values = "poly3", _coefficients(attributes, shape, tuple("abcd"))
        case _:
            kind, values = "paramPoly3", _coefficients(attributes, shape, _PARAMS)
            normalized = _is_normalized(attributes, shape, values, length)
            _check_param(attributes, shape, values)
            _check_length(attributes, node, values, length, 1.0 if normalized else length)
    return Geometry(s, x, y, hdg, length, kind, values, normalized, node.line)


def bounded(attributes: Attributes, node: Node, name: str, value: float, most: float) -> float:
    """The value; with a finding if it is larger than any road's."""
    if abs(value) > most:
        attributes.report(
            "value.out_of_range",
            node,
            f"no road has such a value of {name}",
            attribute=name,
            found=node.get(name),
            allowed=f"-{most:g} to {most:g}",
        )
    return value


def _curvature(attributes: Attributes, node: Node, name: str) -> float:
    return bounded(attributes, node, name, attributes.number(node, name), MAX_CURVATURE)


def _coefficients(attributes: Attributes, node: Node, names: tuple[str, ...]) -> tuple[float, ...]:
    return tuple(bounded(attributes, node, name, attributes.number(node, name), MAX_LENGTH) for name in names)


def _check_param(attributes: Attributes, node: Node, values: tuple[float, ...]) -> None:
    """A paramPoly3 begins at its own origin in the direction of its own heading."""
    a_u, b_u, _, _, a_v, b_v, _, _ = values
    if (
        abs(a_u) > PARAM_TOLERANCE
        or abs(a_v) > PARAM_TOLERANCE
        or abs(b_v) > PARAM_TOLERANCE * max(b_u, 1.0)
        or b_u <= 0
    ):
        attributes.report(
            "asam.net:xodr:1.7.0:road.geometry.paramPoly3.valid_parameters",
            node,
            "a paramPoly3 starts at its own origin, along its own heading",
            found=f"aU={a_u:g} bU={b_u:g} aV={a_v:g} bV={b_v:g}",
            allowed="aU=aV=bV=0, bU>0",
        )


def _is_normalized(attributes: Attributes, node: Node, values: tuple[float, ...], length: float) -> bool:
    """Whether p goes from 0 to 1 (normalized) or to the length (arcLength).

    Version 1.4 lets pRange be left out; readers then take the one or the other. The curve has its stated length by one
    of them only, unless that is 1 m; by none, it is normalized.
    """
    if "pRange" in node.attributes:
        return attributes.choice(node, "pRange", ("arcLength", "normalized"), "normalized") == "normalized"
    return _is_as_long(_curve_length(values, 1.0), length) or not _is_as_long(_curve_length(values, length), length)


def _curve_length(values: tuple[float, ...], last: float) -> float:
    """Length [m] of a paramPoly3 for p from 0 to `last`."""
    _, b_u, c_u, d_u, _, b_v, c_v, d_v = values
    measured = 0.0
    for panel in range(_PANELS):
        for at, weight in zip(NODES, WEIGHTS, strict=True):
            p = last * (panel + at) / _PANELS
            u1, v1 = b_u + p * (2.0 * c_u + 3.0 * d_u * p), b_v + p * (2.0 * c_v + 3.0 * d_v * p)
            measured += weight * math.hypot(u1, v1) * last / _PANELS
    return measured


def _is_as_long(measured: float, length: float) -> bool:
    return abs(measured - length) <= MAX_SCALE * length


def _check_length(attributes: Attributes, node: Node, values: tuple[float, ...], length: float, last: float) -> None:
    """The curve is as long as its geometry says, with p from 0 to 1 (normalized) or to the length (arcLength)."""
    measured = _curve_length(values, last)
    if not abs(measured - length) <= LENGTH_TOLERANCE + LENGTH_SHARE * length:
        close = _is_as_long(measured, length)
        attributes.report(
            f"asam.net:xodr:1.7.0:road.geometry.parampoly3.{'normalized' if last == 1.0 else 'arclength'}_range",
            node,
            "the curve is not as long as its geometry says",
            found=f"{measured:.6g} m",
            allowed=f"{length:.6g} m",
            repair="the whole curve, its stations scaled to the stated length" if close else "",
        )
