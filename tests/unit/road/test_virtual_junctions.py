"""Virtual junctions: ways off a main road and onto it between its ends, along circles of 30 m."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from road_files import arc, geometry, lane, network, road, section, straight, to_road

from openscenario.road.network import RoadNetwork, RoadPosition

QUARTER = 15.0 * math.pi  # m, a quarter of a circle of 30 m
LANE = 28.25 * 0.5 * math.pi  # m, the same in the middle of its right lane


@pytest.fixture
def net(tmp_path: Path) -> RoadNetwork:
    """M runs 200 m along x. 11 leaves its right lane at s = 100 m to the right, onto P; 12 comes from Q, onto it at
    150 m; 13 leaves its left lane, whose traffic runs against s, at 60 m, also to the right, which is to the north."""
    one_way = section((), [lane(-1, before=-1, after=-1)])

    def to_main(end: str, s: float, way: str) -> str:
        return f'<{end} elementType="road" elementId="M" elementS="{s}" elementDir="{way}"/>'

    def connection(number: int, connecting: str, contact: str, source: int) -> str:
        attributes = f'id="{number}" incomingRoad="M" connectingRoad="{connecting}" contactPoint="{contact}"'
        return f'<connection {attributes}><laneLink from="{source}" to="-1"/></connection>'

    def bend(id_: str, x: float, y: float, h: float, link: str) -> str:
        plan = geometry(0.0, x, y, h, QUARTER, arc(-1.0 / 30.0))
        return road(id_, plan, QUARTER, one_way, junction="J", link=link)

    north, south = 0.5 * math.pi, -0.5 * math.pi
    return network(
        tmp_path,
        straight("M", 0.0, 0.0, 0.0, 200.0),
        straight("P", 130.0, -30.0, south, 50.0, link=to_road("predecessor", "11", "end")),
        straight("Q", 120.0, -80.0, north, 50.0, link=to_road("successor", "12", "start")),
        straight("R", 30.0, 30.0, north, 50.0, link=to_road("predecessor", "13", "end")),
        bend("11", 100.0, 0.0, 0.0, to_main("predecessor", 100.0, "+") + to_road("successor", "P", "start")),
        bend("12", 120.0, -30.0, north, to_road("predecessor", "Q", "end") + to_main("successor", 150.0, "+")),
        bend("13", 60.0, 0.0, math.pi, to_main("predecessor", 60.0, "-") + to_road("successor", "R", "start")),
        '<junction id="J" name="J" type="virtual" mainRoad="M" sStart="50" sEnd="160" orientation="none">',
        connection(0, "11", "start", -1),
        connection(1, "12", "end", -1),
        connection(2, "13", "start", 1),
        "</junction>",
    )


def at(road_id: str, lane_id: int, s: float) -> RoadPosition:
    return RoadPosition(road_id, lane_id, s, 0.0, 0.0, 0.0, True)


def places(route: tuple[object, ...]) -> list[object]:
    return [(each[0], each[1], pytest.approx(each[2]), pytest.approx(each[3])) for each in route]  # type: ignore[index]


def test_routes_leave_the_main_road_between_its_ends_and_come_onto_it(net: RoadNetwork) -> None:
    away = net.route(("M", -1, 80.0), ("P", -1, 10.0))
    assert places(away) == [("M", -1, 80.0, 100.0), ("11", -1, 0.0, QUARTER), ("P", -1, 0.0, 10.0)]
    onto = net.route(("Q", -1, 20.0), ("M", -1, 180.0))
    assert [each.road for each in onto] == ["Q", "12", "M"]
    assert (onto[-1].s_from, onto[-1].s_to) == pytest.approx((150.0, 180.0))


def test_the_other_direction_of_the_main_road_has_ways_of_its_own(net: RoadNetwork) -> None:
    away = net.route(("M", 1, 80.0), ("R", -1, 5.0))
    assert places(away) == [("M", 1, 80.0, 60.0), ("13", -1, 0.0, QUARTER), ("R", -1, 0.0, 5.0)]


def test_who_has_a_route_leaves_and_who_has_none_goes_on(net: RoadNetwork) -> None:
    route = net.route(("M", -1, 80.0), ("P", -1, 40.0))
    away = net.advance(at("M", -1, 80.0), 20.0 + LANE + 5.0, along=route)
    assert (away.road, away.lane, away.s) == ("P", -1, pytest.approx(5.0, abs=1e-3))
    on = net.advance(at("M", -1, 80.0), 70.0)
    assert (on.road, on.lane, on.s) == ("M", -1, pytest.approx(150.0))


def test_who_leaves_against_the_axis_keeps_to_the_right(net: RoadNetwork) -> None:
    route = net.route(("M", 1, 80.0), ("R", -1, 40.0))
    away = net.advance(at("M", 1, 80.0), 20.0 + LANE + 5.0, along=route)
    pose = net.lane_pose(away.road, away.lane, away.s)
    assert (away.road, pose.x, pose.y) == ("R", pytest.approx(31.75), pytest.approx(35.0, abs=1e-3))


def test_a_connecting_road_that_ends_there_leads_onto_the_main_road(net: RoadNetwork) -> None:
    onto = net.advance(at("Q", -1, 45.0), 5.0 + LANE + 7.0)
    assert (onto.road, onto.lane, onto.s) == ("M", -1, pytest.approx(157.0, abs=1e-3))
    assert not net.dead_end(at("12", -1, QUARTER))


def test_the_ends_of_the_main_road_lead_nowhere(net: RoadNetwork) -> None:
    assert net.lane_successors("M", -1) == ()
    assert net.advance(at("M", -1, 190.0), 50.0).s == pytest.approx(200.0)


def test_poses_do_not_change_where_a_section_is_cut(net: RoadNetwork) -> None:
    for s in (59.9, 60.0, 100.0, 149.999, 150.0, 200.0):
        pose = net.lane_pose("M", -1, s)
        assert (pose.x, pose.y) == pytest.approx((s, -1.75))
    found = net.locate(120.0, -1.0, 0.0)
    assert (found.road, found.lane, found.s) == ("M", -1, pytest.approx(120.0))
