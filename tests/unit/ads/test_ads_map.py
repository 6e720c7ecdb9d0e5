"""Route, waypoints, map monitor and navigator on a small map of the tests' own."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from ads_plane import WIDTH, PlaneMap

from ads.control.spline import KAPPA, S, X, Y
from ads.localization import Estimate
from ads.map_monitor import MapMonitor
from ads.parameters import Parameters
from ads.planning.navigator import Navigator
from ads.planning.route import Leg, follow, lane_heading, to_goal
from ads.planning.waypoints import BEHIND, reference_path
from ads.transforms import Pose, moved, wrap_angle
from openscenario.road.network import load_network
from openscenario.road.route import RouteError
from scenarios import path
from vehicle.messages import RoadPoint, Task


def navigator_at(network: PlaneMap, x: float, y: float, yaw: float, task: Task | None = None) -> Navigator:
    navigator = Navigator(Parameters(), network)
    navigator.assign(task or Task())
    navigator.update(Estimate(0.0, x, y, yaw, 5.0, 0.0, 0.0, 0.1, 0.01), True)
    return navigator


class TestRoute:
    def test_the_left_lane_leads_back(self):
        assert lane_heading(PlaneMap([(100.0, 0.0)]), "1", 1, 50.0) == pytest.approx(math.pi)

    def test_following_stops_at_the_dead_end(self):
        (leg,) = follow(PlaneMap([(100.0, 0.0)]), "1", -1, 20.0, 500.0)
        assert leg == Leg("1", -1, 20.0, 100.0)

    def test_following_against_s(self):
        (leg,) = follow(PlaneMap([(100.0, 0.0)]), "1", 1, 80.0, 30.0)
        assert leg == Leg("1", 1, 80.0, 50.0)

    def test_points_of_the_route_are_visited_in_order(self):
        network = PlaneMap([(100.0, 0.0)])
        task = Task(goal=RoadPoint("1", -1, 90.0), route=(RoadPoint("1", -1, 40.0),))
        assert to_goal(network.route, RoadPoint("1", -1, 5.0), task) == (Leg("1", -1, 5.0, 90.0),)


class TestWaypoints:
    def test_the_path_runs_in_the_middle_of_the_lane(self):
        network = PlaneMap([(40.0, 0.0), (30.0, 0.05), (40.0, 0.0)])
        path = reference_path(network, (Leg("1", -1, 0.0, 110.0),), 5.0)
        inner = path[(path[:, S] > BEHIND) & (path[:, S] < BEHIND + 100.0)]
        offsets = [network.locate(x, y).offset for x, y in inner[:, X : Y + 1]]
        assert np.abs(offsets).max() < 0.05

    def test_a_lane_change_is_smooth(self):
        class TwoLanes(PlaneMap):
            def lane_pose(self, road, lane, s, offset=0.0):
                return self.at(s, (lane + 0.5) * WIDTH + offset)

        path = reference_path(TwoLanes([(200.0, 0.0)]), (Leg("1", -1, 0.0, 100.0), Leg("1", -2, 100.0, 200.0)), 5.0)
        assert np.abs(path[:, KAPPA]).max() < 0.06
        assert path[-80, Y] == pytest.approx(-1.5 * WIDTH, abs=0.05)


class TestMapMonitor:
    def monitor(self, network: PlaneMap) -> MapMonitor:
        legs = (Leg("1", -1, 0.0, 200.0),)
        return MapMonitor(network, legs, reference_path(network, legs, 5.0))

    def test_a_crossing_lies_where_the_road_has_it(self):
        monitor = self.monitor(PlaneMap([(200.0, 0.0)], crosswalk_at=80.0))
        (crossing,) = monitor.crossings
        assert (crossing.s_from, crossing.s_to) == pytest.approx((BEHIND + 78.5, BEHIND + 81.5), abs=0.05)
        assert (crossing.l_from, crossing.l_to) == pytest.approx((-2.25, 5.75), abs=0.05)  # lane -1: t = -1.75

    def test_a_path_goes_over_a_crosswalk_whose_middle_is_far_from_it(self):
        """Lane -1 runs at t = -1.75, 7.25 m beside the middle."""
        (crossing,) = self.monitor(PlaneMap([(200.0, 0.0)], crosswalk_at=80.0, crosswalk_t=(-3.0, 14.0))).crossings
        assert (crossing.s_from, crossing.s_to) == pytest.approx((BEHIND + 78.5, BEHIND + 81.5), abs=0.05)

    def test_a_path_beside_a_crosswalk_does_not_go_over_it(self):
        network = PlaneMap([(200.0, 0.0)], crosswalk_at=80.0, crosswalk_t=(0.0, 4.0))
        assert self.monitor(network).crossings == ()

    def test_a_crosswalk_ahead_has_its_area_and_distance(self):
        view = self.monitor(PlaneMap([(200.0, 0.0)], crosswalk_at=80.0)).view(BEHIND + 10.0)
        (crossing,) = view.crossings
        assert (crossing.distance, crossing.distance_end) == pytest.approx((68.5, 71.5), abs=0.05)
        assert crossing.area == pytest.approx(np.array([(78.5, -4), (81.5, -4), (81.5, 4), (78.5, 4)]))

    def test_a_signal_has_its_distance_along_the_route_and_the_state_last_heard(self):
        monitor = self.monitor(PlaneMap([(200.0, 0.0)], signal_at=60.0))
        assert [s.state for s in monitor.view(BEHIND).signals] == [""]
        (signal,) = monitor.view(BEHIND + 25.0, {"lamp": "red", "another": "green"}).signals
        assert (signal.id, signal.state) == ("lamp", "red")
        assert signal.distance == pytest.approx(35.0, abs=0.1)

    @pytest.mark.parametrize(("validity", "seen"), [(((-2, -2),), 0), (((-2, -1),), 1), ((), 1)])
    def test_a_signal_for_other_lanes_is_none_of_ours(self, validity, seen):
        class Lights(PlaneMap):
            @property
            def signals(self):
                return (SimpleNamespace(id="lamp", road="1", s=60.0, orientation="+", validity=validity),)

        assert len(self.monitor(Lights([(200.0, 0.0)])).signals) == seen

    def test_a_passed_crossing_is_out_of_view(self):
        assert self.monitor(PlaneMap([(200.0, 0.0)], crosswalk_at=80.0)).view(BEHIND + 120.0).crossings == ()

    def test_room_beside_the_lane(self):
        room = self.monitor(PlaneMap([(200.0, 0.0)])).room(BEHIND + 50.0)
        assert room == (WIDTH / 2, WIDTH, False)

    def test_current_lane(self):
        view = self.monitor(PlaneMap([(200.0, 0.0)])).view(BEHIND + 50.0)
        assert view.lane.lane == -1
        assert view.junction_distance == math.inf


class TestJunctionAhead:
    """The crossroads of the shipped town: every figure against the file's own lengths."""

    NETWORK = load_network(path("urban.xodr"))

    def monitor(self) -> tuple[MapMonitor, tuple[Leg, ...]]:
        junction = next(r for r in self.NETWORK.roads.values() if r.junction != "-1")
        before = self.NETWORK.roads[junction.predecessor.id]
        lane = next(lane.id for lane in junction.sections[0].lanes if lane.drivable)
        start, end = (before.id, -1, 5.0), (junction.id, lane, 0.5 * junction.length)
        legs = tuple(Leg(*leg) for leg in self.NETWORK.route(start, end))
        return MapMonitor(self.NETWORK, legs, reference_path(self.NETWORK, legs, 5.0)), legs

    def to_the_junction(self, legs: tuple[Leg, ...]) -> float:
        """Length [m] of the first lane's middle: that of the reference line but for the bends."""
        line = self.NETWORK.centreline(legs[:1], 0.1)
        return float(np.hypot(*np.diff(line[:, :2], axis=0).T).sum())

    def test_the_way_through_it_and_its_other_lanes(self):
        monitor, legs = self.monitor()
        view = monitor.view(BEHIND)
        assert view.lane == legs[0]
        assert not view.in_junction
        assert view.junction_distance == pytest.approx(self.to_the_junction(legs), abs=0.3)
        assert view.junction_lanes == legs[1:]
        through = {r.id for r in self.NETWORK.roads.values() if r.junction == self.NETWORK.roads[legs[1].road].junction}
        assert {leg.road for leg in view.junction_others} | {legs[1].road} == through
        assert legs[1].road not in {leg.road for leg in view.junction_others}

    def test_inside_it_says_so(self):
        monitor, legs = self.monitor()
        view = monitor.view(BEHIND + self.to_the_junction(legs) + 2.0)
        assert view.in_junction
        assert view.junction_distance == 0.0


class TestNavigator:
    def test_the_goal_has_its_place_on_the_path(self):
        navigator = navigator_at(PlaneMap([(200.0, 0.0)]), 10.0, -1.75, 0.0, Task(goal=RoadPoint("1", -1, 150.0)))
        assert navigator.goal_s - navigator.s == pytest.approx(140.0, abs=0.05)

    def test_a_set_speed_overrides_the_parameter(self):
        navigator = navigator_at(PlaneMap([(200.0, 0.0)]), 10.0, -1.75, 0.0)
        assert navigator.set_speed == Parameters().LQR_v_max
        navigator.assign(Task(set_speed=4.0))
        assert navigator.set_speed == 4.0
        assert navigator.path[:, 5].max() == pytest.approx(4.0)

    def test_a_new_speed_leaves_the_goal(self):
        navigator = navigator_at(PlaneMap([(200.0, 0.0)]), 10.0, -1.75, 0.0, Task(goal=RoadPoint("1", -1, 150.0)))
        navigator.assign(Task(set_speed=4.0))
        assert navigator.task.goal == RoadPoint("1", -1, 150.0)

    def test_a_goal_out_of_reach_is_said_and_the_lane_kept(self):
        class NoWay(PlaneMap):
            def route(self, start, goal):
                raise RouteError("no way")

        navigator = navigator_at(NoWay([(200.0, 0.0)]), 10.0, -1.75, 0.0, Task(goal=RoadPoint("1", 1, 150.0)))
        assert navigator.unreachable
        assert navigator.goal_s == math.inf
        assert navigator.path[-1, X] > 190.0

    def test_off_the_road_it_goes_straight_on(self):
        navigator = navigator_at(PlaneMap([(200.0, 0.0)]), 10.0, 40.0, 0.5)
        heading = math.atan2(*(navigator.path[-1, [Y, X]] - navigator.path[0, [Y, X]]))
        assert heading == pytest.approx(0.5)
        assert navigator.monitor is None

    def test_a_followed_lane_is_planned_on_before_it_ends(self):
        network = PlaneMap([(2000.0, 0.0)])
        navigator = navigator_at(network, 10.0, -1.75, 0.0)
        first = navigator.path
        for x in np.arange(10.0, 900.0, 2.0):
            navigator.update(Estimate(0.0, float(x), -1.75, 0.0, 5.0, 0.0, 0.0, 0.1, 0.01), True)
        assert navigator.path is not first
        assert navigator.path[-1, X] > 1100.0
        assert navigator.lateral == pytest.approx(0.0, abs=1e-6)


class TestTransforms:
    def test_a_pose_and_its_inverse_cancel(self):
        pose = Pose(3.0, -2.0, 0.7)
        assert pose.then(pose.inverse()) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)

    def test_points_go_with_their_frame(self):
        points = Pose(10.0, 5.0, math.pi / 2).apply(np.array([[2.0, 1.0]]))
        assert points[0] == pytest.approx([9.0, 7.0])

    @pytest.mark.parametrize(("angle", "wrapped"), [(3.5 * math.pi, -0.5 * math.pi), (math.pi, math.pi), (-3.0, -3.0)])
    def test_wrap(self, angle, wrapped):
        assert wrap_angle(angle) == pytest.approx(wrapped)

    def test_motion_on_an_arc(self):
        x, y, yaw = moved(0.0, 0.0, 0.0, 5.0, 0.5, 0.2)
        assert (x, y, yaw) == pytest.approx((10 * math.sin(0.1), 10 * (1 - math.cos(0.1)), 0.1), abs=1e-3)
