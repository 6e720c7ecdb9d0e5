"""Rules that a road file breaks: a finding at the right element, with the nearest name; the file mended has none."""

from __future__ import annotations

from pathlib import Path

import pytest
from road_files import cubic, geometry, lane, road, section, straight, to_junction, to_road, write

from openscenario.findings import Finding
from openscenario.road.opendrive import examine_opendrive

WIDTH = cubic("width", 0.0, 3.5)
PLAIN = section((), [lane(-1)])


def errors(path: Path) -> tuple[Finding, ...]:
    return tuple(item for item in examine_opendrive(path)[1] if item.severity == "error")


def junction(*connections: str) -> tuple[str, ...]:
    """Roads 1 and 2 joined by road 10 in junction J."""
    return (
        straight("1", 0, 0, 0, 50, link=to_junction("successor", "J")),
        straight("2", 70, 0, 0, 50, link=to_junction("predecessor", "J")),
        straight(
            "10", 50, 0, 0, 20, PLAIN, junction="J",
            link=to_road("predecessor", "1", "end") + to_road("successor", "2", "start"),
        ),
        f'<junction id="J" name="J">{"".join(connections)}</junction>',
    )  # fmt: skip


def connection(incoming: str = "1", connecting: str = "10", contact: str = "start", to: int = -1) -> str:
    names = f'id="0" incomingRoad="{incoming}" connectingRoad="{connecting}" contactPoint="{contact}"'
    return f'<connection {names}><laneLink from="-1" to="{to}"/></connection>'


def one(sections: str, **parts: str) -> tuple[str, ...]:
    return (straight("1", 0, 0, 0, 60, sections, **parts),)


SIGNAL = '<signal id="7" s="{s}" t="0" dynamic="no" orientation="{o}" type="-1" subtype="-1" zOffset="0"/>'
OBJECT = '<object id="7" s="{s}" t="0" type="obstacle" length="{length}" zOffset="0"/>'
TWICE = PLAIN + section((), [lane(-1)], s=30.0)

BROKEN = {
    "width of a lane": (one(section((), [lane(-1, -3.5)])), "width@a"),
    "width that turns negative": (
        one(section((), [lane(-1, inside=cubic("width", 0.0, 3.5, -0.1))])),
        "width",
    ),
    "type of a lane": (one(section((), [lane(-1, type_="drivng")])), "lane@type"),
    "border inside of the inner lane's": (
        one(section([lane(1, inside=cubic("border", 0.0, 4.0)), lane(2, inside=cubic("border", 0.0, 3.0))])),
        "lane[2]",
    ),
    "order of sections": (one(PLAIN + TWICE.replace('s="30.0"', 's="0.0"')), "laneSection[2]@s"),
    "section beyond the road": (one(TWICE.replace('s="30.0"', 's="300.0"')), "laneSection[2]@s"),
    "lane id taken": (one(section((), [lane(-1), lane(-1)])), "lane[2]@id"),
    "lane link across sections": (
        one(section((), [lane(-1, after=-4)]) + section((), [lane(-1)], s=30.0)),
        "lane",
    ),
    "lane link across roads": (
        (
            straight("1", 0, 0, 0, 50, section((), [lane(-1, after=-4)]), link=to_road("successor", "2", "start")),
            straight("2", 50, 0, 0, 50, PLAIN, link=to_road("predecessor", "1", "end")),
        ),
        "lane",
    ),
    "order of widths": (
        one(section((), [lane(-1, inside=cubic("width", 9.0, 3.5) + WIDTH)])),
        "width[2]@sOffset",
    ),
    "order of elevations": (
        one(PLAIN, elevation=cubic("elevation", 9, 0) + cubic("elevation", 0, 0)),
        "elevation[2]@s",
    ),
    "station of a geometry": (
        (road("1", geometry(0, 0, 0, 0, 60) + geometry(90, 60, 0, 0, 40), 130),),
        "geometry[2]@s",
    ),
    "length of a paramPoly3": (
        (
            road(
                "1",
                geometry(
                    0, 0, 0, 0, 60,
                    '<paramPoly3 pRange="normalized" aU="0" bU="30" cU="0" dU="0" aV="0" bV="0" cV="0" dV="0"/>',
                ),
                60,
            ),
        ),
        "geometry",
    ),
    "road that a link names": (one(PLAIN, link=to_road("successor", "7", "start")), "successor@elementId"),
    "junction that a link names": (one(PLAIN, link=to_junction("successor", "J")), "successor@elementId"),
    "junction that a road belongs to": (one(PLAIN, junction="J"), "road@junction"),
    "incoming road": (junction(connection(incoming="11")), "connection@incomingRoad"),
    "connecting road": (junction(connection(connecting="11")), "connection@connectingRoad"),
    "missing incoming road": (junction(connection().replace('incomingRoad="1"', "")), "connection@incomingRoad"),
    "contact point at the wrong end": (junction(connection(contact="end")), "connection@contactPoint"),
    "lane that a junction links": (junction(connection(to=-3)), "laneLink@to"),
    "connecting road that comes in": (junction(connection(incoming="10", connecting="1")), "connection@incomingRoad"),
    "two junctions of one id": ((*junction(connection()), '<junction id="J" name="J"/>'), "junction[2]@id"),
    "signal beyond the road": (one(PLAIN, signals=SIGNAL.format(s=99, o="+")), "signal@s"),
    "orientation of a signal": (one(PLAIN, signals=SIGNAL.format(s=9, o="left")), "signal@orientation"),
    "object of negative size": (one(PLAIN, objects=OBJECT.format(s=9, length=-1)), "object@length"),
    "signal that is referred to": (
        one(PLAIN, signals='<signalReference id="8" s="1" t="0" orientation="+"/>'),
        "signalReference@id",
    ),
    "signal of a controller": (
        (*one(PLAIN), '<controller id="1" name=""><control signalId="8" type=""/></controller>'),
        "control@signalId",
    ),
    "element with a slip": (
        one(PLAIN.replace("laneSection ", "laneSecton ", 1).replace("</laneSection", "</laneSecton")),
        "laneSecton",
    ),
    "border on the other side of the centre": (
        one(section((), [lane(-1, inside=cubic("border", 0, 3.5))])),
        "lane",
    ),
    "border inside of a lane written by its width": (
        one(section((), [lane(-1), lane(-2, inside=cubic("border", 0, -3.0))])),
        "lane[1]",
    ),
    "direction of a lane": (
        one(section((), [lane(-1).replace("type=", 'direction="reverse" type=')])),
        "lane@direction",
    ),
    "attribute with a slip": (one(section((), [lane(-1, inside=WIDTH.replace("sOffset", "sOfset"))])), "width@sOfset"),
    "include of a file": (
        (*one(PLAIN), '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="/etc/passwd"/>'),
        "xi:include",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_rule_is_found_at_its_element(tmp_path: Path, what: str) -> None:
    parts, element = BROKEN[what]
    found = errors(write(tmp_path, *parts))
    assert element in [finding.element.rpartition("/")[2] for finding in found], [str(finding) for finding in found]
    assert len(found) <= 2  # a slip may also leave something missing


@pytest.mark.parametrize("parts", [junction(connection()), one(TWICE)], ids=["junction", "sections"])
def test_the_same_files_mended_are_clean(tmp_path: Path, parts: tuple[str, ...]) -> None:
    assert examine_opendrive(write(tmp_path, *parts))[1] == ()


def test_the_nearest_name_is_offered(tmp_path: Path) -> None:
    (finding,) = errors(write(tmp_path, *one(section((), [lane(-1, type_="drivng")]))))
    assert "did you mean 'driving'?" in finding.message


def test_an_element_of_another_namespace_is_left_out_with_a_warning(tmp_path: Path) -> None:
    """Even if it is called nearly as one of the standard's."""
    own = '<v:data xmlns:v="urn:vendor"/><v:road xmlns:v="urn:vendor" id="x"/>'
    found = examine_opendrive(write(tmp_path, *one(PLAIN), own))[1]
    assert [(each.severity, each.found) for each in found] == [("warning", "v:data"), ("warning", "v:road")]


def test_a_file_whose_elements_have_the_prefix_of_its_namespace_is_read(tmp_path: Path) -> None:
    path = write(tmp_path, *one(PLAIN))
    start = path.read_text().index("<OpenDRIVE")
    text = path.read_text()[start:].replace("</", "\0").replace("<", "<x:").replace("\0", "</x:")
    path.write_text(text.replace("<x:OpenDRIVE", '<x:OpenDRIVE xmlns:x="http://code.asam.net/x"', 1))
    network, found = examine_opendrive(path)
    assert found == ()
    assert network is not None
    assert len(network.roads) == 1


def test_an_element_of_a_tools_own_is_left_out_with_a_warning(tmp_path: Path) -> None:
    path = write(tmp_path, *one(PLAIN), "<weatherStation/>")
    (finding,) = examine_opendrive(path)[1]
    assert (finding.severity, finding.element) == ("warning", "OpenDRIVE/weatherStation")


def test_a_version_of_the_future_is_refused_by_name(tmp_path: Path) -> None:
    path = write(tmp_path, *one(PLAIN))
    path.write_text(path.read_text().replace('revMinor="7"', 'revMinor="99"'))
    (finding,) = errors(path)
    assert finding.element == "OpenDRIVE/header@revMinor"
    assert "1.9" in finding.allowed


def test_a_lane_for_both_directions_is_driven_in_one_with_a_warning(tmp_path: Path) -> None:
    (finding,) = examine_opendrive(
        write(tmp_path, *one(section((), [lane(-1).replace("type=", 'direction="both" type=')])))
    )[1]
    assert (finding.severity, finding.found) == ("warning", "both")
    assert finding.element.endswith("lane@direction")


def warned(path: Path) -> list[tuple[str, str, str]]:
    found = examine_opendrive(path)[1]
    assert {each.severity for each in found} <= {"warning"}
    return [(each.code, each.element.rpartition("OpenDRIVE/")[2], each.found) for each in found]


def through(tmp_path: Path, x: float, y: float, z: float = 0.0, width: float = 3.5) -> Path:
    """A junction whose connecting road of 20 m begins at x, y, z [m]; it should begin at 100, 0, 0."""
    way = '<connection id="0" incomingRoad="1" connectingRoad="10" contactPoint="start">'
    inner = section((), [lane(-1, width, before=-1, after=-1)])
    links = to_road("predecessor", "1", "end") + to_road("successor", "2", "start")
    height = {"elevation": cubic("elevation", 0.0, z)}
    return write(
        tmp_path,
        straight("1", 0, 0, 0, 100, section((), [lane(-1)]), link=to_junction("successor", "J")),
        straight("2", x + 20.0, y, 0, 100, section((), [lane(-1)]), link=to_junction("predecessor", "J"), **height),
        straight("10", x, y, 0, 20, inner, junction="J", link=links, **height),
        f'<junction id="J" name="J">{way}<laneLink from="-1" to="-1"/></connection></junction>',
    )


@pytest.mark.parametrize(
    ("place", "gap"), [((103.0, 0.0), 3.0), ((100.0, 5.0), 1.5), ((97.0, 0.0), 3.0), ((100.0, 0.0, 4.0), 4.0)]
)
def test_a_connecting_road_that_does_not_meet_its_road_is_told(
    tmp_path: Path, place: tuple[float, ...], gap: float
) -> None:
    expected = ("road.joint_gap", "road[3]/link/predecessor", f"a gap of {gap:g} m")
    assert warned(through(tmp_path, *place)) == [expected]


@pytest.mark.parametrize("place", [(100.4, 0.0), (100.0, 3.0), (100.0, -3.0), (100.0, 0.0, 0.4)])
def test_lanes_that_touch_meet(tmp_path: Path, place: tuple[float, ...]) -> None:
    assert warned(through(tmp_path, *place)) == []


def test_a_step_in_the_height_of_a_road_is_told(tmp_path: Path) -> None:
    steps = cubic("elevation", 0.0, 0.0, 0.1) + cubic("elevation", 50.0, 13.0) + cubic("elevation", 80.0, 13.4)
    path = write(tmp_path, straight("1", 0, 0, 0, 100, elevation=steps))
    assert warned(path) == [("road.height_step", "road/elevationProfile", "a step of 8 m")]
    path = write(tmp_path, straight("1", 0, 0, 0, 100, elevation=cubic("elevation", 5.0, 2.0)))
    assert warned(path) == [("road.height_step", "road/elevationProfile", "a step of 2 m")]


@pytest.mark.parametrize(
    "records", [((50.0, 20.0), (50.0, 0.0)), ((100.0, 20.0),), ((150.0, 20.0),)], ids=["twice", "at the end", "beyond"]
)
def test_a_height_that_holds_nowhere_is_no_step(tmp_path: Path, records: tuple[tuple[float, float], ...]) -> None:
    heights = "".join(cubic("elevation", s, z) for s, z in ((0.0, 0.0), *records))
    assert warned(write(tmp_path, straight("1", 0, 0, 0, 100, elevation=heights))) == []


def test_two_roads_that_meet_at_different_heights_are_told(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        straight("1", 0, 0, 0, 100, link=to_road("successor", "2", "start")),
        straight("2", 100, 0, 0, 9, link=to_road("predecessor", "1", "end"), elevation=cubic("elevation", 0, 8)),
    )
    assert warned(path) == [("road.joint_gap", "road[2]/link/predecessor", "a gap of 8 m")]


def offsets(*jumps: tuple[float, float]) -> str:
    return "".join(f'<laneOffset s="{s}" a="{a}" b="0" c="0" d="0"/>' for s, a in jumps)


@pytest.mark.parametrize(
    ("sections", "jump", "steps"),
    [
        (section([lane(1, after=1)], [lane(-1, after=-1)]) + section([lane(1, before=1)], [lane(-1, before=-1)], s=50),
         2.0, 2),
        (section([lane(1)], [lane(-1)]), 2.0, 2),  # inside a section
        (section([lane(1, after=2)], [lane(-1, after=1), lane(-2, after=-1)])
         + section([lane(1, before=-1), lane(2, before=1)], [lane(-1, before=-2)], s=50), -3.5, 0),  # numbered anew
        (section((), [lane(-1, after=-1)]) + section((), [lane(-1, 5.5, before=-1)], s=50), 2.0, 0),  # wider by as much
        (section([lane(1)], [lane(-1)]), 0.4, 0),
    ],
)  # fmt: skip
def test_a_lane_goes_on_where_it_was(tmp_path: Path, sections: str, jump: float, steps: int) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 100, sections, offset=offsets((0.0, 0.0), (50.0, jump))))
    assert warned(path) == [("road.lane_step", "road/lanes", f"a step of {jump:g} m aside")] * steps
