"""Options of what simulates in parallel and keeps what it simulated: `dvp tune`, `dvp iterate`, `dvp mutate`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import root_here
from pytest_dvp.text.errors import SettingError

if TYPE_CHECKING:
    from pytest_dvp.workers.pool import Workers


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Declare `--jobs` and `--scheduler`: where simulations run. Results do not depend on them."""
    parser.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="number of processes; default: one for each core. Results do not depend on it",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of a `dask scheduler`, as tcp://host:8786, whose workers simulate (extra cluster)",
    )
    parser.add_argument(
        "--cache", metavar="DIR", help="folder of stored simulations; default: ROOTDIR/runs/tuning/cache"
    )


def check_workers(arguments: argparse.Namespace) -> None:
    """Raises SettingError for options that cannot be; connects to nothing."""
    if arguments.jobs is not None and arguments.jobs < 1:
        raise SettingError(f"--jobs is {arguments.jobs}, expected a whole number >= 1")
    if arguments.jobs is not None and arguments.scheduler is not None:
        raise SettingError(
            f"--jobs {arguments.jobs} and --scheduler {arguments.scheduler}, expected one of them: --jobs counts "
            "processes of this machine; how many each machine gives says `dask worker --nworkers N`"
        )


@contextmanager
def workers(
    arguments: argparse.Namespace, tick: Callable[[str], None], work: Callable[[Any], dict[str, Any]] | None = None
) -> Iterator[Workers]:
    """What was asked for: processes of this machine, or the workers of a scheduler. work: what a job gives, None for
    what tuning needs. Raises SettingError."""
    from pytest_dvp.workers.cache import Cache
    from pytest_dvp.workers.pool import Workers
    from pytest_dvp.workers.run_job import work as metrics_of

    does = work or metrics_of
    cache = Cache(Path(arguments.cache) if arguments.cache else root_here() / "runs" / "tuning" / "cache")
    if arguments.scheduler is None:
        with Workers(cache, arguments.jobs or os.cpu_count() or 1, tick, work=does) as found:
            yield found
        return
    from pytest_dvp.workers.dask_cluster import Cluster

    tick(f"connecting to {arguments.scheduler}")
    with Cluster(arguments.scheduler) as cluster, Workers(cache, tick=tick, work=does, cluster=cluster) as found:
        yield found
