"""A tuning run killed 20 times at random, and one left alone."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from pytest_dvp.workers.job import Job
from pytest_dvp.workers.run_job import work
from scenarios import path as shipped

KILLS = 20
OUT = "out"  # of both runs: a result names its own folder in its commands
STUDY = """[study]
objective = "alignment"
search = "coordinate"
budget = 200
model = "models/surrogate.toml"
logs = ["drive.mcap"]

[parameters]
"S.EGO_mass" = { values = [600, 730, 900, 1200], start = 1200 }
"S.EGO_dr_zero_throttle" = { values = [0, 0.05, 0.1, 0.5], start = 0.1 }
"S.EGO_moi" = { values = [0, 0.1, 0.5, 1.0], start = 1.0 }
"S.THROTTLE_delay" = { values = [0, 0.05, 0.1, 0.2], start = 0.2 }
"S.THROTTLE_kp" = { values = [0, 0.25, 0.5, 1.25], start = 0.5 }
"S.BRAKE_kp" = { values = [0, 0.09, 0.5, 1.0], start = 1.0 }
"""
"""S of the surrogate's twin on a drive of the other car that ships: a replay takes 0.1 s, so that a kill hits many."""


def kills(runs: Path, jobs: int, seed: int = 1) -> str:
    """Kill a run KILLS times, let it end, and hold its result against that of a run that nobody touched."""
    folder = runs / "kills"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    work(Job(str(shipped("overtaking.xosc")), save=str(folder / "drive.mcap")))
    begun = time.monotonic()
    _command(folder, "alone", jobs).wait()
    (folder / OUT).rename(folder / "alone")
    whole = time.monotonic() - begun
    draw = random.Random(seed)
    killed = 0
    while killed < KILLS:
        process = _command(folder, "killed", jobs)
        try:
            process.wait(timeout=draw.uniform(0.02, 0.6) * whole)
            # it was faster than the knife: what it had done is thrown away, and it starts anew
            shutil.rmtree(folder / "cache-killed")
        except subprocess.TimeoutExpired:
            # Now and then the harness alone, so that its workers have to notice by themselves.
            (os.kill if draw.random() < 0.5 else os.killpg)(process.pid, signal.SIGKILL)
            process.wait()
            killed += 1
    _command(folder, "killed", jobs).wait()
    (folder / OUT).rename(folder / "killed")
    one, other = ((folder / name / "result.json").read_bytes() for name in ("alone", "killed"))
    same, alone = one == other, json.loads(one)
    verdict = "the same result, byte for byte" if same else "ANOTHER RESULT"
    return (
        f"`dvp tune` with {len(alone['trials'])} points ({alone['simulations']} replays of a log, {jobs} workers), "
        f"killed {killed} times at random (SIGKILL, half of them to the harness alone): {verdict} as the run left "
        "alone."
    )


def _command(folder: Path, name: str, jobs: int) -> subprocess.Popen[bytes]:
    words = ["tune", str(folder / "study.toml"), "--out", str(folder / OUT), "--cache", str(folder / f"cache-{name}")]
    return subprocess.Popen(
        [sys.executable, "-m", "pytest_dvp.cli", *words, "--jobs", str(jobs)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip
