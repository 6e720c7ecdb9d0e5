"""Warm worker processes of a campaign: rows come back one by one, and a worker that dies costs its drive alone."""

from __future__ import annotations

import itertools
import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from types import TracebackType

from pytest_dvp.campaigns.one_drive import Drive, broken
from pytest_dvp.campaigns.store import Row
from pytest_dvp.workers.pool import end_with_parent

AHEAD = 2  # drives handed out for each process: one is driven while the next is on its way


class LocalCrew:
    """`count` processes; 1 drives in this process. `work`: what a drive gives."""

    def __init__(self, count: int, work: Callable[[Drive], Row]) -> None:
        self.count, self._work = count, work
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> LocalCrew:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=kind is None, cancel_futures=True)

    def rows(self, drives: Iterable[Drive]) -> Iterator[Row]:
        """The row of each drive, in the order in which they end; each is asked for when a process is free for it.

        A drive during which its process died is tried again alone; one that kills that process, too, is an ERROR.
        """
        if self.count <= 1:
            for each in drives:
                yield self._work(each)
            return
        waiting = iter(drives)
        under_way: dict[Future[Row], Drive] = {}
        while True:
            for each in itertools.islice(waiting, AHEAD * self.count - len(under_way)):
                under_way[self._started().submit(self._work, each)] = each
            if not under_way:
                return
            done, _ = wait(under_way, return_when=FIRST_COMPLETED)
            suspects: list[Drive] = []
            for future in done:
                each = under_way.pop(future)
                try:
                    row = future.result()
                except BrokenProcessPool:
                    suspects.append(each)
                else:
                    yield row
            if suspects:  # the pool is gone with all that it had: which drive did it shows when each is alone
                suspects += under_way.values()
                under_way.clear()
                self._stop()
                for each in suspects:
                    yield self._alone(each)

    def _alone(self, each: Drive) -> Row:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), initializer=end_with_parent) as pool:
            try:
                return pool.submit(self._work, each).result()
            except BrokenProcessPool:
                return broken(each, "the worker process died twice during this drive")

    def _started(self) -> ProcessPoolExecutor:
        if self._pool is None:
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self.count, context, initializer=end_with_parent)
        return self._pool

    def _stop(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None
