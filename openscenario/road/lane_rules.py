"""Lane rules: order and place of lane sections, widths and borders, and links of lanes that have no width there."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from openscenario.findings import listed, nearest
from openscenario.road.attributes import Attributes, by_tag
from openscenario.road.elements import Cubic, Lane, LaneSection, Road
from openscenario.xml import Node

NO_WIDTH = 1e-3  # m
NEGATIVE = 0.01  # m; cubics end a little below zero where a lane vanishes
CROSSED = 5e-7  # m, of one border beyond the other: ASAM's own checker allows 1e-6
ROUNDING = 0.01  # m, of written stations
_OF_TRAFFIC = (
    "none driving stop shoulder biking sidewalk border restricted parking curb bidirectional median bus taxi HOV"
)
_OF_RAMPS = "entry exit offRamp onRamp connectingRamp mwyEntry mwyExit slipLane shared walking"
_OTHERS = "special1 special2 special3 roadWorks tram rail"
LANE_TYPES = frozenset(f"{_OF_TRAFFIC} {_OF_RAMPS} {_OTHERS}".split())


def check_lanes(attributes: Attributes, road: Road, node: Node) -> None:
    """Add a finding for each broken rule of a road's lanes; `node` is the road element."""
    sections = _section_nodes(node)
    _stations(attributes, road, sections)
    ends = [*(section.s for section in road.sections[1:]), road.length]
    ordered = sorted(sections, key=lambda item: float(item.get("s")))
    for section, end, section_node in zip(road.sections, ends, ordered, strict=True):
        lanes = _lanes(section, section_node)
        for lane, lane_node in lanes:
            _type(attributes, lane, lane_node)
            if lane.id:
                _widths(attributes, lane, end - section.s, lane_node)
        _no_width(attributes, end - section.s, lanes)
        _borders(attributes, road, section, end - section.s, lanes)


def width_at(lane: Lane, ds: float) -> float:
    """Width [m] of a lane written by width records, ds [m] into its section; NaN if it is written by borders."""
    return value_at(lane.widths, ds)


def value_at(records: Sequence[Cubic], ds: float) -> float:
    """What the record that holds at ds [m] has there; NaN before the first one."""
    record = next((record for record in reversed(records) if record.s <= ds + 1e-9), None)
    if record is None:
        return math.nan
    u = ds - record.s
    return record.a + u * (record.b + u * (record.c + u * record.d))


def _section_nodes(road: Node) -> list[Node]:
    lanes = road.find("lanes")
    return [] if lanes is None else lanes.findall("laneSection")


def _lanes(section: LaneSection, node: Node) -> list[tuple[Lane, Node]]:
    """The lanes with their elements."""
    nodes = {int(lane.get("id")): lane for side in node.children for lane in side.findall("lane")}
    return [(lane, nodes[lane.id]) for lane in section.lanes if lane.id in nodes]


def _stations(attributes: Attributes, road: Road, sections: Sequence[Node]) -> None:
    """Sections ascend and lie on the road."""
    for before, node in pairwise(sections):
        if float(node.get("s")) <= float(before.get("s")):
            attributes.report(
                "asam.net:xodr:1.4.0:road.lane_section.elem_asc_order",
                node,
                "lane sections must ascend along the road",
                attribute="s",
                found=node.get("s"),
                allowed=f"s > {before.get('s')}",
            )
    for node in sections:
        if not -ROUNDING <= float(node.get("s")) < max(road.length, ROUNDING) + ROUNDING:
            attributes.report(
                "road.s_out_of_range",
                node,
                "the lane section lies beyond the road",
                attribute="s",
                found=node.get("s"),
                allowed=f"0 to {road.length:g} m",
            )


def _type(attributes: Attributes, lane: Lane, node: Node) -> None:
    if lane.type not in LANE_TYPES:
        near = nearest(lane.type, LANE_TYPES)  # a slip of the pen may mean a lane to drive on
        attributes.report(
            "asam.net:xodr:1.0.0:xml.valid_schema",
            node,
            "no such type of lane",
            attribute="type",
            found=lane.type,
            allowed=listed(sorted(LANE_TYPES)),
            hint=near,
            repair="" if near or not lane.type else "no motor vehicle drives on this lane",
        )


def _lowest(record: Cubic, span: float) -> float:
    """The least value of a cubic over `span` [m] from its start."""
    places = [0.0, span]
    # roots of b + 2 c u + 3 d u^2
    if abs(record.d) > 1e-15:
        root = record.c * record.c - 3.0 * record.b * record.d
        if root >= 0.0:
            places += [(-record.c + sign * math.sqrt(root)) / (3.0 * record.d) for sign in (1.0, -1.0)]
    elif abs(record.c) > 1e-15:
        places.append(-0.5 * record.b / record.c)
    return min(record.a + u * (record.b + u * (record.c + u * record.d)) for u in places if 0.0 <= u <= span)


def _widths(attributes: Attributes, lane: Lane, length: float, node: Node) -> None:
    """A lane has a width, or a border, and is never narrower than nothing."""
    if not lane.widths and not lane.borders:
        text = "a lane beside the centre needs a width or a border"
        code, assumed = "asam.net:xodr:1.0.0:xml.valid_schema", "" if lane.drivable else "the lane has no width"
        attributes.report(code, node, text, allowed="width, border", repair=assumed)
    for number, record in enumerate(lane.widths):
        end = lane.widths[number + 1].s if number + 1 < len(lane.widths) else length
        lowest = _lowest(record, max(0.0, end - record.s))
        if lowest < -NEGATIVE:
            elements = sorted(by_tag(node)["width"], key=lambda item: float(item.get("sOffset", "0")))
            attributes.report(
                "asam.net:xodr:1.4.0:road.lane.width.non_negative",
                elements[max(number - len(lane.widths) + len(elements), 0)],  # the reader may have added the first
                "the lane's width is negative",
                attribute="a" if record.a < -NEGATIVE else "",
                found=f"{lowest:.3g} m",
                allowed=">= 0 m",
                repair="" if lane.drivable else "the borders of the lane cross there, as it is written",
            )
            return


def _no_width(attributes: Attributes, length: float, lanes: list[tuple[Lane, Node]]) -> None:
    """A lane that begins with no width comes from no lane, and one that ends with none leads to none.

    Many tools write such a link, and alone it harms nobody. It does where one lane leads to two of which one appears.
    """
    before = Counter(number for lane, _ in lanes for number in lane.predecessors)
    for lane, element in lanes:
        for ds, links, rule, text in (
            (0.0, lane.predecessors, "zero_width_at_start", "begins with no width but has a predecessor"),
            (length, lane.successors, "zero_width_at_end", "ends with no width but has a successor"),
        ):
            if links and lane.widths and abs(width_at(lane, ds)) < NO_WIDTH:
                attributes.report(
                    f"asam.net:xodr:1.7.0:road.lane.link.{rule}",
                    element,
                    f"the lane {text}",
                    found=f"lane {links[0]}",
                    allowed="no link there",
                    severity="error" if ds == 0.0 and before[links[0]] > 1 else "warning",
                    repair="whoever follows the link starts on a lane without width",
                )


def _borders(
    attributes: Attributes, road: Road, section: LaneSection, length: float, lanes: list[tuple[Lane, Node]]
) -> None:
    """A lane's outer border lies outside of the border of the lane inside of it, or of the centre lane."""
    if not any(_by_border(lane) for lane in section.lanes):
        return
    nodes = {lane.id: element for lane, element in lanes}
    records = [record for lane in section.lanes for record in (*lane.widths, *lane.borders)]
    stations = sorted({0.0, length, *(record.s for record in records if record.s <= length)})
    for side in (1, -1):
        inner = [value_at(road.lane_offsets, section.s + s) for s in stations]
        inner = [0.0 if math.isnan(t) else t for t in inner]
        for lane in sorted((lane for lane in section.lanes if lane.id * side > 0), key=lambda each: abs(each.id)):
            outer = [outer_border(lane, side, s, t) for s, t in zip(stations, inner, strict=True)]
            inside = [s for s, a, b in zip(stations, inner, outer, strict=True) if side * (b - a) < -CROSSED]
            if _by_border(lane) and inside:
                before = lane.id - side
                attributes.report(
                    "asam.net:xodr:1.4.0:road.lane.border.overlap_with_inner_lanes",
                    nodes[before or lane.id],
                    f"lane {lane.id} begins inside of " + (f"lane {before}" if before else "the centre lane"),
                    found=f"borders cross {inside[0]:g} m into the section",
                    allowed="borders in the order of the lanes",
                )
                return
            inner = outer


def _by_border(lane: Lane) -> bool:
    return bool(lane.borders and not lane.widths)


def outer_border(lane: Lane, side: int, s: float, inner: float) -> float:
    """t [m] of a lane's outer border, s [m] into its section."""
    value = value_at(lane.borders if _by_border(lane) else lane.widths, s)
    return value if _by_border(lane) else inner + side * (0.0 if math.isnan(value) else value)
