"""Closed loop: simulated seconds per CPU second, and what the plugin costs a session that does not use it."""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.measure import Row
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run as drive

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"
REPEATS = 3
STARTS = 15


def run() -> list[Row]:
    """The rows of this benchmark."""
    found = [closed_loop(name) for name in ("overtaking", "pedestrian_crossing", "urban")]
    return [*found, idle_cost(("--version",)), idle_cost(())]


def closed_loop(name: str) -> Row:
    """Whole run with reading, recording and judging: EKF, fusion, nets, LQR, MPC at 20 Hz, dynamics at 1 kHz."""
    path = SCENARIOS / f"{name}.xosc"
    drive(path)  # compiled, roads cached
    speeds = []
    last: RunResult | None = None
    for _ in range(REPEATS):
        begin = time.process_time()
        last = drive(path)
        speeds.append(last.log.duration / (time.process_time() - begin))
    assert last is not None
    note = f"{last.status}, {last.log.duration:.0f} s simulated" + (", with SUMO" if name == "urban" else "")
    return Row(
        f"closed loop, {name}", statistics.median(speeds), "s/s", ">= 200, then 400", "no peer has one", None, note
    )


def idle_cost(arguments: tuple[str, ...]) -> Row:
    """CPU time of a pytest session with the plugin minus one without, alternating starts."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "test_nothing.py").write_text("def test_nothing():\n    pass\n")
        with_it, without = [], []
        for _ in range(STARTS):
            with_it.append(_session(folder, arguments))
            without.append(_session(folder, ("-p", "no:dvp", *arguments)))
    more = statistics.median(with_it) - statistics.median(without)
    name = f"plugin idle, pytest {' '.join(arguments)}".rstrip()
    return Row(name, more * 1e3, "ms", "<= 30", "bare pytest", statistics.median(without) * 1e3, "added to bare pytest")


def _session(folder: str, arguments: tuple[str, ...]) -> float:
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
