"""Metrics and the log: TTC of box pairs, MNCC, recording, writing and reading."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from benchmarks.measure import Row, cpu_seconds
from pytest_dvp.drive.run_folder import measure
from pytest_dvp.logs.likeness import likeness
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.mcap_write import encode_log
from pytest_dvp.logs.recorder import LogRecorder
from pytest_dvp.metrics import known_metrics
from pytest_dvp.metrics._box_collision_time import time_to_collision
from vehicle.messages import Command, Detection, Surroundings

PAIRS = 200_000
TICKS = 2000  # 100 s at 20 Hz


def run() -> list[Row]:
    return [*_ttc(), *_mncc(), *_log()]


def _boxes(rng: np.random.Generator, spread: float) -> NDArray[np.float64]:
    """Cars of 0.5 to 5 m somewhere in a square of +- spread [m], 8 m/s standard deviation."""
    place = rng.uniform(-spread, spread, (PAIRS, 2))
    yaw = rng.uniform(-np.pi, np.pi, PAIRS)
    size = rng.uniform(0.5, 5.0, (PAIRS, 2))
    return np.column_stack((place, yaw, size, 8.0 * rng.normal(size=(PAIRS, 2))))


def _ttc() -> list[Row]:
    rows = []
    for spread, note in ((50.0, "2 % meet"), (10.0, "14 % meet"), (3.0, "half meet or overlap")):
        rng = np.random.default_rng(1)
        i, j = _boxes(rng, spread), _boxes(rng, spread)
        seconds = cpu_seconds(lambda i=i, j=j: time_to_collision(i, j))
        rows.append(Row(f"TTC, boxes within {spread:g} m", PAIRS / seconds / 1e6, "M pairs/s", ">= 10", note=note))
    return rows


def _mncc() -> list[Row]:
    rows = []
    for length, name in ((10_000, "100 s"), (360_000, "1 h")):
        rng = np.random.default_rng(2)
        x, y = rng.normal(size=(2, length)).cumsum(axis=1)
        ours = cpu_seconds(lambda x=x, y=y: likeness(x, y, 0.01))
        peer = cpu_seconds(lambda x=x, y=y: correlate(y - y.mean(), x - x.mean(), method="fft"))
        note = "the peer correlates over all lags and computes nothing else"
        rows.append(Row(f"MNCC, +-5 s, {name} at 100 Hz", 1e3 * ours, "ms", "<= peer", "scipy fft", 1e3 * peer, note))
    return rows


def _recorder() -> LogRecorder:
    """100 s: 60 columns of noise and Petri-net places, four objects of which two stand, a path a second."""
    rng = np.random.default_rng(3)
    meta = {"stage": "dt", "ego": {"length": 3.0, "width": 1.5, "center_x": 1.2}, "task": {}}
    recorder = LogRecorder(meta, reference=np.column_stack((np.arange(1200.0), np.zeros(1200))))
    boxes = np.abs(rng.normal(size=(4, 9))) + 100.0
    kinds = np.zeros(4, dtype=np.int64)
    detections = tuple(Detection(0.0, "vehicle", *rng.normal(size=7)) for _ in range(2))
    noise = rng.normal(size=(TICKS, 20)).tolist()
    rows = rng.normal(size=(TICKS, 5, 12))
    rows[:, :, 0] = 0.05 * np.arange(TICKS)[:, None] + 0.01 * np.arange(1, 6)
    path = rng.normal(size=(120, 2))
    for tick in range(TICKS):
        t = 0.05 * tick
        trace = {f"q{i}": value for i, value in enumerate(noise[tick])}
        trace |= {f"net.n.p{i}": float((tick // 200 + i) % 5 == 0) for i in range(30)}
        if tick % 20 == 0:
            path = path + 1.0
        around = Surroundings(boxes + np.array([[tick], [tick], [0], [0]]), kinds, ("a", "b", "c", "d"))
        command = Command(t, *noise[tick][:4])
        held = {"on_road": 1.0}
        recorder.tick(t, command=command, ads=trace, surroundings=around, detections=detections, path=path, held=held)
        recorder.ego_rows(rows[tick])
    return recorder


def _log() -> list[Row]:
    recorder = _recorder()
    log = recorder.finish()
    trace = {f"q{i}": 0.0 for i in range(50)}
    around = Surroundings(np.ones((4, 9)), np.zeros(4, dtype=np.int64), ("a", "b", "c", "d"))
    command, rows = Command(0.0, 0.0, 0.0, 0.0, 0.0), np.zeros((5, 12))
    scratch = LogRecorder()

    def tick() -> None:
        scratch.tick(0.0, command=command, ads=trace, surroundings=around, held={"on_road": 1.0})
        scratch.ego_rows(rows)

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        log.save(path)
        load = cpu_seconds(lambda: Log.load(path))
    size = f"{len(log.columns)} columns, {len(encode_log(log)) / 1e6:.1f} MB"
    single = sum(1 for metric in known_metrics().values() if metric.logs == 1)
    return [
        Row("record one tick", 1e6 * cpu_seconds(tick), "us", "<= 20", note="50 ADS values, 4 objects"),
        Row("columns of a 100 s run", 1e3 * cpu_seconds(recorder.finish), "ms"),
        Row("MCAP of a 100 s run", 1e3 * cpu_seconds(lambda: encode_log(log)), "ms", "<= 150", note=size),
        Row("read it back", 1e3 * load, "ms"),
        Row(f"all {single} metrics of a 100 s run", 1e3 * cpu_seconds(lambda: measure(log)), "ms"),
    ]
