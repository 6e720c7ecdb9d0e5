"""The stack: wires the parts; one tick turns an Observation into a Command."""

from __future__ import annotations

from typing import Final

from ads.control.longitudinal import ComfortSpeedControl, SpeedControl
from ads.control.pedals import Pedals, PiPedals
from ads.control.spline import X, Y
from ads.control.steering import LqrSteering, Steering
from ads.localization import EkfLocalizer, Localizer
from ads.parameters import Parameters
from ads.planning.navigator import Navigator
from ads.planning.route import Map
from vehicle.messages import Command, Detection, FloatArray, Observation, VehicleDescription

TICK: Final = 0.05  # s


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
        steering: Steering | None = None,
        speed_control: SpeedControl | None = None,
        pedals: Pedals | None = None,
    ) -> None:
        self.parameters = parameters
        self.vehicle = vehicle
        self.navigator = Navigator(parameters, network)
        self.localizer = localizer or EkfLocalizer(vehicle, self.navigator.heading_hint)
        self.steering = steering or LqrSteering(parameters, vehicle)
        self.speed_control = speed_control or ComfortSpeedControl(vehicle, TICK)
        self.pedals = pedals or PiPedals(vehicle)
        self.trace: dict[str, float] = {}
        self.detections: tuple[Detection, ...] = ()
        self._path: FloatArray | None = None
        self._shape: FloatArray | None = None

    @property
    def path(self) -> FloatArray | None:
        """Planned path (n, 2) [m]; the same object until it is planned anew, None before the first plan."""
        return self._shape

    def tick(self, observation: Observation) -> Command:
        """One step of the stack. Call it every TICK seconds with all that arrived since the last call."""
        t = observation.t
        navigator = self.navigator
        if observation.task is not None:
            navigator.assign(observation.task)
        estimate = self.localizer.update(observation)
        if estimate is None:
            return Command(t, 0.0, 0.0, 0.0, 0.0)
        if navigator.update(estimate, True):
            self._use(navigator.path)
        path, index, s = self._path, navigator.index, navigator.s
        assert path is not None
        limits: list[tuple[float, float]] = []
        if navigator.goal_s < 1e9:
            limits.append((navigator.goal_s - s, 0.0))
        accel, standing = self.speed_control.step(estimate, path, index, s, limits, 0.0)
        steer = self.steering.steer(estimate, path, index)
        throttle, brake = self.pedals.press(accel, estimate.v, standing, TICK)
        self.trace = {
            "x": estimate.x,
            "y": estimate.y,
            "yaw": estimate.yaw,
            "v": estimate.v,
            "path_error": navigator.lateral,
            "target_speed": float(path[index, 5]),
        }
        return Command(t, steer, accel, throttle, brake)

    def _use(self, path: FloatArray | None) -> None:
        assert path is not None
        self._path = path
        self._shape = path[:, X : Y + 1].copy()
