"""From (road, lane, s, offset) to a pose: lanes, lane offset, borders, slopes, traffic rule."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from road_files import arc, cubic, geometry, lane, network, road, section, straight


def test_lane_middle_lies_half_a_width_beside_the_lanes_within(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section([lane(1, 3.0)], [lane(-1, 4.0), lane(-2, 2.0)])))
    assert net.lane_pose("1", -2, 50.0)[:2] == pytest.approx((50.0, -5.0))
    assert net.lane_pose("1", 1, 50.0)[:2] == pytest.approx((50.0, 1.5))


def test_offset_counts_to_the_left_on_both_sides(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    assert net.lane_pose("1", -1, 50.0, 0.5).y == pytest.approx(-1.25)
    assert net.lane_pose("1", 1, 50.0, 0.5).y == pytest.approx(2.25)


def test_heading_is_that_of_increasing_s_on_all_lanes(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0.5, 100))
    assert net.lane_pose("1", 1, 50.0).h == pytest.approx(0.5)
    assert net.lane_pose("1", -1, 50.0).h == pytest.approx(0.5)


def test_lane_offset_moves_all_lanes(tmp_path: Path) -> None:
    # 2 m to the left over 100 m: t = 1 m in the middle, and the heading follows
    net = network(tmp_path, straight("1", 0, 0, 0, 100, offset=cubic("laneOffset", 0.0, 0.0, 0.02)))
    pose = net.lane_pose("1", -1, 50.0)
    assert pose.y == pytest.approx(-0.75)
    assert pose.h == pytest.approx(math.atan(0.02))


def test_width_polynomial_starts_anew_at_each_record(tmp_path: Path) -> None:
    widths = cubic("width", 0.0, 3.0) + cubic("width", 40.0, 3.0, 0.1)
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1, inside=widths)])))
    assert net.lane_width("1", -1, 39.0) == pytest.approx(3.0)
    assert net.lane_width("1", -1, 50.0) == pytest.approx(4.0)


def test_border_gives_the_outer_edge_itself(tmp_path: Path) -> None:
    lanes = [lane(-1, inside=cubic("border", 0.0, -3.0)), lane(-2, inside=cubic("border", 0.0, -5.0))]
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section((), lanes)))
    assert net.lane_pose("1", -2, 10.0).y == pytest.approx(-4.0)
    assert net.lane_width("1", -2, 10.0) == pytest.approx(2.0)


def test_lane_of_an_arc_lies_on_its_own_circle(tmp_path: Path) -> None:
    net = network(tmp_path, road("1", geometry(0, 0, 0, 0, 100, arc(0.02)), 100))
    for s in (0.0, 30.0, 100.0):
        pose = net.lane_pose("1", -1, s)
        assert math.hypot(pose.x, pose.y - 50.0) == pytest.approx(51.75, abs=1e-9)


def test_uphill_is_a_negative_pitch(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, elevation=cubic("elevation", 0.0, 2.0, 0.1)))
    pose = net.lane_pose("1", 0, 30.0)
    assert pose.z == pytest.approx(5.0)
    assert pose.pitch == pytest.approx(-math.atan(0.1))


def shape(s: float, t: float, *values: float) -> str:
    a, b, c, d = (*values, 0.0, 0.0, 0.0, 0.0)[:4]
    return f'<shape s="{s}" t="{t}" a="{a}" b="{b}" c="{c}" d="{d}"/>'


def test_a_shape_is_a_height_above_the_cross_section_from_right_to_left(tmp_path: Path) -> None:
    """ASAM OpenDRIVE 1.8, 10.5: a + b dt + c dt^2 + d dt^3 from each t on."""
    crown = shape(0.0, -4.0, 0.2, 0.1) + shape(0.0, -2.0, 0.4, 0.0, 0.1, 0.2)
    net = network(tmp_path, straight("1", 0, 0, 0, 100, superelevation=crown))
    right, left = net.road_pose("1", 30.0, -3.0), net.road_pose("1", 30.0, -1.5)
    assert (right.x, right.y, right.z) == pytest.approx((30.0, -3.0, 0.2 + 0.1 * 1.0))
    assert right.roll == pytest.approx(math.atan(0.1))
    assert left.z == pytest.approx(0.4 + 0.1 * 0.25 + 0.2 * 0.125)
    assert left.roll == pytest.approx(math.atan(0.2 * 0.5 + 0.6 * 0.25))
    assert net.road_pose("1", 30.0, -6.0).z == pytest.approx(0.2)


def test_cross_sections_of_a_shape_are_joined_by_straight_lines(tmp_path: Path) -> None:
    profile = shape(20.0, 0.0, 0.0) + shape(60.0, 0.0, 1.0, 0.1) + shape(80.0, 0.0, 1.0)
    net = network(tmp_path, straight("1", 0, 0, 0, 100, superelevation=profile))
    heights = [net.road_pose("1", s, 2.0).z for s in (10.0, 30.0, 60.0, 70.0, 90.0)]
    assert heights == pytest.approx([0.0, 0.25 * 1.2, 1.2, 1.1, 1.0])
    pose = net.road_pose("1", 30.0, 2.0)
    assert (pose.pitch, pose.roll) == pytest.approx((-math.atan(1.2 / 40.0), math.atan(0.25 * 0.1)))


def test_a_shape_stands_on_the_turned_cross_section(tmp_path: Path) -> None:
    bank = cubic("superelevation", 0.0, 0.2) + shape(0.0, -10.0, 0.5)
    net = network(tmp_path, straight("1", 0, 0, 0, 100, superelevation=bank))
    pose = net.road_pose("1", 50.0, 3.0)
    expected = 3.0 * math.cos(0.2) - 0.5 * math.sin(0.2), 3.0 * math.sin(0.2) + 0.5 * math.cos(0.2)
    assert (pose.y, pose.z) == pytest.approx(expected)


def test_positive_superelevation_lifts_the_left(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, superelevation=cubic("superelevation", 0.0, 0.2)))
    pose = net.road_pose("1", 30.0, 3.0)
    assert (pose.y, pose.z, pose.roll) == pytest.approx((3.0 * math.cos(0.2), 3.0 * math.sin(0.2), 0.2))


def test_banked_slope_turns_the_cross_section_about_the_inclined_line(tmp_path: Path) -> None:
    elevation, bank = cubic("elevation", 0.0, 0.0, 0.1), cubic("superelevation", 0.0, 0.4)
    net = network(tmp_path, straight("1", 0, 0, 0, 50, elevation=elevation, superelevation=bank))
    pitch = -math.atan(0.1)
    pose = net.road_pose("1", 25.0, -3.0)
    expected = (
        25.0 - 3.0 * math.sin(pitch) * math.sin(0.4),
        -3.0 * math.cos(0.4),
        2.5 - 3.0 * math.cos(pitch) * math.sin(0.4),
    )
    assert pose[:3] == pytest.approx(expected)


def test_kerb_raises_a_sidewalk(tmp_path: Path) -> None:
    inside = cubic("width", 0.0, 2.0) + '<height sOffset="0" inner="0.1" outer="0.14"/>'
    sides = section((), [lane(-1), lane(-2, type_="sidewalk", inside=inside)])
    net = network(tmp_path, straight("1", 0, 0, 0, 100, sides))
    assert net.lane_pose("1", -2, 10.0).z == pytest.approx(0.12)
    assert net.lane_pose("1", -1, 10.0).z == 0.0


def test_what_has_no_record_yet_has_no_height(tmp_path: Path) -> None:
    """A kerb from 50 m on, and a slope of 2 % from there on, on a road that the header raises by 3 m."""
    inside = cubic("width", 0.0, 2.0) + '<height sOffset="50" inner="0.12" outer="0.12"/>'
    sides = section((), [lane(-1), lane(-2, type_="sidewalk", inside=inside)])
    slope = cubic("elevation", 50.0, 0.0, 0.02)
    text = straight("1", 0, 0, 0, 100, sides, elevation=slope)
    net = network(tmp_path, text, header='<offset x="0" y="0" z="3" hdg="0"/>')
    kerb = 0.12 * math.cos(math.atan(0.02))  # it stands upright on the slope
    heights = [net.lane_pose("1", -2, s).z for s in (10.0, 50.0, 100.0)]
    assert heights == pytest.approx([3.0, 3.0 + kerb, 4.0 + kerb])
    assert [net.road_pose("1", s, 0.0)[2] for s in (10.0, 100.0)] == pytest.approx([3.0, 4.0])


def test_header_offset_turns_the_whole_network_about_its_origin_and_shifts_it(tmp_path: Path) -> None:
    """ASAM OpenDRIVE 1.8, 8.5: xWorld = 25 cos 90 - 0 sin 90 - 10, yWorld = 25 sin 90 + 0 cos 90."""
    header = '<offset x="-10" y="0" z="3" hdg="1.5707963267948966"/>'
    net = network(tmp_path, straight("1", 20, 0, 0, 100), header=header)
    pose = net.road_pose("1", 5.0, 0.0)
    assert pose[:4] == pytest.approx((-10.0, 25.0, 3.0, math.pi / 2.0))


@pytest.mark.parametrize(("rule", "right"), [("RHT", 1), ("LHT", -1)])
def test_traffic_rule_says_which_way_a_lane_runs(tmp_path: Path, rule: str, right: int) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, rule=rule))
    assert net.rule == rule
    assert (net.driving_sign("1", -1), net.driving_sign("1", 1)) == (right, -right)


def test_lane_that_is_not_there_is_named(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100))
    with pytest.raises(KeyError, match="road 1 has no lane -2"):
        net.lane_pose("1", -2, 10.0)


def test_speed_limit_of_the_lane_comes_before_that_of_the_road(tmp_path: Path) -> None:
    limited = lane(-1, inside=cubic("width", 0.0, 3.5) + '<speed sOffset="50" max="36" unit="km/h"/>')
    text = straight("1", 0, 0, 0, 100, section([lane(1)], [limited]))
    text = text.replace("<planView>", '<type s="0" type="town"><speed max="20" unit="m/s"/></type><planView>')
    net = network(tmp_path, text)
    assert net.lane_speed("1", -1, 60.0) == pytest.approx(10.0)
    assert net.lane_speed("1", -1, 10.0) == pytest.approx(20.0)
    assert net.lane_speed("1", 1, 60.0) == pytest.approx(20.0)


def test_no_speed_limit_is_infinite(tmp_path: Path) -> None:
    assert network(tmp_path, straight("1", 0, 0, 0, 100)).lane_speed("1", -1, 5.0) == math.inf
