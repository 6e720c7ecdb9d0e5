"""Jobs over cores or machines: results in the order asked for, whoever made them, each kept as soon as it is there."""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from pytest_dvp.workers.cache import Cache
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.run_job import work
from reports.whole_file import write_whole

if TYPE_CHECKING:
    from pytest_dvp.workers.dask_cluster import Cluster

Tick = Callable[[str], None]
Work = Callable[[Job], dict[str, Any]]


class Workers:
    """Runs jobs that the cache does not know. `count` processes; 1 works in this one. `work`: what a job gives.
    `cluster`: they run on the workers of its machines instead.

    `done`: how many jobs were worked on, `known`: how many the cache had.
    """

    def __init__(
        self, cache: Cache, count: int = 1, tick: Tick = lambda text: None, *, work: Work = work,
        cluster: Cluster | None = None,
    ) -> None:  # fmt: skip
        self.cache, self.count, self.tick, self._work, self._cluster = cache, count, tick, work, cluster
        self.done = 0
        self.known = 0
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=kind is None, cancel_futures=True)

    def run(self, jobs: Sequence[Job], about: str = "") -> list[dict[str, Any]]:
        """A result for each job, in their order; jobs with one key are done once. about: begins the progress."""
        keys = [job.key for job in jobs]
        found: dict[str, dict[str, Any]] = {}
        missing: dict[str, Job] = {}
        for key, job in zip(keys, jobs, strict=True):
            if key in found or key in missing:
                continue
            kept = self.cache.get(key)
            if kept is not None and _complete(job):
                found[key] = kept
                self.known += 1
            else:
                missing[key] = job
        for key, result in self._worked(missing):
            self.done += 1
            found[key] = result
            self.tick(f"{about}{missing[key].title}: {len(found)} of {len(set(keys))}")
        return [found[key] for key in keys]

    def _worked(self, missing: Mapping[str, Job]) -> Iterable[tuple[str, dict[str, Any]]]:
        if self._cluster is not None and missing:
            for key, result, log in self._cluster.worked(self._work, missing):
                save = missing[key].save
                if log is not None and save is not None:
                    Path(save).parent.mkdir(parents=True, exist_ok=True)
                    write_whole(Path(save), log)
                yield key, _put(self.cache, key, result)
            return
        if self.count <= 1 or len(missing) < 2:
            for key, job in missing.items():
                yield key, _kept(self._work, str(self.cache.folder), key, job)
            return
        if self._pool is None:
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self.count, context, initializer=end_with_parent)
        folder = str(self.cache.folder)
        futures = {self._pool.submit(_kept, self._work, folder, key, job): key for key, job in missing.items()}
        for future in as_completed(futures):
            yield futures[future], future.result()


def _kept(what: Work, folder: str, key: str, job: Job) -> dict[str, Any]:
    """Work, and keep the result at once: what was killed after it goes on from here."""
    return _put(Cache(Path(folder)), key, what(job))


def _put(cache: Cache, key: str, result: dict[str, Any]) -> dict[str, Any]:
    cache.put(key, result)
    kept = cache.get(key)  # as it will be found the next time, to the order of its keys
    assert kept is not None
    return kept


def _complete(job: Job) -> bool:
    """Whether what a job should leave behind, its log, is there as well."""
    return job.save is None or Path(job.save).is_file()


def end_with_parent() -> None:
    """A worker whose parent was killed ends: it would wait for ever for work that nobody hands out."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
