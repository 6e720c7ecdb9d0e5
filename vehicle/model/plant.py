"""A vehicle model made ready to run: its numbers laid out for the kernel."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.messages import TRACE_COLUMNS, FloatArray, VehicleState
from vehicle.model.kernel import COMMAND_COLUMNS, run
from vehicle.model.kernel_layout import Layout, body_kind, bus_of, check_delay, input_mode
from vehicle.model.vehicle_model import VehicleModel
from vehicle.model.wind import air_coefficients

__all__ = ["STEP", "Plant", "input_mode"]

STEP = 1e-3  # s, step of the twin
SLIPPERY = 1e-3  # least friction coefficient: without any, nothing would ever stop


class Plant:
    """The moving car: state, effect memories and command, advanced by the compiled kernel.

    `dt` [s] is the step, `every` the steps per trace row. Effects at their neutral values are left out unless
    `keep_neutral`. Raises ModelError if a dead time does not fit the delay line at this step.
    """

    def __init__(self, model: VehicleModel, *, dt: float = STEP, every: int = 10, keep_neutral: bool = False) -> None:
        self.model, self.dt, self.every = model, dt, every
        active = [a for a in model.effects if keep_neutral or not a.effect.is_off(a.values)]
        for applied in active:
            check_delay(applied.effect, applied.values, dt)
        self._layout = Layout(a.effect for a in active)
        self._parameters = self._layout.parameters({a.name: a.values for a in active})
        self._memory = np.zeros(self._layout.memory_size)
        switching = Layout(a.effect for a in active if not a.effect.is_off(a.values))
        self._kind = body_kind(model, switching)
        self._mode = input_mode(model.inputs.longitudinal)
        self._bus = bus_of(model)
        self._air = air_coefficients(model)
        self._command = np.zeros((1, len(COMMAND_COLUMNS)))
        self._trace = np.zeros((64, len(TRACE_COLUMNS)))
        self.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))

    def reset(self, state: VehicleState) -> None:
        """Put the car at `state`: steering at rest there, drive and brake without force, delay lines empty.

        What sensors make of the motion shows from the first step on; until then they show the state.
        """
        car = self.model.car
        self._bus = bus_of(self.model)
        self._clock = self._bus["t"]  # a view: asking the record for its field by name costs ten times as much
        bus = self._bus[0]
        values: dict[str, float] = {
            "t": state.t,
            "t_start": state.t,
            "dt": self.dt,
            "steer": state.steer,
            "steer_cmd": state.steer,
            "x": state.x,
            "y": state.y,
            "z": state.z,
            "yaw": state.yaw,
            "vx": state.v,
            "vy": state.vy + car.cg_to_rear_axle * state.yaw_rate,
            "vy_rear": state.vy,
            "yaw_rate": state.yaw_rate,
            "ax": state.ax,
            "ay": state.ay,
            "meas_x": state.x,
            "meas_y": state.y,
            "meas_yaw": state.yaw,
            "meas_v": state.v,
            "meas_yaw_rate": state.yaw_rate,
            "meas_ax": state.ax - car.ax_x * state.yaw_rate * state.yaw_rate,
            "meas_ay": state.ay,
        }
        for name, value in values.items():
            bus[name] = value
        self._memory[:] = 0.0
        for at, size, start in self._layout.starts:
            self._memory[at : at + size] = bus[start]
        self._command[:] = 0.0
        self._command[0, 0] = state.steer
        self._command[0, 5] = state.v

    def command(
        self, steer: float, accel: float = 0.0, throttle: float = 0.0, brake: float = 0.0, speed: float = 0.0
    ) -> None:
        """Set what holds from now on: angle [rad], acceleration [m/s^2], pedals [0..1], speed [m/s]."""
        row = self._command
        row[0, 0], row[0, 1], row[0, 2], row[0, 3], row[0, 4] = steer, accel, throttle, brake, speed

    def road(self, z: float, grade: float = 0.0, bank: float = 0.0) -> None:
        """Set the ground under the car: height [m], slope along [rad, > 0 uphill], across [rad, > 0 left side up]."""
        bus = self._bus
        bus["z"], bus["road_grade"], bus["road_bank"] = z, grade, bank

    def friction(self, friction: float | None) -> None:
        """Set the friction coefficient [-, >= 0] of the road; None: as much as the tyres need."""
        self._bus["road_friction"] = 0.0 if friction is None else max(friction, SLIPPERY)

    def wind(self, x: float, y: float) -> None:
        """Set the velocity of the air [m/s], map frame; a kinematic car feels it along only."""
        bus = self._bus
        bus["wind_x"], bus["wind_y"] = x, y
        bus["wind_drag"], bus["wind_side"] = self._air
        bus["still_drag"] = self.model.value("aero_drag", "k") or 0.0

    def advance(self, steps: int) -> FloatArray:
        """Advance by `steps` with the command held.

        Returns rows (n, 12) of TRACE_COLUMNS, in SI units, at multiples of `every` steps.
        """
        if steps // self.every + 1 > len(self._trace):
            self._trace = np.zeros((steps // self.every + 1, len(TRACE_COLUMNS)))
        rows = self._run(self._command, steps, False, self._trace)
        return self._trace[:rows].copy()

    def drive(self, commands: FloatArray, hold: int, *, measured: bool = False) -> FloatArray:
        """Advance `hold` steps with each row of `commands` (n, 6: COMMAND_COLUMNS); returns rows (m, 12) of the trace.

        With `measured`, position, heading, speed, yaw rate and accelerations are as the model's sensors show them, at
        their places (ax_x, ay_x) and with its sensor effects, not as they are at the rear axle.
        """
        trace = np.empty((len(commands) * hold // self.every + 1, len(TRACE_COLUMNS)))
        rows = self._run(np.ascontiguousarray(commands, dtype=np.float64), hold, measured, trace)
        return trace[:rows]

    def _run(self, commands: FloatArray, hold: int, measured: bool, trace: FloatArray) -> int:
        count: int = run(
            self._bus,
            self._kind,
            self._mode,
            self._layout.table,
            self._layout.bounds,
            self._parameters,
            self._memory,
            commands,
            hold,
            self.every,
            measured,
            trace,
        )
        return count

    @property
    def time(self) -> float:
        """Time now [s]."""
        return float(self._clock[0])

    @property
    def until_row(self) -> int:
        """Steps to the next trace row, at least 1."""
        return self.every - int(self._bus[0]["count"]) % self.every

    def row(self) -> FloatArray:
        """The present motion as one row (12,) of TRACE_COLUMNS, in SI units."""
        b: Any = self._bus[0]
        names = ("t", "x", "y", "z", "yaw", "vx", "vx", "vy_rear", "yaw_rate", "ax", "ay", "steer")
        return np.array([b[name] for name in names])

    def shown_row(self) -> FloatArray:
        """The present motion as the model's sensors show it, as one row (12,) of TRACE_COLUMNS, in SI units."""
        b: Any = self._bus[0]
        row = self.row()
        row[[1, 2, 4, 5, 6]] = b["meas_x"], b["meas_y"], b["meas_yaw"], b["meas_v"], b["meas_v"]
        row[8:11] = b["meas_yaw_rate"], b["meas_ax"], b["meas_ay"]
        return row

    @property
    def state(self) -> VehicleState:
        """The present motion."""
        t, x, y, z, yaw, v, vx, vy, yaw_rate, ax, ay, steer = self.row().tolist()
        return VehicleState(
            t=t, x=x, y=y, z=z, yaw=yaw, v=v, vx=vx, vy=vy, yaw_rate=yaw_rate, ax=ax, ay=ay, steer=steer
        )
