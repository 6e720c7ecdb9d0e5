"""A job in a worker process of dask.distributed: done as at home, or refused, because this machine is not alike."""

from __future__ import annotations

import dataclasses
import os
import platform
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from pytest_dvp.tuning.installed import first_difference, installed
from pytest_dvp.tuning.job import Job
from pytest_dvp.tuning.parcel import Contents, moved, placed, put_down

ONE_THREAD = "--nthreads 1 (and --nworkers N for N at once): a process does one simulation at a time"


def order(job: Job) -> str:
    """A job as plain text, its files by absolute paths: what comes over the wire is read, not executed."""
    absolute = moved(job, os.path.abspath)
    return msgspec.json.encode(dataclasses.replace(absolute, save=None)).decode()


def whole(contents: Contents) -> Contents:
    """Contents of a parcel as a task of their own: they wander between workers, and come back if one dies."""
    return contents


def worked(
    what: Callable[[Job], dict[str, Any]],
    text: str,
    key: str,
    keep_log: bool,
    home: Mapping[str, str],
    *parcels: Contents,
) -> dict[str, Any]:
    """`{"result", "log"}` of a job, its log as bytes; or `{"refused"}`, or `{"failed"}`; each with `where`.

    text: an `order`; key: the job's where it comes from, so that nothing runs here on other files or sources; home:
    what is `installed` there.
    """
    from distributed import get_worker

    worker = get_worker()
    where = {"where": f"{worker.address} on {platform.node()}"}
    if differs := first_difference(home, installed()):
        return {**where, "refused": differs}
    if worker.state.nthreads > 1:
        return {**where, "refused": f"it has {worker.state.nthreads} threads, start it with {ONE_THREAD}"}
    below = Path(worker.local_directory)
    root = put_down(parcels, below / "dvp-files")
    asked = msgspec.json.decode(text, type=Job)

    def here(path: str) -> str:
        there = placed(path, root)
        return there if Path(there).exists() else path  # what is not carried must lie at the same place

    job = moved(asked, here)
    try:
        same = job.key == key
    except OSError as error:
        return {**where, "refused": f"{error.filename} is not there"}
    if not same:
        return {**where, "refused": _differing(job)}
    with tempfile.TemporaryDirectory(prefix="dvp-", dir=below) as folder:
        log = Path(folder) / "log.mcap"
        try:
            result = what(dataclasses.replace(job, save=str(log)) if keep_log else job)
        except Exception as error:  # whatever it is, it is plain text that goes back
            words = " ".join(str(error).split())
            return {**where, "failed": f"{type(error).__name__}: {words}".replace(str(root), "")}
        return {**where, "result": result, "log": log.read_bytes() if keep_log and log.is_file() else None}


def _differing(job: Job) -> str:
    if job.ads:
        stack = Path(job.ads.rpartition(":")[0])
        if not stack.is_file():
            return f"{stack} is not there: a driving stack of your own must lie at the same place on every machine"
        return f"{stack.parent}: its Python files differ, or changed since the worker began"
    return "a file of the job differs"
