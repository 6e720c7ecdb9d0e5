"""The workers of a dask.distributed scheduler as the crew of a campaign: drives go in batches, rows come back."""

from __future__ import annotations

import dataclasses
import itertools
import queue
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from pytest_dvp.campaigns.campaign import base_key, job_of
from pytest_dvp.campaigns.one_drive import Drive, broken, drive
from pytest_dvp.campaigns.store import Row
from pytest_dvp.text.errors import SettingError
from pytest_dvp.workers.dask_cluster import AGAIN, PATIENCE, Cluster
from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.file_transfer import Contents, Packing, placed, put_down
from pytest_dvp.workers.remote_job import this_worker
from reports.whole_file import write_whole

if TYPE_CHECKING:
    from distributed import Future

BATCH = 2.0  # s of CPU in a task; a task costs some 5 ms of scheduler, wire and unpacking, so 0.3 %
MOST = 200  # drives in a task: what is lost when a worker dies, and driven again
AHEAD = 2  # tasks handed out for each worker: one is driven while the next is on its way


class ClusterCrew:
    """The workers that the scheduler at `address` ("tcp://host:8786") has; they may come and go.

    Drives of a worker that dies are driven by another one. When the scheduler goes, one at the same address is waited
    for, `patience` [s], and what had not come back is handed out again. `work`: what a drive gives.
    """

    def __init__(self, address: str, work: Callable[[Drive], Row] = drive, *, patience: float = PATIENCE) -> None:
        self._address, self._work, self._patience = address, work, patience
        self._cluster: Cluster | None = None
        self._packed: dict[str, list[Any]] = {}  # tasks that hold the files of a base key
        self._cost = 0.0  # s of CPU of a drive, a running mean

    def __enter__(self) -> ClusterCrew:
        """Raises SettingError: no `distributed`, no such scheduler, no workers."""
        self._cluster = Cluster(self._address).__enter__()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._leave()

    def rows(self, drives: Iterable[Drive]) -> Iterator[Row]:
        """The row of each drive, in the order in which they end; each is asked for when a worker is free for it.

        A drive that kills several workers is an ERROR. Raises TuneError: a machine that is not alike, no worker or no
        scheduler left; what came before is kept, and the same command goes on.
        """
        waiting = iter(drives)
        again: list[list[Drive]] = []
        while True:
            under_way: dict[str, list[Drive]] = {}
            ended: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
            try:
                while True:
                    self._hand_out(waiting, again, under_way, ended)
                    if not under_way:
                        return
                    yield from self._taken(under_way, ended, again)
            except ConnectionError:
                again += under_way.values()
                self._reach_again()

    def _hand_out(
        self, waiting: Iterator[Drive], again: list[list[Drive]], under_way: dict[str, list[Drive]],
        ended: queue.SimpleQueue[Future[Any]],
    ) -> None:  # fmt: skip
        """Raises ConnectionError if the scheduler has gone."""
        cluster = self._reached()
        while len(under_way) < AHEAD * max(1, cluster.worker_count()):
            size = 1 if self._cost <= 0.0 else min(max(1, round(BATCH / self._cost)), MOST)
            batch = again.pop() if again else list(itertools.islice(waiting, size))
            if not batch:
                return
            try:
                future = cluster.client.submit(
                    drive_batch, [dataclasses.asdict(each) for each in batch], what=self._work, home=cluster.home,
                    parcels=self._parcels(batch[0]), pure=False,
                )  # fmt: skip
            except Exception as error:
                if cluster.client.status == "running":
                    raise
                again.append(batch)  # the scheduler went before it had them
                raise ConnectionError from error
            under_way[str(future.key)] = batch
            future.add_done_callback(ended.put)

    def _taken(
        self, under_way: dict[str, list[Drive]], ended: queue.SimpleQueue[Future[Any]], again: list[list[Drive]]
    ) -> Iterator[Row]:
        """The rows of the next task that ends. Raises ConnectionError if the scheduler has gone."""
        from distributed import KilledWorker

        cluster = self._reached()
        try:
            future = cluster.patiently(lambda seconds: ended.get(timeout=seconds))
            if future.cancelled():
                raise cluster.lost()
            answers = cluster.patiently(lambda seconds: future.result(timeout=seconds))
        except KilledWorker as error:
            batch = under_way.pop(str(future.key))
            if len(batch) > 1:  # which of them did it shows when each is alone
                again += [[each] for each in batch]
            else:
                yield broken(batch[0], f"{error.allowed_failures + 1} worker processes died during this drive")
            return
        except TuneError as error:
            if cluster.client.status != "running":
                raise ConnectionError from error
            raise
        batch = under_way.pop(str(future.key))
        for order, answer in zip(batch, answers, strict=True):
            yield self._home(order, answer)

    def _home(self, order: Drive, answer: Mapping[str, Any]) -> Row:
        """The row as if it had been driven here, its log put where the campaign keeps it."""
        if "refused" in answer:
            raise TuneError(f"worker {answer['where']}: {answer['refused']}; {AGAIN}")
        if "failed" in answer:
            raise TuneError(f"worker {answer['where']}: {answer['failed']}; {AGAIN}")
        row = Row(**answer["row"])
        self._cost = row.cpu if self._cost <= 0.0 else 0.9 * self._cost + 0.1 * row.cpu
        if answer["log"] is not None:
            place = Path(order.folder) / row.log
            place.parent.mkdir(parents=True, exist_ok=True)
            write_whole(place, answer["log"])
        return row

    def _parcels(self, order: Drive) -> list[Any]:
        """Tasks with the files of a drive; those of one base key travel once."""
        cluster = self._reached()
        if order.base not in self._packed:
            found = Packing().parcels(job_of(order.scenario, order.options))
            self._packed[order.base] = [cluster.task("files", parcel.contents()) for parcel in found]
        return self._packed[order.base]

    def _reached(self) -> Cluster:
        assert self._cluster is not None
        return self._cluster

    def _reach_again(self) -> None:
        """Wait for a scheduler at the same address. Raises TuneError if none comes."""
        self._leave()
        deadline = time.monotonic() + self._patience
        while True:
            try:
                self._cluster = Cluster(self._address).__enter__()
            except SettingError as error:
                if time.monotonic() > deadline:
                    raise TuneError(f"{error}; waited {self._patience:g} s; {AGAIN}") from None
                time.sleep(0.5)
            else:
                return

    def _leave(self) -> None:
        self._packed.clear()
        if self._cluster is not None:
            self._cluster.__exit__(None, None, None)
            self._cluster = None


def drive_batch(
    orders: Sequence[Mapping[str, Any]], *, what: Callable[[Drive], Row], home: Mapping[str, str],
    parcels: Sequence[Contents],
) -> list[dict[str, Any]]:  # fmt: skip
    """In a worker: of each order `{"row", "log"}`, the log as bytes; or `{"refused"}`, or `{"failed"}`; with `where`.

    what: a drive gives; home: what is `installed` where the orders come from; parcels: the files that they need.
    """
    where, refused, below = this_worker(home)
    if refused:
        return [{"where": where, "refused": refused} for _ in orders]
    root = put_down(parcels, below / "dvp-files")
    here = [_moved(Drive(**order), root, below / "dvp-runs") for order in orders]
    alike: dict[str, str] = {}  # why a base key is another one here, once for the batch
    for order in here:
        if order.base not in alike:
            alike[order.base] = _differing(order)
    return [
        {"where": where, "refused": alike[order.base]} if alike[order.base]
        else {"where": where, **_driven(order, what, str(sent["scenario"]), root)}
        for order, sent in zip(here, orders, strict=True)
    ]  # fmt: skip


def _moved(order: Drive, root: Path, folder: Path) -> Drive:
    """The drive with its files where they lie on this machine."""
    options = _options(order.options, root)
    return dataclasses.replace(order, scenario=_here(order.scenario, root), options=options, folder=str(folder))


def _differing(order: Drive) -> str:
    """Why a drive here would be another one than where the campaign is; "" if it would be the same."""
    try:
        same = base_key(order.scenario, order.options) == order.base
    except OSError as error:
        return f"{error.filename} is not there"
    return "" if same else "a file of the drive, or the code, differs from that where the campaign is"


def _driven(order: Drive, what: Callable[[Drive], Row], scenario: str, root: Path) -> dict[str, Any]:
    """Drive; the row names the `scenario` of where the campaign is."""
    try:
        row = what(order)
    except Exception as error:  # whatever it is, it is plain text that goes back
        words = " ".join(str(error).split())
        return {"failed": f"{type(error).__name__}: {words}".replace(str(root), "")}
    log = None
    if row.log:
        file = Path(order.folder) / row.log
        log = file.read_bytes()
        file.unlink()
    return {"row": {**dataclasses.asdict(row), "scenario": scenario}, "log": log}


def _options(options: Mapping[str, Any], root: Path) -> dict[str, Any]:
    """The options with the files that were carried at their places here."""
    found = dict(options)
    for name in ("model", "gates"):
        if found[name] is not None:
            found[name] = Path(_here(str(found[name]), root))
    found["library"] = [Path(_here(str(folder), root)) for folder in found["library"]]
    return found


def _here(path: str, root: Path) -> str:
    """Where a file lies on this machine: below the root if it was carried, else at the same place."""
    there = placed(str(Path(path).absolute()), root)
    return there if Path(there).exists() else path
