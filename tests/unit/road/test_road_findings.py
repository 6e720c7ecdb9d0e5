"""What the reader says about a wrong road file: one finding with file, line and element, never a traceback."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from road_files import arc, cubic, geometry, lane, network, road, section, straight, to_road, write

from openscenario.findings import Finding, ScenarioError
from openscenario.road.network import load_network
from openscenario.road.opendrive import examine_opendrive
from openscenario.road.positions import RoadPosition


def findings_of(path: Path) -> tuple[Finding, ...]:
    return tuple(item for item in examine_opendrive(path)[1] if item.severity == "error")


def only(path: Path) -> tuple[str, str]:
    """Code's last part and element's last step of the one error finding."""
    (finding,) = findings_of(path)
    assert finding.file == str(path)
    assert finding.line is not None
    return finding.code.rpartition(":")[2], finding.element.rpartition("/")[2]


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="no-such"):
        load_network(tmp_path / "no-such.xodr")


def test_gap_between_geometries(tmp_path: Path) -> None:
    plan = geometry(0, 0, 0, 0, 60) + geometry(60, 60, 2.5, 0, 40)
    assert only(write(tmp_path, road("1", plan, 100))) == ("road.geometry_gap", "geometry[2]")


@pytest.mark.parametrize(("heading", "warned"), [(0.04, False), (-0.06, True), (6.2832, False)])
def test_a_kink_between_geometries_is_a_warning(tmp_path: Path, heading: float, warned: bool) -> None:
    plan = geometry(0, 0, 0, 0, 60) + geometry(60, 60, 0, heading, 40)
    findings = examine_opendrive(write(tmp_path, road("1", plan, 100)))[1]
    codes = [(each.severity, each.code, each.element.rpartition("/")[2]) for each in findings]
    assert codes == ([("warning", "road.geometry_kink", "geometry[2]@hdg")] if warned else [])


@pytest.mark.parametrize("value", ["NaN", "inf", "-inf"])
def test_number_that_is_not_finite(tmp_path: Path, value: str) -> None:
    plan = geometry(0, 0, 0, 0, 60, f'<arc curvature="{value}"/>')
    assert only(write(tmp_path, road("1", plan, 60))) == ("value.not_finite", "arc@curvature")


def test_number_that_is_none(tmp_path: Path) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 60).replace('length="60" junction', 'length="sixty" junction'))
    assert only(path) == ("value.not_a_number", "road@length")


def test_curvature_that_no_road_has(tmp_path: Path) -> None:
    assert only(write(tmp_path, road("1", geometry(0, 0, 0, 0, 60, arc(1e6)), 60))) == (
        "value.out_of_range",
        "arc@curvature",
    )


def test_height_that_no_lane_has(tmp_path: Path) -> None:
    inside = cubic("width", 0.0, 3.5) + '<height sOffset="0" inner="0" outer="1e300"/>'
    path = write(tmp_path, straight("1", 0, 0, 0, 60, section(right=[lane(-1, inside=inside)])))
    assert only(path) == ("value.out_of_range", "height@outer")


def test_empty_side_of_a_lane_section(tmp_path: Path) -> None:
    empty = '<laneSection s="0"><center><lane id="0" type="none"/></center><right></right></laneSection>'
    found = findings_of(write(tmp_path, straight("1", 0, 0, 0, 60, empty)))
    codes = [(each.code.rpartition(":")[2], each.element.rpartition("/")[2]) for each in found]
    assert codes == [("xml.valid_schema", "right"), ("road.no_driving_lane", "right")]


def test_lane_ids_with_a_gap(tmp_path: Path) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 60, section((), [lane(-1), lane(-3)])))
    assert only(path) == ("road.lane.id_consecutive", "lane[2]@id")


def test_lane_on_the_wrong_side(tmp_path: Path) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 60, section([lane(-1)], ())))
    assert only(path) == ("road.lane.id_side", "lane@id")


def test_two_roads_of_one_id(tmp_path: Path) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 60), straight("1", 0, 9, 0, 60))
    assert only(path) == ("road.id_unique", "road[2]@id")


def test_linked_roads_that_do_not_meet(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        straight("1", 0, 0, 0, 60, link=to_road("successor", "2", "start")),
        straight("2", 60, 5, 0, 60, link=to_road("predecessor", "1", "end")),
    )
    assert only(path) == ("road.geometry.contact_point", "road[1]")


def test_file_of_another_format_is_named(tmp_path: Path) -> None:
    path = tmp_path / "map.xodr"
    path.write_text('<osm version="0.6"/>')
    (finding,) = findings_of(path)
    assert "Lanelet2" in finding.message
    assert "convert" in finding.message


def test_all_errors_come_at_once(tmp_path: Path) -> None:
    plan = geometry(0, 0, 0, 0, 60, arc(float("nan"))) + geometry(60, 60, 0, 0, 10, arc(float("inf")))
    assert len(findings_of(write(tmp_path, road("1", plan, 70)))) == 2


def test_a_link_to_a_road_that_is_not_here_is_an_error_of_a_file_that_can_be_driven(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 60, link=to_road("successor", "7", "start")))
    assert net.lane_successors("1", -1) == ()
    assert only(Path(net.file.path)) == ("road.linkage.unknown", "successor@elementId")


def test_a_lane_link_that_only_one_side_has_is_an_error_of_a_file_that_can_be_driven(tmp_path: Path) -> None:
    parts = section(right=[lane(-1, after=-2)]) + section(right=[lane(-1, after=-1), lane(-2)], s=30.0)
    net = network(tmp_path, straight("1", 0, 0, 0, 60, parts))
    assert only(Path(net.file.path)) == ("road.lane.link.lanes_across_lane_sections", "lane[2]")
    there = net.advance(RoadPosition("1", -1, 10.0, -1.75, 0.0, 0.0, True), 30.0)
    assert (there.lane, there.s) == (-2, 40.0)


def test_a_link_to_a_lane_that_is_not_there_is_an_error_of_a_file_that_can_be_driven(tmp_path: Path) -> None:
    parts = section(right=[lane(-1, after=-1), lane(-2, after=-3)]) + section(right=[lane(-1, before=-1)], s=30.0)
    net = network(tmp_path, straight("1", 0, 0, 0, 60, parts))
    assert only(Path(net.file.path)) == ("road.lane.link.unknown", "lane[2]")
    assert net.advance(RoadPosition("1", -1, 10.0, -1.75, 0.0, 0.0, True), 30.0).lane == -1


def test_checking_a_road_loads_no_compiler() -> None:
    code = "import sys; import openscenario.road.opendrive; sys.exit('numba' in sys.modules or 'scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(("second", "wrong"), [((10, -2), "shape[2]@t"), ((0, 2), "shape[2]@s")])
def test_records_of_a_shape_ascend_along_the_road_and_to_the_left(
    tmp_path: Path, second: tuple[int, int], wrong: str
) -> None:
    records = "".join(f'<shape s="{s}" t="{t}" a="0" b="0" c="0" d="0"/>' for s, t in ((10, 0), second))
    path = write(tmp_path, straight("1", 0, 0, 0, 60, superelevation=records))
    assert only(path) == ("road.profile.elem_asc_order", wrong)


def test_roads_that_name_each_other_at_different_ends_are_apart(tmp_path: Path) -> None:
    first = straight("1", 0, 0, 0, 60, link=to_road("successor", "2", "end"))
    second = straight("2", 60, 0, 0, 60, link=to_road("predecessor", "1", "end"))
    assert only(write(tmp_path, first, second)) == ("road.geometry.contact_point", "road[1]")


@pytest.mark.parametrize("apart", ["", '</connection><connection id="1" {ways}>'])
def test_an_appearing_lane_is_linked_in_no_connection(tmp_path: Path, apart: str) -> None:
    """The lane that appears beside the one that goes on is linked to no lane, in whichever connection."""
    ways = 'incomingRoad="1" connectingRoad="2" contactPoint="start"'
    growing = lane(-2, inside=cubic("width", 0.0, 0.0, 0.05))
    beside = straight("2", 60, 0, 0, 60, section(right=[lane(-1), growing]), junction="9")
    links = '<laneLink from="-1" to="-1"/>' + apart.format(ways=ways) + '<laneLink from="-1" to="-2"/>'
    junction = f'<junction id="9" name="j"><connection id="0" {ways}>{links}</connection></junction>'
    path = write(tmp_path, straight("1", 0, 0, 0, 60, link='<successor elementType="junction" elementId="9"/>'), beside)
    path.write_text(path.read_text().replace("</OpenDRIVE>", junction + "</OpenDRIVE>"))
    assert "road.lane.link.new_lane_appear" in [finding.code.rpartition(":")[2] for finding in findings_of(path)]
