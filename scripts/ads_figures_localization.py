"""Figures of the localization: consistency, drift without GNSS, jumps, late measurements; all against the twin's truth.

The twin (dynamic bicycle, side slip included) drives a winding course with changing speed; its own sensor models at
nominal noise feed the filter, so that every error they have (slow drift, biases, latency) is in the figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

import scenarios
from ads.localization import EkfLocalizer, Estimate
from ads.transforms import wrap_angle
from vehicle.messages import (
    Command,
    FloatArray,
    GnssFix,
    Observation,
    VehicleDescription,
    VehicleState,
    no_surroundings,
)
from vehicle.model.model_file import read_model
from vehicle.sensors.suite import SensorSuite, default_sensors
from vehicle.twin import Twin

TICK = 0.05  # s
ROWS = 5  # trace rows a tick
SETTLED = 15.0  # s after which the filter has learnt what it can of its sensors
OUTAGE = 30.0  # s
JUMP = 50.0  # m

Figure = dict[str, object]
Spoil = Callable[[Observation], Observation]


class Truth(NamedTuple):
    """A drive of the twin: rows of TRACE_COLUMNS at 100 Hz (n, 12), and the car."""

    rows: FloatArray
    car: VehicleDescription
    suite: SensorSuite


def drive(duration: float, suite: SensorSuite | None = None) -> Truth:
    """The twin on a winding course of `duration` [s] at 5 to 11 m/s, up to 3 m/s^2 sideways."""
    sensors = suite or replace(default_sensors(), lidar=None, camera=None)
    twin = Twin(read_model(scenarios.path("models/tabby_evo.toml")), sensors)
    twin.reset(VehicleState(t=0.0, x=10.0, y=-5.0, yaw=0.3, v=6.0, vx=6.0))
    pieces = []
    for k in range(round(duration / TICK)):
        t, v = k * TICK, twin.state.v
        accel = 0.8 * (8.0 + 2.5 * math.sin(0.25 * t) - v)
        steer = math.atan(2.36 * 2.5 * math.sin(0.31 * t) * math.sin(0.07 * t + 0.4) / max(v, 3.0) ** 2)
        twin.apply(Command(t, steer, accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0))
        pieces.append(twin.step(TICK))
    return Truth(np.concatenate(pieces), twin.description, sensors)


def observations(truth: Truth, seed: int, suite: SensorSuite | None = None) -> Iterator[tuple[Observation, FloatArray]]:
    """What the sensors deliver tick by tick, with the true row at each tick."""
    rows = truth.rows.tolist()
    running = (suite or truth.suite).start(rows[ROWS - 1], seed)
    for k in range(ROWS, len(rows), ROWS):
        running.feed(rows[k : k + ROWS])
        row = truth.rows[k + ROWS - 1]
        yield running.observe(float(row[0]), no_surroundings()), row


class Follow(NamedTuple):
    """The filter after each tick: estimates, pose errors (n, 3) [m, m, rad], covariances (n, k, k), true rows."""

    estimates: list[Estimate]
    errors: FloatArray
    covariances: FloatArray
    rows: FloatArray
    localizer: EkfLocalizer


def follow(
    truth: Truth, seed: int, spoil: Spoil = lambda observation: observation, suite: SensorSuite | None = None
) -> Follow:
    """Run the filter along a drive; `spoil` may take away or change what arrives."""
    heading = float(truth.rows[0, 4])
    localizer = EkfLocalizer(truth.car, lambda x, y: heading)
    estimates, errors, covariances, rows = [], [], [], []
    for observation, row in observations(truth, seed, suite):
        estimate = localizer.update(spoil(observation))
        if estimate is not None:
            estimates.append(estimate)
            errors.append((estimate.x - row[1], estimate.y - row[2], wrap_angle(estimate.yaw - row[4])))
            covariances.append(localizer.covariance.copy())
            rows.append(row)
    return Follow(estimates, np.array(errors), np.array(covariances), np.array(rows), localizer)


def nees(truth: Truth, seeds: int, times: tuple[float, ...]) -> FloatArray:
    """Normalized estimation error squared of the pose (seeds, times): chi-square of 3 if the filter is honest.

    Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), sec. 5.4.2.
    """
    values = np.empty((seeds, len(times)))
    for seed in range(seeds):
        found = follow(truth, seed)
        for k, at in enumerate(times):
            i = int(np.searchsorted(found.rows[:, 0], at))
            e, p = found.errors[i], found.covariances[i]
            values[seed, k] = e @ np.linalg.solve(p[:3, :3], e)
    return values


def askew(truth: Truth) -> Truth:
    """The same drive with the IMU 0.5 m to the left of the middle, turned by 10 degrees; the filter is told."""
    imu = truth.suite.imu
    assert imu is not None
    suite = replace(truth.suite, imu=replace(imu, mount=replace(imu.mount, y=0.5, yaw=math.radians(10.0))))
    return Truth(truth.rows, suite.describe(truth.car), suite)


def without_gnss(start: float, end: float) -> Spoil:
    """Take the fixes away that were measured from `start` to `end` [s]."""
    return lambda o: _with_gnss(o, tuple(f for f in o.gnss if not start <= f.t < end))


def jumped(start: float, end: float) -> Spoil:
    """Move the fixes that were measured from `start` to `end` [s] by JUMP."""

    def spoil(o: Observation) -> Observation:
        return _with_gnss(o, tuple(_moved(f, JUMP) if start <= f.t < end else f for f in o.gnss))

    return spoil


def _moved(f: GnssFix, by: float) -> GnssFix:
    return GnssFix(f.t, f.x + 0.6 * by, f.y - 0.8 * by, f.sigma, f.yaw, f.yaw_sigma)


def _with_gnss(o: Observation, fixes: tuple[GnssFix, ...]) -> Observation:
    return Observation(o.t, fixes, o.odometry, o.imu, o.lidar, o.camera, o.signals, o.task)


def drift(truth: Truth, seed: int, suite: SensorSuite | None = None) -> float:
    """Drift over 30 s without GNSS, as a share of the distance driven in them."""
    found = follow(truth, seed, without_gnss(SETTLED, SETTLED + OUTAGE), suite)
    t = found.rows[:, 0]
    inside = (t >= SETTLED) & (t <= SETTLED + OUTAGE)
    distance = float(np.sum(found.rows[inside, 5])) * TICK
    return float(np.hypot(*found.errors[inside][-1, :2])) / distance


def shuffled(seed: int, latest: float = 0.4) -> Spoil:
    """Hold every fix back by 0 to `latest` [s], so that fixes overtake each other."""
    rng = np.random.default_rng(seed)
    waiting: list[tuple[float, GnssFix]] = []

    def spoil(o: Observation) -> Observation:
        waiting.extend((o.t + latest * float(rng.random()), f) for f in o.gnss)
        come = sorted((pair for pair in waiting if pair[0] <= o.t), key=lambda pair: pair[0])
        waiting[:] = [pair for pair in waiting if pair[0] > o.t]
        return _with_gnss(o, tuple(f for _, f in come))

    return spoil


def position_rmse(found: Follow) -> float:
    """RMSE of the position [m] from SETTLED on."""
    e = found.errors[found.rows[:, 0] > SETTLED]
    return float(np.sqrt(np.mean(e[:, 0] ** 2 + e[:, 1] ** 2)))


def farthest(found: Follow) -> float:
    """Largest position error [m] from SETTLED on."""
    return float(np.hypot(found.errors[:, 0], found.errors[:, 1])[found.rows[:, 0] > SETTLED].max())


def figures(seeds: int = 100, drives: int = 20) -> list[Figure]:
    """The figures, each a dict of name, found, goal, met; `seeds` of the consistency, `drives` of all others."""
    truth = drive(SETTLED + OUTAGE + 1.0)
    gnss, odometry = truth.suite.gnss, truth.suite.odometry
    assert gnss is not None
    assert odometry is not None
    no_heading = replace(truth.suite, gnss=replace(gnss, yaw_sigma=None))
    worn = replace(truth.suite, odometry=replace(odometry, scale=1.02))
    times = (20.0, 30.0, 45.0)
    low, high = chi2.ppf((0.025, 0.975), 3 * seeds) / seeds
    found: list[Figure] = []
    for mounted, seen in (("", truth), (", IMU 0.5 m beside the middle and 10 degrees askew", askew(truth))):
        for at, value in zip(times, nees(seen, seeds, times).mean(axis=0), strict=True):
            found.append(
                {
                    "name": f"NEES of the pose at {at:.0f} s, mean of {seeds} seeds{mounted}",
                    "found": f"{value:.2f}",
                    "goal": f"{low:.2f} to {high:.2f}",
                    "met": bool(low <= value <= high),
                }
            )

    def at_most(name: str, value: float, goal: float, unit: str) -> None:
        shown = f"{100.0 * value:.2f} %" if unit == "%" else f"{value:.3f} {unit}"
        aim = f"<= {100.0 * goal:g} %" if unit == "%" else f"<= {goal:g} {unit}"
        found.append({"name": name, "found": shown, "goal": aim, "met": bool(value <= goal)})

    for label, suite in (("", None), (", receiver without heading", no_heading), (", wheels 2 % off", worn)):
        value = max(drift(truth, seed, suite) for seed in range(drives))
        at_most(f"30 s without GNSS{label}: drift by distance, worst of {drives} seeds", value, 0.01, "%")
    jump = [follow(truth, seed, jumped(SETTLED, SETTLED + 10.0)) for seed in range(drives)]
    at_most("50 m jump of the GNSS for 10 s: largest error, worst seed", max(map(farthest, jump)), 0.5, "m")
    kept = sum(f.localizer.rejected >= 100 for f in jump)
    found.append(
        {
            "name": "50 m jump of the GNSS for 10 s: seeds with every fix of it rejected",
            "found": f"{kept} of {drives}",
            "goal": f"{drives} of {drives}",
            "met": kept == drives,
        }
    )
    plain = max(position_rmse(follow(truth, seed)) for seed in range(drives))
    late = max(position_rmse(follow(truth, seed, shuffled(seed))) for seed in range(drives))
    at_most("position RMSE, worst seed", plain, 0.1, "m")
    at_most("position RMSE with fixes 0 to 0.4 s late and out of order, worst seed", late, 0.1, "m")
    return found


if __name__ == "__main__":
    for figure in figures():
        print("met   " if figure["met"] else "MISSED", figure["name"], figure["found"], figure["goal"], sep=" | ")
