"""A drive of a foreign car: a driver of its own, the bodies stepped at 1 kHz, the log at 50 Hz."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from benchmarks.foreign_cars.car import GRAVITY, WHEELS, ForeignCar, mjcf
from benchmarks.foreign_cars.hidden import Controls, Values, changed, sensed
from benchmarks.foreign_cars.loads import apply_loads
from benchmarks.foreign_cars.tyres import FloatArray
from pytest_dvp.logs.log import Log

PERIOD, STEP, SUBSTEPS = 0.02, 0.001, 20  # s
AIR = 0.6  # kg/m^3, half the density
NOISE = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
LEVELS = {"none": 0.0, "low": 0.5, "mid": 1.0, "high": 2.0}
Kind = Literal["rich", "town"]
DURATION = {"rich": 110.0, "town": 90.0}


class Driver:
    """Speeds and steering patterns by dice; he turns back where he gets far."""

    def __init__(self, kind: Kind, car: ForeignCar, seed: int) -> None:
        self._rng = np.random.default_rng([seed, len(kind)])
        self._top, self._sideways = (20.0, 4.0) if kind == "rich" else (13.0, 2.5)
        self._wheelbase = car.wheelbase
        self._speed, self._until = 0.0, 2.0
        self._pattern, self._pattern_from, self._pattern_until = 0, 0.0, 2.0
        self._drives, self._brakes, self._size, self._beat = 2.0, 2.0, 0.0, 0.3
        self._coasts = self._steer = 0.0

    def command(self, t: float, x: float, y: float, yaw: float, v: float) -> tuple[float, float]:
        """Wanted acceleration [m/s^2] and angle of the road wheels [rad]."""
        rng = self._rng
        if t >= self._until:
            self._speed = self._top * float(rng.choice([0.0, 0.0, 0.25, 0.5, 0.7, 0.85, 1.0]))
            self._until = t + float(rng.uniform(2.5, 6.0))
            self._drives, self._brakes = float(rng.uniform(0.8, 3.2)), float(rng.uniform(1.0, 4.5))
        if t >= self._pattern_until:
            self._pattern, self._pattern_from = int(rng.integers(0, 5)), t
            self._pattern_until = t + float(rng.uniform(3.0, 8.0))
            self._size, self._beat = float(rng.uniform(0.3, 1.0) * rng.choice([-1, 1])), float(rng.uniform(0.15, 0.8))
        return self._pedals(v), self._wheel(t, x, y, yaw, v)

    def _pedals(self, v: float) -> float:
        error = self._speed - v
        if self._speed == 0.0:
            return -self._brakes if v > 0.3 else -1.5
        if abs(error) > 0.6:
            return float(np.clip(1.2 * error, -self._brakes, self._drives))
        self._coasts = self._coasts - 1.0 if self._coasts > 0.0 else 50.0 * (self._rng.random() < 0.004)
        return 0.0 if self._coasts > 0.0 else 0.8 * error

    def _wheel(self, t: float, x: float, y: float, yaw: float, v: float) -> float:
        most = min(0.45, self._sideways * self._wheelbase / max(v, 1.5) ** 2)
        since = t - self._pattern_from
        share = {
            0: 0.0,
            1: self._size,
            2: self._size * np.sin(2.0 * np.pi * self._beat * since),
            3: self._size * (since > 1.0),
            4: self._size * min(since / 3.0, 1.0),
        }[self._pattern]
        if np.hypot(x, y) > 150.0:
            back = np.arctan2(-y, -x) - yaw
            share = 0.7 * np.clip(np.arctan2(np.sin(back), np.cos(back)), -1.0, 1.0)
        self._steer += float(np.clip(most * share - self._steer, -0.02, 0.02))
        return self._steer


class Bodies:
    """The car in MuJoCo; `step` moves it on by a millisecond."""

    def __init__(self, car: ForeignCar, sheet: ForeignCar) -> None:
        import mujoco

        self._mujoco: Any = mujoco
        self.car, self._sheet = car, sheet
        self.model: Any = mujoco.MjModel.from_xml_string(mjcf(car))
        self.data: Any = mujoco.MjData(self.model)
        m, d = self.model, self.data
        self._chassis = m.body("chassis").id
        self._spin = np.array([m.joint(f"spin_{n}").dofadr[0] for n in WHEELS], dtype=np.int64)
        slides, steered = [m.joint(f"slide_{n}") for n in WHEELS], [m.joint(f"steer_{n}") for n in WHEELS[:2]]
        places = [[j.qposadr[0] for j in slides], [j.dofadr[0] for j in slides],
                  [*(j.qposadr[0] for j in steered), *(j.dofadr[0] for j in steered)]]  # fmt: skip
        bodies = [[m.body(f"wheel_{n}").id for n in WHEELS], [m.body(f"carrier_{n}").id for n in WHEELS]]
        load = 0.25 * (car.mass + car.payload) * GRAVITY
        shape = np.array([car.wheel_radius, car.friction, *car.lateral, *car.longitudinal, load])
        # MuJoCo keeps its arrays in place, so that the loads are worked out on them without a copy.
        self._loads = (
            d.qpos, d.qvel, d.xpos, d.xmat, d.cvel, d.subtree_com, d.qfrc_applied, d.xfrc_applied,
            np.array([*bodies, self._spin, *places], dtype=np.int64), self._chassis, np.zeros((4, 2)), np.zeros((4, 3)),
            np.zeros((4, 3)), shape,
            np.array([*car.drive, car.brake_front, sheet.wheel_radius, car.rolling, car.wheel_radius,
                      car.anti_roll * (car.arm or 1.0) ** 2, AIR * car.drag_area,
                      car.ackermann * 0.5 * car.track / car.wheelbase]),
        )  # fmt: skip
        mujoco.mj_forward(self.model, self.data)

    @property
    def spin(self) -> FloatArray:
        """Speeds of the wheels (4,) [rad/s]."""
        return np.asarray(self.data.qvel[self._spin])

    @property
    def pose(self) -> tuple[float, float, float, float]:
        """x, y of the chassis [m], yaw [rad], speed over ground [m/s]."""
        turn = self.data.xmat[self._chassis]
        v = float(np.hypot(*self.data.qvel[:2]))
        return float(self.data.qpos[0]), float(self.data.qpos[1]), float(np.arctan2(turn[3], turn[0])), v

    def load(self, drive: float, brake: float, steer: float) -> None:
        """Forces for the next step: of drive and brakes [N], the servo towards an angle [rad], tyres and air."""
        apply_loads(drive, brake, steer, STEP, *self._loads)

    def shown(self) -> tuple[float, ...]:
        """x, y of the ground point of the rear axle, yaw, wheel speed, yaw rate, ax, ay at the centre of gravity."""
        self._mujoco.mj_forward(self.model, self.data)
        d, car = self.data, self._sheet
        turn = d.xmat[self._chassis].reshape(3, 3)
        rear = d.xpos[self._chassis] + turn @ np.array([-car.cg_to_rear_axle, 0.0, -car.cg_height])
        felt = turn.T @ (d.qacc[:3] - self.model.opt.gravity)
        pair = slice(0, 2) if car.measures_front else slice(2, 4)
        speed = float(np.mean(self.spin[pair])) * car.wheel_radius
        yaw = float(np.arctan2(turn[1, 0], turn[0, 0]))
        return float(rear[0]), float(rear[1]), yaw, speed, float(d.qvel[5]), float(felt[0]), float(felt[1])

    def lean(self, hill: Mapping[str, float]) -> None:
        """Gravity as it is felt on the slope of a hill, in the frame of the ground, which is taken as plane: a hill so
        long bends too little to press the car up or down."""
        x, y, _, _ = self.pose
        ahead, left = (x - hill["x"]) / hill["length"], (y - hill["y"]) / hill["length"]
        fall = -hill["height"] / hill["length"] * np.exp(-0.5 * (ahead * ahead + left * left))
        slope = np.array([fall * ahead, fall * left, 1.0])
        self.model.opt.gravity[:] = -GRAVITY * slope / np.linalg.norm(slope)

    def step(self) -> None:
        """A millisecond on."""
        self._mujoco.mj_step(self.model, self.data)


def driven(
    car: ForeignCar, kind: Kind, seed: int, hidden: Values | None = None, *, duration: float | None = None,
    commands: FloatArray | None = None,
) -> dict[str, FloatArray]:  # fmt: skip
    """Commands and the true motion at 50 Hz; `commands` (n, 2) take the place of the driver's."""
    hidden = hidden or {}
    bodies, controls = Bodies(changed(car, hidden), car), Controls(hidden)
    driver = Driver(kind, car, seed)
    n = round((duration or DURATION[kind]) / PERIOD)
    rows, given = np.empty((n, 7)), np.empty((n, 2))
    motor = brake = angle = 0.0
    motor_share = STEP / (car.torque_lag + controls.value("drive_lag", "tau", 0.0))
    brake_share = STEP / (car.brake_lag + controls.value("brake_lag", "tau", 0.0))
    steer_lag = controls.value("steer_lag", "tau", 0.0)
    accel_late = round(controls.value("drive_delay", "T", 0.0) / STEP)  # steps of 1 ms: commands come between samples
    steer_late = round(controls.value("steer_delay", "T", 0.0) / STEP)
    asked = np.empty((n, 2))
    for k in range(n):
        x, y, yaw, v = bodies.pose
        given[k] = driver.command(k * PERIOD, x, y, yaw, v) if commands is None else commands[k]
        if "road_profile" in hidden:
            bodies.lean(hidden["road_profile"])
        asked[k] = controls.asked(float(given[k, 0]), float(given[k, 1]), v)
        for j in range(SUBSTEPS):
            now = k * SUBSTEPS + j
            accel = float(asked[max(now - accel_late, 0) // SUBSTEPS, 0])
            steer = float(asked[max(now - steer_late, 0) // SUBSTEPS, 1])
            motor += motor_share * (car.mass * max(accel, 0.0) - motor)
            brake += brake_share * (car.mass * max(-accel, 0.0) - brake)
            controls.heat(brake / car.mass, v, STEP)
            angle += (STEP / steer_lag if steer_lag > 0.0 else 1.0) * (steer - angle)
            bodies.load(motor, brake, angle)
            if j == 0:
                rows[k] = bodies.shown()
            bodies.step()
    rows[:, 2] = np.unwrap(rows[:, 2])
    names = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay")
    found = {name: np.ascontiguousarray(rows[:, k]) for k, name in enumerate(names)}
    return {"t": PERIOD * np.arange(n), "accel_cmd": given[:, 0].copy(), "steer_cmd": given[:, 1].copy(), **found}


def make_log(car: ForeignCar, kind: Kind, seed: int, noise: str = "mid", hidden: Values | None = None) -> Log:
    """The log of a drive, with white noise of a level of LEVELS."""
    return logged(driven(car, kind, seed, hidden), seed, noise, hidden)


def logged(truth: Mapping[str, FloatArray], seed: int, noise: str, hidden: Values | None = None) -> Log:
    """The log of what a car did (`driven`), with the faults of its sensors and white noise."""
    shown = sensed(truth, hidden or {})
    rng = np.random.default_rng([seed, 17])
    noisy = {name: y + LEVELS[noise] * NOISE[name] * rng.normal(size=len(y)) for name, y in shown.items()}
    return Log({"t": truth["t"], "accel_cmd": truth["accel_cmd"], "steer_cmd": truth["steer_cmd"], **noisy})
