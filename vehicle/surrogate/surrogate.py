"""The surrogate car as an object that is stepped: commands in, truth and measurements out."""

from __future__ import annotations

import math

import numpy as np

from vehicle.messages import Command, FloatArray, VehicleDescription, VehicleState, brake_first
from vehicle.surrogate.double_track import (
    A_JERK,
    A_LAG,
    CAR_AT,
    D_LAG,
    D_REST,
    N_STATE,
    RING,
    ROW,
    STEPS,
    VX,
    VY,
    W0,
    WORK,
    R,
    X,
    Y,
    advance,
    parameters,
)
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.sensors import MEMORY, Sensors

STEP = 1e-3  # s
TRACE_EVERY = 0.01  # s between two rows that `step` returns
MEASURED_UNITS = {
    "x": "m",
    "y": "m",
    "yaw": "rad",
    "v": "m/s",
    "yaw_rate": "rad/s",
    "ax": "m/s^2",
    "ay": "m/s^2",
}


class DoubleTrack:
    """A double-track car with hidden effects.

    `hidden` the car and what is hidden; `seed` of the sensor noise; `step` [s] of the integration; `pedals` whether
    throttle and brake drive it in place of the wanted acceleration. Same seed and commands, same bytes.

    Life: `reset`, then per tick `measure`, `apply`, `step`.
    """

    def __init__(self, hidden: Hidden | None = None, *, seed: int = 0, step: float = STEP, pedals: bool = False):
        self.hidden = hidden or Hidden()
        self.dt = step
        self.pedals = pedals
        self._seed = seed
        self._p = parameters(self.hidden)
        self._s = np.zeros(N_STATE)
        self._ring = np.zeros((RING, 2))
        self._steer = self._accel = 0.0
        self._rows = np.zeros((0, len(ROW)))
        self._memory = round(MEMORY / step)
        self._sensors = Sensors(self.hidden, seed, step)
        self.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))

    @property
    def description(self) -> VehicleDescription:
        """Size and limits of the car."""
        car = self.hidden.car
        return VehicleDescription(
            length=3.03,
            width=1.488,
            height=1.38,
            wheelbase=car.wheelbase,
            center_x=0.5 * car.wheelbase,
            max_steer=math.radians(20.0),
            max_speed=car.motor_speed / car.gear_ratio * car.wheel_radius,
            max_acceleration=car.motor_torque * car.gear_ratio / car.wheel_radius / car.mass,
            max_deceleration=car.full_brake,
            mass=car.mass,
        )

    @property
    def time(self) -> float:
        """Time now [s]."""
        return self._t0 + float(self._s[STEPS]) * self.dt

    @property
    def work(self) -> float:
        """Work of the motor since reset [J]."""
        return float(self._s[WORK])

    @property
    def energy(self) -> float:
        """Kinetic energy of body, wheels and motor [J]."""
        s, p, car = self._s, self._p, self.hidden.car
        mass = car.mass * self.hidden.value("mass", "ratio")
        yaw = car.yaw_inertia * self.hidden.value("yaw_inertia", "ratio")
        body = 0.5 * mass * (s[VX] ** 2 + s[VY] ** 2) + 0.5 * yaw * s[R] ** 2
        spin = s[W0 : W0 + 4]
        wheels = 0.5 * p[CAR_AT["wheel_inertia"]] * np.sum(spin**2)
        motor = 0.25 * car.motor_inertia * car.gear_ratio**2 * np.sum(spin[2:] ** 2)
        return float(body + wheels + motor)

    @property
    def wheel_loads(self) -> FloatArray:
        """Loads of the last step [N], float64 (4,): front left, front right, rear left, rear right."""
        return self._s[32:36].copy()

    @property
    def lean(self) -> tuple[float, float]:
        """Roll (> 0 to the right) and pitch (> 0 nose down) [rad]."""
        return float(self._s[6]), float(self._s[8])

    @property
    def state(self) -> VehicleState:
        """True motion of the rear axle's ground point now; accelerations are those of the last step."""
        s = self._s
        b = self.hidden.car.wheelbase - self.hidden.car.cg_to_front_axle
        yaw, vx, r = float(s[2]), float(s[VX]), float(s[R])
        return VehicleState(
            t=self.time,
            x=float(s[X]) - b * math.cos(yaw),
            y=float(s[Y]) - b * math.sin(yaw),
            yaw=yaw,
            v=vx,
            vx=vx,
            vy=float(s[VY]) - b * r,
            yaw_rate=r,
            ax=float(self._history[-1, 6]),
            ay=float(self._history[-1, 7]),
            steer=float(self._history[-1, 8]),
        )

    def reset(self, state: VehicleState) -> None:
        """Stand (or roll straight on) at `state` with empty actuators and sensors."""
        b = self.hidden.car.wheelbase - self.hidden.car.cg_to_front_axle
        s = self._s
        s[:] = 0.0
        s[X], s[Y], s[2] = state.x + b * math.cos(state.yaw), state.y + b * math.sin(state.yaw), state.yaw
        s[VX] = state.v
        s[W0 : W0 + 4] = state.v / self.hidden.car.wheel_radius
        s[D_LAG : D_LAG + 5] = state.steer
        s[D_REST] = state.steer
        s[A_LAG] = s[A_JERK] = 0.0
        self._ring[:] = 0.0
        self._steer, self._accel = state.steer, 0.0
        self._t0 = state.t
        row = np.zeros(len(ROW))
        row[0], row[1], row[2], row[3], row[8], row[11] = state.x, state.y, state.yaw, state.v, state.steer, state.v
        self._history = np.tile(row, (self._memory, 1))
        self._sensors = Sensors(self.hidden, self._seed, self.dt)

    def apply(self, command: Command) -> None:
        """Hand over a command; it holds until the next one."""
        self._steer = command.steer
        command = brake_first(command, self.hidden.car.full_brake)
        if self.pedals:
            car = self.hidden.car
            throttle, brake = min(max(command.throttle, 0.0), 1.0), min(max(command.brake, 0.0), 1.0)
            self._accel = car.full_throttle * throttle - car.full_brake * brake
        else:
            self._accel = command.accel

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s], a multiple of 10 ms, pass. Returns rows (n, 12) of `vehicle.messages.TRACE_COLUMNS` at 100 Hz.

        A row stands at the begin of its 10 ms, with the command that holds from there. Raises ValueError on another dt.
        """
        n = round(dt / self.dt)
        every = round(TRACE_EVERY / self.dt)
        if n <= 0 or n % every or abs(n * self.dt - dt) > 1e-9:
            raise ValueError(f"a step of {dt:g} s is no multiple of {TRACE_EVERY:g} s")
        if len(self._rows) != n:
            self._rows = np.empty((n, len(ROW)))
        t = self.time
        advance(self._s, self._p, self._ring, self._steer, self._accel, n, self.dt, self._rows)
        self._history = np.concatenate([self._history, self._rows])[-self._memory :]
        part = self._rows[::every]
        trace = np.zeros((len(part), 12))
        trace[:, 0] = t + np.arange(len(part)) * TRACE_EVERY
        trace[:, [1, 2, 4, 5, 6]] = part[:, [0, 1, 2, 3, 3]]
        trace[:, 7:12] = part[:, 4:9]
        return trace

    def measure(self, back: float = 0.0) -> dict[str, float]:
        """What its sensors show, with noise: x, y, yaw, v, yaw_rate, ax, ay (MEASURED_UNITS).

        Of the begin of the last step of integration, or of `back` [s] before that (up to 0.05 s). Call it with growing
        time, once a sample: noise is drawn each time.
        """
        return self._sensors.show(self._history[: len(self._history) - round(back / self.dt)])
