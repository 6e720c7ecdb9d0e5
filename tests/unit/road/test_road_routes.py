"""Routes over the lane graph, the line they draw, and moving along lanes."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest
from road_files import arc, crossing, cubic, geometry, lane, network, road, section, straight, to_road
from scipy.sparse.csgraph import dijkstra

from openscenario.road.network import RouteError, RouteLane
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.routes import way

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


def ring(tmp_path: Path):
    """A circle of two half roads, 100 m around, one lane each way."""
    half = section([lane(1, before=1, after=1)], [lane(-1, before=-1, after=-1)])
    curvature = 2.0 * math.pi / 100.0
    both = [("1", 0.0, 0.0, 0.0, "2"), ("2", 0.0, 2.0 / curvature, math.pi, "1")]
    return network(
        tmp_path,
        *(
            road(
                name, geometry(0, x, y, hdg, 50, arc(curvature)), 50, half,
                link=to_road("predecessor", other, "end") + to_road("successor", other, "start"),
            )
            for name, x, y, hdg, other in both
        ),
    )  # fmt: skip


def test_route_ahead_on_one_lane_is_that_stretch(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    assert net.route(("1", -1, 10.0), ("1", -1, 60.0)) == (RouteLane("1", -1, 10.0, 60.0),)


def test_route_on_a_left_lane_runs_against_s(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    assert net.route(("1", 1, 60.0), ("1", 1, 10.0)) == (RouteLane("1", 1, 60.0, 10.0),)


def test_goal_behind_the_start_is_reached_round_the_loop(tmp_path: Path) -> None:
    way = ring(tmp_path).route(("1", -1, 30.0), ("1", -1, 10.0))
    assert way == (RouteLane("1", -1, 30.0, 50.0), RouteLane("2", -1, 0.0, 50.0), RouteLane("1", -1, 0.0, 10.0))


def test_goal_behind_without_a_loop_is_an_error_that_names_both_places(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1), lane(-2)])))
    with pytest.raises(RouteError, match=r"from road 1 lane -1 s = 60 m to road 1 lane -2 s = 10 m"):
        net.route(("1", -1, 60.0), ("1", -2, 10.0))


def test_route_through_a_junction_takes_the_turn(tmp_path: Path) -> None:
    way = crossing(tmp_path).route(("W", -1, 50.0), ("N", -1, 40.0))
    assert [(item.road, item.lane) for item in way] == [("W", -1), ("12", -1), ("N", -1)]


def test_route_changes_lane_where_only_the_neighbour_leads_on(tmp_path: Path) -> None:
    net = network(
        tmp_path,
        straight(
            "1", 0, 0, 0, 100, section((), [lane(-1), lane(-2, after=-1)]), link=to_road("successor", "2", "start")
        ),
        straight("2", 100, 0, 0, 100, section((), [lane(-1, before=-2)]), link=to_road("predecessor", "1", "end")),
    )
    way = net.route(("1", -1, 0.0), ("2", -1, 50.0))
    assert [(item.road, item.lane) for item in way] == [("1", -1), ("1", -2), ("2", -1)]
    assert way[0].s_to == way[1].s_from


def test_shorter_way_wins(tmp_path: Path) -> None:
    net = ring(tmp_path)
    way = net.route(("1", 1, 10.0), ("2", 1, 40.0))
    assert sum(abs(item.s_to - item.s_from) for item in way) == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("goal", "message"),
    [(("9", -1, 0.0), "no road 9"), (("1", -3, 0.0), "lane -3"), (("1", -1, 200.0), "100 m long")],
)
def test_goal_that_does_not_exist_is_named(tmp_path: Path, goal: tuple[str, int, float], message: str) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    with pytest.raises(RouteError, match=message):
        net.route(("1", -1, 0.0), goal)


def test_lane_graph_is_ready_for_scipy(tmp_path: Path) -> None:
    graph = ring(tmp_path).lane_graph()
    nodes = graph.nodes.tolist()
    distances = dijkstra(graph.matrix(), indices=[nodes.index([0, 0, -1])])[0]
    assert distances[nodes.index([1, 1, -1])] == pytest.approx(50.0)


def test_centreline_of_an_arc_has_the_curvature_of_its_own_circle(tmp_path: Path) -> None:
    net = network(tmp_path, road("1", geometry(0, 0, 0, 0, 100, arc(0.02)), 100))
    line = net.centreline((RouteLane("1", -1, 0.0, 100.0),))
    assert line[:, 3] == pytest.approx(np.full(len(line), 1.0 / 51.75))


def test_centreline_against_s_turns_heading_and_curvature_round(tmp_path: Path) -> None:
    net = network(tmp_path, road("1", geometry(0, 0, 0, 0, 100, arc(0.02)), 100))
    line = net.centreline((RouteLane("1", 1, 100.0, 0.0),))
    assert line[-1, :2] == pytest.approx((0.0, 1.75))
    assert math.remainder(line[-1, 2] - math.pi, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert line[0, 3] == pytest.approx(-1.0 / 48.25)


def test_centreline_samples_lie_a_step_apart_over_road_borders(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    line = net.centreline(net.route(("W", -1, 50.0), ("N", -1, 40.0)), step=0.5)
    gaps = np.hypot(np.diff(line[:, 0]), np.diff(line[:, 1]))
    assert gaps[:-1] == pytest.approx(np.full(len(gaps) - 1, 0.5), abs=1e-3)
    assert line[-1, :2] == pytest.approx(net.lane_pose("N", -1, 40.0)[:2])


def test_heading_and_curvature_of_a_widening_lane_in_a_bend_fit_its_points(tmp_path: Path) -> None:
    widening = lane(-1, inside=cubic("width", 0.0, 3.0, 0.0, 0.003, -0.00002))
    net = network(tmp_path, road("1", geometry(0, 0, 0, 0, 90, arc(0.02)), 90, section((), [widening])))
    line = net.centreline((RouteLane("1", -1, 0.0, 90.0),), step=0.05)[:-1]
    middle = (line[2:, :2] - line[:-2, :2]) / 0.1
    assert line[1:-1, 2] == pytest.approx(np.unwrap(np.arctan2(middle[:, 1], middle[:, 0])), abs=1e-4)
    assert line[1:-1, 3] == pytest.approx((line[2:, 2] - line[:-2, 2]) / 0.1, abs=1e-5)


def test_lane_change_of_a_route_is_drawn_smoothly(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 200, section((), [lane(-1), lane(-2)])))
    line = net.centreline(net.route(("1", -1, 0.0), ("1", -2, 200.0)))
    assert line[0, 1] == pytest.approx(-1.75)
    assert line[-1, 1] == pytest.approx(-5.25)
    assert np.abs(np.diff(line[:, 3])).max() < 1e-3
    assert np.abs(line[:, 2]).max() < 0.15


def test_advance_counts_the_way_on_the_lane_not_on_the_reference_line(tmp_path: Path) -> None:
    net = network(tmp_path, road("1", geometry(0, 0, 0, 0, 100, arc(0.02)), 100))
    start = net.locate(*net.lane_pose("1", -1, 10.0)[:2])
    moved = net.advance(start, 20.7)
    assert moved.s == pytest.approx(10.0 + 20.7 / (1.0 + 0.02 * 1.75), abs=1e-9)


def test_advance_on_a_left_lane_reduces_s(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    start = net.locate(50.0, 1.75)
    assert net.advance(start, 5.0).s == pytest.approx(45.0)
    assert net.advance(start, -5.0).s == pytest.approx(55.0)


def test_advance_goes_straight_on_unless_told_to_turn(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    start = net.locate(-15.0, -1.75)
    assert net.advance(start, 20.0).road == "10"
    assert net.advance(start, 20.0, turn=math.pi / 2).road == "12"


def test_advance_stays_on_its_route(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    way = net.route(("W", -1, 50.0), ("N", -1, 40.0))
    moved = net.advance(net.locate(-15.0, -1.75), 40.0, along=way)
    assert (moved.road, moved.lane) == ("N", -1)


def test_advance_keeps_the_offset_to_the_same_side_of_the_traveller(tmp_path: Path) -> None:
    there = section([lane(1, after=-1)], [lane(-1, after=1)])
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, there, link=to_road("successor", "2", "end")),
        straight("2", 200, 0, math.pi, 100, there, link=to_road("successor", "1", "end")),
    )
    moved = net.advance(net.locate(90.0, -2.0), 20.0)
    assert net.lane_pose(moved.road, moved.lane, moved.s, moved.offset)[:2] == pytest.approx((110.0, -2.0))


def test_advance_follows_a_lane_whose_id_changes_with_the_section(tmp_path: Path) -> None:
    sections = section((), [lane(-1, after=-2)]) + section((), [lane(-1, 3.0), lane(-2, before=-1)], s=50.0)
    net = network(tmp_path, straight("1", 0, 0, 0, 100, sections))
    assert net.advance(net.locate(40.0, -1.75), 20.0).lane == -2
    assert net.advance(net.locate(60.0, -4.75), -20.0).lane == -1


def test_dead_end_is_where_the_way_ends(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    start = net.locate(90.0, -1.75)
    assert not net.dead_end(start)
    end = net.advance(start, 50.0)
    assert end.s == pytest.approx(100.0)
    assert net.dead_end(end)


def test_a_lane_that_vanishes_gives_way_to_one_of_its_own_direction(tmp_path: Path) -> None:
    """The inner left lane (2.625 m wide at s = 90) is gone at s = 60; both its neighbours touch it there."""
    growing = cubic("width", 0.0, 0.0) + cubic("width", 60.0, 0.0, 0.0875)
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section([lane(1, inside=growing), lane(2)], [lane(-1)])))
    there = net.advance(net.locate(90.0, 1.3125), 40.0)  # traffic of the left side runs against s
    assert (there.lane, there.s, there.t) == (2, pytest.approx(50.0), pytest.approx(1.75))


@pytest.mark.parametrize(("inner", "expected"), [("driving", -1), ("sidewalk", -2)])
def test_a_lane_that_becomes_a_shoulder_ends_where_another_goes_on(tmp_path: Path, inner: str, expected: int) -> None:
    both = [lane(-1, type_=inner, after=-1), lane(-2, after=-2)]
    then = [lane(-1, type_=inner, before=-1), lane(-2, type_="shoulder", before=-2)]
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section(right=both) + section(right=then, s=50.0)))
    there = net.advance(net.locate(40.0, -5.25), 20.0)
    assert (there.lane, there.s) == (expected, pytest.approx(60.0))


@pytest.mark.parametrize("contact", ["start", "end"])
def test_a_lane_that_ends_with_its_road_leads_to_the_nearest_of_the_next(tmp_path: Path, contact: str) -> None:
    """Two lanes each way, then one each way that runs on or against; the outer one is linked to nothing."""
    right, left = (-1, 1) if contact == "start" else (1, -1)
    wide = section([lane(1, after=left), lane(2)], [lane(-1, after=right), lane(-2)])
    narrow = section([lane(1)], [lane(-1)])
    second = (
        straight("2", 100, 0, 0, 60, narrow, link=to_road("predecessor", "1", "end"))
        if contact == "start"
        else straight("2", 160, 0, math.pi, 60, narrow, link=to_road("successor", "1", "end"))
    )
    net = network(tmp_path, straight("1", 0, 0, 0, 100, wide, link=to_road("successor", "2", contact)), second)
    there = net.advance(net.locate(90.0, -5.0), 30.0)  # 0.25 m left of the middle
    assert (there.road, there.lane, there.offset) == ("2", right, 0.0)
    pose = net.lane_pose("2", there.lane, there.s)
    assert (pose.x, pose.y) == (pytest.approx(120.0), pytest.approx(-1.75))


def test_a_lane_ends_where_only_traffic_against_it_goes_on(tmp_path: Path) -> None:
    onwards = straight("2", 100, 0, 0, 60, section([lane(1, before=1)]), link=to_road("predecessor", "1", "end"))
    first = section([lane(1, after=1)], [lane(-1)])
    net = network(tmp_path, straight("1", 0, 0, 0, 100, first, link=to_road("successor", "2", "start")), onwards)
    there = net.advance(net.locate(90.0, -1.75), 30.0)
    assert (there.road, there.s) == ("1", pytest.approx(100.0))


def test_a_thousand_small_steps_are_one_large_one(tmp_path: Path) -> None:
    net = ring(tmp_path)
    start = net.locate(*net.lane_pose("1", -1, 10.0, 0.5)[:2])
    position = start
    for _ in range(1000):
        position = net.advance(position, 0.2)
    whole = net.advance(start, 200.0)
    assert (position.road, position.lane) == (whole.road, whole.lane)
    assert (position.s, position.offset) == pytest.approx((whole.s, whole.offset), abs=1e-9)


def test_distance_counts_ahead_and_behind(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    west, east = net.locate(-60.0, -1.75), net.locate(40.0, -1.75)
    assert net.distance(west, east) == pytest.approx(100.0)
    assert net.distance(east, west) == pytest.approx(-100.0)


def test_distance_round_a_ring_is_the_shorter_way(tmp_path: Path) -> None:
    net = ring(tmp_path)
    here, there = (net.locate(*net.lane_pose("1", -1, s)[:2]) for s in (45.0, 5.0))
    assert net.distance(here, there) == pytest.approx(-40.0)


def test_distance_between_unlinked_roads_is_unknown(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100), straight("2", 0, 50, 0, 100))
    assert math.isnan(net.distance(net.locate(10.0, -1.0), net.locate(10.0, 49.0)))


@pytest.mark.parametrize(("start", "goal"), [(-1, 1), (1, -1), (1, 1)])
def test_a_waypoint_in_a_lane_that_no_way_leads_to_means_its_road(tmp_path: Path, start: int, goal: int) -> None:
    """Lanes 1 of W and N run towards W's beginning and the junction: the way is that of the lanes beside them."""
    board = cast("Storyboard", SimpleNamespace(network=crossing(tmp_path)))
    places = [
        Place(0.0, 0.0, 0.0, 0.0, road=RoadPoint(road, lane, s, 0.0))
        for road, lane, s in (("W", start, 50.0), ("N", goal, 30.0))
    ]
    assert [(each.road, each.lane) for each in way(board, places)] == [("W", -1), ("12", -1), ("N", -1)]


def test_of_two_lanes_beside_a_waypoint_the_nearer_one_is_meant(tmp_path: Path) -> None:
    """Both waypoints lie in lane -1, whose traffic comes from there: the way back is that of lane 1, not of lane 2."""
    wide = section([lane(1, before=1, after=1), lane(2, before=2, after=2)], [lane(-1, before=-1, after=-1)])
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, wide, link=to_road("successor", "2", "start")),
        straight("2", 100, 0, 0, 100, wide, link=to_road("predecessor", "1", "end")),
    )
    board = cast("Storyboard", SimpleNamespace(network=net))
    places = [Place(0.0, 0.0, 0.0, 0.0, road=RoadPoint(road, -1, 50.0, 0.0)) for road in ("2", "1")]
    assert [(each.road, each.lane) for each in way(board, places)] == [("2", 1), ("1", 1)]


def test_a_road_that_no_way_leads_to_cuts_the_route(tmp_path: Path) -> None:
    """From E a way leads to W, none to N."""
    board = cast("Storyboard", SimpleNamespace(network=crossing(tmp_path)))
    places = [
        Place(0.0, 0.0, 0.0, 0.0, road=RoadPoint(road, 1, s, 0.0))
        for road, s in (("E", 50.0), ("N", 30.0), ("W", 30.0))
    ]
    assert way(board, places) == ()
    assert [(each.road, each.lane) for each in way(board, places[::2])] == [("E", 1), ("11", -1), ("W", 1)]
