"""Roads linked against each other, round a bend, or driven on the left: the world does not change with how a road file
counts s and lanes (ASAM OpenSCENARIO XML 1.3, 6.3: actions and conditions mean places and distances)."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import pytest

from openscenario.road.network import RoadNetwork, load_network

from .conftest import (
    LANE,
    Make,
    at_time,
    by_entity,
    condition,
    event,
    group,
    lane_change,
    log,
    run,
    speed,
    story,
    teleport,
)

LENGTH = 200.0
RADIUS = 100.0


def lanes() -> str:
    left, right = "".join(LANE.format(id=i) for i in (2, 1)), "".join(LANE.format(id=i) for i in (-1, -2))
    return (
        f'<lanes><laneSection s="0"><left>{left}</left><center><lane id="0" type="none"/></center>'
        f"<right>{right}</right></laneSection></lanes>"
    )


def linked(text: str, end: str, other: str) -> str:
    """All lanes of a road, at its start ("predecessor") or end ("successor"), with those of the same or other sign."""
    for lane in (2, 1, -1, -2):
        there = f'<{end} id="{lane if other == "same" else -lane}"/>'
        before, after = text.split(f'<lane id="{lane}"', 1)
        text = f'{before}<lane id="{lane}"{after.replace("<link/>", f"<link>{there}</link>", 1)}'
    return text


def straight(number: int, x: float, heading: float, link: str, end: str, other: str) -> str:
    return (
        f'<road length="{LENGTH}" id="{number}" junction="-1" rule="RHT"><link>{link}</link><planView>'
        f'<geometry s="0" x="{x}" y="0" hdg="{heading}" length="{LENGTH}"><line/></geometry></planView>'
        f"{linked(lanes(), end, other)}</road>"
    )


def network(folder: Path, *roads: str) -> RoadNetwork:
    path = folder / "roads.xodr"
    path.write_text(
        '<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="6" name=""/>' + "".join(roads) + "</OpenDRIVE>"
    )
    return load_network(path)


@pytest.fixture(scope="module", params=["along", "against"])
def two_roads(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> RoadNetwork:
    """Road 1 from x = 0 to 200, road 2 on to 400: along x as well, or against it from its end."""
    against = request.param == "against"
    contact, other = ("end", "mirrored") if against else ("start", "same")
    first = f'<successor elementType="road" elementId="2" contactPoint="{contact}"/>'
    second = '<{} elementType="road" elementId="1" contactPoint="end"/>'.format(
        "successor" if against else "predecessor"
    )
    return network(
        tmp_path_factory.mktemp(request.param),
        straight(1, 0.0, 0.0, first, "successor", other),
        straight(2, 400.0, math.pi, second, "successor", other)
        if against
        else straight(2, 200.0, 0.0, second, "predecessor", other),
    )


@pytest.fixture(scope="module")
def circle(tmp_path_factory: pytest.TempPathFactory) -> RoadNetwork:
    """Three quarters of a circle to the left."""
    length = 1.5 * math.pi * RADIUS
    road = (
        f'<road length="{length}" id="1" junction="-1" rule="RHT"><link/><planView><geometry s="0" x="0" y="0" hdg="0" '
        f'length="{length}"><arc curvature="{1.0 / RADIUS}"/></geometry></planView>{lanes()}</road>'
    )
    return network(tmp_path_factory.mktemp("circle"), road)


def world(x: float, y: float, h: float = 0.0) -> str:
    return teleport(f'<WorldPosition x="{x}" y="{y}" h="{h}"/>')


def beside(target: str, continuous: str = "false") -> str:
    return (
        f'<PrivateAction><LateralAction><LaneOffsetAction continuous="{continuous}"><LaneOffsetActionDynamics '
        f'dynamicsShape="cubic" maxLateralAcc="1"/><LaneOffsetTarget>{target}</LaneOffsetTarget></LaneOffsetAction>'
        "</LateralAction></PrivateAction>"
    )


def test_an_offset_to_another_is_to_where_it_is(make: Make, two_roads: RoadNetwork) -> None:
    """B at y = -1.25 m on the second road; 0.5 m to its left is y = -0.75 m."""
    act = event("e", beside('<RelativeTargetLaneOffset entityRef="B" value="0.5"/>'))
    board = make(A=[world(50.0, -1.75), speed(10.0)], B=[world(300.0, -1.25)], stories=story(act), on=two_roads)
    run(board, 5.0)
    assert board.entities["A"].y == pytest.approx(-0.75, abs=1e-6)
    assert board.entities["A"].h == pytest.approx(0.0, abs=1e-9)


def test_a_lateral_distance_goes_on_where_the_road_runs_the_other_way(make: Make, two_roads: RoadNetwork) -> None:
    """From y = -1.75 to -4.75 m, 3 m to the right of B; half way over when it comes to the second road."""
    action = (
        '<PrivateAction><LateralAction><LateralDistanceAction entityRef="B" continuous="true" distance="3" '
        'freespace="false" displacement="rightToReferencedEntity" coordinateSystem="road"><DynamicConstraints '
        'maxAcceleration="1" maxDeceleration="1"/></LateralDistanceAction></LateralAction></PrivateAction>'
    )
    on_one, on_two = (
        make(A=[world(x, -1.75), speed(10.0)], B=[world(350.0, -1.75)], stories=story(event("e", action)), on=two_roads)
        for x in (100.0, 185.0)
    )
    run(on_one, 9.0)
    run(on_two, 9.0)
    a, b = on_one.entities["A"], on_two.entities["A"]
    root = math.sqrt(0.4)  # of the stiffness of a critically damped spring: 0.4 x the limit
    rest = (1.0 + root * 9.0) * math.exp(-root * 9.0)
    assert a.y == pytest.approx(-4.75 + 3.0 * rest, abs=0.01)
    assert b.y == pytest.approx(a.y, abs=1e-3)
    assert b.x - a.x == pytest.approx(85.0, abs=1e-3)


def test_where_a_road_begins_it_still_runs_as_it_does(two_roads: RoadNetwork) -> None:
    """From the second road to the very start of the first one: not through it and round."""
    here, there = two_roads.locate(250.0, -1.75), two_roads.locate(0.0, -1.75)
    assert two_roads.runs_against(here, there) == (math.cos(two_roads.road_pose("2", 50.0, 0.0).h) < 0.0)
    assert abs(two_roads.distance(here, there)) == pytest.approx(250.0)


@pytest.mark.parametrize("y", [-5.25, 1.75])
def test_headway_to_the_side_is_the_same_on_both_sides(make: Make, y: float) -> None:
    """3.5 m at 7 m/s are 0.5 s, to the left as to the right."""
    test = (
        '<TimeHeadwayCondition entityRef="B" value="0.6" freespace="false" coordinateSystem="road" '
        'relativeDistanceType="lateral" rule="lessThan"/>'
    )
    act = event("e", speed(7.0), start=group(condition(by_entity(test, "A"))))
    board = make(A=[world(100.0, -1.75), speed(7.0)], B=[world(150.0, y)], stories=story(act))
    run(board, 0.05)
    assert any(what == "startTransition" for _, _, what in log(board, "event"))


def to_collision(kind: str, value: float, system: str = "road", rule: str = "lessThan", free: str = "false") -> str:
    test = (
        f'<TimeToCollisionCondition value="{value}" freespace="{free}" coordinateSystem="{system}" '
        f'relativeDistanceType="{kind}" rule="{rule}"><TimeToCollisionConditionTarget><EntityRef entityRef="B"/>'
        "</TimeToCollisionConditionTarget></TimeToCollisionCondition>"
    )
    return event("e", speed(10.0), start=group(condition(at_time(0.1)), condition(by_entity(test, "A"))))


def on_circle(angle: float, lane: int = -1) -> str:
    s = math.radians(angle) * RADIUS
    return teleport(f'<LanePosition roadId="1" laneId="{lane}" s="{s}" offset="0"/>')


@pytest.mark.parametrize(("ahead", "fires"), [(10.0, False), (9.0, True)])
def test_round_a_bend_who_drives_as_fast_is_not_closed_in_on(
    make: Make, circle: RoadNetwork, ahead: float, fires: bool
) -> None:
    """A at 10 m/s, B a quarter of the circle (157 m) ahead: never at 10 m/s, in 157 s at 9 m/s."""
    board = make(
        A=[on_circle(10.0), speed(10.0)],
        B=[on_circle(100.0), speed(ahead)],
        stories=story(to_collision("longitudinal", 170.0)),
        on=circle,
    )
    run(board, 1.0)
    assert any(what == "startTransition" for _, _, what in log(board, "event")) == fires


def test_at_no_distance_there_is_no_time_to_a_collision(make: Make) -> None:
    """Both 5 m long, one beside the other: they overlap along the road."""
    act = to_collision("longitudinal", 5.0, free="true")
    board = make(A=[world(100.0, -1.75), speed(10.0)], B=[world(101.0, -5.25), speed(9.0)], stories=story(act))
    run(board, 0.5)
    assert not any(what == "startTransition" for _, _, what in log(board, "event"))


def test_in_world_coordinates_closing_in_is_along_the_worlds_axes(make: Make) -> None:
    """A drives along y, B stands 20 m further along x: it never closes in along x."""
    act = to_collision("longitudinal", 100.0, system="world")
    board = make(
        A=[world(100.0, 0.0, 0.5 * math.pi), speed(10.0)],
        B=[world(120.0, 0.0)],
        stories=story(act),
        without_road=True,
    )
    run(board, 1.0)
    assert not any(what == "startTransition" for _, _, what in log(board, "event"))


@pytest.fixture(scope="module")
def shifted_ids(tmp_path_factory: pytest.TempPathFactory) -> RoadNetwork:
    """From x = 100 m on a lane more begins on the left of two lanes to the right of y = 0, so that their ids rise."""
    before = "".join(LANE.format(id=i).replace("<link/>", f'<link><successor id="{i - 1}"/></link>') for i in (-1, -2))
    after = LANE.format(id=-1) + "".join(
        LANE.format(id=i).replace("<link/>", f'<link><predecessor id="{i + 1}"/></link>') for i in (-2, -3)
    )
    sections = "".join(
        f'<laneSection s="{s}"><center><lane id="0" type="none"/></center><right>{right}</right></laneSection>'
        for s, right in ((0, before), (100, after))
    )
    offset = '<laneOffset s="0" a="0" b="0" c="0" d="0"/><laneOffset s="100" a="3.5" b="0" c="0" d="0"/>'
    road = (
        '<road length="400" id="1" junction="-1" rule="RHT"><link/><planView><geometry s="0" x="0" y="0" hdg="0" '
        f'length="400"><line/></geometry></planView><lanes>{offset}{sections}</lanes></road>'
    )
    return network(tmp_path_factory.mktemp("shifted"), road)


@pytest.mark.parametrize(("by", "y"), [(0, -1.75), (-1, -5.25)])
def test_a_lane_change_to_the_lane_of_another_on_the_next_road(
    make: Make, two_roads: RoadNetwork, by: int, y: float
) -> None:
    """B drives in the inner lane of the second road: A goes to that lane, or to the one on its right."""
    act = event("e", lane_change(f'<RelativeTargetLane entityRef="B" value="{by}"/>'))
    start = -5.25 if by == 0 else -1.75
    board = make(A=[world(50.0, start), speed(10.0)], B=[world(300.0, -1.75)], stories=story(act), on=two_roads)
    run(board, 5.0)
    assert board.entities["A"].y == pytest.approx(y, abs=1e-6)


@pytest.mark.parametrize(("x", "other"), [(20.0, 110.0), (110.0, 80.0)])
def test_a_lane_change_to_the_lane_of_another_where_ids_shift(
    make: Make, shifted_ids: RoadNetwork, x: float, other: float
) -> None:
    act = event("e", lane_change('<RelativeTargetLane entityRef="B" value="0"/>'))
    board = make(A=[world(x, -5.25), speed(10.0)], B=[world(other, -1.75)], stories=story(act), on=shifted_ids)
    run(board, 5.0)
    assert board.entities["A"].y == pytest.approx(-1.75, abs=1e-6)


def test_where_no_links_lead_a_lane_change_counts_ids_and_says_so(make: Make, tmp_path: Path) -> None:
    """Two roads of their own, side by side; B is in lane -1 of the other one."""
    apart = network(
        tmp_path, straight(1, 0.0, 0.0, "", "successor", "same"), straight(2, 900.0, 0.0, "", "successor", "same")
    )
    act = event("e", lane_change('<RelativeTargetLane entityRef="B" value="0"/>'))
    board = make(A=[world(50.0, -5.25), speed(10.0)], B=[world(950.0, -1.75)], stories=story(act), on=apart)
    run(board, 5.0)
    assert board.entities["A"].lane == -1
    assert "no lane links lead from the lane of B to A on road 1" in " ".join(each.text for each in board.report())


@pytest.mark.parametrize(("apart", "found"), [(100.1, True), (99.9, False)])
def test_lanes_lead_onwards_along_at_most_twice_the_way_of_the_roads_and_50_m(
    two_roads: RoadNetwork, monkeypatch: pytest.MonkeyPatch, apart: float, found: bool
) -> None:
    """The lanes need 250 m from x = 50 m to x = 300 m; the roads are said to need about 100 m."""
    start, goal = two_roads.locate(50.0, -5.25), two_roads.locate(300.0, -5.25)
    monkeypatch.setattr(two_roads, "_distances", SimpleNamespace(between=lambda *_: (apart, False)))
    assert two_roads.lane_onwards(start, goal) == (goal.lane if found else None)


def is_clear(make: Make, on: RoadNetwork, lane: int, x: float, y: float) -> bool:
    """Whether A, 20 m before the end of what counts its way, finds a lane free of B 30 m ahead."""
    test = (
        '<RelativeClearanceCondition distanceForward="50" distanceBackward="0" freeSpace="false" oppositeLanes="false">'
        f'<RelativeLaneRange from="{lane}" to="{lane}"/></RelativeClearanceCondition>'
    )
    act = event("e", speed(0.0), start=group(condition(by_entity(test, "A"))))
    board = make(A=[world(x, -1.75)], B=[world(x + 30.0, y)], stories=story(act), on=on)
    run(board, 0.05)
    return ("e", "startTransition") in [(name, what) for _, name, what in log(board, "event")]


LANES = [(-1.75, 0, False), (-1.75, -1, True), (-5.25, -1, False), (-5.25, 0, True)]


@pytest.mark.parametrize(("y", "lane", "clear"), LANES)
def test_who_is_ahead_in_a_lane_whose_id_shifts_is_in_the_way(
    make: Make, shifted_ids: RoadNetwork, y: float, lane: int, clear: bool
) -> None:
    assert is_clear(make, shifted_ids, lane, 80.0, y) is clear


@pytest.mark.parametrize(("y", "lane", "clear"), LANES)
def test_who_is_ahead_on_the_next_road_is_in_the_way(
    make: Make, two_roads: RoadNetwork, y: float, lane: int, clear: bool
) -> None:
    assert is_clear(make, two_roads, lane, 180.0, y) is clear


@pytest.mark.parametrize(("ds", "x"), [(5.0, 185.0), (50.0, 230.0)])
@pytest.mark.parametrize("y", [-1.25, 2.25])
def test_a_place_on_the_next_road_is_on_the_same_side(
    make: Make, two_roads: RoadNetwork, ds: float, x: float, y: float
) -> None:
    """B is 0.5 m left of the middle of its lane, seen along x: so is a place ahead of it along the roads."""
    there = teleport(f'<RelativeRoadPosition entityRef="B" ds="{ds}" dt="0"/>')
    board = make(B=[world(180.0, y, 0.0 if y < 0.0 else math.pi)], A=[there], on=two_roads)
    board.start()
    assert (board.entities["A"].x, board.entities["A"].y) == pytest.approx((x, y), abs=1e-6)
