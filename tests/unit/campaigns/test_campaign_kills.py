"""A campaign that is killed at random times, DVP_KILLS times (`make campaigns`): no row is lost, none is doubled.

`make test` takes the kills of test_campaign_store.py and test_campaign_cluster.py.
"""

from __future__ import annotations

import collections
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "tuning")]
import farm  # noqa: E402
import on_cluster  # noqa: E402
from test_campaign_cluster import begun, expected, rows  # noqa: E402

KILLS = int(os.environ.get("DVP_KILLS", "0"))
RUNS = 400

pytestmark = pytest.mark.skipif(KILLS == 0, reason="minutes; DVP_KILLS=200 asks for it")


def local(folder: Path) -> subprocess.Popen[bytes]:
    """The campaign in two processes of one machine, a process group of its own."""
    words = [sys.executable, on_cluster.__file__, str(folder), "local", str(RUNS), "noted"]
    return subprocess.Popen(words, start_new_session=True)


def test_the_command_and_its_processes_may_die_at_any_time(tmp_path: Path) -> None:
    draw, killed, ended = random.Random(1), 0, 0
    while killed < KILLS // 2:
        folder = tmp_path / str(ended)
        process = local(folder)
        try:
            assert process.wait(timeout=draw.uniform(0.5, 6.0)) == 0
        except subprocess.TimeoutExpired:
            # Now and then the command alone, so that its workers have to notice by themselves.
            (os.kill if draw.random() < 0.5 else os.killpg)(process.pid, signal.SIGKILL)
            process.wait()
            killed += 1
        else:
            check(folder)
            ended += 1
    assert local(tmp_path / str(ended)).wait() == 0
    check(tmp_path / str(ended))


def check(folder: Path) -> None:
    found = rows(folder / "out")
    assert found == expected(folder, RUNS)
    driven = collections.Counter((folder / "driven.txt").read_text().split())
    assert set(driven) == {row.key for row in found}


def test_command_workers_and_scheduler_may_die_at_any_time(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="needs the extra cluster")
    running = farm.Farm(tmp_path)
    draw, killed, ended = random.Random(2), 0, 0
    try:
        while killed < KILLS - KILLS // 2:
            folder = tmp_path / f"campaign-{ended}"
            running.staffed(2)
            process = begun(folder, running, RUNS, "slow")
            while killed < KILLS - KILLS // 2:
                time.sleep(draw.uniform(0.2, 6.0))
                victim = draw.choice(["command", "worker", "scheduler"])
                if process.poll() is not None:
                    break
                killed += 1
                if victim == "command":
                    process.kill()
                    process.wait()
                elif victim == "worker":
                    running.dismissed(1)
                else:
                    running.restarted()
                running.staffed(2)
                if victim == "command":
                    process = begun(folder, running, RUNS, "slow")
            if process.wait(240.0) != 0:  # a command that begins without a scheduler ends, and may be given again
                assert begun(folder, running, RUNS, "slow").wait(240.0) == 0
            assert rows(folder / "out") == expected(folder, RUNS)
            ended += 1
    finally:
        running.close()
