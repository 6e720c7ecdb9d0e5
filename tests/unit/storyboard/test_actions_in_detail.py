"""Actions step by step: what their warnings say, which way they choose, how far they go in a step."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from openscenario.storyboard.actions import keep_distance, lateral, speed_profile
from openscenario.storyboard.plausibility import Plausibility

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
    story,
    teleport,
)

assert (keep_distance.REACHED, lateral.NEAR, speed_profile.LATE) == (0.1, 1e-6, 1e-3)  # as the docstrings say


def at(s: float, v: float) -> list[str]:
    return [teleport(lane_position(s)), speed(v)]


def profile(*entries: tuple[float, float], mode: str = "position", limits: str = "") -> str:
    inner = "".join(f'<SpeedProfileEntry time="{t}" speed="{v}"/>' for t, v in entries)
    constraints = f"<DynamicConstraints {limits}/>" if limits else ""
    return (
        f'<PrivateAction><LongitudinalAction><SpeedProfileAction followingMode="{mode}">{constraints}{inner}'
        "</SpeedProfileAction></LongitudinalAction></PrivateAction>"
    )


JERK = 'maxAcceleration="5" maxDeceleration="5" maxAccelerationRate="4" maxDecelerationRate="4"'


@pytest.mark.parametrize(
    ("entries", "mode", "limits", "late"),
    [
        (((1.0, 20.0),), "position", "", "1.00"),  # 10 m/s^2: 2 s for 20 m/s
        (((1.0, 20.0), (1.0, 0.0)), "position", "", "2.00"),
        (((1.0, 10.0),), "follow", JERK, "2.25"),  # 10 / 5 + 5 / 4 s
        (((1.0, 10.0), (9.0, 10.0)), "follow", JERK, "1.62"),  # 10 / 5 - 1 s at the corner, and half of its 5 / 4 s
        (((2.0, 20.0),), "position", "", None),
    ],
)
def test_a_profile_that_comes_late_says_by_how_much(
    make: Make, entries: tuple[tuple[float, float], ...], mode: str, limits: str, late: str | None
) -> None:
    board = make(A=at(100.0, 0.0), stories=story(event("e", profile(*entries, mode=mode, limits=limits))))
    run(board, 0.1)
    texts = [finding.text for finding in board.report() if "reached" in finding.text]
    if late is None:
        assert texts == []
    elif mode == "follow" and len(entries) > 1:  # what a rounded corner takes behind its point is not late
        assert all("s later than its times say" in text for text in texts)
    else:
        assert texts == [f"A: the limits let the last speed be reached {late} s later than its times say"]


def test_a_profile_that_something_else_drives_lasts_until_its_last_entry(make: Make) -> None:
    """10 m/s^2: 2 s to 20 m/s, then 1 s to 15 m/s; the action of an external entity ends after 3 s."""
    board = make(A=at(100.0, 0.0), external=("A",), stories=story(event("e", profile((1.0, 20.0), (1.0, 15.0)))))
    run(board, 4.0)
    assert [time for time, _, transition in log(board, "action") if transition == "endTransition"] == [
        pytest.approx(3.0, abs=0.02)
    ]


def distance(
    value: float,
    displacement: str,
    *,
    gap: bool = False,
    continuous: bool = True,
    free: bool = False,
    limits: str = "",
    system: str = "road",
) -> str:
    kind = "timeGap" if gap else "distance"
    inner = f"<DynamicConstraints {limits}/>" if limits else ""
    return (
        f'<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="B" {kind}="{value}" '
        f'freespace="{str(free).lower()}" continuous="{str(continuous).lower()}" displacement="{displacement}" '
        f'coordinateSystem="{system}">{inner}</LongitudinalDistanceAction>'
        "</LongitudinalAction></PrivateAction>"
    )


@pytest.mark.parametrize(
    ("displacement", "start", "stays"),
    [("any", 100.0, 130.0), ("any", 200.0, 170.0), ("leadingReferencedEntity", 100.0, 170.0),
     ("trailingReferencedEntity", 200.0, 130.0)],
)  # fmt: skip
def test_a_distance_is_kept_on_the_side_that_is_asked_for_or_where_one_is(
    make: Make, displacement: str, start: float, stays: float
) -> None:
    """B stands at 150 m; A comes to 20 m before or behind it."""
    board = make(A=at(start, 0.0), B=at(150.0, 0.0), stories=story(event("e", distance(20.0, displacement))))
    run(board, 0.1)
    assert board.entities["A"].x == pytest.approx(stays)


@pytest.mark.parametrize("system", ["road", "entity"])
@pytest.mark.parametrize("start", [100.0, 148.0, 151.0, 200.0])
@pytest.mark.parametrize(("displacement", "stays"), [("leadingReferencedEntity", 175.0),
                                                     ("trailingReferencedEntity", 125.0)])  # fmt: skip
def test_a_free_distance_is_that_between_the_ends_that_face_each_other_then(
    make: Make, displacement: str, stays: float, start: float, system: str
) -> None:
    """Boxes of 5 m: B's reference point at 150 m, A's 20 + 5 m before or behind it, wherever it begins."""
    action = distance(20.0, displacement, free=True, continuous=False, system=system)
    board = make(A=at(start, 0.0), B=at(150.0, 0.0), stories=story(event("e", action)))
    run(board, 0.1)
    assert board.entities["A"].x == pytest.approx(stays)


@pytest.mark.parametrize("rate", ["", ' maxDecelerationRate="3" maxAccelerationRate="3"'])
@pytest.mark.parametrize("ahead", [100.0, 200.0])
@pytest.mark.parametrize("free", [True, False])
def test_who_comes_from_far_behind_stops_closing_at_its_place(make: Make, ahead: float, free: bool, rate: str) -> None:
    """B goes on with 10 m/s. A may brake with 3 m/s^2: it keeps 20 m, or 20 + 5 m between reference points."""
    limits = f'maxAcceleration="3" maxDeceleration="3" maxSpeed="30"{rate}'
    action = distance(20.0, "trailingReferencedEntity", free=free, limits=limits)
    board = make(A=at(100.0, 15.0), B=at(100.0 + ahead, 10.0), stories=story(event("e", action)))
    a, b, nearest = board.entities["A"], board.entities["B"], math.inf
    for _ in range(300):
        run(board, 0.1)
        nearest = min(nearest, b.x - a.x)
    place = 25.0 if free else 20.0
    assert nearest > place - 0.01
    assert b.x - a.x == pytest.approx(place, abs=0.01)


def test_who_keeps_a_time_gap_goes_to_its_place_no_faster_than_it_can(make: Make) -> None:
    """2 s behind B, which brakes from 20 to 10 m/s at once: from 40 m to 20 m behind with 70 m/s at most."""
    later = story(event("slow", speed(10.0), start=group(condition(at_time(1.0)))), actor="B", name="other")
    board = make(A=at(100.0, 20.0), B=at(200.0, 20.0),
                 stories=story(event("e", distance(2.0, "trailingReferencedEntity", gap=True))) + later)  # fmt: skip
    run(board, 0.01)
    a, b = board.entities["A"], board.entities["B"]
    gaps, ways = [], []
    for _ in range(250):
        x = a.x
        run(board, 0.01)
        gaps.append(b.x - a.x)
        ways.append(a.x - x)
    assert gaps[50] == pytest.approx(40.0, abs=0.3)
    assert gaps[-1] == pytest.approx(20.0, abs=0.2)
    assert max(ways) == pytest.approx(0.7, abs=0.11)  # 70 m/s x 10 ms, and its own way in the step
    assert a.speed == b.speed == 10.0


@pytest.mark.parametrize("lane", [-1, 1])
@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_a_lane_change_over_a_distance_heads_along_its_line(make: Make, lane: int, dt: float) -> None:
    """3.5 m to the left in 35 m: a slope of 0.1, whichever way the lane runs and whatever steps are taken."""
    to = '<RelativeTargetLane entityRef="A" value="1"/>'
    start = [teleport(lane_position(500.0, -2 if lane < 0 else 2)), speed(10.0)]
    board = make(A=start, stories=story(event("e", lane_change(to, "linear", "distance", 35.0))))
    run(board, 1.0, dt)
    a = board.entities["A"]
    base = 0.0 if lane < 0 else math.pi
    assert math.remainder(a.h - base, math.tau) == pytest.approx(math.atan(0.1), abs=1e-3)
    assert abs(a.x - 500.0) == pytest.approx(10.0 / math.hypot(1.0, 0.1), rel=1e-2)
    run(board, 3.0, dt)
    assert abs(a.y) == pytest.approx(1.75)
    assert math.remainder(a.h - base, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_who_drives_off_the_end_of_a_road_stands_there(make: Make) -> None:
    """The road is 1000 m long; an end without any way for a whole step takes the speed."""
    board = make(A=at(990.0, 10.0))
    run(board, 3.0)
    a = board.entities["A"]
    assert (a.x, a.speed, a.vx) == (pytest.approx(1000.0), 0.0, 0.0)
    back = make(A=[teleport(lane_position(10.0, 1)), speed(10.0)])
    run(back, 3.0)
    assert (back.entities["A"].x, back.entities["A"].speed) == (pytest.approx(0.0), 0.0)


@pytest.mark.parametrize("h", [0.3, -0.4, math.pi - 0.3, math.pi + 0.4])
def test_who_was_put_askew_keeps_its_angle_to_the_lane(make: Make, h: float) -> None:
    board = make(A=[teleport(f'<WorldPosition x="100" y="-1.75" h="{h}"/>'), speed(5.0)])
    run(board, 1.0)
    a = board.entities["A"]
    assert math.remainder(a.h - h, math.tau) == pytest.approx(0.0, abs=1e-9)
    assert a.y == pytest.approx(-1.75)
    assert a.x == pytest.approx(105.0 if math.cos(h) > 0.0 else 95.0)


def follow(*vertices: tuple[float | None, float, float], timing: str = "<None/>") -> str:
    """Time [s] or None, x, y [m]."""
    line = ""
    for t, x, y in vertices:
        stamp = "" if t is None else f' time="{t}"'
        line += f'<Vertex{stamp}><Position><WorldPosition x="{x}" y="{y}"/></Position></Vertex>'
    return (
        "<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef>"
        f'<Trajectory name="t" closed="false"><Shape><Polyline>{line}</Polyline></Shape></Trajectory>'
        f"</TrajectoryRef><TimeReference>{timing}</TimeReference>"
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )


RELATIVE = '<Timing domainAbsoluteRelative="relative" scale="1" offset="0"/>'
ABSOLUTE = '<Timing domainAbsoluteRelative="absolute" scale="1" offset="0"/>'


@pytest.mark.parametrize(("timing", "ends"), [(RELATIVE, 3.0), (ABSOLUTE, 2.0)])
def test_a_trajectory_that_something_else_drives_lasts_until_its_last_time(
    make: Make, timing: str, ends: float
) -> None:
    """2 s from the start of the action at 1 s, or until 2 s."""
    do = follow((0.0, 100.0, -1.75), (2.0, 120.0, -1.75), timing=timing)
    board = make(A=at(100.0, 10.0), external=("A",),
                 stories=story(event("e", do, start=group(condition(at_time(1.0))))))  # fmt: skip
    run(board, 4.0)
    assert [time for time, _, transition in log(board, "action") if transition == "endTransition"] == [
        pytest.approx(ends, abs=0.02)
    ]


def test_who_drives_backwards_follows_a_trajectory_rear_first(make: Make) -> None:
    """No headings are given: at -5 m/s it goes the way of the trajectory and looks back."""
    board = make(A=at(100.0, -5.0), stories=story(event("e", follow((None, 100.0, -1.75), (None, 150.0, -1.75)))))
    run(board, 2.0)
    a = board.entities["A"]
    assert a.x == pytest.approx(110.0, abs=0.06)
    assert abs(a.h) == pytest.approx(math.pi)


def test_ways_add_up_along_a_trajectory_and_beyond_its_end(make: Make) -> None:
    """Back and forth over the ground: 20 m at 10 m/s, then straight on; the way driven is the speed's integral."""
    way = follow((None, 100.0, -1.75), (None, 112.0, 7.25), (None, 117.0, 7.25))
    board = make(A=at(100.0, 10.0), stories=story(event("e", way)))
    run(board, 0.0)
    a = board.entities["A"]
    ways = []
    for _ in range(300):
        run(board, 0.01)
        ways.append(a.travelled)
    steps = [b - c for c, b in pairwise(ways)]
    assert ways[-1] == pytest.approx(30.0, abs=0.11)
    assert (min(steps), max(steps)) == (pytest.approx(0.1, abs=1e-6), pytest.approx(0.1, abs=1e-6))


def test_each_step_beyond_a_limit_counts_once(make: Make) -> None:
    """90 m/s, of which a car of 70 m/s is not able, from 1 s to 3 s in steps of 0.05 s."""
    do = follow((0.0, 110.0, -1.75), (10.0, 1010.0, -1.75), timing=RELATIVE)
    board = make(A=at(100.0, 10.0), stories=story(event("e", do, start=group(condition(at_time(1.0))))))
    board.start()
    watch = Plausibility(board)
    for _ in range(60):
        board.step(0.05)
        watch.look(0.05)
    (count,) = [found["count"] for found in watch.findings() if found["field"] == "A.speed"]
    assert count == pytest.approx(40, abs=1)


@pytest.mark.parametrize(("reads", "least"), [(5.0, 2.0), (10.0, 1.0)])
def test_who_is_slower_than_the_shape_goes_on_with_it_as_it_can(make: Make, reads: float, least: float) -> None:
    """To 10 m/s with B in 1 s: with 5 m/s^2 it takes 2 s, with 10 m/s^2 as long as the shape."""
    to = '<RelativeTargetSpeed entityRef="B" value="0" speedTargetValueType="delta" continuous="true"/>'
    board = make(A=at(100.0, 0.0), B=at(300.0, 10.0), acceleration=reads,
                 stories=story(event("e", relative_speed(to, "linear", "time", 1.0))))  # fmt: skip
    run(board, 0.0)
    a = board.entities["A"]
    speeds = []
    for _ in range(250):
        run(board, 0.01)
        speeds.append(a.speed)
    assert speeds[49] == pytest.approx(min(reads, 10.0) * 0.5, rel=0.03)
    assert speeds[round(100 * least) - 4] < 10.0
    assert speeds[round(100 * least) + 3] == pytest.approx(10.0)
