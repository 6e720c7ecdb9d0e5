"""Small OpenDRIVE files for the tests of the road room."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from openscenario.road.network import RoadNetwork, load_network

LINE = "<line/>"


def geometry(s: float, x: float, y: float, hdg: float, length: float, shape: str = LINE) -> str:
    return f'<geometry s="{s}" x="{x}" y="{y}" hdg="{hdg}" length="{length}">{shape}</geometry>'


def arc(curvature: float) -> str:
    return f'<arc curvature="{curvature}"/>'


def spiral(start: float, end: float) -> str:
    return f'<spiral curvStart="{start}" curvEnd="{end}"/>'


def cubic(tag: str, s: float, a: float, b: float = 0.0, c: float = 0.0, d: float = 0.0) -> str:
    key = "sOffset" if tag in ("width", "border") else "s"
    return f'<{tag} {key}="{s}" a="{a}" b="{b}" c="{c}" d="{d}"/>'


def lane(
    id_: int,
    width: float = 3.5,
    type_: str = "driving",
    before: int | None = None,
    after: int | None = None,
    inside: str | None = None,
) -> str:
    links = "" if before is None else f'<predecessor id="{before}"/>'
    links += "" if after is None else f'<successor id="{after}"/>'
    body = inside if inside is not None else cubic("width", 0.0, width)
    return f'<lane id="{id_}" type="{type_}"><link>{links}</link>{body}</lane>'


def section(left: Sequence[str] = (), right: Sequence[str] = (), s: float = 0.0) -> str:
    """A lane section; lanes from the centre outwards."""
    sides = f"<left>{''.join(reversed(left))}</left>" if left else ""
    sides += '<center><lane id="0" type="none"/></center>'
    sides += f"<right>{''.join(right)}</right>" if right else ""
    return f'<laneSection s="{s}">{sides}</laneSection>'


TWO_WAY = section([lane(1)], [lane(-1)])


def road(
    id_: str,
    geometries: str,
    length: float,
    sections: str = TWO_WAY,
    *,
    link: str = "",
    junction: str = "-1",
    rule: str = "RHT",
    elevation: str = "",
    superelevation: str = "",
    offset: str = "",
    objects: str = "",
    signals: str = "",
) -> str:
    return f"""
  <road id="{id_}" name="road {id_}" length="{length}" junction="{junction}" rule="{rule}">
    <link>{link}</link>
    <planView>{geometries}</planView>
    <elevationProfile>{elevation}</elevationProfile>
    <lateralProfile>{superelevation}</lateralProfile>
    <lanes>{offset}{sections}</lanes>
    <objects>{objects}</objects>
    <signals>{signals}</signals>
  </road>"""


def straight(id_: str, x: float, y: float, hdg: float, length: float, sections: str = TWO_WAY, **parts: str) -> str:
    return road(id_, geometry(0.0, x, y, hdg, length), length, sections, **parts)


def to_road(end: str, id_: str, contact: str) -> str:
    return f'<{end} elementType="road" elementId="{id_}" contactPoint="{contact}"/>'


def to_junction(end: str, id_: str) -> str:
    return f'<{end} elementType="junction" elementId="{id_}"/>'


def write(folder: Path, *parts: str, header: str = "") -> Path:
    path = folder / "road.xodr"
    head = f'<header revMajor="1" revMinor="7">{header}</header>'
    path.write_text(f'<?xml version="1.0"?>\n<OpenDRIVE>\n{head}{"".join(parts)}\n</OpenDRIVE>\n')
    return path


def network(folder: Path, *parts: str, header: str = "") -> RoadNetwork:
    return load_network(write(folder, *parts, header=header))


def crossing(folder: Path) -> RoadNetwork:
    """Roads W (from the west) and E meet N (to the north) in junction J; ways: W-E 10, E-W 11, W-N 12 (left turn).

    W runs along x from -100 to -10, E from 10 to 100, N along y from 10 to 100.
    """
    one_way = section((), [lane(-1, before=-1, after=-1)])
    quarter = 10.0 * 1.5707963267948966

    def connection(number: int, incoming: str, connecting: str, lanes: tuple[int, int] = (-1, -1)) -> str:
        link = f'<laneLink from="{lanes[0]}" to="{lanes[1]}"/>'
        attributes = f'id="{number}" incomingRoad="{incoming}" connectingRoad="{connecting}" contactPoint="start"'
        return f"<connection {attributes}>{link}</connection>"

    east = section((), [lane(-1, before=-1, after=-1)])
    west = section((), [lane(-1, before=1, after=1)])
    return network(
        folder,
        straight("W", -100.0, 0.0, 0.0, 90.0, link=to_junction("successor", "J")),
        straight("E", 10.0, 0.0, 0.0, 90.0, link=to_junction("predecessor", "J")),
        straight("N", 0.0, 10.0, 1.5707963267948966, 90.0, link=to_junction("predecessor", "J")),
        straight(
            "10", -10.0, 0.0, 0.0, 20.0, east, junction="J",
            link=to_road("predecessor", "W", "end") + to_road("successor", "E", "start"),
        ),
        straight(
            "11", 10.0, 0.0, 3.141592653589793, 20.0, west, junction="J",
            link=to_road("predecessor", "E", "start") + to_road("successor", "W", "end"),
        ),
        road(
            "12", geometry(0.0, -10.0, 0.0, 0.0, quarter, arc(0.1)), quarter, one_way, junction="J",
            link=to_road("predecessor", "W", "end") + to_road("successor", "N", "start"),
        ),
        '<junction id="J" name="J">',
        connection(0, "W", "10"),
        connection(1, "E", "11", (1, -1)),
        connection(2, "W", "12"),
        "</junction>",
    )  # fmt: skip
