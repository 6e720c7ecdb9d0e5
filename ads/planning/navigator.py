"""Navigator: keeps the route, its reference path and the car's place on it up to date."""

from __future__ import annotations

import math

from ads.control.speed_profile import fill_speed
from ads.control.spline import project
from ads.localization import Estimate
from ads.map_monitor import MapMonitor
from ads.parameters import Parameters
from ads.planning.lane_graph import router_of
from ads.planning.route import Leg, Map, Route, continued, follow, lane_heading, to_goal
from ads.planning.waypoints import BEHIND, BEYOND, STEP, reference_path, straight_path
from ads.transforms import wrap_angle
from openscenario.road.route import RouteError
from vehicle.messages import FloatArray, RoadPoint, Task

ACCELERATION = 1.0  # m/s^2, of the speed profile
DECELERATION = 0.8  # m/s^2, of the speed profile; chosen, not measured
WINDOW = 60  # path points around the last index


class Navigator:
    """Route, reference path and progress. `path` is the reference, never shifted; `goal_s` is inf without a goal.

    `dead_end_s`: where a followed lane leads nowhere, inf if it goes on. `unreachable`: no way led to the last task.
    """

    def __init__(self, parameters: Parameters, network: Map) -> None:
        self._parameters = parameters
        self.network = network
        self._router = router_of(network)
        self.blocked: tuple[RoadPoint, ...] = ()  # places that no way leads by
        self.task = Task()
        self.route = Route((), False)
        self.path: FloatArray | None = None
        self.monitor: MapMonitor | None = None
        self.goal_s = math.inf
        self.dead_end_s = math.inf
        self.unreachable = False
        self.index = -1
        self.s = 0.0
        self.lateral = 0.0
        self._end = math.inf  # arc length where a merely followed lane was cut off
        self._stale = True

    @property
    def set_speed(self) -> float:
        """Wanted speed on a straight road [m/s]."""
        speed = self.task.set_speed
        return self._parameters.LQR_v_max if speed is None else max(speed, 0.0)

    def assign(self, task: Task) -> None:
        """Take over a new task; fields it leaves out keep their old meaning."""
        old = self.task
        if task.goal is not None or task.route:
            self.unreachable = False
            self.blocked = ()
            self.task = Task(task.set_speed if task.set_speed is not None else old.set_speed, task.goal, task.route)
            self._stale = True
        else:
            self.task = Task(task.set_speed, old.goal, old.route)
            if self.path is not None:
                self.fill(self.path)

    def avoid(self, s: float, estimate: Estimate) -> bool:
        """Take another way to the goal than over arc length `s` [m] of the path; False if there is none.

        A route whose points the task prescribes is not left.
        """
        task, monitor = self.task, self.monitor
        if monitor is None or task.goal is None or task.route or not self.route.to_goal or s > self.goal_s:
            return False
        span = next((span for span in monitor.spans if span.s_from <= s <= span.s_to), None)
        here = self.network.locate(estimate.x, estimate.y, estimate.yaw)
        if span is None or not here.on_road:
            return False
        share = (s - span.s_from) / max(span.s_to - span.s_from, 1e-6)
        leg = span.leg
        point = RoadPoint(leg.road, leg.lane, leg.s_from + share * (leg.s_to - leg.s_from))
        blocked = (*self.blocked, point)
        try:
            self._router(RoadPoint(str(here.road), int(here.lane), float(here.s)), task.goal, blocked)
        except RouteError:
            return False
        self.blocked, self._stale = blocked, True
        return True

    def fill(self, path: FloatArray) -> None:
        """Write the speed column [m/s] of a path (n, COLUMNS) of a spline for the present set speed, in place."""
        fill_speed(path, self.set_speed, self._parameters.LQR_rc_max, ACCELERATION, DECELERATION)

    def heading_hint(self, x: float, y: float) -> float | None:
        """Direction of traffic at a place [rad]; None off the road."""
        here = self.network.locate(x, y)
        return lane_heading(self.network, here.road, here.lane, here.s) if here.on_road else None

    def update(self, estimate: Estimate, may_replan: bool) -> bool:
        """Progress along the path; True if the reference path is a new one."""
        new = False
        ends_soon = self._end - self.s < self._reach() * 0.4
        if self.path is None or (may_replan and (self._stale or ends_soon)):
            self._plan(estimate)
            new = True
        assert self.path is not None
        self.index, self.s, self.lateral = project(
            self.path, estimate.x, estimate.y, round(BEHIND / STEP) if new else self.index, WINDOW
        )
        return new

    def _reach(self) -> float:
        """How much of a followed lane is planned at once [m]: at least 40 s of driving."""
        return max(400.0, 40.0 * self.set_speed)

    def _plan(self, estimate: Estimate) -> None:
        asked, self._stale = self._stale, False  # a route already driven is not driven again
        net = self.network
        here = net.locate(estimate.x, estimate.y, estimate.yaw)
        against = True
        if here.on_road:
            start = RoadPoint(str(here.road), int(here.lane), float(here.s))
            against = abs(wrap_angle(lane_heading(net, *start) - estimate.yaw)) > 0.5 * math.pi
        if against:
            self._straight(estimate)
            return
        legs: tuple[Leg, ...] = ()
        if asked and (self.task.goal is not None or self.task.route):
            try:
                legs = to_goal(lambda a, b: self._router(a, b, self.blocked), start, self.task)
            except RouteError:  # no way there: keep the lane and say so
                self.unreachable = True
        self.route = Route(legs, bool(legs))
        goal: RoadPoint | None = None
        if legs:
            goal = RoadPoint(legs[-1].road, legs[-1].lane, legs[-1].s_to)
            legs = continued(net, legs, BEYOND if self.task.goal is not None else self._reach())
        else:
            legs = follow(net, *start, self._reach())
        if not legs:
            self._straight(estimate)
            return
        path = reference_path(net, legs, self.set_speed)
        self.fill(path)
        self.path = path
        self.monitor = MapMonitor(net, legs, path)
        self.goal_s = math.inf
        if goal is not None and self.task.goal is not None:
            pose = net.lane_pose(*goal)
            travelled = BEHIND + sum(abs(leg.s_to - leg.s_from) for leg in self.route.legs)
            # near the end of the route, not an earlier pass of the same place
            _, self.goal_s, _ = project(path, pose.x, pose.y, round(travelled / STEP), 60 + len(path) // 20)
        self._end = self.dead_end_s = math.inf
        if math.isinf(self.goal_s):
            last = self.monitor.spans[-1].s_to
            if last - BEHIND > 0.9 * self._reach():
                self._end = last
            else:
                self.dead_end_s = last

    def _straight(self, estimate: Estimate) -> None:
        """Off the road: straight on, which is the best guess there is."""
        self.route = Route((), False)
        path = straight_path(estimate.x, estimate.y, estimate.yaw, self._reach() + BEHIND)
        self.fill(path)
        self.path, self.monitor = path, None
        self.goal_s = self.dead_end_s = self._end = math.inf
