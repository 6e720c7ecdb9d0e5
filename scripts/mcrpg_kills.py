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
from typing import Any

KILLS = 20
STUDY = """[study]
objective = "performance"
search = "coordinate"
preset = 1
budget = 40
model = "models/surrogate.toml"

[[scenario]]
file = "overtaking.xosc"

[parameters]
"P.LQR_q11" = [10, 20, 30, 50]
"P.LQR_q22" = [0.0001, 1, 10, 100]
"P.DECISION_OT_speed" = [4, 5, 7]
"""


def kills(runs: Path, jobs: int, seed: int = 1) -> str:
    """Kill a run KILLS times, let it end, and hold its result against that of a run that nobody touched."""
    folder = runs / "kills"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    begun = time.monotonic()
    _command(folder, "alone", jobs).wait()
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
    same = _result(folder, "alone") == _result(folder, "killed")
    alone = _result(folder, "alone")
    verdict = "the same result, byte for byte" if same else "ANOTHER RESULT"
    return (
        f"`dvp tune` with {len(alone['trials'])} points ({alone['simulations']} simulations, {jobs} workers), "
        f"killed {killed} times at random (SIGKILL, half of them to the harness alone): {verdict} as the run left "
        "alone."
    )


def _command(folder: Path, name: str, jobs: int) -> subprocess.Popen[bytes]:
    words = ["tune", str(folder / "study.toml"), "--out", str(folder / name), "--cache", str(folder / f"cache-{name}")]
    return subprocess.Popen(
        [sys.executable, "-m", "pytest_dvp.cli", *words, "--jobs", str(jobs)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip


def _result(folder: Path, name: str) -> Any:
    return json.loads((folder / name / "result.json").read_text(encoding="utf-8"))
