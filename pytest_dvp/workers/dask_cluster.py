"""Jobs over several machines: the workers of a dask.distributed scheduler do them, and bring back result and log."""

from __future__ import annotations

import asyncio
import contextlib
import importlib.metadata
import itertools
import logging
import queue
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from pytest_dvp.text.errors import SettingError
from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.file_transfer import MOST, Packing
from pytest_dvp.workers.installation import installed
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.remote_job import order, whole, worked

if TYPE_CHECKING:
    from distributed import Client, Future

Work = Callable[[Job], dict[str, Any]]
Got = TypeVar("Got")
Answer: TypeAlias = dict[str, Any]

CONNECT = 5.0  # s to wait for a scheduler, and then for a first worker
PATIENCE = 60.0  # s to wait for workers when the last one has gone
TOGETHER = 4  # replays in a task, which take as long as a drive: a task costs 5 to 10 % of one
LOOK = 1.0  # s between looks at whether there are workers
AGAIN = "what was simulated is kept, the same command goes on from there"
ALIKE = "the same checkout must be installed where scheduler and workers run"


class Cluster:
    """The workers that a scheduler at `address` ("tcp://host:8786") has; it may gain and lose some meanwhile."""

    def __init__(self, address: str, *, connect: float = CONNECT, patience: float = PATIENCE) -> None:
        self.address, self.connect, self.patience = address, connect, patience
        self._session = uuid.uuid4().hex  # tasks of two commands are never taken for each other
        self._count = itertools.count()
        self._parcels: dict[str, Future[Any]] = {}

    def __enter__(self) -> Cluster:
        """Raises SettingError: no `distributed`, no such scheduler, no workers."""
        try:
            from distributed import Client
        except ImportError as error:
            text = f"--scheduler needs {error.name}: pip install -e '.[cluster]' from the checkout"
            raise SettingError(text) from None
        for name in ("distributed", "distributed.client"):  # what matters is said here, in one line
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            asyncio.run(_greeted(self.address, self.connect))
            self.client: Client = Client(self.address, timeout=self.connect, set_as_default=False)
        except Exception as error:  # whatever it is that listens there may answer anything
            raise SettingError(f"--scheduler {self.address}: {_unreachable(error, self.connect)}") from None
        deadline = time.monotonic() + self.connect
        while not self.worker_count():
            if time.monotonic() > deadline:
                self._close()
                raise SettingError(
                    f"--scheduler {self.address}: it has no workers; start some on each machine: dask worker "
                    f"{self.address} --nworkers N --nthreads 1"
                )
            time.sleep(0.05)
        if lacking := self._without():
            self._close()
            raise SettingError(f"--scheduler {self.address}: {lacking} has no pytest-dvp; {ALIKE}")
        self.home = self.task("home", dict(installed()))
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._close()

    def worked(self, what: Work, jobs: Mapping[str, Job]) -> Iterator[tuple[str, dict[str, Any], bytes | None]]:
        """Key, result and log of each job, as they come; the log of those with `save`.

        A run that broke, there or in the stack, is done once more by this process, and that decides. Raises what the
        job raises here, and TuneError: a machine that is not alike, one that dies again and again, or none left.
        """
        ended: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        waiting = self._submitted(what, jobs)
        for future, _ in waiting.values():
            future.add_done_callback(ended.put)
        while waiting:
            future = self.patiently(lambda seconds: ended.get(timeout=seconds))
            _, keys = waiting.pop(str(future.key))
            answers = self._answers(future, jobs[keys[0]])
            for key, answer in zip(keys, answers, strict=True):
                yield from self._judged(what, key, jobs[key], answer)

    def _judged(
        self, what: Work, key: str, job: Job, answer: Answer
    ) -> Iterator[tuple[str, dict[str, Any], bytes | None]]:
        if "refused" in answer:
            raise TuneError(f"worker {answer['where']}: {answer['refused']}; {AGAIN}")
        if "result" in answer and not answer["result"].get("error"):
            yield key, answer["result"], answer["log"]
            return
        here = what(job)
        yield key, here, None
        if here != answer.get("result"):
            said = answer.get("failed") or answer["result"]["error"]
            raise TuneError(f"worker {answer['where']}: {job.title} fails there, not here: {said}; {AGAIN}")

    def _submitted(self, what: Work, jobs: Mapping[str, Job]) -> dict[str, tuple[Future[Any], list[str]]]:
        """Tasks by name, with the keys of their jobs."""
        packing = Packing()
        needed = {key: packing.parcels(job) for key, job in jobs.items()}
        parcels = {parcel.name: parcel for each in needed.values() for parcel in each}
        # those of before that nobody needs any more are let go
        self._parcels = {
            name: self._parcels.get(name) or self.task("files", parcel.contents()) for name, parcel in parcels.items()
        }
        alike: dict[tuple[str, ...], list[str]] = {}  # those with the same files go as one message
        for key, each in needed.items():
            alike.setdefault(tuple(parcel.name for parcel in each), []).append(key)
        share = -(-len(jobs) // max(1, self.worker_count()))
        found: dict[str, tuple[Future[Any], list[str]]] = {}
        for names, keys in alike.items():
            most = min(TOGETHER, share) if all(jobs[key].log for key in keys) else 1
            tasks = [keys[k : k + most] for k in range(0, len(keys), most)]
            futures = self.client.map(
                worked, [[order(jobs[key], key) for key in each] for each in tasks],
                key=[self._key(jobs[each[0]].title) for each in tasks], pure=False,
                what=what, home=self.home, parcels=[self._parcels[name] for name in names],
            )  # fmt: skip
            found.update({str(future.key): (future, each) for future, each in zip(futures, tasks, strict=True)})
        return found

    def task(self, title: str, given: dict[str, Any]) -> Future[Any]:
        """Data as a task: unlike data that is scattered, they can be made anew when the worker that has them dies."""
        import dask

        with dask.config.set({"distributed.admin.large-graph-warning-threshold": 2 * MOST}):
            return self.client.submit(whole, given, key=self._key(title))

    def _key(self, title: str) -> str:
        return f"dvp-{self._session}-{next(self._count)}-{title}"

    def patiently(self, get: Callable[[float], Got]) -> Got:
        """What `get(seconds)` gives; TimeoutError and queue.Empty are waited out, as long as there are workers.

        Raises TuneError if the connection has gone, or no worker is left.
        """
        since = time.monotonic()
        while True:
            try:
                return get(LOOK)
            except (TimeoutError, queue.Empty):
                now = time.monotonic()
                if self.client.status != "running":
                    raise self.lost() from None
                if self.worker_count():
                    since = now
                elif now - since > self.patience:
                    text = (
                        f"scheduler {self.address}: no workers are left, waited {self.patience:g} s; {ALIKE}; {AGAIN}"
                    )
                    raise TuneError(text) from None

    def _answers(self, future: Future[Any], first: Job) -> list[Answer]:
        from distributed import KilledWorker

        if future.cancelled():
            raise self.lost()
        try:
            return list(self.patiently(lambda seconds: future.result(timeout=seconds)))
        except TuneError:
            raise
        except KilledWorker as error:
            times, last = error.allowed_failures + 1, error.last_worker.address
            text = f"{times} workers died while they had {first.title}, the last one {last}; {AGAIN}"
        except CancelledError:
            raise self.lost() from None
        except Exception as error:
            # Not of the job, whose errors come as text: of a process in which it could not even begin.
            cause = error.__cause__ or error
            text = f"{first.title} cannot begin: {type(cause).__name__}: {_line(cause)}; {ALIKE}"
        raise TuneError(f"scheduler {self.address}: {text}")

    def _without(self) -> str:
        """Where this package is not installed: a worker that is sent what it cannot import ends without a word."""
        asked = (importlib.metadata.version, "pytest-dvp")
        told = self.client.run(*asked, on_error="return")
        lacking = [f"worker {where}" for where, found in told.items() if isinstance(found, ImportError)]
        try:
            self.client.run_on_scheduler(*asked)
        except ImportError:
            lacking.append("the scheduler")
        return ", ".join(lacking)

    def worker_count(self) -> int:
        """How many worker processes the scheduler has now; 0 if it is not reached."""
        try:
            told = self.client.scheduler_info()
        except (OSError, CancelledError, RuntimeError):  # the connection ends just now
            return 0
        # Empty while the connection ends. Some versions of distributed list five workers at most, and count them all.
        return int(told.get("n_workers", len(told.get("workers", ()))))

    def lost(self) -> TuneError:
        """What is raised when the connection has gone."""
        return TuneError(f"scheduler {self.address}: the connection was lost; {AGAIN}")

    def _close(self) -> None:
        self._parcels.clear()
        with contextlib.suppress(Exception):  # it may have gone before
            self.client.close(timeout=self.connect)


async def _greeted(address: str, seconds: float) -> None:
    """Raises if no scheduler answers: a Client that never got one would take its time to go, and say so."""
    from distributed.core import rpc
    from distributed.security import Security

    async with rpc(address, connection_args=Security().get_connection_args("client")) as there:
        kind = (await asyncio.wait_for(there.identity(), seconds))["type"]
    if kind != "Scheduler":
        raise ValueError(f"found the address of a {kind}")


def _unreachable(error: Exception, seconds: float) -> str:
    if isinstance(error, OSError):
        return f"no scheduler answers within {seconds:g} s; start one: dask scheduler"
    return f"{_line(error)}; expected the address of a dask scheduler, as tcp://host:8786"


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())
