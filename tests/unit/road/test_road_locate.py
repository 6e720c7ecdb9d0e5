"""From x, y back to a road position."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from road_files import arc, crossing, cubic, geometry, lane, network, road, section, spiral, straight

from openscenario.road.network import RoadNetwork


@pytest.fixture(scope="module")
def bends(tmp_path_factory: pytest.TempPathFactory) -> RoadNetwork:
    """A line, a spiral and an arc in a row, 200 m in all, with a banked slope."""
    end = geometry(0, 0, 0, 0, 60)
    end += geometry(60, 60, 0, 0, 40, spiral(0.0, 0.02))
    net = network(tmp_path_factory.mktemp("part"), road("1", end, 100))
    pose = net.road_pose("1", 100.0, 0.0)
    end += geometry(100, pose.x, pose.y, pose.h, 100, arc(0.02))
    lanes = section([lane(1), lane(2, 2.0, "sidewalk")], [lane(-1), lane(-2, 3.0)])
    slope, bank = cubic("elevation", 0.0, 0.0, 0.05), cubic("superelevation", 0.0, 0.1)
    text = road("1", end, 200, lanes, elevation=slope, superelevation=bank)
    return network(tmp_path_factory.mktemp("whole"), text)


@settings(deadline=None)
@given(s=st.floats(0.01, 199.9), lane_id=st.sampled_from([1, -1, -2]), offset=st.floats(-1.4, 1.4))
def test_a_lane_position_comes_back(bends: RoadNetwork, s: float, lane_id: int, offset: float) -> None:
    pose = bends.lane_pose("1", lane_id, s, offset)
    found = bends.locate(pose.x, pose.y)
    assert (found.road, found.lane, found.on_road) == ("1", lane_id, True)
    assert (found.s, found.offset) == pytest.approx((s, offset), abs=1e-6)


@settings(deadline=None)
@given(s=st.floats(1.0, 190.0), ds=st.floats(-3.0, 3.0), offset=st.floats(-1.4, 1.4))
def test_a_hint_changes_nothing_but_the_cost(bends: RoadNetwork, s: float, ds: float, offset: float) -> None:
    pose = bends.lane_pose("1", -1, s, offset)
    near = bends.lane_pose("1", -1, s + ds)
    hint = bends.locate(near.x, near.y)
    assert bends.locate(pose.x, pose.y, hint=hint) == pytest.approx(bends.locate(pose.x, pose.y), abs=1e-6)


def test_beside_the_lanes_the_nearest_drivable_one_counts(bends: RoadNetwork) -> None:
    pose = bends.lane_pose("1", 2, 30.0)
    found = bends.locate(pose.x, pose.y)
    assert (found.lane, found.on_road) == (1, False)


def test_a_pedestrian_may_ask_for_the_sidewalk(bends: RoadNetwork) -> None:
    pose = bends.lane_pose("1", 2, 30.0)
    found = bends.locate(pose.x, pose.y, drivable=False)
    assert (found.lane, found.on_road) == (2, True)
    assert found.offset == pytest.approx(0.0, abs=1e-9)


def test_far_from_any_road_the_nearest_is_found(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100), straight("2", 0, 200, 0, 100))
    found = net.locate(30.0, -500.0)
    assert (found.road, found.lane, found.on_road) == ("1", -1, False)
    assert found.s == pytest.approx(30.0, abs=1e-6)


def test_before_the_start_s_is_zero(bends: RoadNetwork) -> None:
    found = bends.locate(-5.0, -1.0)
    assert (found.s, found.on_road) == (0.0, False)


def test_heading_decides_between_overlapping_roads(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    turning = net.lane_pose("12", -1, 3.0)
    assert net.locate(turning.x, turning.y, h=turning.h).road == "12"
    assert net.locate(turning.x, turning.y, h=0.0).road == "10"


def test_hint_keeps_a_vehicle_on_its_way_through_a_junction(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    start = net.lane_pose("12", -1, 1.0)
    hint = net.locate(start.x, start.y, h=start.h)._replace(road="12", s=1.0)
    later = net.lane_pose("12", -1, 2.0)
    assert net.locate(later.x, later.y, hint=hint).road == "12"


@pytest.mark.parametrize("past", [1e-5, 3e-4, 4e-3])
def test_a_hint_of_the_road_before_does_not_hide_the_next_one(tmp_path: Path, past: float) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100), straight("2", 100, 0, 0, 100))
    hint = net.locate(99.9, -0.95)
    found = net.locate(100.0 + past, -0.95, hint=hint)
    assert (hint.road, found.road, found.on_road) == ("1", "2", True)


def test_heading_picks_the_direction_of_traffic_in_the_junction(tmp_path: Path) -> None:
    net = crossing(tmp_path)
    assert net.locate(0.0, 1.75, h=math.pi).road == "11"
    assert net.locate(0.0, -1.75, h=0.0).road == "10"


def test_height_tells_a_bridge_from_the_road_below(tmp_path: Path) -> None:
    net = network(
        tmp_path,
        straight("low", -50, 0, 0, 100),
        straight("high", 0, -50, math.pi / 2, 100, elevation=cubic("elevation", 0.0, 6.0)),
    )
    assert net.locate(1.0, -1.0, z=0.0).road == "low"
    assert net.locate(1.0, -1.0, z=6.0).road == "high"


def test_lane_of_a_merging_lane_with_no_width_left_is_not_preferred(tmp_path: Path) -> None:
    vanishing = lane(-2, inside=cubic("width", 0.0, 3.5, -0.035))
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1), vanishing])))
    assert net.locate(99.99, -3.2).lane == -1


def test_a_lane_far_from_its_reference_line_is_found_where_another_road_is_nearer(tmp_path: Path) -> None:
    """Road 1 has its lane 20 m right of its line (lane offset); road 2, which is nearer, holds nothing here."""
    shifted = straight("1", 0, 0, 0, 60, section((), [lane(-1)]), offset=cubic("laneOffset", 0, -20.0))
    beside = straight("2", 0, -24.0, 0, 60, section((), [lane(-1)]))
    net = network(tmp_path, beside, shifted)
    found = net.locate(30.0, -23.3)  # lane -1 of road 1 reaches from -20 to -23.5 m, road 2 begins at -24 m
    assert (found.road, found.lane, found.on_road) == ("1", -1, True)
