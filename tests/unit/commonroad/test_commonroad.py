"""CommonRoad files: lanelets become roads, obstacles actors, the planning problem the task of the ego."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from openscenario.findings import ScenarioError
from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.engine import Storyboard
from pytest_dvp.cli.command_line import main

from .commonroad_files import (
    after,
    before,
    beside,
    dynamic,
    lanelet,
    problem,
    scenario,
    static,
    straight,
    two_lanes,
)


def written(tmp_path: Path, *parts: str, version: str = "2020a") -> Path:
    path = tmp_path / "x.xml"
    path.write_text(scenario(*parts, version=version))
    return path


def network(tmp_path: Path, *parts: str) -> RoadNetwork:
    return load_network(written(tmp_path, *parts))


# --- roads


def test_lanelets_side_by_side_are_the_lanes_of_one_road(tmp_path: Path) -> None:
    net = network(tmp_path, *two_lanes())
    assert {road.id: road.length for road in net.roads.values()} == {"1": 100.0, "3": 100.0}
    assert [lane.id for lane in net.roads["1"].sections[0].lanes] == [1, 0, -1, -2]
    assert [net.lane_width("1", lane, 37.0) for lane in (1, -1, -2)] == [3.5, 3.5, 3.5]
    for lane, y in ((1, 1.75), (-1, -1.75), (-2, -5.25)):
        pose = net.lane_pose("1", lane, 40.0)
        assert (pose.x, pose.y, pose.h) == (pytest.approx(40.0), pytest.approx(y), pytest.approx(0.0))


def test_lanelets_behind_each_other_are_linked(tmp_path: Path) -> None:
    net = network(tmp_path, *two_lanes())
    assert net.lane_successors("1", -1) == (("3", -1),)
    assert net.lane_successors("1", -2) == (("3", -2),)
    assert net.driving_sign("1", 1) == -1
    assert not net.junctions


@pytest.mark.parametrize("radius", [20.0, 50.0, 200.0])
def test_a_quarter_of_a_circle_has_its_length_and_its_middle(tmp_path: Path, radius: float) -> None:
    """Bounds of 3 m apart with a point every 3 degrees; the lane's middle lies between both, within 3 mm."""
    angles = [math.radians(3.0 * n) for n in range(31)]
    left, right = ([(r * math.sin(a), radius - r * math.cos(a)) for a in angles] for r in (radius - 1.5, radius + 1.5))
    net = network(tmp_path, lanelet(7, left, right))
    road = net.roads["7"]
    assert road.length == pytest.approx(0.5 * math.pi * (radius - 1.5), rel=2e-4)
    for part in (0.1, 0.5, 0.9):
        pose = net.lane_pose("7", -1, part * road.length)
        assert math.hypot(pose.x, pose.y - radius) == pytest.approx(radius, abs=0.003)
        assert pose.h == pytest.approx(part * 0.5 * math.pi, abs=0.01)


def fork() -> list[str]:
    """Lanelet 1 goes on straight (2) and to the left (3); 2 and 4 merge into 5."""
    curve = [(100 + 40 * math.sin(a), 40 - 40 * math.cos(a)) for a in (math.radians(5.0 * n) for n in range(19))]
    outer = [(100 + 43.5 * math.sin(a), 40 - 43.5 * math.cos(a)) for a in (math.radians(5.0 * n) for n in range(19))]
    return [
        lanelet(1, straight(0, 100, 0.0), straight(0, 100, -3.5), more=after(2, 3)),
        lanelet(2, straight(100, 200, 0.0), straight(100, 200, -3.5), more=before(1) + after(5)),
        lanelet(3, curve, outer, more=before(1)),
        lanelet(4, [(150, -60), (200, 0.0)], [(153, -62), (200, -3.5)], more=after(5)),
        lanelet(5, straight(200, 300, 0.0), straight(200, 300, -3.5), more=before(2, 4)),
    ]


@pytest.mark.parametrize(("start", "goal"), [("1", "2"), ("1", "3"), ("1", "5"), ("4", "5")])
def test_forks_and_merges_are_junctions_over_which_routes_lead(tmp_path: Path, start: str, goal: str) -> None:
    net = network(tmp_path, *fork())
    assert len(net.junctions) == 2
    assert net.route((start, -1, 10.0), (goal, -1, 20.0))


def test_a_speed_limit_and_kinds_of_lanelets(tmp_path: Path) -> None:
    sign = (
        '<trafficSign id="50"><trafficSignElement><trafficSignID>274</trafficSignID>'
        "<additionalValue>13.9</additionalValue></trafficSignElement></trafficSign>"
    )
    walk = lanelet(2, straight(0, 50, -3.5), straight(0, 50, -5.5), more=beside("Left", 1), kind="sidewalk")
    road = lanelet(
        1, straight(0, 50, 0.0), straight(0, 50, -3.5), more=beside("Right", 2) + '<trafficSignRef ref="50"/>'
    )
    net = network(tmp_path, road, walk, sign)
    assert net.lane_speed("1", -1, 10.0) == 13.9
    assert net.lane_type("1", -2, 10.0) == "sidewalk"


@pytest.mark.parametrize("kind", ["shoulder", "parking", "restricted"])
def test_no_car_is_led_onto_a_lanelet_beside_the_traffic(tmp_path: Path, kind: str) -> None:
    road = lanelet(1, straight(0, 50, 0.0), straight(0, 50, -3.5), more=beside("Right", 2))
    beyond = lanelet(2, straight(0, 50, -3.5), straight(0, 50, -6.0), more=beside("Left", 1), kind=kind)
    net = network(tmp_path, road, beyond)
    assert net.lane_type("1", -2, 10.0) == kind
    assert [tuple(node)[2] for node in net.lane_graph().nodes] == [-1]


def test_the_short_roads_of_a_junction_are_as_the_lanelets_they_go_on_from(tmp_path: Path) -> None:
    sign = (
        '<trafficSign id="50"><trafficSignElement><trafficSignID>274</trafficSignID>'
        "<additionalValue>13.9</additionalValue></trafficSignElement></trafficSign>"
    )
    first, *others = fork()
    limited = first.replace("<laneletType>", '<trafficSignRef ref="50"/><laneletType>')
    net = network(tmp_path, limited, *others, sign)
    ways = {name for name, _ in net.lane_successors("1", -1)}
    assert [net.lane_speed(name, -1, 0.01) for name in sorted(ways)] == [13.9, 13.9]

    walks = [each.replace("urban</laneletType>", "sidewalk</laneletType>") for each in fork()]
    net = network(tmp_path, *walks, lanelet(9, straight(0, 50, 90.0), straight(0, 50, 86.5)))
    assert {net.lane_type(name, -1, 0.01) for name in net.roads if name.startswith("c")} == {"sidewalk"}


# --- obstacles and the task

CAR = [(k, 50.0 + 0.8 * k, -1.75, 0.0, 8.0) for k in range(51)]


def test_an_obstacle_is_where_its_states_say_and_gone_after_the_last(tmp_path: Path) -> None:
    path = written(tmp_path, *two_lanes(), dynamic(10, CAR), static(11, 150.0, -5.25), problem(20, -5.25, 6.0, GOAL))
    board = Storyboard(read_scenario(path), load_network(path))
    board.start()
    board.settle()
    car, parked = board.entities["obstacle10"], board.entities["static11"]
    for step in range(500):
        board.step(0.01)
        if step % 100 == 99 and step < 499:
            assert car.x == pytest.approx(50.0 + 8.0 * board.time, abs=1e-6)
            assert car.active
    board.step(0.02)
    assert not car.active
    assert (parked.x, parked.y, parked.speed) == (150.0, -5.25, 0.0)


GOAL = '<lanelet ref="3"/>'


def test_who_comes_later_is_not_there_before(tmp_path: Path) -> None:
    late = [(k + 20, 50.0 + 0.8 * k, -1.75, 0.0, 8.0) for k in range(51)]
    path = written(tmp_path, *two_lanes(), dynamic(10, late), problem(20, -5.25, 6.0, GOAL))
    board = Storyboard(read_scenario(path), load_network(path))
    board.start()
    seen = []
    for _ in range(40):
        board.step(0.1)
        seen.append(board.entities["obstacle10"].active)
    assert not any(seen[:19])
    assert all(seen[21:])


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("pedestrian", "pedestrian"), ("bus", "vehicle"), ("bicycle", "vehicle"), ("constructionZone", "misc")],
)
def test_kinds_of_obstacles(tmp_path: Path, kind: str, expected: str) -> None:
    read = read_scenario(written(tmp_path, *two_lanes(), dynamic(10, CAR, kind), problem(20, -5.25, 6.0, GOAL)))
    assert {each.name: each.kind for each in read.entities}["obstacle10"] == expected


@pytest.mark.parametrize("version", ["2018b", "2020a"])
@pytest.mark.nightly(by_day=2)
def test_check_and_run_take_it_and_the_ego_reaches_its_goal(
    tmp_path: Path, version: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, *two_lanes(), dynamic(10, CAR), problem(40, -5.25, 8.0, GOAL, 300), version=version)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "."]) == 0
    assert "x.xml: runs" in capsys.readouterr().err
    assert main(["run", str(path), "--no-report", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    row = result[0] if isinstance(result, list) else result
    assert row["status"] == "PASS"
    assert "goal" in row["ended"]


@pytest.mark.parametrize(
    ("old", "new", "code", "says"),
    [
        ("2020a", "2099z", "version.unsupported", "2018b or 2020a"),
        ("<x>10.0</x>", "<x>ten</x>", "value.not_a_number", "ten"),
        ('timeStepSize="0.1"', 'timeStepSize="0"', "value.out_of_range", "more than 0"),
        ("<goalState>", "<goalStat>", "xml.not_well_formed", "goalStat"),
        ("<width>1.8</width>", "", "commonroad.missing", "width"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, old: str, new: str, code: str, says: str) -> None:
    path = written(tmp_path, *two_lanes(), dynamic(10, CAR), problem(20, -5.25, 6.0, GOAL))
    text = path.read_text()
    assert old in text
    path.write_text("\n\n" + text.replace(old, new).removeprefix('<?xml version="1.0"?>'))
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path)
    first = caught.value.findings[0]
    assert (first.code, first.line) == (code, 3)
    assert says in str(first)


def test_what_is_read_over_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lights = '<trafficLight id="70"/><trafficLight id="71"/>'
    path = written(tmp_path, *two_lanes(), problem(20, -5.25, 6.0, GOAL), lights)
    main(["check", str(path)])
    assert "trafficLight is read over, 2 times" in capsys.readouterr().out


def test_another_xml_file_is_none_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "junit.xml").write_text("<testsuites/>")
    written(tmp_path, *two_lanes(), problem(20, -5.25, 6.0, GOAL))
    from pytest_dvp.cli.shared.checkable_files import files_of

    assert [path.name for path in files_of(tmp_path)] == ["x.xml"]
