"""Elements of an OpenDRIVE file as plain data, named as in the standard; SI units, angles in rad.

Only what the product uses is kept. Every element that a message may name carries its 1-based line.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from openscenario.findings import Finding

Contact = Literal["start", "end", ""]
Rule = Literal["RHT", "LHT"]

# Lane types that a motor vehicle may drive on (ASAM OpenDRIVE 1.8, table "lane types").
DRIVABLE = frozenset(
    (
        *("driving", "bidirectional", "shared", "stop", "bus", "taxi", "HOV", "special1", "special2", "special3"),
        *("entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane", "mwyEntry", "mwyExit"),
    )
)


class Cubic(msgspec.Struct, frozen=True):
    """a + b ds + c ds^2 + d ds^3 from s [m] on."""

    s: float
    a: float
    b: float
    c: float
    d: float


class Shape(msgspec.Struct, frozen=True):
    """Height a + b dt + c dt^2 + d dt^3 above the cross-section from t [m] to the left, at s [m]; linear between s."""

    s: float
    t: float
    a: float
    b: float
    c: float
    d: float


class Geometry(msgspec.Struct, frozen=True):
    """One geometry of a reference line.

    `values` by kind: arc curvature; spiral curvStart, curvEnd; poly3 a to d; paramPoly3 aU to dU, aV to dV.
    """

    s: float
    x: float
    y: float
    hdg: float
    length: float
    kind: Literal["line", "arc", "spiral", "poly3", "paramPoly3"]
    values: tuple[float, ...]
    normalized: bool
    line: int


class LaneHeight(msgspec.Struct, frozen=True):
    """Height of a lane's inner and outer edge above the road plane [m] from s [m] of the section on."""

    s: float
    inner: float
    outer: float


class SpeedLimit(msgspec.Struct, frozen=True):
    """Speed limit [m/s] from s [m] on (of the road or the section); inf for no limit."""

    s: float
    max: float


class RoadMark(msgspec.Struct, frozen=True):
    """Marking of a lane's outer border from s [m] of the section on."""

    s: float
    type: str
    lane_change: str


class Friction(msgspec.Struct, frozen=True):
    """Friction coefficient [-] of a lane's material from s [m] of its section on."""

    s: float
    friction: float


class Lane(msgspec.Struct, frozen=True):
    """A lane of a section; id > 0 left of the reference line, 0 the centre lane."""

    id: int
    type: str
    level: bool
    widths: tuple[Cubic, ...]
    borders: tuple[Cubic, ...]
    heights: tuple[LaneHeight, ...]
    speeds: tuple[SpeedLimit, ...]
    marks: tuple[RoadMark, ...]
    predecessors: tuple[int, ...]
    successors: tuple[int, ...]
    line: int
    direction: str = "standard"
    frictions: tuple[Friction, ...] = ()

    @property
    def drivable(self) -> bool:
        """Whether a motor vehicle may drive here."""
        return self.id != 0 and self.type in DRIVABLE


class LaneSection(msgspec.Struct, frozen=True):
    """Lanes, leftmost first (ids descend to the right without a gap), from s [m] to the next section."""

    s: float
    lanes: tuple[Lane, ...]
    line: int

    @property
    def left(self) -> int:
        """Number of lanes left of the centre lane."""
        return self.lanes[0].id if self.lanes else 0


class RoadLink(msgspec.Struct, frozen=True):
    """What a road is linked to at one of its ends."""

    kind: Literal["road", "junction"]
    id: str
    contact: Contact
    line: int
    s: float | None = None  # [m] on the main road of a virtual junction
    direction: str = ""


class RoadType(msgspec.Struct, frozen=True):
    """Type of a road (town, motorway ...) from s [m] on, with its speed limit [m/s] or None."""

    s: float
    type: str
    speed: float | None


class Corner(msgspec.Struct, frozen=True):
    """A corner of an outline: local u, v [m] in the object's frame, or s, t [m] on the road."""

    a: float
    b: float
    on_road: bool


class Repeat(msgspec.Struct, frozen=True):
    """An object repeated from s over length, each `distance` [m] (0: one continuous object)."""

    s: float
    length: float
    distance: float
    t_start: float
    t_end: float
    width_start: float
    width_end: float


class RoadObject(msgspec.Struct, frozen=True):
    """An object at s, t [m] of a road; hdg [rad] relative to the road."""

    id: str
    name: str
    type: str
    s: float
    t: float
    z_offset: float
    hdg: float
    length: float
    width: float
    height: float
    radius: float
    outlines: tuple[tuple[Corner, ...], ...]
    repeats: tuple[Repeat, ...]
    line: int


class Signal(msgspec.Struct, frozen=True):
    """A traffic sign or light at s, t [m] of a road; `value` as written (a speed limit, say).

    A signalReference of the file is a further Signal of the same id: on the road that refers to it, with the place,
    orientation and validity that stand there. `validity`: ranges (lowest, highest) of the lane ids that it is for;
    without any it is for all lanes of its orientation.
    """

    id: str
    name: str
    road: str
    s: float
    t: float
    z_offset: float
    h_offset: float
    type: str
    subtype: str
    country: str
    dynamic: bool
    orientation: str
    value: float | None
    unit: str
    width: float
    height: float
    line: int
    validity: tuple[tuple[int, int], ...] = ()


class Road(msgspec.Struct, frozen=True):
    """A road: reference line, profiles [m, rad], lane sections, and what stands on it."""

    id: str
    name: str
    length: float
    junction: str
    rule: Rule
    predecessor: RoadLink | None
    successor: RoadLink | None
    types: tuple[RoadType, ...]
    geometries: tuple[Geometry, ...]
    elevations: tuple[Cubic, ...]
    superelevations: tuple[Cubic, ...]
    lane_offsets: tuple[Cubic, ...]
    sections: tuple[LaneSection, ...]
    objects: tuple[RoadObject, ...]
    signals: tuple[Signal, ...]
    line: int
    shapes: tuple[Shape, ...] = ()


class Connection(msgspec.Struct, frozen=True):
    """A way through a junction: from `incoming` onto `connecting` (in a direct junction the linked road itself)."""

    id: str
    incoming: str
    connecting: str
    contact: Contact
    lane_links: tuple[tuple[int, int], ...]
    line: int


class Junction(msgspec.Struct, frozen=True):
    """A junction: default, direct or virtual."""

    id: str
    name: str
    type: str
    connections: tuple[Connection, ...]
    line: int


class OpenDrive(msgspec.Struct, frozen=True):
    """A road network file; `geo_reference` is the projection string as written (empty if none).

    `repairs`: faults of the file in whose place the reader assumed something.
    """

    path: str
    version: tuple[int, int]
    geo_reference: str
    geo_offset: tuple[float, float, float, float]
    roads: tuple[Road, ...]
    junctions: tuple[Junction, ...]
    repairs: tuple[Finding, ...] = ()


def lane_direction(lane: int, rule: int, reversed_: bool = False) -> int:
    """+1 if traffic on the lane runs with increasing s; rule is +1 for right-hand traffic, -1 for left-hand."""
    sign = rule if lane <= 0 else -rule
    return -sign if reversed_ else sign
