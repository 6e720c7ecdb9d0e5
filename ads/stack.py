"""The stack: wires the parts; one tick turns an Observation into a Command."""

from __future__ import annotations

import math
from typing import Any, Literal

from ads.control.longitudinal import ComfortSpeedControl, SpeedControl, allowed_speed
from ads.control.pedals import Pedals, PiPedals
from ads.control.spline import SPEED, X, Y, project
from ads.control.steering import LqrSteering, Steering
from ads.input_stamps import InputStamps
from ads.localization import EkfLocalizer, Localizer
from ads.map_monitor import View
from ads.parameters import Parameters
from ads.perception.pipeline import Perception, TrackingPerception
from ads.planning.behaviour import Behaviour, Planner
from ads.planning.drawn import plain_net
from ads.planning.navigator import Navigator
from ads.planning.route import Map
from vehicle.messages import TICK, Command, Detection, FloatArray, Observation, VehicleDescription


class Stack:
    """The reference driving stack at 20 Hz; it sees observations and the map, nothing else.

    Every part can be replaced by an object of the same Protocol; `perception=None` switches perception off.
    """

    def __init__(
        self,
        parameters: Parameters,
        network: Map,
        vehicle: VehicleDescription,
        *,
        localizer: Localizer | None = None,
        perception: Perception | Literal["default"] | None = "default",
        planner: Planner | None = None,
        steering: Steering | None = None,
        speed_control: SpeedControl | None = None,
        pedals: Pedals | None = None,
    ) -> None:
        self.parameters = parameters
        self.vehicle = vehicle
        self.navigator = Navigator(parameters, network)
        self.localizer: Localizer = localizer or EkfLocalizer(vehicle, self.navigator.heading_hint)
        self.perception: Perception | None = (
            TrackingPerception(parameters, vehicle, self.navigator.heading_hint)
            if perception == "default"
            else perception
        )
        self.planner: Planner = planner or Behaviour(parameters, vehicle)
        self.steering: Steering = steering or LqrSteering(parameters, vehicle)
        self.speed_control: SpeedControl = speed_control or ComfortSpeedControl(vehicle, TICK)
        self.pedals: Pedals = pedals or PiPedals(vehicle)
        self.trace: dict[str, float] = {}
        self._stamps = InputStamps()
        self.detections: tuple[Detection, ...] = ()
        self._path: FloatArray | None = None
        self._shape: FloatArray | None = None
        self._signals: dict[str, str] = {}

    @property
    def nets(self) -> list[dict[str, Any]]:
        """The nets of the behaviour as plain data, for a report; a planner of another kind has none."""
        return [plain_net(net) for net in self.planner.nets] if isinstance(self.planner, Behaviour) else []

    @property
    def path(self) -> FloatArray | None:
        """Planned path (n, 2) [m]; the same object until it is planned anew, None before the first plan."""
        return self._shape

    @property
    def view(self) -> View | None:
        """What the map holds ahead of the car now; None off the road and before the first fix."""
        monitor = self.navigator.monitor
        return None if monitor is None else monitor.view(self.navigator.s, self._signals)

    def tick(self, observation: Observation) -> Command:
        """One step of the stack. Call it every TICK seconds with all that arrived since the last call."""
        t, stamps = observation.t, self._stamps.update(observation)
        navigator, planner = self.navigator, self.planner
        if observation.task is not None:
            navigator.assign(observation.task)
        for signal in observation.signals:
            self._signals[signal.id] = signal.state
        estimate = self.localizer.update(observation)
        if estimate is None:  # nothing is known yet: keep rolling, straight on
            return Command(t, 0.0, 0.0, 0.0, 0.0)
        if self.perception is not None:
            self.detections = self.perception.update(observation, estimate)
        new = navigator.update(estimate, planner.may_replan())
        decision = planner.step(estimate, navigator, new, self.detections, observation.signals)
        path, index, s, monitor = decision.path, navigator.index, navigator.s, navigator.monitor
        if path is not self._path:
            self._path, self._shape = path, path[:, X : Y + 1].copy()
        accel, standing = self.speed_control.step(estimate, path, index, s, decision.limits, decision.brake)
        steer = self.steering.steer(estimate, path, index)
        throttle, brake = self.pedals.press(accel, estimate.v, standing, TICK)
        self.trace = {
            "x": estimate.x,
            "y": estimate.y,
            "yaw": estimate.yaw,
            "v": estimate.v,
            "position_sigma": estimate.position_sigma,
            "path_error": float(project(path, estimate.x, estimate.y, index, 10)[2]),
            "target_speed": allowed_speed(float(path[index, SPEED]), estimate.v, decision.limits),
            "lane_width": math.nan if monitor is None else 2.0 * monitor.half_width(s),
            **stamps,
            **(self.localizer.consistency if isinstance(self.localizer, EkfLocalizer) else {}),
            **planner.trace,
        }
        return Command(t, steer, accel, throttle, brake)
