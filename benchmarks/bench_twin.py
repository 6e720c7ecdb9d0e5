"""Speed of the digital twin: kernel, log evaluation, LiDAR, camera, one closed-loop tick."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import odeint

from benchmarks.measure import Row, cpu_seconds
from vehicle.messages import Command, Surroundings, VehicleState
from vehicle.model.car import make_car
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import read_model
from vehicle.model.open_loop import Replay
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import Inputs, VehicleModel
from vehicle.sensors import default_sensors
from vehicle.twin import Twin

MODEL = Path(__file__).parents[1] / "scenarios" / "models" / "tabby_evo.toml"
STEPS = 100_000


def _single_track(state: Any, _t: float, p: tuple[float, ...]) -> list[float]:
    """Right-hand side in plain Python, as CommonRoad's vehicle models are written."""
    _x, _y, yaw, vx, vy, r, d = state
    front, rear, cf, cr, m, inertia = p
    force_f = cf * (d - math.atan2(vy + front * r, vx))
    force_r = cr * -math.atan2(vy - rear * r, vx)
    along = math.cos(yaw) * vx - math.sin(yaw) * vy
    across = math.sin(yaw) * vx + math.cos(yaw) * vy
    turn = (front * force_f - rear * force_r) / inertia
    return [along, across, r, 0.0, (force_f + force_r) / m - vx * r, turn, 0.0]


@njit(cache=True)
def _rate(s: Any, p: Any, out: Any) -> None:
    force_f = p[2] * (s[6] - math.atan2(s[4] + p[0] * s[5], s[3]))
    force_r = p[3] * -math.atan2(s[4] - p[1] * s[5], s[3])
    c, n = math.cos(s[2]), math.sin(s[2])
    out[0], out[1], out[2], out[3] = s[3] * c - s[4] * n, s[3] * n + s[4] * c, s[5], 0.0
    out[4], out[6] = (force_f + force_r) / p[4] - s[3] * s[5], 0.0
    out[5] = (p[0] * force_f - p[1] * force_r) / p[5]


@njit(cache=True)
def _hand_written(s: Any, p: Any, dt: float, steps: int) -> float:
    """RK4 of the same car as one hand-written loop without effects: what the effect slots are measured against."""
    k1, k2, k3, k4, y = np.empty(7), np.empty(7), np.empty(7), np.empty(7), np.empty(7)
    for _ in range(steps):
        _rate(s, p, k1)
        for i in range(7):
            y[i] = s[i] + 0.5 * dt * k1[i]
        _rate(y, p, k2)
        for i in range(7):
            y[i] = s[i] + 0.5 * dt * k2[i]
        _rate(y, p, k3)
        for i in range(7):
            y[i] = s[i] + dt * k3[i]
        _rate(y, p, k4)
        for i in range(7):
            s[i] += dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
    return float(s[0])


def _numpy_scan(boxes: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Every ray against every box by slabs, in numpy."""
    c, s = np.cos(boxes[:, 3]), np.sin(boxes[:, 3])
    ox, oy = -(c * boxes[:, 0] + s * boxes[:, 1]), s * boxes[:, 0] - c * boxes[:, 1]
    bx = rays[:, :1] * c + rays[:, 1:] * s + 1e-300
    by = -rays[:, :1] * s + rays[:, 1:] * c + 1e-300
    x1, x2 = (-boxes[:, 4] / 2 - ox) / bx, (boxes[:, 4] / 2 - ox) / bx
    y1, y2 = (-boxes[:, 5] / 2 - oy) / by, (boxes[:, 5] / 2 - oy) / by
    near = np.maximum(np.minimum(x1, x2), np.minimum(y1, y2))
    far = np.minimum(np.maximum(x1, x2), np.maximum(y1, y2))
    found: np.ndarray = np.where((near <= far) & (near > 0), near, np.inf).min(axis=1)
    return found


def _world(count: int) -> Surroundings:
    rng = np.random.default_rng(3)
    bearing, distance = rng.uniform(-np.pi, np.pi, count), rng.uniform(6.0, 50.0, count)
    boxes = np.zeros((count, 9))
    boxes[:, 0], boxes[:, 1], boxes[:, 2] = distance * np.cos(bearing), distance * np.sin(bearing), 0.75
    boxes[:, 3] = rng.uniform(-np.pi, np.pi, count)
    boxes[:, 4:7] = 4.2, 1.8, 1.5
    return Surroundings(boxes, np.zeros(count, dtype=np.int64), tuple(f"car {i}" for i in range(count)))


def _kernel_rows() -> list[Row]:
    model = read_model(MODEL)
    car = model.car
    p = (
        car.cg_to_front_axle,
        car.cg_to_rear_axle,
        car.cornering_stiffness_front,
        car.cornering_stiffness_rear,
        car.mass,
        car.yaw_inertia,
    )
    start = np.array([0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.05])
    loop = STEPS / 1e6 / cpu_seconds(lambda: _hand_written(start.copy(), np.array(p), 1e-3, STEPS))

    def restarted() -> None:  # a new command every 50 ms, as in a closed loop
        state = start
        for k in range(100):
            state = odeint(_single_track, [*state[:6], 0.05 + 0.001 * (k % 2)], (0.0, 0.05), args=(p,))[-1]

    by_odeint = 5.0 / cpu_seconds(restarted)

    def speed(found: Any) -> float:
        plant = Plant(found)
        plant.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=8.0, steer=0.05))
        plant.command(0.05, throttle=0.1)
        return STEPS / 1e6 / cpu_seconds(lambda: plant.advance(STEPS))

    full, bare = speed(model), speed(replace(model, effects=()))
    effects = f"{len(model.effects)} effects"
    return [
        Row("twin, TABBY EVO", full, "M steps/s", ">= 5", "hand-written numba RK4, no effects", loop, effects),
        Row("twin, no effects", bare, "M steps/s", ">= 5", "hand-written numba RK4, no effects", loop),
        Row(
            "twin, TABBY EVO at 1 kHz",
            full * 1e3,
            "s/s",
            ">= 3x",
            "scipy odeint, Python",
            by_odeint,
            "new command every 50 ms",
        ),
    ]


def _log_rows() -> list[Row]:
    """Commands of a log to what it would show: nothing active, what a diagnosis tries most, tyres, and all at once."""
    base = VehicleModel("kinematic_bicycle", Inputs(), make_car({"wheelbase": 2.45, "mass": 1150.0}))
    n = 8250
    t = np.arange(n) * 0.02
    commands = {"steer_cmd": 0.1 * np.sin(t), "accel_cmd": 2.0 * np.sign(np.sin(0.4 * t))}
    starts = np.arange(0, n, 250)
    states = np.full((len(starts), 6), np.nan)
    states[:, :4] = 0.0, 0.0, 0.0, 8.0
    replay = Replay(base, t, commands)
    many = {
        (e.name, k.name): k.low + 0.4 * (k.high - k.low)
        for e in catalogue().values()
        if e.slot != "perception"
        for k in e.parameters
    }
    cases: list[tuple[str, dict[tuple[str, str], float]]] = [
        ("no effect", {}),
        ("delay and lag of steering and drive", dict.fromkeys(_ACTUATORS, 0.2)),
        ("understeer (tyres)", {("understeer", "K"): 0.004}),
        (f"all {len({e for e, _ in many})} effects at once", many),
    ]
    return [
        Row(
            "165 s of 50 Hz commands to motion, 33 segments",
            cpu_seconds(lambda v=values: replay.run(v, starts=starts, states=states)) * 1e3,
            "ms",
            "<= 2" if k < 3 else "",
            note=note,
        )
        for k, (note, values) in enumerate(cases)
    ]


_ACTUATORS = (("steer_delay", "T"), ("steer_lag", "tau"), ("drive_delay", "T"), ("drive_lag", "tau"))


def _sensor_rows() -> list[Row]:
    world = _world(12)
    suite = default_sensors()
    assert suite.lidar is not None
    assert suite.camera is not None
    lidar, camera = (
        suite.lidar.start(0.0, np.random.SeedSequence(1)),
        suite.camera.start(0.0, np.random.SeedSequence(1)),
    )
    clock = iter(range(1 << 40))
    angles = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    rays = np.tile(np.column_stack((np.cos(angles), np.sin(angles))), (3, 1))

    def scan() -> None:
        t = next(clock) / 10
        lidar.measure(t, 0.0, 0.0, 0.0, 0.0, world.boxes)
        lidar.arrived(t)

    def look() -> None:
        t = next(clock) / 10
        camera.measure(t, 0.0, 0.0, 0.0, 0.0, world)
        camera.arrived(t)

    peer = cpu_seconds(lambda: _numpy_scan(world.boxes, rays)) * 1e6
    note = "720 x 3 rays, 12 cars around"
    return [
        Row("LiDAR scan", cpu_seconds(scan) * 1e6, "us", "<= 60", "numpy, all rays x boxes", peer, note),
        Row("camera frame", cpu_seconds(look) * 1e6, "us", note="12 cars around, occlusion by 35 points a box"),
    ]


def _tick_row() -> Row:
    twin = Twin(read_model(MODEL), default_sensors(), 7)
    world = _world(4)

    def tick() -> None:
        t = twin.observe(world).t
        twin.apply(Command(t, 0.05, 0.0, 0.02, 0.0))
        twin.step(0.05)

    return Row(
        "twin, one 20 Hz tick", cpu_seconds(tick) * 1e6, "us", "<= 120", note="observe, apply, step; 4 cars around"
    )


def run() -> list[Row]:
    """Rows of the table."""
    return [*_kernel_rows(), *_log_rows(), *_sensor_rows(), _tick_row()]
