"""A campaign on the workers of a dask scheduler: the same rows, whoever dies meanwhile."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row, Store, StoreError

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "tuning")]
import farm  # noqa: E402
import on_cluster  # noqa: E402
import planted  # noqa: E402


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[farm.Farm]:
    pytest.importorskip("distributed", reason="needs the extra cluster")
    found = farm.Farm(tmp_path_factory.mktemp("farm"))
    yield found
    found.close()


def begun(folder: Path, running: farm.Farm, runs: int, work: str) -> subprocess.Popen[bytes]:
    """A campaign in a process of its own: a client whose scheduler is killed leaves open sockets behind."""
    return subprocess.Popen([sys.executable, on_cluster.__file__, str(folder), running.address, str(runs), work])


def rows(folder: Path) -> list[Row]:
    """The rows of a campaign in the order of their keys, without what they cost; none before it has begun."""
    try:
        with Store(folder) as store:
            return sorted((dataclasses.replace(row, cpu=0.0) for row in store.rows()), key=lambda row: row.key)
    except StoreError:
        return []


def expected(folder: Path, runs: int) -> list[Row]:
    """The rows of the same campaign, driven in this process."""
    with Store(folder / "local", writes=True) as store:
        one = planted.campaign(folder / "scenario", store)
        one.rows(sample("sobol", one.space.axes, runs, 7), "sample")
    return rows(folder / "local")


def wait_for(folder: Path, count: int, running: subprocess.Popen[bytes]) -> None:
    """Until the store of a campaign that runs holds so many rows."""
    while len(rows(folder / "out")) < count:
        assert running.poll() is None
        time.sleep(0.05)


@pytest.mark.nightly
def test_rows_are_those_of_one_process_and_a_dead_worker_loses_none(running: farm.Farm, tmp_path: Path) -> None:
    running.staffed(2)
    assert begun(tmp_path, running, 60, "deadly_once").wait(60.0) == 0
    assert running.mark.exists()
    assert rows(tmp_path / "out") == expected(tmp_path, 60)


@pytest.mark.nightly
def test_neither_a_killed_command_nor_a_killed_scheduler_loses_a_row(running: farm.Farm, tmp_path: Path) -> None:
    running.staffed(2)
    first = begun(tmp_path, running, 300, "slow")
    wait_for(tmp_path, 20, first)
    first.kill()
    assert first.wait() != 0
    again = begun(tmp_path, running, 300, "slow")
    wait_for(tmp_path, len(rows(tmp_path / "out")) + 20, again)
    running.restarted()
    running.staffed(1)
    assert again.wait(90.0) == 0
    assert rows(tmp_path / "out") == expected(tmp_path, 300)
