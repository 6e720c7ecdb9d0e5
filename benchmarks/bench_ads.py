"""The reference stack: one tick with everything in it, and one plan of the MPC."""

from __future__ import annotations

import statistics
import time
from functools import cache

import numpy as np

from ads.control.mpc import N, OffsetPlanner
from ads.parameters import Parameters
from ads.planning.route import Map
from ads.stack import Stack
from benchmarks.measure import Row, cpu_seconds
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run as drive
from scenarios import path
from vehicle.messages import Command, Observation, VehicleDescription

SCENARIOS = ("overtaking", "pedestrian_crossing", "urban")


class Timed(Stack):
    """The stack, which notes the CPU time [s] of its ticks in `ticks`."""

    def __init__(self, parameters: Parameters, network: Map, vehicle: VehicleDescription) -> None:
        super().__init__(parameters, network, vehicle)
        self.ticks: list[float] = []

    def tick(self, observation: Observation) -> Command:
        begin = time.process_time_ns()
        command = super().tick(observation)
        self.ticks.append(1e-9 * (time.process_time_ns() - begin))
        return command


def run() -> list[Row]:
    """The rows of this benchmark."""
    ticks = [1e3 * seconds for seconds in tick_seconds()]
    worst = f"99 % below {float(np.percentile(ticks, 99)):.2f} ms"
    return [
        Row("tick of the stack, median", statistics.median(ticks), "ms", "<= 2", note=worst),
        Row("MPC, horizon 20: condensing and QP", 1e6 * mpc_seconds(), "us", "<= 100", note="daqp"),
    ]


def timed_drive(name: str) -> tuple[Timed, RunResult]:
    """One run of a shipped scenario, and the stack that drove it."""
    made: list[Timed] = []

    def make(parameters: Parameters, network: Map, vehicle: VehicleDescription) -> Timed:
        made.append(Timed(parameters, network, vehicle))
        return made[-1]

    result = drive(path(f"{name}.xosc"), ads=make)
    return made[-1], result


@cache
def tick_seconds() -> tuple[float, ...]:
    """CPU times [s] of all ticks of the shipped scenarios, warm."""
    found: list[float] = []
    for name in SCENARIOS:
        for _ in range(2):  # the first one compiles and reads
            stack, _ = timed_drive(name)
        found += stack.ticks
    return tuple(found)


def mpc_seconds() -> float:
    """CPU time [s] of one plan around an obstacle, bounds active."""
    planner, k = OffsetPlanner(), np.arange(1, N + 1)
    middle = (k >= 7) & (k <= 13)
    wanted, low, high = np.where(middle, 2.75, 0.0), np.where(middle, 2.0, -1e3), np.full(N, 3.2)
    assert planner.solve((0.0, 0.0, 0.0), 3.0, wanted, low, high, 0.1) is not None
    return cpu_seconds(lambda: planner.solve((0.0, 0.0, 0.0), 3.0, wanted, low, high, 0.1))
