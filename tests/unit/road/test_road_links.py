"""Which lanes follow which: road links, lane links, junctions, left-hand traffic."""

from __future__ import annotations

from pathlib import Path

import pytest
from road_files import crossing, lane, network, section, straight, to_junction, to_road

from openscenario.road.positions import RoadPosition

PAIR = section([lane(1, after=1)], [lane(-1, after=-1)])
PAIR_BACK = section([lane(1, before=1)], [lane(-1, before=-1)])


def chain(tmp_path: Path, rule: str = "RHT"):
    return network(
        tmp_path,
        straight("1", 0, 0, 0, 100, PAIR, link=to_road("successor", "2", "start"), rule=rule),
        straight("2", 100, 0, 0, 100, PAIR_BACK, link=to_road("predecessor", "1", "end"), rule=rule),
    )


def test_right_lane_goes_on_with_increasing_s(tmp_path: Path) -> None:
    net = chain(tmp_path)
    assert net.lane_successors("1", -1) == (("2", -1),)
    assert net.lane_successors("2", -1) == ()


def test_left_lane_goes_on_against_s(tmp_path: Path) -> None:
    assert chain(tmp_path).lane_successors("2", 1) == (("1", 1),)


def test_left_hand_traffic_turns_both_round(tmp_path: Path) -> None:
    net = chain(tmp_path, "LHT")
    assert net.lane_successors("1", 1) == (("2", 1),)
    assert net.lane_successors("2", -1) == (("1", -1),)


def test_roads_that_meet_end_to_end_swap_sides(tmp_path: Path) -> None:
    there = section([lane(1, after=-1)], [lane(-1, after=1)])
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, there, link=to_road("successor", "2", "end")),
        straight("2", 200, 0, 3.141592653589793, 100, there, link=to_road("successor", "1", "end")),
    )
    assert net.lane_successors("1", -1) == (("2", 1),)


def test_file_without_lane_links_keeps_lane_ids(tmp_path: Path) -> None:
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, link=to_road("successor", "2", "start")),
        straight("2", 100, 0, 0, 100, link=to_road("predecessor", "1", "end")),
    )
    assert net.lane_successors("1", -1) == (("2", -1),)


def test_junction_offers_each_connecting_road(tmp_path: Path) -> None:
    assert crossing(tmp_path).lane_successors("W", -1) == (("10", -1), ("12", -1))


def test_connecting_road_leads_to_the_outgoing_lane(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    assert net.lane_successors("10", -1) == (("E", -1),)
    assert net.lane_successors("11", -1) == (("W", 1),)


def test_direct_junction_joins_roads_without_a_connecting_road(tmp_path: Path) -> None:
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, section((), [lane(-1), lane(-2)]), link=to_junction("successor", "9")),
        straight("main", 100, 0, 0, 100, section((), [lane(-1)]), link=to_junction("predecessor", "9")),
        straight("ramp", 100, -3.5, -0.1, 50, section((), [lane(-1)]), link=to_junction("predecessor", "9")),
        '<junction id="9" type="direct">'
        '<connection id="0" incomingRoad="1" linkedRoad="main" contactPoint="start">'
        '<laneLink from="-1" to="-1"/></connection>'
        '<connection id="1" incomingRoad="1" linkedRoad="ramp" contactPoint="start">'
        '<laneLink from="-2" to="-1"/></connection>'
        "</junction>",
    )
    assert net.lane_successors("1", -1) == (("main", -1),)
    assert net.lane_successors("1", -2) == (("ramp", -1),)


def test_a_link_that_the_other_road_contradicts_joins_nothing(tmp_path: Path) -> None:
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, link=to_road("successor", "2", "start")),
        straight("2", 100, 0, 0, 100, link=to_road("predecessor", "1", "end")),
        straight("liar", 300, 0, 0, 100, link=to_road("predecessor", "1", "end")),
    )
    assert net.lane_successors("1", -1) == (("2", -1),)


@pytest.mark.parametrize(
    ("start", "goal", "lane"),
    [
        (("W", -1), "E", -1),
        (("E", -1), "W", -1),
        (("E", 1), "W", 1),  # over the way of the other direction, on which this lane lies
        (("W", 1), "E", 1),
        (("W", -1), "N", -1),
        (("N", -1), "W", -1),
        (("N", 1), "W", None),  # no way leads from the north
        (("N", -1), "E", -1),  # back over the way to the north, and on from where it began
    ],
)
def test_lanes_run_on_over_the_ways_of_a_junction(
    tmp_path: Path, start: tuple[str, int], goal: str, lane: int | None
) -> None:
    """Lane -1 of W goes to E and N, lane 1 of E to W: whichever way one looks along them."""
    net = crossing(tmp_path)
    road, own = start
    here = RoadPosition(road, own, 50.0, 0.0, 0.0, 0.0, True)
    assert net.lane_onwards(here, here._replace(road=goal, s=40.0)) == lane
