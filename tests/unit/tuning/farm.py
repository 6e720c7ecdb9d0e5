"""A scheduler of dask.distributed and its workers, processes of their own on free ports of this machine; and work for
them that costs nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO, Any

import bowl

from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.job import Job

DIES = "DVP_TEST_DIES"  # variable: a file that a worker makes when it dies
DEATHS = 1  # of workers, that a job survives: distributed.scheduler.allowed-failures


class Farm:
    """Give `close` a chance, whatever happens."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.mark = folder / "died"
        self._workers: list[subprocess.Popen[str]] = []
        self._readers: list[threading.Thread] = []
        self._scheduler = self._begun("dask_scheduler", ["--port", "0"])
        self.address = self._said(self._scheduler, "Scheduler at:").split()[-1]

    def staffed(self, count: int) -> None:
        """At least so many workers: those that died are replaced."""
        self.mark.unlink(missing_ok=True)
        self._workers = [worker for worker in self._workers if worker.poll() is None]
        options = [self.address, "--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder)]
        fresh = [self._begun("dask_worker", options) for _ in range(count - len(self._workers))]
        self._workers += fresh
        for worker in fresh:
            self._said(worker, "Registered to:")

    def dismissed(self, count: int | None = None) -> None:
        """So many workers less; by default none any more."""
        for worker in self._workers[:count]:
            worker.kill()
            worker.wait()

    def restarted(self) -> None:
        """Another scheduler at the same address; the workers of the first one have gone with it."""
        self.dismissed()
        self._scheduler.kill()
        self._scheduler.wait()
        self._scheduler = self._begun("dask_scheduler", ["--port", self.address.rpartition(":")[2]])
        self._said(self._scheduler, "Scheduler at:")

    def close(self) -> None:
        self.dismissed()
        self._scheduler.kill()
        self._scheduler.wait()
        for reader in self._readers:
            reader.join()

    def _begun(self, module: str, options: list[str]) -> subprocess.Popen[str]:
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)]),
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(DEATHS),
            DIES: str(self.mark),
        }
        command = [sys.executable, "-m", f"distributed.cli.{module}", *options, "--host", "127.0.0.1"]
        return subprocess.Popen(
            [*command, "--dashboard-address", "127.0.0.1:0"], env=environment, cwd=self.folder, text=True,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip

    def _said(self, process: subprocess.Popen[str], words: str) -> str:
        """The line in which a process says that it is there."""
        assert process.stderr is not None
        told = next((line for line in process.stderr if words in line), "")
        assert told, f"ended before it said {words!r}: {process.args}"
        reader = threading.Thread(target=_read_out, args=[process.stderr], daemon=True)
        reader.start()
        self._readers.append(reader)
        return told


def _read_out(stream: IO[str]) -> None:
    """To the end, or the pipe fills up and the process stands still."""
    with stream:
        for _ in stream:
            pass


def dies_once(job: Job) -> dict[str, Any]:
    """The first worker that gets to it is killed; work that others do goes well."""
    mark = Path(os.environ[DIES])
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return bowl.work(job)


def dies_at_seed_8(job: Job) -> dict[str, Any]:
    if job.seed == 8 and DIES in os.environ:
        os.kill(os.getpid(), signal.SIGKILL)
    return bowl.work(job)


def fails_there(job: Job) -> dict[str, Any]:
    if DIES in os.environ:
        raise RuntimeError(f"no graphics\n at {job.scenario}")
    return bowl.work(job)


def breaks_there(job: Job) -> dict[str, Any]:
    error = "the stack broke" if DIES in os.environ else None
    return {**bowl.work(job), "error": error}


def reads(job: Job) -> dict[str, Any]:
    """Characters of the files that a scenario names, and whether it is where it came from."""
    folder = Path(job.scenario).parent
    metrics = {
        "elsewhere": float(Path(os.environ[DIES]).parent in folder.parents),  # below the worker's own folder
        "catalogue": len((folder / "catalogs" / "car.xosc").read_text(encoding="utf-8")),
        "road": len((folder / ".." / "roads" / "town.xodr").read_text(encoding="utf-8")),
    }
    return {"metrics": metrics, "ending": "goal", "error": None}


def refuses(job: Job) -> dict[str, Any]:
    """As what reads a user's file does."""
    raise TuneError("unknown element", file=job.scenario, line=3)
