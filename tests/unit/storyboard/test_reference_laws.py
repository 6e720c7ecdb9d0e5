"""Laws that the standard leaves open and that are fixed here: expected values in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.road.network import load_network
from openscenario.storyboard.places import turned_in_plane, yaw_in_plane
from openscenario.storyboard.positions import turned
from openscenario.storyboard.trajectories import Course

from .conftest import (
    LANE,
    XODR,
    Make,
    at_time,
    by_entity,
    condition,
    event,
    group,
    lane_change,
    lane_position,
    log,
    run,
    speed,
    story,
    teleport,
)

WIDTH = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
HERE = [teleport(lane_position(100.0)), speed(10.0)]
NOW = group(condition(at_time(0.0)))
ROAD = '<RoadPosition roadId="1" s="{s}" t="0"/>'


def test_in_a_lane_change_the_speed_is_that_along_the_oblique_path(make: Make) -> None:
    """Linear, 3.5 m in 2 s at 10 m/s: the way along the road is sqrt(20^2 - 3.5^2)."""
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "time", 2.0)
    board = make(A=HERE, stories=story(event("e", change, start=NOW)))
    run(board, 1.0)
    assert -board.entities["A"].h == pytest.approx(math.asin(1.75 / 10.0), abs=1e-9)
    run(board, 1.0)
    assert board.entities["A"].x == pytest.approx(100.0 + math.sqrt(20.0**2 - 3.5**2), abs=2e-3)


def test_a_lane_change_by_distance_takes_that_way_along_the_lane(make: Make) -> None:
    """Linear, 3.5 m over 20 m at 10 m/s: sqrt(20^2 + 3.5^2) / 10 s."""
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "distance", 20.0)
    board = make(A=HERE, stories=story(event("e", change, start=NOW)))
    run(board, 3.0)
    ((time, _, _),) = [each for each in log(board, "action") if each[2] == "endTransition"]
    assert time == pytest.approx(math.hypot(20.0, 3.5) / 10.0, abs=0.0101)


def test_a_speed_change_over_a_distance_may_pass_through_standstill(make: Make) -> None:
    """From 10 to -10 m/s over 40 m: 20 m forth in 4 s, 20 m back in 4 s; less half a beat of 10 ms of the change."""
    board = make(A=HERE, stories=story(event("e", speed(-10.0, "linear", "distance", 40.0), start=NOW)))
    run(board, 4.0)
    assert board.entities["A"].speed == pytest.approx(0.0, abs=1e-6)
    assert board.entities["A"].x == pytest.approx(120.0 - 0.5 * 0.01 * 10.0, abs=1e-3)
    run(board, 4.0)
    assert board.entities["A"].speed == -10.0


def test_keeping_a_distance_is_limited_by_the_vehicle_too(make: Make) -> None:
    action = (
        "<PrivateAction><LongitudinalAction>"
        '<LongitudinalDistanceAction entityRef="B" continuous="true" freespace="false" distance="20">'
        '<DynamicConstraints maxAcceleration="50" maxDeceleration="50" maxSpeed="60"/>'
        "</LongitudinalDistanceAction></LongitudinalAction></PrivateAction>"
    )
    board = make(
        A=HERE,
        B=[teleport(lane_position(400.0, -2)), speed(10.0)],
        stories=story(event("e", action, start=NOW)),
        acceleration=3.0,
    )
    run(board, 2.0)
    assert board.entities["A"].speed == pytest.approx(16.0, abs=0.01)


def test_what_starts_at_once_shows_before_the_first_step(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", speed(3.0), start=NOW)))
    board.start()
    board.settle()
    assert board.entities["A"].speed == 3.0
    run(board, 1.0)
    assert board.entities["A"].x == pytest.approx(103.0)
    assert len([each for each in log(board, "event") if each[2] == "startTransition"]) == 1


def corner() -> Course:
    return Course([(0.0, 0.0, 0.0, 1.0), (10.0, 0.0, 0.0, 1.0), (10.0, 5.0, 0.0, 1.0)])


@pytest.mark.parametrize(("x", "y", "s"), [(4.0, -3.0, 4.0), (12.0, 2.0, 12.0), (-5.0, 1.0, 0.0), (11.0, 9.0, 15.0)])
def test_the_nearest_point_of_a_curve(x: float, y: float, s: float) -> None:
    assert corner().nearest(x, y) == pytest.approx(s)


@pytest.mark.parametrize(("s", "direction"), [(3.0, 0.0), (12.0, math.pi / 2.0), (15.0, math.pi / 2.0)])
def test_the_tangent_does_not_depend_on_headings(s: float, direction: float) -> None:
    assert corner().tangent(s) == pytest.approx(direction)


def lateral_distance(limits: str, freespace: bool = False) -> str:
    return (
        '<PrivateAction><LateralAction><LateralDistanceAction entityRef="B" continuous="false" distance="1" '
        f'freespace="{str(freespace).lower()}" displacement="rightToReferencedEntity" coordinateSystem="road">'
        f"{limits}</LateralDistanceAction></LateralAction></PrivateAction>"
    )


@pytest.mark.parametrize(("freespace", "y"), [(False, -1.75 - 1.0), (True, -1.75 - 1.0 - 2.0)])
def test_a_lateral_distance_without_limits_is_taken_at_once(make: Make, freespace: bool, y: float) -> None:
    """Both vehicles are 2 m wide."""
    board = make(
        B=[teleport(lane_position(200.0)), speed(10.0)],
        A=[teleport(lane_position(100.0, -2)), speed(10.0)],
        stories=story(event("e", lateral_distance("", freespace), start=NOW)),
    )
    run(board, 0.02)
    assert board.entities["A"].y == pytest.approx(y)


def test_a_lateral_distance_is_reached_at_the_highest_speed_allowed(make: Make) -> None:
    """From -5.25 to -2.75 m at 1 m/s."""
    limits = '<DynamicConstraints maxSpeed="1"/>'
    board = make(
        B=[teleport(lane_position(200.0)), speed(10.0)],
        A=[teleport(lane_position(100.0, -2)), speed(10.0)],
        stories=story(event("e", lateral_distance(limits), start=NOW)),
    )
    run(board, 1.0)
    assert board.entities["A"].y == pytest.approx(-4.25, abs=1e-6)
    run(board, 1.6)
    assert board.entities["A"].y == pytest.approx(-2.75, abs=0.01)
    assert board.entities["A"].h == pytest.approx(0.0, abs=1e-9)
    assert any(what == "endTransition" for _, _, what in log(board, "action"))


def test_a_lateral_distance_with_a_limit_of_acceleration_does_not_overshoot(make: Make) -> None:
    """A critically damped spring of k = 0.4 x 2: after t the rest is (1 + sqrt(k) t) exp(-sqrt(k) t)."""
    limits = '<DynamicConstraints maxAcceleration="2" maxDeceleration="2"/>'
    board = make(
        B=[teleport(lane_position(200.0)), speed(10.0)],
        A=[teleport(lane_position(100.0, -2)), speed(10.0)],
        stories=story(event("e", lateral_distance(limits), start=NOW)),
    )
    run(board, 3.0)
    way = math.sqrt(0.8) * 3.0
    assert -2.75 - board.entities["A"].y == pytest.approx(2.5 * (1.0 + way) * math.exp(-way), abs=0.02)
    run(board, 6.0)
    assert board.entities["A"].y == pytest.approx(-2.75, abs=0.0101)


def test_who_stands_does_not_change_lanes(make: Make) -> None:
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "time", 1.0)
    board = make(A=[teleport(lane_position(100.0))], stories=story(event("e", change, start=NOW)))
    run(board, 3.0)
    assert board.entities["A"].y == pytest.approx(-1.75)


def test_a_lane_change_faster_than_the_vehicle_goes_straight_to_the_side(make: Make) -> None:
    """Linear, 3.5 m in 2 s at 1 m/s: all of the way is sideways, and 3.5 m at 1 m/s take 3.5 s."""
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "time", 2.0)
    board = make(A=[teleport(lane_position(100.0)), speed(1.0)], stories=story(event("e", change, start=NOW)))
    run(board, 2.0)
    a = board.entities["A"]
    assert (a.x, a.y) == (pytest.approx(100.0, abs=1e-6), pytest.approx(-1.75 - 2.0, abs=0.011))
    assert a.h == pytest.approx(-0.5 * math.pi, abs=1e-5)
    run(board, 2.0)
    ((time, _, _),) = [each for each in log(board, "action") if each[2] == "endTransition"]
    assert time == pytest.approx(3.5, abs=0.0101)


def test_a_lane_offset_is_that_of_the_road_s_t_axis(make: Make) -> None:
    """In a left lane, heading against s: +1 m is to the left of the reference line's direction, as in LanePosition."""
    offset = (
        '<PrivateAction><LateralAction><LaneOffsetAction continuous="false">'
        '<LaneOffsetActionDynamics dynamicsShape="cubic" maxLateralAcc="2"/>'
        '<LaneOffsetTarget><AbsoluteTargetLaneOffset value="1"/></LaneOffsetTarget>'
        "</LaneOffsetAction></LateralAction></PrivateAction>"
    )
    board = make(A=[teleport(lane_position(500.0, 1)), speed(10.0)], stories=story(event("e", offset, start=NOW)))
    run(board, 4.0)
    assert board.entities["A"].y == pytest.approx(1.75 + 1.0)


def test_what_is_relative_to_a_body_lies_in_its_frame(make: Make) -> None:
    """A body that lies on its left side: its up points to where its left was (here +y)."""
    lying = lane_position(200.0, -1, inner=f'<Orientation type="relative" r="{-0.5 * math.pi}"/>')
    other = '<RelativeObjectPosition entityRef="B" dx="3" dy="0" dz="0.5"/>'
    board = make(B=[teleport(lying)], A=[teleport(other)])
    board.start()
    a = board.entities["A"]
    assert (a.x, a.y, a.z) == (pytest.approx(203.0), pytest.approx(-1.75 + 0.5), pytest.approx(0.0))


def test_where_a_lane_shrinks_to_nothing_one_goes_on_beside_it(tmp_path: Path) -> None:
    road = tmp_path / "road.xodr"
    widths = (
        '<width sOffset="0" a="3.5" b="0" c="0" d="0"/><width sOffset="300" a="3.5" b="-0.035" c="0" d="0"/>'
        '<width sOffset="400" a="0" b="0" c="0" d="0"/>'
    )
    road.write_text(XODR.replace(LANE.format(id=-2), LANE.format(id=-2).replace(WIDTH, widths)))
    network = load_network(road)
    there = network.advance(network.locate(290.0, -5.25), 150.0)
    # the shift to the side makes no way: s grows by what was driven
    assert (there.lane, there.s) == (-1, pytest.approx(440.0))
    assert network.lane_pose("1", there.lane, there.s).y == pytest.approx(-1.75)


@pytest.mark.parametrize(
    ("position", "x", "y"),
    [
        ('<RelativeLanePosition entityRef="B" dLane="0" ds="20"/>', 520.0, 1.75),  # along s
        ('<RelativeLanePosition entityRef="B" dLane="0" dsLane="20"/>', 480.0, 1.75),  # ahead of it
        ('<RelativeLanePosition entityRef="B" dLane="1" ds="0" offset="0.5"/>', 500.0, 5.25 + 0.5),  # ids, t
        ('<RelativeLanePosition entityRef="B" dLane="1" dsLane="0" offset="0.5"/>', 500.0, -1.75 - 0.5),  # to its left
        ('<RelativeLanePosition entityRef="B" dLane="0"/>', 500.0, 1.75),  # neither: beside it, as with ds of 0
        ('<RelativeLanePosition entityRef="B" dLane="1" offset="0.5"/>', 500.0, 5.25 + 0.5),
        ('<RelativeRoadPosition entityRef="B" ds="20" dt="1"/>', 520.0, 2.75),
    ],
)
def test_what_is_relative_to_who_drives_against_s(make: Make, position: str, x: float, y: float) -> None:
    board = make(B=[teleport(lane_position(500.0, 1))], A=[teleport(position)])
    board.start()
    assert (board.entities["A"].x, board.entities["A"].y) == (pytest.approx(x), pytest.approx(y))


def test_world_positions_go_with_the_header_s_offset(make: Make, tmp_path: Path) -> None:
    """The header turns by 90 degrees about the origin and shifts by (-10, 5): x' = -y - 10, y' = x + 5."""
    road = tmp_path / "road.xodr"
    header = '<header revMajor="1" revMinor="6" name="straight">'
    offset = f'{header}<offset x="-10" y="5" z="0" hdg="{0.5 * math.pi}"/></header>'
    road.write_text(XODR.replace(header.replace(">", "/>"), offset))
    network = load_network(road)
    assert network.moved(30.0, 2.0, 0.0, 0.1) == pytest.approx((-12.0, 35.0, 0.0, 0.1 + 0.5 * math.pi))
    start = network.lane_pose("1", -1, 0.0)
    assert (start.x, start.y) == (pytest.approx(1.75 - 10.0), pytest.approx(5.0))


def test_a_change_of_lights_lasts_its_transition(make: Make) -> None:
    lights = (
        '<PrivateAction><AppearanceAction><LightStateAction transitionTime="1.5"><LightType>'
        '<VehicleLight vehicleLightType="lowBeam"/></LightType><LightState mode="on"/></LightStateAction>'
        "</AppearanceAction></PrivateAction>"
    )
    board = make(A=HERE, stories=story(event("e", lights, start=NOW)))
    run(board, 3.0)
    ((time, _, _),) = [each for each in log(board, "action") if each[2] == "endTransition"]
    assert time == pytest.approx(1.5, abs=1e-6)


def light(kind: str, mode: str) -> str:
    return (
        "<PrivateAction><AppearanceAction><LightStateAction><LightType>"
        f'<VehicleLight vehicleLightType="{kind}"/></LightType><LightState mode="{mode}"/></LightStateAction>'
        "</AppearanceAction></PrivateAction>"
    )


def test_a_light_flashes_until_another_action_takes_it(make: Make) -> None:
    """Another light does not; what is taken over is stopped, as by a stop trigger, and its event goes on."""
    board = make(
        A=HERE,
        stories=story(
            event("blink", light("indicatorLeft", "flashing"), start=NOW),
            event("brake", light("brakeLights", "on"), start=group(condition(at_time(1.0)))),
            event("off", light("indicatorLeft", "off"), start=group(condition(at_time(2.0)))),
        ),
    )
    run(board, 3.0)
    over = [(time, name, how) for time, name, how in log(board, "action") if how in ("endTransition", "stopTransition")]
    assert over == [
        (1.0, "brake-0", "endTransition"),
        (2.0, "blink-0", "stopTransition"),
        (2.0, "off-0", "endTransition"),
    ]
    assert (2.0, "blink", "endTransition") in log(board, "event")


def headway(value: float, along_route: bool) -> str:
    attributes = f'value="{value}" freespace="false" rule="greaterThan" alongRoute="{str(along_route).lower()}"'
    return group(condition(by_entity(f'<TimeHeadwayCondition entityRef="B" {attributes}/>', "A")))


@pytest.mark.parametrize(("value", "fires"), [(3.0, True), (3.02, True), (3.03, False)])
def test_a_distance_along_the_route_counts_what_lies_to_the_side(make: Make, value: float, fires: bool) -> None:
    """30 m ahead and 3.5 m to the side: hypot(30, 3.5) / 10 m/s = 3.0203 s. The standard speaks of turns only."""
    ahead = [teleport(lane_position(130.0, -2)), speed(10.0)]
    board = make(A=HERE, B=ahead, stories=story(event("e", speed(10.0), start=headway(value, True))))
    run(board, 0.1)
    assert bool([each for each in log(board, "event") if each[2] == "startTransition"]) is fires


@pytest.mark.parametrize(("along_route", "seconds"), [(True, 5.0 * math.pi), (False, 10.0 * math.sqrt(2.0))])
def test_turns_make_a_distance_along_the_route_longer(
    make: Make, tmp_path: Path, along_route: bool, seconds: float
) -> None:
    """A quarter of a circle of 100 m radius at 10 m/s: the arc, or the chord."""
    road = tmp_path / "arc.xodr"
    line = '<geometry s="0" x="0" y="0" hdg="0" length="1000"><line/>'
    arc = line.replace("1000", "400").replace("<line/>", '<arc curvature="0.01"/>')
    road.write_text(XODR.replace(line, arc).replace('length="1000"', 'length="400"'))
    quarter = 50.0 * math.pi
    for off, fires in ((-0.02, True), (0.02, False)):
        board = make(
            A=[teleport(ROAD.format(s=10.0)), speed(10.0)],
            B=[teleport(ROAD.format(s=10.0 + quarter)), speed(10.0)],
            stories=story(event("e", speed(10.0), start=headway(seconds + off, along_route))),
            on=load_network(road),
        )
        board.start()
        board.settle()
        assert bool([each for each in log(board, "event") if each[2] == "startTransition"]) is fires


def synchronize(master_s: float, own_s: float, final: float) -> str:
    return (
        '<PrivateAction><SynchronizeAction masterEntityRef="B">'
        f"<TargetPositionMaster>{lane_position(master_s)}</TargetPositionMaster>"
        f"<TargetPosition>{lane_position(own_s, -2)}</TargetPosition>"
        f'<FinalSpeed><AbsoluteSpeed value="{final}"/></FinalSpeed></SynchronizeAction></PrivateAction>'
    )


def test_who_synchronizes_from_the_start_stands_until_it_has_seen_the_master_move(make: Make) -> None:
    """100 m at 10 m/s for the master, 50 m to a final 8 m/s: the one ramp that fits begins with 2 * 50 / 10 - 8 m/s."""
    board = make(
        A=[teleport(lane_position(100.0, -2)), speed(5.0)],
        B=[teleport(lane_position(100.0)), speed(10.0)],
        stories=story(event("e", synchronize(200.0, 150.0, 8.0))),
    )
    board.start()
    board.settle()
    assert board.entities["A"].speed == 0.0
    run(board, 0.01)
    assert board.entities["A"].speed == pytest.approx(2.0, abs=0.01)


def test_a_master_that_is_put_on_its_trajectory_has_not_moved(make: Make) -> None:
    """Its trajectory begins where it came from: for that instant it stands, and so does who synchronizes with it."""
    vertices = "".join(f'<Vertex><Position><WorldPosition x="{x}" y="-1.75"/></Position></Vertex>' for x in (100, 300))
    follow = (
        '<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name="t" closed="false">'
        f"<Shape><Polyline>{vertices}</Polyline></Shape></Trajectory></TrajectoryRef><TimeReference><None/>"
        '</TimeReference><TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction>'
        "</PrivateAction>"
    )
    later = group(condition(at_time(1.0)))
    board = make(
        A=[teleport(lane_position(100.0, -2)), speed(0.0)],
        B=[teleport(lane_position(100.0)), speed(10.0)],
        stories=story(event("s", synchronize(200.0, 150.0, 8.0), start=later))
        + story(event("t", follow, start=later), actor="B", name="other"),
    )
    run(board, 1.01)
    assert board.entities["A"].speed == 0.0
    run(board, 0.01)
    assert board.entities["A"].speed == pytest.approx(2.0, abs=0.03)


def test_headings_that_look_back_make_a_vehicle_reverse(make: Make) -> None:
    vertices = "".join(
        f'<Vertex time="{t}"><Position><WorldPosition x="{x}" y="0" h="{math.pi}"/></Position></Vertex>'
        for t, x in ((0.0, 100.0), (5.0, 150.0))
    )
    action = (
        "<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef>"
        f'<Trajectory name="t" closed="false"><Shape><Polyline>{vertices}</Polyline></Shape></Trajectory>'
        "</TrajectoryRef>"
        '<TimeReference><Timing domainAbsoluteRelative="relative" scale="1" offset="0"/></TimeReference>'
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )
    board = make(A=HERE, stories=story(event("e", action, start=NOW)))
    run(board, 2.0)
    a = board.entities["A"]
    assert (a.x, a.speed) == (pytest.approx(120.0, abs=0.11), pytest.approx(-10.0))
    assert abs(a.h) == pytest.approx(math.pi)


def test_a_reference_point_ahead_draws_the_vehicle_along(make: Make) -> None:
    """Drawn straight to the side the angle to the way falls as a tractrix: tan(a / 2) by e^(-way / length)."""
    trajectory = "".join(
        f'<Vertex><Position><WorldPosition x="{x}" y="0"/></Position></Vertex>' for x in (100.0, 200.0)
    )
    action = (
        "<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef>"
        f'<Trajectory name="t" closed="false"><Shape><Polyline>{trajectory}</Polyline></Shape></Trajectory>'
        "</TrajectoryRef><TimeReference><None/></TimeReference>"
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )
    board = make(
        A=[teleport('<WorldPosition x="100" y="0" h="1.2"/>'), speed(10.0)],
        stories=story(event("e", action, start=NOW)),
    )
    a = board.entities["A"]
    a.leads = 3.0
    run(board, 0.6)
    assert math.tan(0.5 * a.h) == pytest.approx(math.tan(0.6) * math.exp(-6.0 / 3.0), rel=0.05)


@pytest.mark.parametrize(("pitch", "roll"), [(0.55, 0.0), (0.0, 0.3), (-0.4, 0.2)])
@pytest.mark.parametrize("yaw", [0.3, -1.2, 2.8])
def test_a_turn_on_an_inclined_plane_keeps_the_body_on_it(pitch: float, roll: float, yaw: float) -> None:
    """Both its axes stand at right angles to the normal of the plane, and the yaw comes back from the heading."""
    h, p, r = turned_in_plane(0.7, pitch, roll, yaw)
    normal = turned(0.7, pitch, roll, 0.0, 0.0, 1.0)
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        assert sum(a * b for a, b in zip(turned(h, p, r, *axis), normal, strict=True)) == pytest.approx(0.0, abs=1e-12)
    ahead = turned(0.7, pitch, roll, math.cos(yaw), math.sin(yaw), 0.0)
    assert turned(h, p, r, 1.0, 0.0, 0.0) == pytest.approx(ahead)
    assert yaw_in_plane(pitch, roll, h - 0.7) == pytest.approx(yaw)


def test_who_changes_lanes_on_a_slope_turns_on_it(make: Make, tmp_path: Path) -> None:
    """On a slope of tan p = 0.5 the lane change's yaw y shows in the plan as atan2(sin y, cos y cos p)."""
    (tmp_path / "slope.xodr").write_text(
        XODR.replace(
            "<lanes>", '<elevationProfile><elevation s="0" a="0" b="0.5" c="0" d="0"/></elevationProfile><lanes>'
        )
    )
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "time", 2.0)
    board = make(A=HERE, stories=story(event("e", change, start=NOW)), on=load_network(tmp_path / "slope.xodr"))
    run(board, 1.0)
    yaw, p = math.asin(1.75 / 10.0), math.atan(0.5)
    assert -board.entities["A"].h == pytest.approx(math.atan2(math.sin(yaw), math.cos(yaw) * math.cos(p)), abs=1e-9)


@pytest.mark.parametrize(("first", "beats"), [("lane", -1), ("speed", 1)])
def test_who_changes_lanes_before_its_speed_in_the_file_takes_its_speed_a_beat_later(
    make: Make, first: str, beats: int
) -> None:
    """Actions of a step follow each other as in the file: 10 to 20 m/s in 2 s makes half a beat of 10 ms x 10 m/s."""
    actions = [
        lane_change('<AbsoluteTargetLane value="-1"/>', "linear", "time", 3.0),
        speed(20.0, "linear", "time", 2.0),
    ]
    start = [teleport(lane_position(100.0, -1, 1e-3)), speed(10.0)]
    board = make(A=start, stories=story(event("e", *actions[:: 1 if first == "lane" else -1], start=NOW)))
    run(board, 2.0)
    assert board.entities["A"].x == pytest.approx(100.0 + 30.0 + beats * 0.5 * 0.01 * 10.0, abs=1e-4)


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_being_put_somewhere_takes_a_beat_of_the_default_controller(make: Make, dt: float) -> None:
    """10 m/s, put to x = 300 at 1 s: there until 1.01 s, at 301 a tenth of a second later; its speed is kept."""
    jump = event("e", teleport(lane_position(300.0)), start=group(condition(at_time(1.0))))
    board = make(A=HERE, stories=story(jump))
    a = board.entities["A"]
    run(board, 1.0, dt)
    run(board, dt, dt)
    assert (a.x, a.speed, a.vx) == (pytest.approx(300.0 + 10.0 * (dt - 0.01)), 10.0, pytest.approx(10.0))
    run(board, 0.1, dt)
    assert a.x == pytest.approx(300.0 + 10.0 * (dt + 0.09))


def test_who_changes_lanes_from_where_it_is_put_goes_on_at_once(make: Make) -> None:
    """Its lateral action takes it along: 0.1 m in the first 10 ms at 10 m/s."""
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "time", 10.0)
    jump = event("e", teleport(lane_position(300.0)), change, start=group(condition(at_time(1.0))))
    board = make(A=HERE, stories=story(jump))
    run(board, 1.01)
    assert board.entities["A"].x == pytest.approx(300.1, abs=1e-3)
