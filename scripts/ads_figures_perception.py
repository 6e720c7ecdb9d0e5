"""Figures of the perception: what of the road users in view is reported, and how far off; against the twin's truth.

The twin drives among cars and pedestrians of random size, place and motion; its sensor models at nominal noise and the
stack's own localization feed the perception, so that the figures hold what a planner gets.

A road user counts while its middle is within the range and inside the LiDAR's crop, at least half of its outline is
hidden by no other, and both have been so for SEEN seconds (a track is reported after three scans). It is found if a
detection of its kind, paired one to one, has its middle within PAIRED of the true one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

import scenarios
from ads.localization import EkfLocalizer
from ads.parameters import Parameters
from ads.perception.pipeline import Perception, TrackingPerception
from vehicle.messages import (
    OBJECT_KINDS,
    Command,
    Detection,
    FloatArray,
    Surroundings,
    VehicleDescription,
    VehicleState,
)
from vehicle.model.model_file import read_model
from vehicle.sensors.suite import SensorSuite, default_sensors
from vehicle.twin import Twin

TICK = 0.05  # s
DURATION = 20.0  # s of a drive
SEEN = 0.5  # s
PAIRED = 2.0  # m
VEHICLE_RANGE, PEDESTRIAN_RANGE = 30.0, 25.0  # m
LANE = 3.5  # m
APART = 0.3  # m between road users, at least
VEHICLE, PEDESTRIAN = 0, 1
RMSE = 0.25  # m
FALSE = 5.0  # in 100 scans
OCCLUDED = 0.2, 1.0  # s, least and longest time out of view of a track that is to be kept
KEPT = 0.9  # share

Figure = dict[str, object]


class Users(NamedTuple):
    """Road users: boxes (n, 9) as in Surroundings at t = 0, kinds (n,)."""

    boxes: FloatArray
    kinds: NDArray[np.int64]

    def at(self, t: float) -> FloatArray:
        """Boxes at `t` [s]; each goes straight on."""
        boxes = self.boxes.copy()
        boxes[:, :2] += t * boxes[:, 7:9]
        return boxes


def traffic(seed: int) -> Users:
    """A road along x: cars ahead, oncoming, parked on both sides; pedestrians walking along, across, and standing.

    Whoever would touch another, or the ego, in the time of a drive is left out.
    """
    rng = np.random.default_rng([seed, 62])
    users: list[tuple[FloatArray, int]] = []
    ego = np.array([1.18, 0.0, 0.7, 0.0, 3.6, 1.9, 1.4, 5.5, 0.0])

    def add(kind: int, x: float, y: float, yaw: float, speed: float) -> None:
        if kind == VEHICLE:
            size = rng.uniform((3.6, 1.6, 1.4), (4.8, 1.9, 1.7))
        else:
            size = np.full(3, rng.uniform(0.45, 0.6))
            size[2] = rng.uniform(1.5, 1.9)
        way = (speed * math.cos(yaw), speed * math.sin(yaw))
        box = np.array([x, y, 0.5 * size[2], yaw, *size, *way])
        if not any(_meet(box, other) for other, _ in [*users, (ego, VEHICLE)]):
            users.append((box, kind))

    add(VEHICLE, rng.uniform(14.0, 24.0), 0.0, 0.0, rng.uniform(5.5, 7.0))  # ahead
    for x in (40.0, 75.0, 130.0):
        add(VEHICLE, x + rng.uniform(0.0, 12.0), LANE, math.pi, rng.uniform(3.0, 9.0))  # oncoming
    for x in range(10, 150, 14):
        if rng.random() < 0.6:
            add(VEHICLE, x + rng.uniform(0.0, 5.0), -2.9, 0.03 * float(rng.standard_normal()), 0.0)  # parked
    for x in range(15, 150, 22):
        if rng.random() < 0.5:
            add(VEHICLE, x + rng.uniform(0.0, 10.0), rng.uniform(7.5, 9.0), rng.uniform(-math.pi, math.pi), 0.0)
    for x in range(14, 160, 8):
        side = -1.0 if rng.random() < 0.5 else 1.0
        what, y = rng.random(), side * rng.uniform(5.0, 7.0)
        if what < 0.3:
            add(PEDESTRIAN, x, y, 0.0 if rng.random() < 0.5 else math.pi, rng.uniform(0.8, 1.6))  # along
        elif what < 0.8:
            add(PEDESTRIAN, x, y, -side * 0.5 * math.pi, rng.uniform(0.5, 2.0))  # across
        else:
            add(PEDESTRIAN, x, y, 0.0, 0.0)
    return Users(np.array([box for box, _ in users]), np.array([kind for _, kind in users], dtype=np.int64))


def _meet(a: FloatArray, b: FloatArray) -> bool:
    """Whether two users come closer than APART in the time of a drive; discs of their width along their length."""
    times = np.arange(0.0, DURATION, 0.1)[:, None, None]
    apart = (_discs(a) - _discs(b)[:, None]).reshape(1, -1, 2) + times * (a[7:9] - b[7:9])
    return bool(np.hypot(apart[..., 0], apart[..., 1]).min() < 0.6 * (a[5] + b[5]) + APART)


def _discs(box: FloatArray) -> FloatArray:
    """Middles (k, 2) [m] of discs along a box."""
    reach = max(0.5 * (box[4] - box[5]), 0.0)
    along = np.linspace(-reach, reach, 5)[:, None]
    middles: FloatArray = box[:2] + along * np.array([math.cos(box[3]), math.sin(box[3])])
    return middles


def free_share(boxes: FloatArray, i: int, x: float, y: float) -> float:
    """Share of 9 directions across box `i`, seen from (x, y) [m], in which no other box stands nearer."""
    corners = _corners(boxes[i]) - (x, y)
    middle = math.atan2(boxes[i, 1] - y, boxes[i, 0] - x)
    bearing = (np.arctan2(corners[:, 1], corners[:, 0]) - middle + math.pi) % (2.0 * math.pi) - math.pi
    free = 0
    for angle in middle + np.linspace(bearing.min(), bearing.max(), 11)[1:-1]:
        own = _entry(boxes[i], x, y, angle)
        free += all(_entry(boxes[j], x, y, angle) > own for j in range(len(boxes)) if j != i)
    return free / 9.0


def _corners(box: FloatArray) -> FloatArray:
    c, s = math.cos(box[3]), math.sin(box[3])
    local = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * (0.5 * box[4], 0.5 * box[5])
    moved: FloatArray = box[:2] + local @ np.array([[c, s], [-s, c]])
    return moved


def _entry(box: FloatArray, x: float, y: float, angle: float) -> float:
    """Distance [m] at which a ray enters a box in the plane, inf if it misses."""
    c, s = math.cos(box[3]), math.sin(box[3])
    px, py = x - box[0], y - box[1]
    dx, dy = math.cos(angle), math.sin(angle)
    near, far = 0.0, math.inf
    for o, d, half in (
        (c * px + s * py, c * dx + s * dy, 0.5 * box[4]),
        (c * py - s * px, c * dy - s * dx, 0.5 * box[5]),
    ):
        if abs(d) < 1e-12:
            if abs(o) > half:
                return math.inf
            continue
        a, b = sorted(((-half - o) / d, (half - o) / d))
        near, far = max(near, a), min(far, b)
    return near if near <= far else math.inf


class Score(NamedTuple):
    """One row a road user and scan: kind, distance [m], error of its middle [m] (inf: not found).

    `false`: detections within PEDESTRIAN_RANGE that have no road user within PAIRED, in `ticks` scans. `kept` of
    `hidden` road users that came into view again within OCCLUDED still had their track's number.
    """

    rows: FloatArray
    false: int
    ticks: int
    kept: int
    hidden: int


def drive(
    seed: int,
    parameters: Parameters,
    suite: SensorSuite | None = None,
    make: Callable[..., Perception] = TrackingPerception,
) -> Score:
    """One drive of the twin past traffic, and how the perception did."""
    twin = Twin(read_model(scenarios.path("models/tabby_evo.toml")), suite or default_sensors(), seed)
    twin.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=5.5, vx=5.5))
    car = twin.description
    localizer = EkfLocalizer(car, lambda x, y: 0.0)
    perception = make(parameters, car, _traffic_goes)
    users = traffic(seed)
    names = tuple(str(k) for k in range(len(users.kinds)))
    since = np.full(len(names), -math.inf)
    rows: list[tuple[float, float, float]] = []
    false = ticks = kept = hidden = 0
    number: dict[int, int] = {}  # track of each road user when last counted
    last = np.full(len(names), -math.inf)  # when that was
    for k in range(round(DURATION / TICK)):
        t = k * TICK
        boxes = users.at(t)
        observation = twin.observe(Surroundings(boxes, users.kinds, names))
        estimate = localizer.update(observation)
        found = () if estimate is None else perception.update(observation, estimate)
        state = twin.state
        if k % 2 == 0:
            counted = _counting(boxes, users.kinds, state, car, parameters, since, t)
            near = tuple(d for d in found if math.hypot(d.x - state.x, d.y - state.y) < PEDESTRIAN_RANGE)
            errors, tracks, _ = _pair(boxes, users.kinds, found)
            *_, extra = _pair(boxes, users.kinds, near)
            for i in counted:
                rows.append((float(users.kinds[i]), _distance(boxes[i], state), errors[i]))
                if tracks[i] >= 0:
                    if i in number and OCCLUDED[0] + SEEN < t - last[i] < OCCLUDED[1] + SEEN:
                        hidden += 1
                        kept += number[i] == tracks[i]
                    number[i], last[i] = tracks[i], t
            false += extra
            ticks += 1
        yaw_error = state.yaw + 0.05 * state.y
        accel = 0.8 * (5.5 + 1.5 * math.sin(0.4 * t) - state.v)
        steer = max(min(-yaw_error, 0.1), -0.1)
        twin.apply(Command(t, steer, accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0))
        twin.step(TICK)
    return Score(np.array(rows), false, ticks, kept, hidden)


def _traffic_goes(x: float, y: float) -> float | None:
    """Direction of traffic [rad] as the map would tell it; None off the road."""
    if not -2.5 < y < 1.5 * LANE:
        return None
    return 0.0 if y < 0.5 * LANE else math.pi


def _distance(box: FloatArray, state: VehicleState) -> float:
    return math.hypot(box[0] - state.x, box[1] - state.y)


def _counting(
    boxes: FloatArray, kinds: NDArray[np.int64], state: VehicleState, car: VehicleDescription, p: Parameters,
    since: FloatArray, t: float,
) -> list[int]:  # fmt: skip
    """Which road users count now; `since` keeps when each came into view."""
    c, s = math.cos(state.yaw), math.sin(state.yaw)
    x, y = state.x + c * car.lidar_x, state.y + s * car.lidar_x
    counted = []
    for i, box in enumerate(boxes):
        dx, dy = box[0] - x, box[1] - y
        ahead, left = c * dx + s * dy, c * dy - s * dx
        reach = VEHICLE_RANGE if kinds[i] == VEHICLE else PEDESTRIAN_RANGE
        inside = abs(ahead) <= p.LIDAR_x_max and abs(left) <= p.LIDAR_abs_y_max and _distance(box, state) <= reach
        if not inside or free_share(boxes, i, x, y) < 0.5:
            since[i] = -math.inf
        elif since[i] == -math.inf:
            since[i] = t
        elif t - since[i] >= SEEN:
            counted.append(i)
    return counted


def _pair(
    boxes: FloatArray, kinds: NDArray[np.int64], found: tuple[Detection, ...]
) -> tuple[FloatArray, list[int], int]:
    """Error [m] and track (inf, -1: not found) of each road user, and how many detections are of none at all."""
    errors, tracks = np.full(len(boxes), np.inf), [-1] * len(boxes)
    if not found:
        return errors, tracks, 0
    apart = np.array([[math.hypot(d.x - b[0], d.y - b[1]) for d in found] for b in boxes])
    cost = apart.copy()
    for i, kind in enumerate(kinds):
        for j, d in enumerate(found):
            if d.kind != OBJECT_KINDS[kind] or apart[i, j] > PAIRED:
                cost[i, j] = 1e3
    for i, j in zip(*linear_sum_assignment(cost), strict=True):
        if cost[i, j] < 1e3:
            errors[i], tracks[i] = apart[i, j], found[j].track
    return errors, tracks, int(np.sum(apart.min(axis=0) > PAIRED))


def figures(drives: int = 10) -> list[Figure]:
    """The figures, each a dict of name, found, goal, met: `drives` of 20 s under each of three conditions."""
    around = Parameters().with_values({"LIDAR_x_max": 40.0, "LIDAR_abs_y_max": 15.0})
    nominal = default_sensors()
    assert nominal.lidar is not None
    on_ground = replace(nominal, lidar=replace(nominal.lidar, ground=True))
    found: list[Figure] = []
    for label, parameters, suite in (
        ("LiDAR crop of the 10th preset", Parameters(), nominal),
        ("crop 40 m x 15 m", around, nominal),
        ("the same with returns of the ground", around, on_ground),
    ):
        scores = [drive(seed, parameters, suite) for seed in range(drives)]
        rows = np.concatenate([score.rows for score in scores])
        found += _of_kind(rows[rows[:, 0] == VEHICLE], f"vehicles within {VEHICLE_RANGE:.0f} m, {label}", 0.98)
        found += _of_kind(rows[rows[:, 0] == PEDESTRIAN], f"pedestrians within {PEDESTRIAN_RANGE:.0f} m, {label}", 0.95)
        false = 100.0 * sum(score.false for score in scores) / sum(score.ticks for score in scores)
        found.append(
            {
                "name": f"false objects within {PEDESTRIAN_RANGE:.0f} m, {label}",
                "found": f"{false:.1f} in 100 scans",
                "goal": f"<= {FALSE:.0f} in 100 scans (ours)",
                "met": bool(false <= FALSE),
            }
        )
        kept, hidden = sum(score.kept for score in scores), sum(score.hidden for score in scores)
        found.append(
            {
                "name": f"tracks that keep their number through {OCCLUDED[0]} to {OCCLUDED[1]} s out of view, {label}",
                "found": f"{kept} of {hidden}",
                "goal": f">= {KEPT:.2f} (ours)",
                "met": kept >= KEPT * hidden,
            }
        )
    return found


def _of_kind(rows: FloatArray, label: str, least: float) -> list[Figure]:
    hit = np.isfinite(rows[:, 2])
    recall, rmse = float(hit.mean()), float(np.sqrt(np.mean(rows[hit, 2] ** 2)))
    goal = f"<= {RMSE:.2f} m" + ("" if least == 0.98 else " (ours)")
    return [
        {
            "name": f"recall of {label}",
            "found": f"{recall:.4f} of {len(rows)}",
            "goal": f">= {least:.2f}",
            "met": recall >= least,
        },
        {
            "name": f"position RMSE of {label}",
            "found": f"{rmse:.3f} m",
            "goal": goal,
            "met": rmse <= RMSE,
        },
    ]


if __name__ == "__main__":
    for figure in figures():
        print("met   " if figure["met"] else "MISSED", figure["name"], figure["found"], figure["goal"], sep=" | ")
