"""A campaign without a simulator on the workers of a scheduler, as a process that can be killed.

python on_cluster.py FOLDER ADDRESS RUNS WORK    WORK: the name of a function below; ADDRESS local: two processes here
"""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import planted

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.crew import LocalCrew
from pytest_dvp.campaigns.one_drive import Drive
from pytest_dvp.campaigns.parameter_space import space_of
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row, Store
from pytest_dvp.drive.run_spec import RunSpec

DIES = "DVP_TEST_DIES"  # variable: a file that a worker makes when it dies; `farm.py` sets it


def slow(order: Drive) -> Row:
    """A drive that takes a while: time to kill somebody."""
    time.sleep(0.02)
    return planted.corner(order)


def noted(order: Drive) -> Row:
    """The same, and a line in driven.txt beside the store."""
    row = slow(order)
    with (Path(order.folder).parent / "driven.txt").open("a") as file:
        file.write(f"{order.key}\n")
    return row


def deadly_once(order: Drive) -> Row:
    """Ends its worker process at the first drive with a > 0.5."""
    mark = Path(os.environ[DIES])
    if float(order.parameters["a"]) > 0.5 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return planted.corner(order)


def main() -> None:
    from pytest_dvp.campaigns.cluster_crew import ClusterCrew

    folder, address, runs, work = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), globals()[sys.argv[4]]
    settings = RunSpec()
    scenario = planted.scenario(folder / "scenario")
    crew = LocalCrew(2, work) if address == "local" else ClusterCrew(address, work)
    with Store(folder / "out", writes=True) as store, crew:
        one = Campaign(space_of(scenario, settings), settings, store, crew)
        one.rows(sample("sobol", one.space.axes, runs, 7), "sample")


if __name__ == "__main__":
    sys.modules["on_cluster"] = sys.modules["__main__"]
    for each in (slow, noted, deadly_once):
        each.__module__ = "on_cluster"  # a worker imports it by its name
    main()
