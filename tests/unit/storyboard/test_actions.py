"""What actions do to an entity on a straight road; expected values from kinematics."""

from __future__ import annotations

import math

import pytest

from openscenario.findings import ScenarioError

from .conftest import (
    Make,
    at_time,
    condition,
    event,
    group,
    lane_change,
    lane_position,
    log,
    relative_speed,
    run,
    speed,
    state_of,
    story,
    teleport,
)

HERE = [teleport(lane_position(100.0)), speed(10.0)]
LATER = group(condition(at_time(1.0)))


def follow(vertices: str, timing: str = "<None/>") -> str:
    return (
        "<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef>"
        f'<Trajectory name="t" closed="false"><Shape><Polyline>{vertices}</Polyline></Shape></Trajectory>'
        f"</TrajectoryRef><TimeReference>{timing}</TimeReference>"
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )


def vertex(x: float, y: float, time: float | None = None) -> str:
    stamp = "" if time is None else f' time="{time}"'
    return f'<Vertex{stamp}><Position><WorldPosition x="{x}" y="{y}"/></Position></Vertex>'


def test_teleport_puts_the_reference_point_in_the_lane(make: Make) -> None:
    board = make(A=[teleport(lane_position(100.0, -2, 0.5))])
    board.start()
    a = board.entities["A"]
    assert (a.x, a.y, a.h) == (pytest.approx(100.0), pytest.approx(-5.25 + 0.5), pytest.approx(0.0))


def test_a_left_lane_heads_against_the_reference_line(make: Make) -> None:
    board = make(A=[teleport(lane_position(100.0, 1)), speed(10.0)])
    run(board, 1.0)
    a = board.entities["A"]
    assert a.x == pytest.approx(90.0)
    assert abs(a.h) == pytest.approx(math.pi)
    assert a.vx == pytest.approx(-10.0)


def test_relative_orientation_is_relative_to_the_driving_direction(make: Make) -> None:
    board = make(A=[teleport(lane_position(100.0, 1, inner='<Orientation type="relative" h="0.5"/>'))])
    board.start()
    assert board.entities["A"].h == pytest.approx(0.5 - math.pi)


@pytest.mark.parametrize(
    ("position", "x", "y"),
    [
        ('<RelativeLanePosition entityRef="B" dLane="1" ds="20"/>', 220.0, -1.75),
        ('<RelativeLanePosition entityRef="B" dLane="2" ds="20"/>', 220.0, 1.75),
        ('<RelativeRoadPosition entityRef="B" ds="-5" dt="1"/>', 195.0, -4.25),
        ('<RelativeObjectPosition entityRef="B" dx="3" dy="2"/>', 203.0, -3.25),
        ('<RelativeWorldPosition entityRef="B" dx="3" dy="-2"/>', 203.0, -7.25),
        ('<RoadPosition roadId="1" s="50" t="-2"/>', 50.0, -2.0),
        ('<WorldPosition x="7" y="8" h="0.3"/>', 7.0, 8.0),
    ],
)
def test_positions(make: Make, position: str, x: float, y: float) -> None:
    board = make(B=[teleport(lane_position(200.0, -2))], A=[teleport(position)])
    board.start()
    assert (board.entities["A"].x, board.entities["A"].y) == (pytest.approx(x), pytest.approx(y))


def test_a_constant_acceleration_covers_the_way_of_the_textbook(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", speed(30.0, "linear", "rate", 4.0), start=LATER)))
    run(board, 6.0)
    # 1 s at 10 m/s, then 5 s at 4 m/s^2; a speed counts from the start of the beat of 10 ms that reaches it
    assert board.entities["A"].x == pytest.approx(100.0 + 10.0 + 10.0 * 5.0 + 0.5 * 4.0 * 25.0 + 0.5 * 0.01 * 20.0)
    assert board.entities["A"].speed == pytest.approx(30.0)


def test_the_way_does_not_depend_on_the_step(make: Make) -> None:
    ways = []
    for dt in (0.01, 0.05):
        board = make(A=HERE, stories=story(event("e", speed(30.0, "linear", "rate", 4.0), start=LATER)))
        run(board, 6.0, dt)
        ways.append(board.entities["A"].x)
    assert ways[0] == pytest.approx(ways[1], abs=1e-6)


def test_a_vehicle_accelerates_no_faster_than_it_can(make: Make) -> None:
    board = make(A=HERE, acceleration=2.0, stories=story(event("e", speed(30.0, "linear", "rate", 50.0))))
    run(board, 3.0)
    assert board.entities["A"].speed == pytest.approx(16.0)


def test_speed_over_a_distance_takes_that_distance(make: Make) -> None:
    board = make(A=[teleport(lane_position(100.0))], stories=story(event("e", speed(20.0, "cubic", "distance", 50.0))))
    run(board, 5.0)
    assert board.entities["A"].x == pytest.approx(150.0 + 0.5 * 0.01 * 20.0, abs=0.01)
    assert board.entities["A"].speed == pytest.approx(20.0)


def test_a_continuous_relative_speed_follows_the_other(make: Make) -> None:
    target = '<RelativeTargetSpeed entityRef="B" value="5" speedTargetValueType="delta" continuous="true"/>'
    other = event("other", speed(20.0, "linear", "time", 1.0), start=LATER)
    board = make(
        A=HERE,
        B=[teleport(lane_position(300.0)), speed(10.0)],
        stories=story(event("e", relative_speed(target))) + story(other, actor="B").replace('"act"', '"act2"'),
    )
    run(board, 3.0)
    assert board.entities["A"].speed == pytest.approx(25.0, abs=0.2)


def test_a_lane_change_follows_its_shape_and_ends_in_the_lane(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", lane_change('<AbsoluteTargetLane value="-2"/>', value=4.0))))
    run(board, 1.0)
    a = board.entities["A"]
    assert a.y == pytest.approx(-1.75 - 3.5 * (1.0 - math.cos(math.pi / 4.0)) / 2.0)
    rate = -3.5 * math.pi / 8.0 * math.sin(math.pi / 4.0)
    assert a.h == pytest.approx(math.atan(rate / 10.0), abs=0.01)
    run(board, 3.1)
    assert (a.y, a.h, a.lane) == (pytest.approx(-5.25), pytest.approx(0.0), -2)


def test_the_way_of_a_lane_change_is_the_oblique_one(make: Make) -> None:
    board = make(
        A=HERE, stories=story(event("e", lane_change('<AbsoluteTargetLane value="-2"/>', "linear", value=5.0)))
    )
    run(board, 4.0)
    # 0.7 m/s sideways at 10 m/s
    assert board.entities["A"].x == pytest.approx(100.0 + 40.0 * math.cos(math.atan(0.07)), abs=1e-3)


def test_a_relative_lane_is_counted_to_the_left_of_the_other(make: Make) -> None:
    change = lane_change('<RelativeTargetLane entityRef="A" value="1"/>', value=1.0)
    board = make(A=[teleport(lane_position(100.0, 2)), speed(10.0)], stories=story(event("e", change)))
    run(board, 1.5)
    assert board.entities["A"].lane == 1


def test_a_trajectory_without_timing_is_followed_at_the_entity_s_speed(make: Make) -> None:
    path = vertex(100.0, 0.0) + vertex(130.0, 40.0)
    board = make(A=[teleport('<WorldPosition x="100" y="0"/>'), speed(5.0)], stories=story(event("e", follow(path))))
    run(board, 4.0)
    a = board.entities["A"]
    assert (a.x, a.y) == (pytest.approx(112.0), pytest.approx(16.0))
    assert a.h == pytest.approx(math.atan2(4, 3))


def test_a_trajectory_with_timing_gives_the_speed(make: Make) -> None:
    path = vertex(100.0, -5.0, 0.0) + vertex(100.0, 5.0, 5.0)
    timing = '<Timing domainAbsoluteRelative="relative" scale="1" offset="0"/>'
    board = make(A=HERE, stories=story(event("e", follow(path, timing), start=LATER)))
    run(board, 3.0)
    a = board.entities["A"]
    assert (a.x, a.y) == (pytest.approx(100.0), pytest.approx(-1.0))
    assert a.speed == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("domain", "after_start", "after_two", "over"),
    [
        ("relative", 104.0, 108.0, 4.0),  # 4 m of 10 m in 5 s left out: the rest takes 3 s from the start at 1 s
        ("absolute", 104.0, 106.0, 5.0),  # at 1 s the file would have it at 102 m: it waits for its time
    ],
)
def test_an_initial_distance_offset_cuts_a_trajectory_with_timing(
    make: Make, domain: str, after_start: float, after_two: float, over: float
) -> None:
    path = vertex(100.0, 0.0, 0.0) + vertex(110.0, 0.0, 5.0)
    timing = f'<Timing domainAbsoluteRelative="{domain}" scale="1" offset="0"/>'
    cut = follow(path, timing).replace("<FollowTrajectoryAction", '<FollowTrajectoryAction initialDistanceOffset="4"')
    board = make(A=HERE, stories=story(event("e", cut, start=LATER)))
    run(board, 1.01)
    assert board.entities["A"].x == pytest.approx(after_start, abs=0.03)
    run(board, 1.99)
    assert board.entities["A"].x == pytest.approx(after_two, abs=0.03)
    run(board, 3.0)
    assert log(board, "event")[-1] == (over, "e", "endTransition")


def test_headings_that_look_back_make_a_timed_trajectory_reverse_for_as_long_as_they_do(make: Make) -> None:
    """Headed west all the way: 10 m to the east in 2 s are driven in reverse, then 4 m to the west in 1 s forward."""
    stamps = ((0.0, 100.0), (2.0, 110.0), (3.0, 106.0))
    path = "".join(vertex(x, 0.0, time).replace("/></Pos", ' h="3.141592653589793"/></Pos') for time, x in stamps)
    timing = '<Timing domainAbsoluteRelative="relative" scale="1" offset="0"/>'
    board = make(A=HERE, stories=story(event("e", follow(path, timing), start=LATER)))
    a = board.entities["A"]
    run(board, 2.0)
    assert (a.x, a.speed) == (pytest.approx(105.0, abs=0.06), pytest.approx(-5.0))
    run(board, 1.5)
    assert (a.x, a.speed) == (pytest.approx(108.0, abs=0.05), pytest.approx(4.0))
    assert math.cos(a.h) == pytest.approx(-1.0)


@pytest.mark.parametrize("scale", ["0", "-1"])
def test_time_cannot_be_scaled_by_nothing(make: Make, scale: str) -> None:
    timing = f'<Timing domainAbsoluteRelative="relative" scale="{scale}" offset="0"/>'
    path = vertex(100.0, 0.0, 0.0) + vertex(110.0, 0.0, 5.0)
    with pytest.raises(ScenarioError, match="Timing@scale"):
        make(A=HERE, stories=story(event("e", follow(path, timing))))


def test_synchronize_arrives_with_the_master(make: Make) -> None:
    action = (
        '<PrivateAction><SynchronizeAction masterEntityRef="B">'
        f"<TargetPositionMaster>{lane_position(400.0)}</TargetPositionMaster>"
        f"<TargetPosition>{lane_position(250.0, -2)}</TargetPosition>"
        '<FinalSpeed><AbsoluteSpeed value="8"/></FinalSpeed></SynchronizeAction></PrivateAction>'
    )
    board = make(
        A=[teleport(lane_position(100.0, -2)), speed(10.0)],
        B=[teleport(lane_position(200.0)), speed(20.0)],
        stories=story(event("e", action)),
    )
    run(board, 10.0)
    assert board.entities["B"].x == pytest.approx(400.0, abs=1e-6)
    assert board.entities["A"].x == pytest.approx(250.0, abs=0.3)
    assert board.entities["A"].speed == pytest.approx(8.0, abs=0.1)


def test_an_entity_stops_at_the_end_of_the_road(make: Make) -> None:
    board = make(A=[teleport(lane_position(990.0)), speed(10.0)])
    run(board, 2.0)
    assert board.entities["A"].x == pytest.approx(1000.0)
    assert board.entities["A"].end_of_road


def test_variables_are_set_and_calculated(make: Make) -> None:
    add = (
        '<GlobalAction><VariableAction variableRef="v"><ModifyAction><Rule><AddValue value="2.5"/></Rule>'
        "</ModifyAction></VariableAction></GlobalAction>"
    )
    board = make(A=HERE, stories=story(event("e", add)))
    run(board, 0.1)
    assert board.variables.get("v") == 3.5


def test_a_distance_without_limits_is_kept_from_the_start(make: Make) -> None:
    action = (
        '<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="B" distance="20" continuous="true" '
        'freespace="true"/></LongitudinalAction></PrivateAction>'
    )
    board = make(A=HERE, B=[teleport(lane_position(200.0)), speed(10.0)], stories=story(event("e", action)))
    run(board, 2.0)
    # A's front is 4 m ahead of its reference point, B's rear 1 m behind its own
    assert board.entities["B"].x - board.entities["A"].x == pytest.approx(25.0, abs=0.11)
    assert board.entities["A"].speed == 10.0


def test_a_speed_profile_goes_through_its_entries(make: Make) -> None:
    entries = '<SpeedProfileEntry time="1" speed="20"/><SpeedProfileEntry time="2" speed="4"/>'
    action = (
        f'<PrivateAction><LongitudinalAction><SpeedProfileAction followingMode="position">{entries}'
        "</SpeedProfileAction></LongitudinalAction></PrivateAction>"
    )
    board = make(A=HERE, stories=story(event("e", action)))
    run(board, 1.0)
    assert board.entities["A"].speed == pytest.approx(20.0)
    run(board, 1.0)
    assert board.entities["A"].speed == pytest.approx(12.0)
    run(board, 1.5)
    assert board.entities["A"].speed == pytest.approx(4.0)


def test_a_vehicle_goes_no_faster_than_it_can(make: Make) -> None:
    """Its performance says 70 m/s."""
    board = make(A=[teleport(lane_position(100.0)), speed(80.0, "linear", "rate", 10.0)])
    run(board, 8.0)
    assert board.entities["A"].speed == pytest.approx(70.0)
    assert board.entities["A"].longitudinal is None


def test_a_relative_orientation_on_a_road_is_one_to_its_reference_line(make: Make) -> None:
    """Class RelativeRoadPosition (1.3): `with respect to the (s,t)-coordinate system of the target road`."""
    inner = '<Orientation type="relative" h="0.5"/>'
    position = f'<RelativeRoadPosition entityRef="B" ds="-5" dt="0">{inner}</RelativeRoadPosition>'
    board = make(B=[teleport(lane_position(200.0, 1))], A=[teleport(position)])
    board.start()
    assert abs(board.entities["B"].h) == pytest.approx(math.pi)
    assert board.entities["A"].h == pytest.approx(0.5)


def synchronize(final: float) -> str:
    return (
        '<PrivateAction><SynchronizeAction masterEntityRef="B">'
        f"<TargetPositionMaster>{lane_position(900.0)}</TargetPositionMaster>"
        f"<TargetPosition>{lane_position(250.0, -2)}</TargetPosition>"
        f'<FinalSpeed><AbsoluteSpeed value="{final}"/></FinalSpeed></SynchronizeAction></PrivateAction>'
    )


def test_who_would_wait_beyond_half_of_the_way_brakes_hard(make: Make) -> None:
    """A is faster than its final speed and the master far away: it stops with 8 m/s^2, here from 20 m/s in 25 m."""
    board = make(
        A=[teleport(lane_position(100.0, -2)), speed(20.0)],
        B=[teleport(lane_position(200.0)), speed(10.0)],
        stories=story(event("e", synchronize(10.0), start=LATER)),
    )
    run(board, 4.0)
    assert board.entities["A"].speed == 0.0
    assert board.entities["A"].x == pytest.approx(120.0 + 20.0**2 / (2.0 * 8.0), abs=0.3)
    run(board, 66.0)  # B needs 70 s to its target
    assert board.entities["A"].x == pytest.approx(250.0, abs=0.5)


def test_who_would_wait_before_half_of_the_way_brakes_evenly(make: Make) -> None:
    """Braking with (v0^2 + v1^2) / (2 s), from 10 m/s with 20 m/s at the end of the remaining 140 m."""
    board = make(
        A=[teleport(lane_position(100.0, -2)), speed(10.0)],
        B=[teleport(lane_position(200.0)), speed(10.0)],
        stories=story(event("e", synchronize(20.0), start=LATER)),
    )
    run(board, 2.0)
    assert board.entities["A"].speed == pytest.approx(10.0 - (10.0**2 + 20.0**2) / (2.0 * 140.0), abs=0.03)


def lane_offset(target: str, continuous: bool = False) -> str:
    return (
        f'<PrivateAction><LateralAction><LaneOffsetAction continuous="{str(continuous).lower()}">'
        '<LaneOffsetActionDynamics dynamicsShape="sinusoidal" maxLateralAcc="2"/>'
        f"<LaneOffsetTarget>{target}</LaneOffsetTarget></LaneOffsetAction></LateralAction></PrivateAction>"
    )


def test_a_lane_offset_is_over_with_the_step_that_begins_at_its_target(make: Make) -> None:
    """Half a metre with 2 m/s^2 at most takes pi sqrt(0.5 / 4) = 1.111 s; what waits for it starts in that step."""
    after = group(condition(state_of("event", "e", "endTransition")))
    events = event("e", lane_offset('<AbsoluteTargetLaneOffset value="0.5"/>')), event("next", speed(5.0), start=after)
    board = make(A=HERE, stories=story(*events))
    run(board, 2.0)
    assert (1.12, "e", "endTransition") in log(board, "event")
    assert (1.12, "next", "startTransition") in log(board, "event")
    assert board.entities["A"].y == pytest.approx(-1.75 + 0.5)


def test_a_continuous_lane_offset_follows_the_other(make: Make) -> None:
    other = '<RelativeTargetLaneOffset entityRef="B" value="1"/>'
    change = lane_change('<AbsoluteTargetLane value="-2"/>', "linear", "time", 2.0)
    board = make(
        A=HERE,
        B=[teleport(lane_position(150.0)), speed(10.0)],
        stories=story(event("e", lane_offset(other, continuous=True)))
        + story(event("b", change, start=group(condition(at_time(3.0)))), actor="B", name="second"),
    )
    run(board, 2.5)
    assert board.entities["A"].y == pytest.approx(-1.75 + 1.0)
    run(board, 8.0)  # B moves over and stops at once; A needs its lateral acceleration for that
    assert board.entities["B"].y == pytest.approx(-5.25)
    assert board.entities["A"].y == pytest.approx(-5.25 + 1.0)


@pytest.mark.parametrize("first", ["trajectory", "speed"])
def test_of_two_actions_of_an_event_the_one_that_stands_first_in_the_file_acts_first(make: Make, first: str) -> None:
    """From 10 to 20 m/s in 1 s: 11 m/s after 0.1 s, on a way of 1.05 m; and 1 m/s times half a beat of 10 ms more
    if the speed changes first, so much less if the car is moved first."""
    actions = {
        "trajectory": follow(vertex(100, -1.75) + vertex(300, -1.75)),
        "speed": speed(20.0, "linear", "time", 1.0),
    }
    second = next(name for name in actions if name != first)
    board = make(A=HERE, stories=story(event("e", actions[first], actions[second])))
    run(board, 0.1, 0.1)
    a = board.entities["A"]
    assert a.speed == pytest.approx(11.0)
    assert a.x == pytest.approx(101.05 + (0.005 if first == "speed" else -0.005), abs=1e-6)
