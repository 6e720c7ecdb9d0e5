"""Right of way at a junction: who goes first by sign and by direction, and where the car waits."""

from __future__ import annotations

from pathlib import Path

import pytest
from ads_loop import TABBY

from ads.localization import Estimate
from ads.parameters import Parameters
from ads.planning.junction import JunctionRule
from ads.planning.memory import TrackMemory
from ads.planning.navigator import Navigator
from ads.planning.right_of_way import Priority, priority_of, sign_of
from openscenario.road.network import RoadNetwork, load_network
from vehicle.messages import Detection, RoadPoint, Task

# The T of the town: West Street (1) comes from the south, Harbour Street (6) from the north, Garden Road (7) from the
# west. Lanes that lead to the junction: 1 of West Street, -1 of Harbour Street, 1 of Garden Road.
FROM_SOUTH, FROM_NORTH, FROM_WEST = RoadPoint("1", 1, 25.0), RoadPoint("6", -1, 40.0), RoadPoint("7", 1, 40.0)
TO_SOUTH, TO_NORTH, TO_WEST = RoadPoint("1", -1, 20.0), RoadPoint("6", 1, 40.0), RoadPoint("7", -1, 30.0)
CAR = TABBY
FRONT = TABBY.center_x + 0.5 * TABBY.length


def town(scenarios_dir: Path, tmp_path: Path, sign: str = "", validity: str = "") -> RoadNetwork:
    """The town; `sign`: type of a sign (ES) for the traffic of Garden Road that comes to the junction,
    for the lanes of `validity`."""
    text = (scenarios_dir / "urban.xodr").read_text()
    if sign:
        head, tail = text.split('<road name="Garden Road"')
        signal = (
            '<signals><signal id="77" s="1" t="5" dynamic="no" orientation="-" zOffset="2" country="ES" '
            f'type="{sign}" subtype="-1">{validity}</signal></signals></road>'
        )
        text = head + '<road name="Garden Road"' + tail.replace("</road>", signal, 1)
    path = tmp_path / "town.xodr"
    path.write_text(text)
    return load_network(path)


def on_the_way(network: RoadNetwork, start: RoadPoint, goal: RoadPoint) -> Navigator:
    navigator = Navigator(Parameters(), network)
    navigator.assign(Task(goal=goal))
    pose = network.lane_pose(*start)
    heading = navigator.heading_hint(pose.x, pose.y)
    navigator.update(Estimate(0.0, pose.x, pose.y, heading, 5.0, 0.0, 0.0, 0.1, 0.01), True)
    return navigator


def priority(network: RoadNetwork, start: RoadPoint, goal: RoadPoint) -> Priority | None:
    navigator = on_the_way(network, start, goal)
    before, span = navigator.monitor.spans[:2]
    return priority_of(network, before, span, navigator.path, navigator.monitor.side)


class TestWhoGoesFirst:
    def test_left_turn_gives_way_to_those_who_come_towards_it(self, scenarios_dir: Path, tmp_path: Path) -> None:
        found = priority(town(scenarios_dir, tmp_path), FROM_SOUTH, TO_WEST)
        # straight on from the north, and its right turn, which ends where ours does
        to_the_west, to_the_south = sorted(way.line[-1, :2].tolist() for way in found.ways)
        assert to_the_west == pytest.approx([-14.0, 62.75], abs=0.01)
        assert to_the_south == pytest.approx([-1.75, 47.0], abs=0.01)
        assert found.sign == ""

    @pytest.mark.parametrize(("start", "goal"), [(FROM_SOUTH, TO_NORTH), (FROM_NORTH, TO_SOUTH), (FROM_NORTH, TO_WEST)])
    def test_straight_on_and_to_the_right_nobody_goes_first(
        self, scenarios_dir: Path, tmp_path: Path, start: RoadPoint, goal: RoadPoint
    ) -> None:
        assert priority(town(scenarios_dir, tmp_path), start, goal) is None

    @pytest.mark.parametrize(("kind", "sign"), [("R1", "yield"), ("R2", "stop")])
    def test_a_sign_gives_way_to_all_who_have_none(
        self, scenarios_dir: Path, tmp_path: Path, kind: str, sign: str
    ) -> None:
        network = town(scenarios_dir, tmp_path, kind)
        assert sign_of(network, "7", 1, False) == sign
        found = priority(network, FROM_WEST, TO_NORTH)
        assert found.sign == sign
        assert len(found.ways) == 3  # straight on both ways, and who turns left into our road crosses ours

    def test_who_has_a_sign_is_not_waited_for(self, scenarios_dir: Path, tmp_path: Path) -> None:
        assert priority(town(scenarios_dir, tmp_path, "R1"), FROM_NORTH, TO_SOUTH) is None

    def test_a_sign_for_the_other_direction_is_none(self, scenarios_dir: Path, tmp_path: Path) -> None:
        assert sign_of(town(scenarios_dir, tmp_path, "R1"), "7", -1, False) == ""

    @pytest.mark.parametrize(("lanes", "sign"), [((2, 2), ""), ((1, 2), "yield")])
    def test_a_sign_for_other_lanes_is_none(
        self, scenarios_dir: Path, tmp_path: Path, lanes: tuple[int, int], sign: str
    ) -> None:
        low, high = lanes
        validity = f'<validity fromLane="{low}" toLane="{high}"/>'
        assert sign_of(town(scenarios_dir, tmp_path, "R1", validity), "7", 1, False) == sign


def oncoming(y: float, v: float) -> Detection:
    """A car on Harbour Street or the way straight on, coming from the north."""
    return Detection(0.0, "vehicle", -1.75, y, -1.5708, 4.3, 1.8, 0.0, -v, track=3)


class TestRule:
    def wait(self, scenarios_dir: Path, tmp_path: Path, car: Detection | None, v: float = 4.0, at: float = 15.0):
        """(near, wait) of a car that turns left `at` metres before the junction."""
        navigator = on_the_way(town(scenarios_dir, tmp_path), FROM_SOUTH, TO_WEST)
        rule, memory, seen = JunctionRule(CAR), TrackMemory(CAR.camera_z), () if car is None else (car,)
        memory.note(0.0, 0.0, 0.0, seen)
        s = navigator.monitor.spans[1].s_from - at
        found = rule.update(0.0, s, v, navigator, seen, memory)
        return found, rule.limits(s, found[1])

    def test_drives_on_when_nobody_comes(self, scenarios_dir: Path, tmp_path: Path) -> None:
        assert self.wait(scenarios_dir, tmp_path, None) == ((True, False), [])

    def test_waits_before_the_way_of_one_who_comes(self, scenarios_dir: Path, tmp_path: Path) -> None:
        (near, waits), ((distance, speed),) = self.wait(scenarios_dir, tmp_path, oncoming(80.0, 5.0))
        assert near
        assert waits
        assert speed == 0.0
        # the way begins 1.75 m left of ours to 3.5 m; the bumper stays before it, inside the junction
        assert 15.0 - FRONT < distance < 15.0 - FRONT + 8.0

    def test_drives_before_one_who_is_far(self, scenarios_dir: Path, tmp_path: Path) -> None:
        (_, waits), _ = self.wait(scenarios_dir, tmp_path, oncoming(100.0, 1.0))
        assert not waits

    def test_one_who_has_passed_is_not_waited_for(self, scenarios_dir: Path, tmp_path: Path) -> None:
        (_, waits), _ = self.wait(scenarios_dir, tmp_path, oncoming(40.0, 5.0))
        assert not waits

    def test_does_not_look_far_from_the_junction(self, scenarios_dir: Path, tmp_path: Path) -> None:
        (near, waits), _ = self.wait(scenarios_dir, tmp_path, oncoming(80.0, 5.0), at=35.0)
        assert not near
        assert not waits

    def test_at_a_stop_sign_it_stands_though_nobody_comes(self, scenarios_dir: Path, tmp_path: Path) -> None:
        navigator = on_the_way(town(scenarios_dir, tmp_path, "R2"), FROM_WEST, TO_NORTH)
        rule, memory = JunctionRule(CAR), TrackMemory(CAR.camera_z)
        line = navigator.monitor.spans[1].s_from
        assert rule.update(0.0, line - 20.0, 3.0, navigator, (), memory) == (True, True)
        assert rule.update(9.0, line - FRONT - 0.6, 0.0, navigator, (), memory) == (True, False)
