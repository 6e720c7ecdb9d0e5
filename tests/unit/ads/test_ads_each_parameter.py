"""Each parameter of P does what its declaration says, where it acts, whatever the others are.

Several of them change no metric of a scenario that ships: the scenarios set a speed and so mask LQR_v_max. Expected
values are closed forms. The other parameters have values unlike all defaults and unlike each other, so that a part
which reads a wrong one of them fails.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from ads_loop import TABBY, Car, Drive, drive, new_stack
from ads_plane import PlaneMap
from ads_traffic import SeeingAll, parked
from scipy.linalg import solve_discrete_are
from test_ads_control import at, straight
from test_ads_perception import scan

from ads.control.spline import SPEED
from ads.control.steering import LqrSteering
from ads.localization import Estimate
from ads.map_monitor import Crossing
from ads.parameters import DECLARATIONS, ITERATIONS, STAGES, Parameters, preset
from ads.perception import pipeline
from ads.perception.pipeline import ClusterDetector, TrackingPerception
from ads.planning.crossing import CrossingRule
from ads.planning.navigator import Navigator
from ads.planning.overtaking import Obstacle, Overtaking
from vehicle.messages import LidarScan, Observation, RoadPoint, Task

# Table of Arango et al., Sensors 2026, 26, 1338: 1st | 5th | 10th iteration, each DT; PE; RW where they differ.
PAPER = {
    "LQR_v_max": "7.0; 5.5; 5.5 | 5.5 | 5.5",
    "LQR_rc_max": "25 | 30 | 40",
    "LQR_q11": "20 | 30 | 30",
    "LQR_q22": "100; 10; 10 | 1 | 0.0001",
    "LQR_r11": "9000; 5000; 5000 | 5000 | 5000",
    "MPC_w": "3.5; 2.75; 2.75 | 2.75 | 2.75",
    "DECISION_PC_d_max": "30 | 30 | 40",
    "DECISION_PC_d_min": "10 | 10; 15; 15 | 15",
    "DECISION_OT_d_max": "40 | 40; 30; 30 | 30",
    "DECISION_OT_speed": "7 | 7; 5; 5 | 5",
    "FUSION_min_dist": "2.5 | 2.5; 2.5; 4.0 | 4.5",
    "LIDAR_x_max": "50 | 50; 50; 30 | 30",
    "LIDAR_abs_y_max": "10 | 10 | 5",
}
ODD = Parameters(
    LQR_v_max=6.1, LQR_rc_max=47.0, LQR_q11=23.0, LQR_q22=310.0, LQR_r11=4100.0, MPC_w=3.3, DECISION_PC_d_max=36.0,
    DECISION_PC_d_min=12.5, DECISION_OT_d_max=27.0, DECISION_OT_speed=4.3, FUSION_min_dist=3.7, LIDAR_x_max=33.5,
    LIDAR_abs_y_max=7.25,
)  # fmt: skip
FRONT = TABBY.center_x + 0.5 * TABBY.length
GOAL = RoadPoint("1", -1, 150.0)


def test_every_preset_is_the_papers_table() -> None:
    for name, row in PAPER.items():
        for iteration, cell in zip(ITERATIONS, row.split("|"), strict=True):
            values = [float(value) for value in cell.split(";")]
            for stage, value in zip(STAGES, values * 3 if len(values) == 1 else values, strict=True):
                assert getattr(preset(iteration, stage), name) == value, (name, iteration, stage)


def test_every_default_is_the_papers_tenth_iteration() -> None:
    assert Parameters().as_dict() == {name: float(row.split("|")[2]) for name, row in PAPER.items()}


# What a part makes of a parameter, and what it should by hand; each takes the parameters and gives (found, expected).
Check = Callable[[Parameters], tuple[Any, Any]]
CHECKS: dict[str, Check] = {}


def checks(*names: str) -> Callable[[Check], Check]:
    def add(check: Check) -> Check:
        CHECKS.update(dict.fromkeys(names, check))
        return check

    return add


def planned(p: Parameters, pieces: list[tuple[float, float]], set_speed: float | None) -> np.ndarray:
    """Speeds [m/s] of the path that is planned over a road of pieces (length [m], curvature [1/m])."""
    navigator = Navigator(p, PlaneMap(pieces))  # type: ignore[arg-type]
    navigator.assign(Task(set_speed=set_speed, goal=GOAL))
    navigator.update(Estimate(0.0, 2.0, -1.75, 0.0, 0.0, 0.0, 0.0, 0.1, 0.01), may_replan=True)
    assert navigator.path is not None
    return navigator.path[:, SPEED]


@checks("LQR_v_max")
def _(p: Parameters) -> tuple[Any, Any]:
    free, told = (planned(p, [(200.0, 0.0)], speed).max() for speed in (None, 3.0))
    return (free, told), (p.LQR_v_max, 3.0)  # the task's speed stands before it


@checks("LQR_rc_max")
def _(p: Parameters) -> tuple[Any, Any]:
    radius = 18.0 + 1.75  # of the right-hand lane in a bend to the left
    speed = 5.0 * math.sqrt(radius / p.LQR_rc_max)  # below the root of 2.5 m/s^2 of lateral acceleration, 7 m/s
    return planned(p, [(60.0, 0.0), (40.0, 1.0 / 18.0), (60.0, 0.0)], 5.0).min(), pytest.approx(speed, rel=0.02)


@checks("LQR_q11", "LQR_q22", "LQR_r11")
def _(p: Parameters) -> tuple[Any, Any]:
    v, dt, errors = 5.0, 0.05, (0.02, 0.004)  # m/s, s; m and rad, so small that no limit of the steering acts
    a = v * dt
    b = np.array([[0.5 * a * a], [a]]) / TABBY.wheelbase
    f = np.array([[1.0, a], [0.0, 1.0]])
    cost = solve_discrete_are(f, b, np.diag([p.LQR_q11, p.LQR_q22]), np.array([[p.LQR_r11]]))
    gain = np.linalg.solve(b.T @ cost @ b + p.LQR_r11, b.T @ cost @ f)[0]
    path = straight()
    off = at(v, 50.0)._replace(y=errors[0]), at(v, 50.0)._replace(yaw=errors[1])
    found = [-LqrSteering(p, TABBY).steer(one, path, 100) for one in off]
    return found, pytest.approx([gain[0] * errors[0], gain[1] * errors[1]], rel=0.03)  # the integral's first 1.25 %


@checks("MPC_w")
def _(p: Parameters) -> tuple[Any, Any]:
    room = SimpleNamespace(half_width=1.75, side_width=7.0)
    monitor: Any = SimpleNamespace(side=1.0, room=lambda s: room)
    return Overtaking(p, TABBY).wanted_offset(Obstacle(1, 30.0, 34.0, -0.5, 0.5), monitor), p.MPC_w


@checks("DECISION_PC_d_max", "DECISION_PC_d_min")
def _(p: Parameters) -> tuple[Any, Any]:
    crossing = Crossing("zebra", 98.5, 101.5, -4.0, 4.0)
    monitor: Any = SimpleNamespace(crossings=(crossing,))
    rule, fast, slow = CrossingRule(p, TABBY), 8.0, 6.0  # m/s: the set speed and three quarters of it

    def looks(distance: float) -> tuple[bool, float]:
        near, _ = rule.update(0.0, 100.0 - distance, fast, monitor, (), [])
        return near, rule.limits(100.0 - distance, fast, stop=False)[0][1] if near else math.inf

    middle = 0.5 * (p.DECISION_PC_d_min + p.DECISION_PC_d_max)
    found = [looks(d) for d in (p.DECISION_PC_d_max + 0.1, p.DECISION_PC_d_max - 1e-6, middle, p.DECISION_PC_d_min)]
    half_way = math.sqrt(0.5 * (fast**2 + slow**2))  # even deceleration: v^2 is linear in the distance
    expected = [(False, math.inf), *((True, pytest.approx(v, abs=1e-3)) for v in (fast, half_way, slow))]
    return found, expected


def overtakes(p: Parameters) -> tuple[float, Drive]:
    """Gap [m] to a parked car where the plan around it begins, and the drive; nobody else is there."""
    rear, begun = 80.0 - 2.2, []
    stack = new_stack(PlaneMap([(300.0, 0.0)]), parameters=p, perception=SeeingAll([parked(80.0)], reach=75.0))

    def watch(t: float, car: Car) -> None:
        if not begun and stack.trace.get("net.overtaking.out", 0.0) > 0.5:
            begun.append(rear - car.x - FRONT)

    log = drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 6.0), 30.0, Task(set_speed=7.0, goal=GOAL), None, watch)
    return begun[0], log


@checks("DECISION_OT_d_max")
def _(p: Parameters) -> tuple[Any, Any]:
    return overtakes(p)[0], pytest.approx(p.DECISION_OT_d_max - 0.2, abs=0.45)  # a tick at 7 m/s, half of it


@checks("DECISION_OT_speed")
def _(p: Parameters) -> tuple[Any, Any]:
    log = overtakes(p)[1]
    beside = np.abs(log.column(1) - 80.0) < 2.0
    return float(np.median(log.v[beside])), pytest.approx(p.DECISION_OT_speed, abs=0.25)


@checks("FUSION_min_dist")
def _(p: Parameters) -> tuple[Any, Any]:
    given = []

    def fuse(*arguments: Any) -> np.ndarray:
        given.append(arguments[-1])
        return sound(*arguments)

    # How it decides is in test_ads_perception.py (TestFusion); here: that this parameter is what it decides by.
    sound = pipeline.fuse
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pipeline, "fuse", fuse)
        estimate = Estimate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.01)
        TrackingPerception(p, TABBY).update(Observation(0.0, lidar=LidarScan(0.0, np.zeros((0, 3)))), estimate)
    return given, [p.FUSION_min_dist]


@checks("LIDAR_x_max", "LIDAR_abs_y_max")
def _(p: Parameters) -> tuple[Any, Any]:
    def seen(x: float, y: float) -> bool:
        """Whether a car is found whose nearest face is there, seen from the sensor."""
        points = scan((x + 2.0 * np.sign(x), y + 0.9 * np.sign(y), 0.0, 4.0, 1.8))
        return len(ClusterDetector(p, TABBY).boxes(LidarScan(0.0, points))) > 0

    x, y = p.LIDAR_x_max, p.LIDAR_abs_y_max
    places = [(x - 1.0, 0.0), (x + 1.0, 0.0), (-x + 1.0, 0.0), (-x - 1.0, 0.0), (8.0, y - 1.0), (8.0, y + 1.0)]
    return [seen(*place) for place in places], [True, False] * 3


def test_every_parameter_is_checked() -> None:
    assert sorted(CHECKS) == sorted(d.name for d in DECLARATIONS)


@pytest.mark.parametrize("name", [d.name for d in DECLARATIONS])
def test_the_parameter_acts_where_its_declaration_says(name: str) -> None:
    other = {"LQR_q11": 71.0, "LQR_q22": 1500.0, "LQR_r11": 2300.0, "DECISION_OT_speed": 5.6}
    for parameters in (ODD, ODD.with_values({name: other.get(name, 0.83 * getattr(ODD, name))})):
        found, expected = CHECKS[name](parameters)
        assert found == expected
