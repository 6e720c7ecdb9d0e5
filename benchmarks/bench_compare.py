"""Comparing a log with a model: the objective of a diagnosis, and a whole log of one hour."""

from __future__ import annotations

import resource
import sys
import time

import numpy as np

from benchmarks.measure import Row, cpu_seconds
from pytest_dvp.gap.compare import iso18571
from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.compare.compared_model import ModelSubject
from pytest_dvp.gap.compare.segments import cut, measured_array, residuals
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.model_file import parse_model
from vehicle.model.open_loop import Replay

MODEL = "[model]\nbase = 'kinematic_bicycle'\n[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 1150.0\n"
SIGMA = np.array([0.02, 0.02, 0.005, 0.03, 0.005, 0.1, 0.1, np.inf])


def run() -> list[Row]:
    return [*_objective(), *_hour(), *_rating()]


def drive(duration: float, rate: float, seed: int = 1) -> Log:
    """A log of `duration` [s] at `rate` [Hz]: the model's own motion with a steering delay of 0.2 s and noise, stops
    and turns at random."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(duration * rate)) / rate
    knots = np.arange(0.0, duration + 4.0, 4.0)
    steer = np.interp(t, knots, rng.uniform(-0.15, 0.15, len(knots)))
    accel = np.interp(t, knots, rng.uniform(-1.5, 1.5, len(knots)))
    commands = {"steer_cmd": steer, "accel_cmd": accel}
    moved = np.asarray(Replay(parse_model(MODEL), t, commands).run({("steer_delay", "T"): 0.2}))
    noisy = moved + np.where(np.isfinite(SIGMA), SIGMA, 0.0) * rng.normal(size=moved.shape)
    names = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay")
    return Log({"t": t, **commands, **{name: np.ascontiguousarray(noisy[:, k]) for k, name in enumerate(names)}})


def _objective() -> list[Row]:
    log = drive(165.0, 50.0)
    measured: FloatArray = measured_array(log.columns)
    segments = cut(log.t, measured)
    replay = Replay(parse_model(MODEL), log.t, {name: log[name] for name in ("steer_cmd", "accel_cmd")})

    def evaluate() -> None:
        rows = replay.run({("steer_delay", "T"): 0.1}, starts=segments.starts, states=segments.states)
        residuals(np.asarray(rows), measured, log.t, SIGMA, segments)

    rows = np.asarray(replay.run(starts=segments.starts, states=segments.states))
    part = cpu_seconds(lambda: residuals(rows, measured, log.t, SIGMA, segments))
    return [
        Row("commands to residuals, 165 s at 50 Hz", cpu_seconds(evaluate) * 1e3, "ms", "<= 2", note="7 channels"),
        Row("of it residuals with the start taken out", part * 1e3, "ms", ""),
    ]


def _hour() -> list[Row]:
    log = drive(3600.0, 100.0)
    subject = ModelSubject(parse_model(MODEL))
    compare(drive(60.0, 100.0), subject)  # compiled before the clock runs
    begin = time.process_time()
    compare(log, subject)
    seconds = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform != "darwin" else 1e9)
    return [
        Row("compare a log of 1 h at 100 Hz", seconds, "s", "<= 10", note="all figures, warm"),
        Row("memory of the process after it", peak, "GB", "<= 1", note="highest so far"),
    ]


def _rating() -> list[Row]:
    rng = np.random.default_rng(3)
    y = np.cumsum(rng.normal(size=36_000))
    other = y + rng.normal(size=36_000)
    seconds = cpu_seconds(lambda: iso18571.score(y, other, 0.1))
    return [Row("ISO 18571 of 36,000 samples", seconds * 1e3, "ms", "", note="DTW in pieces of 1,000")]
