"""A campaign on the workers of a dask scheduler: the same rows, whoever dies meanwhile."""

from __future__ import annotations

import dataclasses
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.one_drive import Drive
from pytest_dvp.campaigns.parameter_space import space_of
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row, Store
from pytest_dvp.drive.run_spec import RunSpec

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "tuning")]
import farm  # noqa: E402
import planted  # noqa: E402

pytest.importorskip("distributed", reason="needs the extra cluster")
from pytest_dvp.campaigns.cluster_crew import ClusterCrew  # noqa: E402


@pytest.fixture
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[farm.Farm]:
    found = farm.Farm(tmp_path_factory.mktemp("farm"))
    found.staffed(2)
    yield found
    found.close()


def slowly(order: Drive) -> Row:
    """A drive that takes a while: time to kill somebody."""
    time.sleep(0.02)
    return planted.corner(order)


def deadly_once(order: Drive) -> Row:
    """Ends its worker process at the first drive with a > 0.5."""
    mark = Path(os.environ[farm.DIES])
    if float(order.parameters["a"]) > 0.5 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return planted.corner(order)


def rows(folder: Path, address: str, work: Callable[[Drive], Row], count: int = 60) -> list[Row]:
    """The rows of a campaign, in the order of their keys, without what they cost."""
    settings = RunSpec()
    scenario = planted.scenario(folder / "scenario")
    with Store(folder / "out", writes=True) as store, ClusterCrew(address, work, patience=30.0) as crew:
        one = Campaign(space_of(scenario, settings), settings, store, crew)
        one.rows(sample("sobol", one.space.axes, count, 7), "sample")
    with Store(folder / "out") as store:
        return sorted((dataclasses.replace(row, cpu=0.0) for row in store.rows()), key=lambda row: row.key)


def expected(folder: Path, count: int = 60) -> list[Row]:
    """The same, driven in this process."""
    with Store(folder / "local", writes=True) as store:
        one = planted.campaign(folder / "scenario", store)
        one.rows(sample("sobol", one.space.axes, count, 7), "sample")
        return sorted((dataclasses.replace(row, cpu=0.0) for row in store.rows()), key=lambda row: row.key)


def test_rows_are_those_of_one_process_and_a_dead_worker_loses_none(running: farm.Farm, tmp_path: Path) -> None:
    assert rows(tmp_path, running.address, deadly_once) == expected(tmp_path)
    assert running.mark.exists()


def test_a_scheduler_that_comes_back_is_found_and_nothing_is_lost(running: farm.Farm, tmp_path: Path) -> None:
    def kill() -> None:
        time.sleep(1.0)
        running.restarted()
        running.staffed(2)

    killer = threading.Thread(target=kill)
    killer.start()
    found = rows(tmp_path, running.address, slowly, 200)
    killer.join()
    assert found == expected(tmp_path, 200)
