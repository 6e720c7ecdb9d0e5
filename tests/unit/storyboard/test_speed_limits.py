"""Limits along the way: what an action and a vehicle allow, and targets that move. Expected values are closed forms."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.reading import Reading
from tests.unit.storyboard.conftest import (
    Make,
    at_time,
    condition,
    event,
    group,
    lane_position,
    log,
    relative_speed,
    run,
    speed,
    story,
    teleport,
)

LATER = group(condition(at_time(1.0)))


def at(s: float, start: float) -> list[str]:
    return [teleport(lane_position(s)), speed(start)]


def profile(*entries: tuple[float | None, float], mode: str = "position", limits: str = "", other: str = "") -> str:
    inner = "".join(
        f'<SpeedProfileEntry speed="{v}"/>' if t is None else f'<SpeedProfileEntry time="{t}" speed="{v}"/>'
        for t, v in entries
    )
    constraints = f"<DynamicConstraints {limits}/>" if limits else ""
    reference = f' entityRef="{other}"' if other else ""
    return (
        f'<PrivateAction><LongitudinalAction><SpeedProfileAction followingMode="{mode}"{reference}>'
        f"{constraints}{inner}</SpeedProfileAction></LongitudinalAction></PrivateAction>"
    )


def relative(value: float, kind: str = "delta", other: str = "B", continuous: bool = False) -> str:
    return (
        f'<RelativeTargetSpeed entityRef="{other}" value="{value}" speedTargetValueType="{kind}" '
        f'continuous="{str(continuous).lower()}"/>'
    )


def speeds(board: Storyboard, seconds: float, name: str = "A", dt: float = 0.01) -> list[float]:
    if not board.running:
        board.start()
    out = [board.entities[name].speed]
    for _ in range(round(seconds / dt)):
        board.step(dt)
        out.append(board.entities[name].speed)
    return out


def end_of(board: Storyboard, name: str) -> float:
    """When the action of that name ended by itself [s]."""
    (time,) = [each[0] for each in log(board, "action") if each[1:] == (name, "endTransition")]
    return time


def doubts(board: Storyboard) -> str:
    return "\n".join(finding.text for finding in board.report())


# --- SpeedProfileAction: class SpeedProfileAction (1.3), dynamicConstraints: `limitations to the action in terms of
# acceleration, deceleration, speed and/or jerk`


@pytest.mark.parametrize("mode", ["position", "follow"])
@pytest.mark.parametrize("time", [4.0, None])
def test_a_profile_keeps_to_its_highest_speed(make: Make, mode: str, time: float | None) -> None:
    limits = 'maxSpeed="5" maxAcceleration="2" maxDeceleration="3" maxAccelerationRate="4" maxDecelerationRate="4"'
    board = make(A=at(100.0, 0.0), stories=story(event("e", profile((time, 10.0), mode=mode, limits=limits))))
    trace = speeds(board, 8.0)
    assert max(trace) == pytest.approx(5.0) == trace[-1]
    assert "10 m/s is beyond the limit of 5 m/s" in doubts(board)


@pytest.mark.parametrize("mode", ["position", "follow"])
def test_a_profile_keeps_to_its_accelerations_and_puts_off_what_follows(make: Make, mode: str) -> None:
    """At 2 m/s^2 from 0 to 10 m/s takes 5 s instead of 1, at 4 m/s^2 down to 2 m/s 2 s instead of 1; then 1 s up."""
    limits = 'maxAcceleration="2" maxDeceleration="4"'
    profiled = profile((1.0, 10.0), (1.0, 2.0), (1.0, 3.0), mode=mode, limits=limits)
    board = make(A=at(100.0, 0.0), stories=story(event("e", profiled)))
    trace = speeds(board, 9.0)
    for time, wanted in ((2.5, 5.0), (5.0, 10.0), (6.0, 6.0), (7.0, 2.0), (7.5, 2.5), (8.0, 3.0), (9.0, 3.0)):
        assert trace[round(time * 100)] == pytest.approx(wanted, abs=0.05)
    assert (8.0, "e", "endTransition") in log(board, "event")
    assert "5.00 s later than its times say" in doubts(board)


def test_a_rounded_profile_keeps_to_its_jerk_where_the_times_are_too_short(make: Make) -> None:
    """4 m/s^3 up to 2 m/s^2 and back: 0.5 s each, (10 - 2 x 0.5) / 2 = 4.5 s between them."""
    limits = 'maxAcceleration="2" maxDeceleration="2" maxAccelerationRate="4" maxDecelerationRate="4"'
    board = make(A=at(100.0, 0.0), stories=story(event("e", profile((1.0, 10.0), mode="follow", limits=limits))))
    trace = speeds(board, 6.0)
    slopes = [(b - a) / 0.01 for a, b in pairwise(trace)]
    assert max(slopes) == pytest.approx(2.0)
    assert max(abs(b - a) for a, b in pairwise(slopes)) <= 4.0 * 0.01 + 1e-9
    assert trace[50] == pytest.approx(0.5)
    assert trace[500] == pytest.approx(9.5)
    assert (5.5, "e", "endTransition") in log(board, "event")


def test_corners_that_are_too_near_for_the_jerk_are_taken_one_by_one(make: Make) -> None:
    limits = 'maxAcceleration="9" maxDeceleration="9" maxAccelerationRate="2" maxDecelerationRate="2"'
    entries = ((0.3, 12.0), (0.3, 10.0), (0.3, 13.0))
    board = make(A=at(100.0, 10.0), stories=story(event("e", profile(*entries, mode="follow", limits=limits))))
    trace = speeds(board, 9.0)
    slopes = [(b - a) / 0.01 for a, b in pairwise(trace)]
    assert max(abs(b - a) for a, b in pairwise(slopes)) <= 2.0 * 0.01 + 1e-9
    assert trace[200] == pytest.approx(12.0)  # 2 m/s with 2 m/s^3 and back: 2 sqrt(2 / 2) = 2 s
    assert trace[400] == pytest.approx(10.0)
    assert trace[-1] == pytest.approx(13.0)


def test_a_vehicle_in_a_profile_does_no_more_than_its_performance_says(make: Make) -> None:
    """4 m/s^2: from 0 to 20 m/s in 5 s, not 1; without constraints, and beyond what they allow."""
    for limits in ("", 'maxSpeed="60"', 'maxAcceleration="9"'):
        profiled = profile((1.0, 20.0), limits=limits)
        board = make(A=at(100.0, 0.0), acceleration=4.0, stories=story(event("e", profiled)))
        trace = speeds(board, 6.0)
        assert trace[250] == pytest.approx(10.0)
        assert trace[490] < 20.0 == pytest.approx(trace[501])


@pytest.mark.parametrize(("reading", "first"), [("esmini", 4.0), ("standard", 8.0)])
def test_whether_constraints_have_precedence_over_the_performance(make: Make, reading: Reading, first: float) -> None:
    """Class SpeedProfileAction (1.3): `These settings has precedence over any Performance settings`. The performance
    here is 4 m/s^2, the constraint 8."""
    profiled = profile((None, 20.0), limits='maxAcceleration="8"')
    stories = story(event("e", profiled))
    board = make(A=at(100.0, 0.0), acceleration=4.0, stories=stories, reading=reading)
    assert speeds(board, 1.0)[-1] == pytest.approx(first)
    assert ("--reading standard" in doubts(board)) is (reading == "esmini")


def test_the_speeds_of_a_profile_may_be_relative(make: Make) -> None:
    """`interpreted as relative delta to the speed of the referenced entity`: 12 + 3, at 2 m/s^2 from 10 m/s."""
    board = make(
        A=at(100.0, 10.0),
        B=at(200.0, 12.0),
        stories=story(event("e", profile((1.0, 3.0), (1.0, -1.0), limits='maxAcceleration="2"', other="B"))),
    )
    trace = speeds(board, 4.0)
    assert trace[100] == pytest.approx(12.0)
    assert trace[250] == pytest.approx(15.0)
    assert trace[350] == pytest.approx(11.0)


def test_a_profile_that_may_not_accelerate_never_ends(make: Make) -> None:
    board = make(A=at(100.0, 7.0), stories=story(event("e", profile((1.0, 9.0), limits='maxAcceleration="0"'))))
    assert set(speeds(board, 3.0)) == {7.0}
    assert "reached never" in doubts(board)


def test_a_distance_with_a_limit_of_speed_alone_is_not_jumped_to(make: Make) -> None:
    action = (
        '<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="B" distance="20" continuous="true" '
        'freespace="false"><DynamicConstraints maxSpeed="15"/></LongitudinalDistanceAction></LongitudinalAction>'
        "</PrivateAction>"
    )
    board = make(A=at(100.0, 10.0), B=at(200.0, 12.0), stories=story(event("e", action)))
    trace = speeds(board, 20.0)
    assert max(trace) == pytest.approx(15.0)
    assert max(abs(b - a) for a, b in pairwise(trace)) <= 0.1 + 1e-9  # the vehicle's 10 m/s^2
    assert board.entities["A"].x > 300.0


# --- targets that move


def follow(make: Make, dimension: str, value: float, shape: str = "linear", continuous: bool = False) -> Storyboard:
    """B drives 10 m/s and from the start on 2 m/s^2 faster, up to 20; A, from 5 m/s, wants B's speed."""
    action = relative_speed(relative(0.0, continuous=continuous), shape, dimension, value)
    return make(
        A=at(100.0, 5.0),
        B=at(200.0, 10.0),
        stories=story(event("b", speed(20.0, "linear", "rate", 2.0)), actor="B", name="one")
        + story(event("a", action), name="other"),
    )


@pytest.mark.parametrize("shape", ["linear", "cubic", "sinusoidal"])
def test_over_time_a_moving_target_is_met_where_it_is_then(make: Make, shape: str) -> None:
    board = follow(make, "time", 4.0, shape)
    assert speeds(board, 5.0)[-1] == pytest.approx(18.0)  # 10 + 2 x 4
    assert end_of(board, "a-0") == 4.0


def test_at_a_rate_a_moving_target_is_met_where_the_lines_meet(make: Make) -> None:
    """5 + 4 t = 10 + 2 t at 2.5 s, at 15 m/s."""
    board = follow(make, "rate", 4.0)
    trace = speeds(board, 4.0)
    assert trace[100] == pytest.approx(9.0)
    assert trace[-1] == pytest.approx(15.0, abs=0.05)
    assert end_of(board, "a-0") == pytest.approx(2.5, abs=0.02)


@pytest.mark.parametrize("shape", ["cubic", "sinusoidal"])
def test_a_peak_rate_holds_for_a_moving_target(make: Make, shape: str) -> None:
    board = follow(make, "rate", 4.0, shape)
    trace = speeds(board, 8.0)
    assert max(b - a for a, b in pairwise(trace)) <= 0.04 + 1e-9
    assert trace[-1] == pytest.approx(min(10.0 + 2.0 * end_of(board, "a-0"), 20.0), abs=0.05)


@pytest.mark.parametrize("shape", ["linear", "cubic", "sinusoidal"])
def test_over_a_distance_a_moving_target_is_met_at_its_end(make: Make, shape: str) -> None:
    board = follow(make, "distance", 40.0, shape)
    run(board, 8.0)
    ended = end_of(board, "a-0")
    assert board.entities["A"].speed == pytest.approx(min(10.0 + 2.0 * ended, 20.0), abs=0.1)
    since = 8.0 - ended
    assert board.entities["A"].x - 100.0 - since * board.entities["A"].speed == pytest.approx(40.0, abs=0.5)


def test_a_target_that_runs_away_is_followed_until_it_is_reached(make: Make) -> None:
    """At 1 m/s^2 from 5 m/s: 20 m/s only at 15 s."""
    board = follow(make, "rate", 1.0)
    trace = speeds(board, 16.0)
    assert trace[800] == pytest.approx(13.0)
    assert end_of(board, "a-0") == pytest.approx(15.0, abs=0.02)


def test_a_target_relative_to_oneself_is_that_of_the_start(make: Make) -> None:
    action = relative_speed(relative(4.0, other="A"), "linear", "time", 2.0)
    board = make(A=at(100.0, 5.0), stories=story(event("a", action)))
    assert speeds(board, 3.0)[-1] == pytest.approx(9.0)
    assert log(board, "action")[-1] == (2.0, "a-0", "endTransition")


@pytest.mark.parametrize("kind", ["factor", "delta"])
@pytest.mark.parametrize("shape", ["step", "linear"])
def test_two_cars_that_want_to_be_faster_than_each_other_accelerate_as_they_can(
    make: Make, kind: str, shape: str
) -> None:
    """3 m/s^2 at most, beside the one step that a step is, and 70 m/s."""
    value = 1.2 if kind == "factor" else 0.5
    board = make(
        A=at(100.0, 2.8),
        B=at(200.0, 2.8),
        acceleration=3.0,
        stories=story(
            event("a", relative_speed(relative(value, kind, "B", True), shape, "rate", 9.0), start=LATER), name="one"
        )
        + story(
            event("b", relative_speed(relative(value, kind, "A", True), shape, "rate", 9.0), start=LATER),
            actor="B",
            name="other",
        ),
    )
    trace = speeds(board, 40.0)
    rises = sorted((b - a for a, b in pairwise(trace)), reverse=True)
    assert rises[0] <= max(value, 1.0) + 3.0 * 0.01
    assert rises[1] <= 3.0 * 0.01 + 1e-9
    assert trace[-1] <= 70.0


def test_a_follower_brakes_no_harder_than_it_can(make: Make) -> None:
    """B stands at once; A, of 10 m/s^2, needs 2 s from 20 m/s."""
    board = make(
        A=at(100.0, 0.0),
        B=at(200.0, 20.0),
        stories=story(event("a", relative_speed(relative(0.0, continuous=True))), name="one")
        + story(event("b", speed(0.0), start=LATER), actor="B", name="other"),
    )
    trace = speeds(board, 4.0)
    assert trace[50] == 20.0
    assert trace[200] == pytest.approx(10.0, abs=0.11)
    assert trace[310] == 0.0


def test_speeds_without_a_performance_stay_finite(make: Make) -> None:
    """Two cars whose performance has no bound to speak of."""
    both = [relative_speed(relative(3.0, "factor", other, True)) for other in ("B", "A")]
    board = make(
        A=at(100.0, 5.0),
        B=at(200.0, 5.0),
        acceleration=1e12,
        stories=story(event("a", both[0]), name="one") + story(event("b", both[1]), actor="B", name="other"),
    )
    assert all(math.isfinite(each) and each <= 70.0 for each in speeds(board, 2.0))


def test_cars_that_want_to_be_behind_each_other_are_not_thrown_away(make: Make) -> None:
    """Without limits each is put behind the other one: no faster than it drives, 70 m/s, once it is there."""
    gap = (
        '<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="{}" distance="10" continuous="true" '
        'freespace="false"/></LongitudinalAction></PrivateAction>'
    )
    board = make(
        A=at(800.0, 5.0),
        B=at(820.0, 5.0),
        stories=story(event("a", gap.format("B")), name="one")
        + story(event("b", gap.format("A")), actor="B", name="other"),
    )
    run(board, 0.05)
    before = board.entities["A"].x
    run(board, 1.0)
    assert abs(board.entities["A"].x - before) <= 75.0


def test_who_synchronizes_goes_no_faster_than_it_can_and_says_what_it_cannot(make: Make) -> None:
    """The vehicle's 70 m/s, where the final speed asks for 90; from standstill in little time it is no vehicle's."""
    action = (
        '<PrivateAction><SynchronizeAction masterEntityRef="B">'
        f"<TargetPositionMaster>{lane_position(300.0)}</TargetPositionMaster>"
        f"<TargetPosition>{lane_position(700.0)}</TargetPosition>"
        '<FinalSpeed><AbsoluteSpeed value="90"/></FinalSpeed></SynchronizeAction></PrivateAction>'
    )
    board = make(A=at(100.0, 10.0), B=at(200.0, 20.0), stories=story(event("a", action, start=LATER)))
    trace = speeds(board, 8.0)
    assert max(trace) == pytest.approx(70.0)
    assert "beyond its Performance" in doubts(board)


def beside(other: str, value: float, limit: str) -> str:
    return (
        '<PrivateAction><LateralAction><LaneOffsetAction continuous="true"><LaneOffsetActionDynamics '
        f'dynamicsShape="sinusoidal" {limit}/><LaneOffsetTarget><RelativeTargetLaneOffset entityRef="{other}" '
        f'value="{value}"/></LaneOffsetTarget></LaneOffsetAction></LateralAction></PrivateAction>'
    )


def sideways(board: Storyboard, name: str, seconds: float) -> list[float]:
    board.start()
    out = [board.entities[name].y]
    for _ in range(round(seconds * 100)):
        board.step(0.01)
        out.append(board.entities[name].y)
    return out


def test_two_cars_that_want_to_be_left_of_each_other_keep_their_lateral_acceleration(make: Make) -> None:
    """Each wants to be 1 m left of the other, at 0.5 m/s^2: after 8 s none moves over faster than 4 m/s."""
    board = make(
        A=at(100.0, 10.0),
        B=at(130.0, 10.0),
        stories=story(event("a", beside("B", 1.0, 'maxLateralAcc="0.5"')), name="one")
        + story(event("b", beside("A", 1.0, 'maxLateralAcc="0.5"')), actor="B", name="other"),
    )
    trace = sideways(board, "A", 8.0)
    rates = [(b - a) / 0.01 for a, b in pairwise(trace)]
    assert max(abs(b - a) for a, b in pairwise(rates)) <= 0.5 * 0.01 + 1e-6
    assert max(map(abs, rates)) <= 4.0


def test_who_is_beside_another_stays_there_within_its_lateral_acceleration(make: Make) -> None:
    """B changes its offset by 1 m in pi sqrt(1 / (2 x 0.2)) = 5.0 s, at 0.2 m/s^2; A may do 0.5 and stays with it."""
    move = (
        '<PrivateAction><LateralAction><LaneOffsetAction continuous="false"><LaneOffsetActionDynamics '
        'dynamicsShape="sinusoidal" maxLateralAcc="0.2"/><LaneOffsetTarget><AbsoluteTargetLaneOffset value="1"/>'
        "</LaneOffsetTarget></LaneOffsetAction></LateralAction></PrivateAction>"
    )
    board = make(
        A=at(100.0, 10.0),
        B=at(130.0, 10.0),
        stories=story(event("a", beside("B", 0.0, 'maxLateralAcc="0.5"')), name="one")
        + story(event("b", move, start=LATER), actor="B", name="other"),
    )
    trace = sideways(board, "A", 8.0)
    assert trace[350] == pytest.approx(-1.75 + 0.5, abs=0.05)
    assert trace[-1] == pytest.approx(-0.75, abs=0.01)
