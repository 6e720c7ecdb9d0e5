"""A fault that leaves a geometry and a route is repaired and said; a rule does not judge a file older than itself."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest
from road_files import cubic, geometry, lane, road, section, straight, to_junction, write

from openscenario.findings import ScenarioError
from openscenario.road.network import RoadNetwork, load_network
from openscenario.road.opendrive import examine_opendrive
from openscenario.road.repairs import as_results
from openscenario.road.route import RouteLane

NIGHT = "DVP_NIGHTLY" in os.environ
WILD = 0.97  # share of the roads found in public repositories that must be taken


def assumed(path: Path) -> list[str]:
    """What the lenient reader assumes in the place of the faults of a file that it takes."""
    return [finding.repair for finding in load_network(path).file.repairs]


def refused(path: Path) -> bool:
    try:
        load_network(path)
    except ScenarioError:
        return True
    return False


def of_version(path: Path, minor: int) -> Path:
    path.write_text(path.read_text().replace('revMinor="7"', f'revMinor="{minor}"'))
    return path


def pair(tmp_path: Path, offset: float) -> Path:
    """Two linked roads whose reference lines are `offset` [m] apart where they meet."""
    there = '<successor elementType="road" elementId="2" contactPoint="start"/>'
    back = '<predecessor elementType="road" elementId="1" contactPoint="end"/>'
    first = road("1", geometry(0, 0, 0, 0, 50), 50, link=there)
    return write(tmp_path, first, road("2", geometry(0, 50, offset, 0, 50), 50, link=back))


@pytest.mark.parametrize(("minor", "refuses"), [(4, False), (6, False), (7, True), (9, True)])
def test_a_rule_of_1_7_judges_files_of_1_7_and_later(tmp_path: Path, minor: int, refuses: bool) -> None:
    path = of_version(pair(tmp_path, 3.5), minor)
    assert refused(path) is refuses
    for roads in ("strict", "lenient"):
        (finding,) = examine_opendrive(path, roads)[1]
        assert finding.code == "asam.net:xodr:1.7.0:road.geometry.contact_point"
        assert finding.severity == ("error" if refuses else "warning")


def test_strict_refuses_what_lenient_repairs(tmp_path: Path) -> None:
    empty = '<laneSection s="0"><left></left><center><lane id="0" type="none"/></center><right>'
    path = write(tmp_path, straight("1", 0, 0, 0, 60, f"{empty}{lane(-1)}</right></laneSection>"))
    assert assumed(path) == ["the road has no lane on this side"]
    with pytest.raises(ScenarioError, match="the left side of a lane section is empty"):
        load_network(path, "strict")


def test_a_clean_file_is_not_repaired(tmp_path: Path) -> None:
    assert assumed(write(tmp_path, straight("1", 0, 0, 0, 60))) == []


def test_lanes_without_width_take_no_room_and_driving_lanes_need_one(tmp_path: Path) -> None:
    lanes = section((), [lane(-1), lane(-2, inside="", type_="none"), lane(-3)])
    net = load_network(write(tmp_path, straight("1", 0, 0, 0, 60, lanes)))
    assert net.lane_pose("1", -3, 30.0).y == pytest.approx(-3.5 - 1.75)  # lane -3 begins where lane -1 ends
    assert refused(write(tmp_path, straight("1", 0, 0, 0, 60, section((), [lane(-1, inside="")]))))


def test_geometries_out_of_order_are_sorted_if_that_makes_a_line(tmp_path: Path) -> None:
    parts = [geometry(0, 0, 0, 0, 30), geometry(60, 60, 0, 0, 30), geometry(30, 30, 0, 0, 30)]
    net = load_network(write(tmp_path, road("1", "".join(parts), 90)))
    assert [net.road_pose("1", s, 0.0).x for s in (15.0, 45.0, 75.0)] == pytest.approx([15.0, 45.0, 75.0])
    astray = [*parts[:2], geometry(30, 30, 8.0, 0, 30)]
    assert refused(write(tmp_path, road("1", "".join(astray), 90)))


@pytest.mark.parametrize(("gap", "refuses"), [(0.09, False), (0.4, False), (0.6, True)])
def test_a_gap_in_a_road_may_be_as_wide_as_one_between_roads(tmp_path: Path, gap: float, refuses: bool) -> None:
    plan = geometry(0, 0, 0, 0, 30) + geometry(30, 30, gap, 0, 30)
    assert refused(write(tmp_path, road("1", plan, 60))) is refuses


@pytest.mark.parametrize(("length", "refuses"), [(104.0, False), (107.0, True)])
def test_a_curve_is_scaled_to_a_stated_length_that_is_nearly_its_own(
    tmp_path: Path, length: float, refuses: bool
) -> None:
    """A straight paramPoly3 of 100 m ends at 100 m, whatever length is written beside it."""
    shape = '<paramPoly3 aU="0" bU="100" cU="0" dU="0" aV="0" bV="0" cV="0" dV="0" pRange="normalized"/>'
    path = write(tmp_path, road("1", geometry(0, 0, 0, 0, length, shape), length))
    assert refused(path) is refuses
    if not refuses:
        assert load_network(path).road_pose("1", length, 0.0).x == pytest.approx(100.0)


def test_an_object_that_cannot_be_read_is_left_out_and_the_next_one_stays(tmp_path: Path) -> None:
    objects = "".join(f'<object id="{n}" type="pole" s="9" t="{t}"/>' for n, t in ((1, "-3+2i"), (2, "-4")))
    net = load_network(write(tmp_path, straight("1", 0, 0, 0, 60, objects=objects)))
    assert [item.id for item in net.file.roads[0].objects] == ["2"]
    assert {each.repair for each in net.file.repairs} == {"it is left out"}


def test_a_slip_is_harmless_beside_the_road_and_not_in_it(tmp_path: Path) -> None:
    sign = '<object id="1" type="pole" s="9" t="4" zoffset="1"/>'
    assert not refused(write(tmp_path, straight("1", 0, 0, 0, 60, objects=sign)))
    assert refused(write(tmp_path, straight("1", 0, 0, 0, 60).replace("<elevationProfile>", "<elevationProfil>")
                         .replace("</elevationProfile>", "</elevationProfil>")))  # fmt: skip


def test_records_out_of_order_hold_from_their_places_on(tmp_path: Path) -> None:
    offsets = cubic("laneOffset", 0, 0) + cubic("laneOffset", 40, 2) + cubic("laneOffset", 20, 1)
    net = load_network(write(tmp_path, road("1", geometry(0, 0, 0, 0, 60), 60, offset=offsets)))
    assert [net.lane_t("1", 0, s) for s in (10.0, 30.0, 50.0)] == [0.0, 1.0, 2.0]


def test_of_the_layers_of_1_9_the_permanent_one_is_driven_on(tmp_path: Path) -> None:
    path = of_version(write(tmp_path, straight("1", 0, 0, 0, 60, section((), [lane(-1, 3.0)]))), 9)
    text = path.read_text()
    layer = text[text.index("<lanes>") : text.index("</lanes>") + 8]
    temporary = layer.replace("<lanes>", '<lanes layer="temporary">').replace('a="3.0"', 'a="2.0"')
    path.write_text(text.replace(layer, temporary + layer.replace("<lanes>", '<lanes layer="permanent">')))
    assert load_network(path).lane_width("1", -1, 30.0) == pytest.approx(3.0)
    (finding,) = examine_opendrive(path)[1]
    assert (finding.severity, finding.code) == ("warning", "road.unsupported")


@pytest.mark.parametrize(("bank", "warned"), [(0.1, True), (0.0, False)])
def test_a_level_lane_of_a_banked_road_is_told(tmp_path: Path, bank: float, warned: bool) -> None:
    """ASAM OpenDRIVE 1.8, 11.6: a lane on level does not take part in the superelevation; here it does."""
    sides = section((), [lane(-1), lane(-2, type_="sidewalk").replace("<lane ", '<lane level="true" ')])
    path = write(tmp_path, straight("1", 0, 0, 0, 60, sides, superelevation=cubic("superelevation", 0, bank)))
    found = [finding for finding in examine_opendrive(path)[1] if finding.code == "road.unsupported"]
    assert [(finding.severity, finding.element.rpartition("@")[2]) for finding in found] == (
        [("warning", "level")] if warned else []
    )
    assert load_network(path).lane_pose("1", -2, 30.0).roll == pytest.approx(bank)


def test_each_rule_and_assumption_is_one_row_with_its_first_place(tmp_path: Path) -> None:
    objects = "".join(f'<object id="{n}" type="pole" s="9" t="x"/>' for n in range(3))
    path = write(tmp_path, straight("1", 0, 0, 0, 60, objects=objects))
    (row,) = as_results(load_network(path).file.repairs)
    assert (row["code"], row["rule"], row["count"]) == ("road.repaired", "value.not_a_number", 3)
    assert row["field"].endswith("objects/object[1]@t")
    assert (row["file"], row["assumed"]) == (str(path), "it is left out")


def start_of(net: RoadNetwork) -> tuple[str, int, float] | None:
    """A place on the longest driving lane that is two metres wide there."""
    found: list[tuple[float, str, int, float]] = []
    for item in net.file.roads:
        for each in item.sections[0].lanes:
            near = min(6.0, 0.2 * item.length)
            s = near if net.driving_sign(item.id, each.id) > 0 else item.length - near
            if net.lane_type(item.id, each.id, s) == "driving" and net.lane_width(item.id, each.id, s) > 2.0:
                found.append((item.length, item.id, each.id, s))
    return max(found)[1:] if found else None


def test_roads_of_public_repositories_are_taken_and_driven(shared_dir: Path) -> None:
    """50 m from the start of the longest lane of each road, along the links; ends of roads end the drive."""
    files = sorted((shared_dir / "openscenario" / "wild").rglob("*.xodr"))[:: 1 if NIGHT else 5]
    judged = driven = 0
    for path in files:
        network, findings = examine_opendrive(path, "lenient")
        if any(each.code == "xml.not_well_formed" for each in findings) or (network and network.version < (1, 4)):
            continue
        judged += 1
        if network is None or any(each.severity == "error" for each in findings):
            continue
        net = RoadNetwork(network)
        start = start_of(net)
        if start is None:
            continue
        pose = net.lane_pose(*start)
        place = net.locate(pose.x, pose.y, pose.h)._replace(road=start[0], lane=start[1], s=start[2], offset=0.0)
        for _ in range(50):
            if not net.dead_end(place):
                place = net.advance(place, 1.0)
        driven += math.isfinite(net.lane_pose(place.road, place.lane, place.s).x)
    assert judged > (100 if NIGHT else 20)
    assert driven >= (WILD if NIGHT else 0.9) * judged  # of two dozen, one or two are less than 0.97


def test_a_line_along_a_lane_that_ends_ends_with_it(tmp_path: Path) -> None:
    """Lane -2 is there for the first 30 m of 60: a line along it is no endless search for the rest."""
    sections = section((), [lane(-1), lane(-2)]) + section((), [lane(-1)], s=30.0)
    net = load_network(write(tmp_path, straight("1", 0, 0, 0, 60, sections)))
    for ends in ((0.0, 60.0), (60.0, 0.0)):
        line = net.centreline([RouteLane("1", -2, *ends)], 1.0)
        assert all(math.isfinite(value) for value in line.ravel())
        assert len(line) <= 31
    assert net.centreline([RouteLane("1", -2, 0.0, 60.0)], 1.0)[-1][0] == pytest.approx(29.0, abs=1.01)


SORTED = "the records in the order of their places"


def test_speed_limits_of_a_lane_out_of_order_hold_where_they_say(tmp_path: Path) -> None:
    limits = '<speed sOffset="50" max="10"/><speed sOffset="0" max="20"/>'
    path = write(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1, inside=cubic("width", 0, 3.5) + limits)])))
    assert [load_network(path).lane_speed("1", -1, s) for s in (30.0, 60.0)] == [20.0, 10.0]
    assert assumed(path) == [SORTED]


@pytest.mark.parametrize(
    ("unit", "speed", "said"),
    [
        ("kph", 50.0 / 3.6, ["it is km/h"]),
        ("KM/H", 50.0 / 3.6, ["it is km/h"]),
        ("mps", 50.0, ["it is m/s"]),
        ("km/h", 50.0 / 3.6, []),
        ("knots", math.inf, ["no speed limit is stated there"]),
    ],
)
def test_a_unit_of_speed_that_the_standard_does_not_have_costs_no_road(
    tmp_path: Path, unit: str, speed: float, said: list[str]
) -> None:
    limit = f'<speed sOffset="0" max="50" unit="{unit}"/>'
    path = write(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1, inside=cubic("width", 0, 3.5) + limit)])))
    assert load_network(path).lane_speed("1", -1, 30.0) == pytest.approx(speed)
    assert assumed(path) == said
    if said:
        with pytest.raises(ScenarioError, match="unit has an unknown value"):
            load_network(path, "strict")


@pytest.mark.parametrize("b_u", [1.0, 40.0])
def test_the_range_of_a_curve_that_does_not_state_it_is_that_of_its_length(tmp_path: Path, b_u: float) -> None:
    """Of 40 m: by the length with a tangent of 1, or from 0 to 1 with one of 40 m."""
    shape = f'<paramPoly3 aU="0" bU="{b_u}" cU="0" dU="0" aV="0" bV="0" cV="0" dV="0"/>'
    path = of_version(write(tmp_path, road("1", geometry(0, 0, 0, 0, 40, shape), 40)), 4)
    assert load_network(path).road_pose("1", 30.0, 0.0).x == pytest.approx(30.0)
    assert assumed(path) == []


LIGHT = '<signal id="7" s="30" t="-4" dynamic="yes" orientation="+" type="1000001" country="OpenDRIVE">{}</signal>'


def test_a_validity_without_lanes_is_for_every_lane(tmp_path: Path) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 60, signals=LIGHT.format('<validity fromLane="-1"/>')))
    (signal,) = load_network(path).signals
    assert signal.validity == ()
    assert assumed(path) == ["it is for every lane of its direction"]


@pytest.mark.parametrize(("first", "last", "told"), [(-9, -5, True), (-2, -1, False), (0, 0, False)])
def test_a_signal_for_lanes_that_its_road_does_not_have_is_told(
    tmp_path: Path, first: int, last: int, told: bool
) -> None:
    """From 0 to 0 is for nobody, as of a mast."""
    validity = f'<validity fromLane="{first}" toLane="{last}"/>'
    path = write(tmp_path, straight("1", 0, 0, 0, 60, signals=LIGHT.format(validity)))
    findings = [each for each in examine_opendrive(path, "lenient")[1] if each.code == "road.validity_unknown"]
    assert [(each.severity, each.found, each.allowed) for each in findings] == (
        [("warning", "-9 to -5", "-1, 1")] if told else []
    )


def test_types_of_a_road_out_of_order_hold_where_they_say(tmp_path: Path) -> None:
    types = '<type s="50" type="town"><speed max="10"/></type><type s="0" type="rural"><speed max="20"/></type>'
    path = write(tmp_path, straight("1", 0, 0, 0, 100).replace("<planView>", f"{types}<planView>"))
    assert [load_network(path).lane_speed("1", -1, s) for s in (30.0, 60.0)] == [20.0, 10.0]
    assert assumed(path) == [SORTED]


@pytest.mark.parametrize(("late", "repairs"), [(10.0, ["the first one holds from there"]), (1e-5, [])])
def test_a_first_width_that_begins_late_holds_from_the_beginning(
    tmp_path: Path, late: float, repairs: list[str]
) -> None:
    path = write(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1, inside=cubic("width", late, 3.5, 0.01))])))
    net = load_network(path)
    assert [net.lane_width("1", -1, s) for s in (0.0, 5e-6, late, late + 10.0)] == pytest.approx([3.5, 3.5, 3.5, 3.6])
    assert assumed(path) == repairs


def test_a_link_without_contact_point_leads_to_the_end_that_leads_back(tmp_path: Path) -> None:
    """Two roads that meet end to end at x = 100; the start of the second one lies at x = 200."""
    first = straight("1", 0, 0, 0, 100, link='<successor elementType="road" elementId="2"/>')
    second = straight("2", 200, 0, math.pi, 100, link='<successor elementType="road" elementId="1"/>')
    path = write(tmp_path, first, second)
    net = load_network(path)
    there = net.advance(net.locate(95.0, -1.75, 0.0), 20.0)
    assert net.lane_pose(there.road, there.lane, there.s)[:2] == pytest.approx((115.0, -1.75))
    assert assumed(path) == ["it leads to the end of road 2", "it leads to the end of road 1"]
    assert not any(each.severity == "error" for each in examine_opendrive(path, "lenient")[1])
    assert any(each.severity == "error" for each in examine_opendrive(path, "strict")[1])


def test_a_connecting_road_without_contact_points_leads_to_the_nearer_ends(tmp_path: Path) -> None:
    inner = section((), [lane(-1, before=-1, after=1)])
    names = "".join(f'<{end} elementType="road" elementId="{n}"/>' for end, n in (("predecessor", 1), ("successor", 2)))
    way = '<connection id="0" incomingRoad="1" connectingRoad="10" contactPoint="start">'
    path = write(
        tmp_path,
        straight("1", 0, 0, 0, 100, link=to_junction("predecessor", "J") + to_junction("successor", "J")),
        straight("2", 220, 0, math.pi, 100, link=to_junction("successor", "J") + to_junction("predecessor", "J")),
        straight("10", 100, 0, 0, 20, inner, junction="J", link=names),
        f'<junction id="J" name="J">{way}<laneLink from="-1" to="-1"/></connection></junction>',
    )
    route = load_network(path).route(("1", -1, 5.0), ("2", 1, 50.0))
    assert [each.road for each in route] == ["1", "10", "2"]


def test_a_ring_of_one_road_needs_no_contact_point(tmp_path: Path) -> None:
    arc = '<arc curvature="0.1"/>'
    length = 20.0 * math.pi
    link = '<predecessor elementType="road" elementId="1"/><successor elementType="road" elementId="1"/>'
    net = load_network(write(tmp_path, road("1", geometry(0, 0, 0, 0, length, arc), length, link=link)))
    place = net.advance(net.locate(0.0, -1.75, 0.0), 3.0 * 11.75)
    assert (place.road, place.lane, place.s) == ("1", -1, pytest.approx(30.0))
    ends = net.file.roads[0].predecessor, net.file.roads[0].successor
    assert [each and each.contact for each in ends] == ["end", "start"]


def test_the_end_that_leads_back_to_the_other_end_of_the_road_is_not_meant(tmp_path: Path) -> None:
    """A ring of two half circles: only the second one's end is linked, and it leads to the start of the first."""
    arc, length = '<arc curvature="0.1"/>', 10.0 * math.pi
    both = "".join(f'<{end} elementType="road" elementId="2"/>' for end in ("predecessor", "successor"))
    back = '<successor elementType="road" elementId="1" contactPoint="start"/>'
    path = write(
        tmp_path,
        road("1", geometry(0, 0, 0, 0, length, arc), length, link=both),
        road("2", geometry(0, 0, 20, math.pi, length, arc), length, link=back),
    )
    assert assumed(path) == ["it leads to the end of road 2", "it leads to the start of road 2"]


def test_a_road_of_a_type_that_the_standard_does_not_have_is_driven_on(tmp_path: Path) -> None:
    kind = '<type s="0" type="highway"><speed max="20"/></type>'
    path = write(tmp_path, straight("1", 0, 0, 0, 100).replace("<planView>", f"{kind}<planView>"))
    assert assumed(path) == ["a road of unknown type"]
    assert load_network(path).lane_speed("1", -1, 5.0) == 20.0
