"""Lane sections with singleSide="true": the other side of the road goes on under them."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork
from openscenario.road.opendrive import examine_opendrive, read_opendrive

ROAD = """<OpenDRIVE><header revMajor="1" revMinor="7"/><road id="1" length="300" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="300"><line/></geometry></planView>
<lanes>{}</lanes></road></OpenDRIVE>"""


def lane(number: int, records: str, link: str = "") -> str:
    return f'<lane id="{number}" type="driving"><link>{link}</link>{records}</lane>'


def width(a: float, b: float = 0.0, c: float = 0.0, s: float = 0.0) -> str:
    return f'<width sOffset="{s}" a="{a}" b="{b}" c="{c}" d="0"/>'


def section(s: float, left: str = "", right: str = "", single: bool = False) -> str:
    sides = "".join(f"<{name}>{lanes}</{name}>" for name, lanes in (("left", left), ("right", right)) if lanes)
    more = ' singleSide="true"' if single else ""
    return f'<laneSection s="{s}"{more}><center><lane id="0" type="none"/></center>{sides}</laneSection>'


def written(folder: Path, *sections: str) -> Path:
    path = folder / "road.xodr"
    path.write_text(ROAD.format("".join(sections)))
    return path


def test_a_side_goes_on_under_sections_of_the_other_side(tmp_path: Path) -> None:
    """The width is 3 + 0.01 ds, and from 150 m on 4.5 m, wherever sections of the left side begin."""
    right = lane(-1, width(3.0, 0.01) + width(4.5, s=150.0))
    path = written(
        tmp_path,
        section(0, lane(1, width(3.5)), right),
        section(100, lane(1, width(3.5)) + lane(2, width(3.0)), single=True),
        section(200, lane(1, width(3.5)), single=True),
    )
    assert examine_opendrive(path)[1] == ()
    network = RoadNetwork(read_opendrive(path))
    for s, wide in ((50.0, 3.5), (120.0, 4.2), (149.0, 4.49), (160.0, 4.5), (299.0, 4.5)):
        assert network.lane_width("1", -1, s) == pytest.approx(wide)
    assert [network.lane_width("1", 2, s) for s in (50.0, 150.0, 250.0)] == [0.0, 3.0, 0.0]
    place = network.locate(50.0, -1.75, 0.0)
    assert network.advance(place, 200.0).s == pytest.approx(250.0)


def test_a_cubic_is_the_same_one_beyond_the_cut(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        section(0, lane(1, width(3.5)), lane(-1, width(3.0, 0.02, -5e-5))),
        section(100, lane(1, width(3.5)), single=True),
    )
    network = RoadNetwork(read_opendrive(path))
    for s in (99.0, 101.0, 250.0):
        assert network.lane_width("1", -1, s) == pytest.approx(3.0 + 0.02 * s - 5e-5 * s * s)


def test_two_sections_of_one_side_each_at_one_place_are_one(tmp_path: Path) -> None:
    left, right = lane(1, width(3.5)), lane(-1, width(3.0))
    path = written(tmp_path, section(0, left=left, single=True), section(0, right=right, single=True))
    assert examine_opendrive(path)[1] == ()
    (road,) = read_opendrive(path).roads
    assert [[each.id for each in part.lanes] for part in road.sections] == [[1, 0, -1]]


def test_without_the_attribute_a_side_ends_where_a_section_has_none(tmp_path: Path) -> None:
    path = written(tmp_path, section(0, lane(1, width(3.5)), lane(-1, width(3.0))), section(100, lane(1, width(3.5))))
    assert RoadNetwork(read_opendrive(path)).lane_width("1", -1, 150.0) == 0.0


def test_a_place_that_is_no_number_is_for_the_reader(tmp_path: Path) -> None:
    left = section(0, lane(1, width(3.5)), lane(-1, width(3.0)))
    path = written(tmp_path, left, section(100, lane(1, width(3.5)), single=True).replace('"100"', '"far"'))
    assert "value.not_a_number" in [each.code for each in examine_opendrive(path)[1]]
