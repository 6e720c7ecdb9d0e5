"""A job in a worker process of dask.distributed: done as at home, or refused, because this machine is not alike."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import platform
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from pytest_dvp.workers.file_transfer import Contents, moved, placed, put_down
from pytest_dvp.workers.installation import first_difference, installed
from pytest_dvp.workers.job import Job

ONE_THREAD = "--nthreads 1 (and --nworkers N for N at once): a process does one simulation at a time"


def order(job: Job, key: str) -> dict[str, str | bool]:
    """A job as plain text, its files by absolute paths: what comes over the wire is read, not executed. key: the job's
    where it comes from, so that nothing runs elsewhere on other files or sources."""
    absolute = dataclasses.replace(moved(job, os.path.abspath), save=None)
    return {"job": msgspec.json.encode(absolute).decode(), "key": key, "log": job.save is not None}


def whole(contents: dict[str, Any]) -> dict[str, Any]:
    """Contents of a parcel as a task of their own: they wander between workers, and come back if one dies."""
    return contents


def worked(
    orders: Sequence[Mapping[str, Any]], *, what: Callable[[Job], dict[str, Any]], home: Mapping[str, str],
    parcels: Sequence[Contents],
) -> list[dict[str, Any]]:  # fmt: skip
    """Of each job `{"result", "log"}`, its log as bytes; or `{"refused"}`, or `{"failed"}`; each with `where`.

    what: a job gives; home: what is `installed` where the orders come from; parcels: the files that they need.
    """
    where, refused, below = this_worker(home)
    if refused:
        return [{"where": where, "refused": refused} for _ in orders]
    root = put_down(parcels, below / "dvp-files")
    return [{"where": where, **_done(each, what, root, below)} for each in orders]


def this_worker(home: Mapping[str, str]) -> tuple[str, str, Path]:
    """Where this worker process is, why it must not work ("" if it may), and a folder of its own.

    home: what is `installed` where the orders come from.
    """
    from distributed import get_worker

    worker = get_worker()
    refused = first_difference(home, installed())
    if not refused and worker.state.nthreads > 1:
        refused = f"it has {worker.state.nthreads} threads, start it with {ONE_THREAD}"
    return f"{worker.address} on {platform.node()}", refused, Path(worker.local_directory)


def _done(order: Mapping[str, Any], what: Callable[[Job], dict[str, Any]], root: Path, below: Path) -> dict[str, Any]:
    def here(path: str) -> str:
        there = placed(path, root)
        return there if Path(there).exists() else path  # what is not carried must lie at the same place

    job = moved(msgspec.json.decode(order["job"], type=Job), here)
    try:
        if job.key != order["key"]:
            return {"refused": _differing(job)}
    except OSError as error:
        return {"refused": f"{error.filename} is not there"}
    with _log_file(below) if order["log"] else contextlib.nullcontext() as log:
        try:
            result = what(dataclasses.replace(job, save=log))
        except Exception as error:  # whatever it is, it is plain text that goes back
            words = " ".join(str(error).split())
            return {"failed": f"{type(error).__name__}: {words}".replace(str(root), "")}
        return {"result": result, "log": Path(log).read_bytes() if log and Path(log).is_file() else None}


@contextlib.contextmanager
def _log_file(below: Path) -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="dvp-", dir=below) as folder:
        yield str(Path(folder) / "log.mcap")


def _differing(job: Job) -> str:
    if job.ads:
        stack = Path(job.ads.rpartition(":")[0])
        if not stack.is_file():
            return f"{stack} is not there: a driving stack of your own must lie at the same place on every machine"
        return f"{stack.parent}: its Python files differ, or changed since the worker began"
    return "a file of the job differs"
