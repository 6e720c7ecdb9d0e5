"""The digital twin: a vehicle model and its sensors behind the Vehicle protocol, in simulated time."""

from __future__ import annotations

from collections.abc import Collection
from math import isfinite

import numpy as np

from vehicle.messages import (
    Command,
    FloatArray,
    Observation,
    Surroundings,
    Task,
    VehicleDescription,
    VehicleState,
    brake_first,
)
from vehicle.model.errors import ModelError
from vehicle.model.plant import STEP, Plant
from vehicle.model.vehicle_model import VehicleModel
from vehicle.sensors.perceived import Perceived
from vehicle.sensors.suite import SensorSuite


class Twin:
    """A simulated car. Same model, sensors, seed and calls: same bytes.

    What the model's sensor effects do to pose, speed, yaw rate and accelerations, its GNSS, odometry and IMU show too:
    they measure what the effects make of the motion, at its stamp, each at its own mount (ax_x and ay_x of the model
    are places of the car's log). LiDAR and camera look around from the true pose, at what the model's perception
    effects make of the road users (`vehicle.sensors.perceived`).

    It integrates at 1 kHz and returns motion at 100 Hz. `seed` starts the generators of the sensors, one each.
    `reads` names the sensors that somebody reads, as `Observation` does; the others stay silent. None: all work.
    Raises ModelError if the model cannot run at this step or takes other inputs than a Command has.
    """

    is_real = False

    def __init__(
        self, model: VehicleModel, sensors: SensorSuite, seed: int = 0, reads: Collection[str] | None = None
    ) -> None:
        if not model.inputs.by_a_stack:
            raise ModelError(
                "a driving stack cannot drive this model",
                key="inputs.longitudinal",
                found=" + ".join(model.inputs.longitudinal),
                allowed="accel_cmd, throttle_cmd + brake_cmd",
            )
        self.model, self.sensors, self.seed, self._reads = model, sensors, seed, reads
        self._plant = Plant(model.with_car({"ax_x": 0.0, "ay_x": 0.0}))
        self._shows = any(a.effect.slot == "sensor" and not a.effect.is_off(a.values) for a in model.effects)
        self._description = sensors.describe(model.description())
        self._task: Task | None = None
        self.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))

    @property
    def description(self) -> VehicleDescription:
        """Size, axles, limits and sensor mounting."""
        return self._description

    @property
    def state(self) -> VehicleState:
        """The true motion now."""
        return self._plant.state

    def reset(self, state: VehicleState) -> None:
        """Put the car at `state` with empty actuators; sensors start anew from the seed."""
        self._plant.reset(state)
        row = self._plant.row().tolist()
        self._t: float = row[0]
        self._steer = state.steer
        self._running = self.sensors.start(row, self.seed, self._reads)
        self._perceived = Perceived(self.model.effects, self.seed)

    def give_task(self, task: Task) -> None:
        """Hand over what the ego is asked to do; the next observation carries it."""
        self._task = task

    def place_on_road(self, z: float, grade: float = 0.0, bank: float = 0.0) -> None:
        """Say what is under the wheels: height [m], slope along [rad, > 0 uphill], across [rad, > 0 left side up]."""
        self._plant.road(z, grade, bank)

    def limit_friction(self, friction: float | None) -> None:
        """Say the friction coefficient [-, >= 0] of the road; None: the road that the model was made for."""
        self._plant.friction(friction)

    def blow(self, x: float, y: float) -> None:
        """Say how the air moves [m/s, map frame]; 0, 0: no wind."""
        self._plant.wind(x, y)

    def observe(self, surroundings: Surroundings) -> Observation:
        """Everything the sensors delivered since the last call."""
        task, self._task = self._task, None
        if self._perceived.changes:
            state = self._plant.state
            surroundings = self._perceived.seen(self._t, state.x, state.y, state.yaw, surroundings, state.z)
        return self._running.observe(self._t, surroundings, task)

    def apply(self, command: Command) -> None:
        """Hold a command from now on. Raises ValueError, naming the field, if a value is not finite."""
        steer, accel, throttle, brake = command.steer, command.accel, command.throttle, command.brake
        if not (isfinite(steer) and isfinite(accel) and isfinite(throttle) and isfinite(brake)):
            values = {"steer": steer, "accel": accel, "throttle": throttle, "brake": brake}
            wrong = ", ".join(f"{name} = {value}" for name, value in values.items() if not isfinite(value))
            raise ValueError(f"command at t = {command.t:.3f} s is not finite: {wrong}")
        self._steer = steer
        obeyed = brake_first(command, self.description.max_deceleration)
        self._plant.command(steer, obeyed.accel, obeyed.throttle, brake)

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s] pass (a multiple of 1 ms). Returns rows (n, 12) of TRACE_COLUMNS at 100 Hz, oldest first.

        Raises ValueError if `dt` is not a positive multiple of the 1 ms step.
        """
        steps = round(dt / STEP)
        if steps < 1 or abs(steps * STEP - dt) > 1e-9:
            raise ValueError(f"dt = {dt!r} s is not a positive multiple of {STEP} s")
        rows = self._shown(steps) if self._shows else self._plant.advance(steps)
        if not self._shows:
            self._running.feed(rows.tolist())
        self._t = self._plant.time
        return rows

    def _shown(self, steps: int) -> FloatArray:
        """Advance from trace row to trace row, as what the sensor effects show of a moment is gone after it."""
        plant, parts = self._plant, []
        while steps:
            part = min(plant.until_row, steps)
            rows = plant.advance(part)
            parts.append(rows)
            if len(rows):
                self._running.feed([plant.shown_row().tolist()], rows[-1].tolist())
            steps -= part
        return np.concatenate(parts)

    def stop(self) -> None:
        """Brake with all the model has, steering as last commanded."""
        full = self.model.inputs.full_brake
        self._plant.command(self._steer, -full, 0.0, 1.0)

    def close(self) -> None:
        """Nothing to free."""
