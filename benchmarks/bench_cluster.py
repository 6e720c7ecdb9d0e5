"""What it costs to have a job done by a worker of dask.distributed: CPU time of all processes beside the job itself."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.measure import Row, cpu_seconds
from pytest_dvp.workers.dask_cluster import Cluster
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.run_job import work
from scenarios import path as shipped

JOBS = 200
WAITED = 20.0  # s
TWIN = str(shipped("models/surrogate.toml"))


def run() -> list[Row]:
    try:
        from distributed import LocalCluster
    except ImportError:
        return []
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as made,
        Cluster(made.scheduler_address) as cluster,
    ):
        log = Path(folder) / "drive.mcap"
        scenario = str(shipped("follow.xosc"))
        work(Job(scenario, model=TWIN, save=str(log)))
        drive = _row(cluster, "a drive", lambda k: Job(scenario, model=TWIN, seed=k))
        replay = _row(cluster, "a replay", lambda k: Job("", model=TWIN, log=str(log), S=(("EGO_mass", 700.0 + k),)))
        return [drive, replay, _waiting(cluster)]


def nothing(job: Job) -> dict[str, Any]:
    return {"metrics": {}, "ending": "", "error": None}


def _row(cluster: Cluster, what: str, made: Callable[[int], Job]) -> Row:
    """The cost of handing out jobs in which nothing is done, in % of one that is."""
    one = cpu_seconds(lambda: work(made(1)), repeats=3)
    rounds = []
    for number in range(4):  # in the first everything is loaded
        jobs = {job.key: job for job in map(made, range(number * JOBS, (number + 1) * JOBS))}
        begun = _spent(cluster)
        assert len(list(cluster.worked(nothing, jobs))) == JOBS
        rounds.append((_spent(cluster) - begun) / JOBS)
    cost = min(rounds[1:])
    note = f"{cost * 1e3:.1f} ms; {what} takes {one * 1e3:.0f} ms"
    return Row(f"dask.distributed around {what}", cost / one * 100.0, "%", "<= 5", note=note)


def _waiting(cluster: Cluster) -> Row:
    """What a worker process takes for itself, whether it simulates or not: dask's monitors, many times a second."""
    begun, start = cluster.client.run(_cpu), time.perf_counter()
    time.sleep(WAITED)
    ended, lasted = cluster.client.run(_cpu), time.perf_counter() - start
    share = max(ended[where] - begun[where] for where in begun) / lasted
    return Row("dask.distributed, a worker that waits", share * 100.0, "% of a core")


def _spent(cluster: Cluster) -> float:
    """CPU time [s] so far of this process, with the scheduler in it, and of the workers."""
    return time.process_time() + sum(cluster.client.run(_cpu).values())


def _cpu() -> float:
    spent = os.times()
    return spent.user + spent.system
