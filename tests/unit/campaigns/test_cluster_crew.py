"""The crew of a campaign on a cluster, where the scheduler goes at an awkward moment; without a cluster."""

from __future__ import annotations

import queue
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.campaigns.cluster_crew import ClusterCrew
from pytest_dvp.campaigns.one_drive import Drive
from pytest_dvp.workers.dask_cluster import Cluster

sys.path.insert(0, str(Path(__file__).parent))
import planted

ORDERS = [Drive(str(k), "base", "sample", "x.xosc", {"a": "0.5", "b": "0.5"}, {}, ".") for k in range(3)]


def closed(*_: Any, **__: Any) -> None:
    raise RuntimeError("Client is closed. Can't send update-graph message.")


@pytest.mark.parametrize(("status", "raised"), [("closed", ConnectionError), ("running", RuntimeError)])
def test_what_the_scheduler_did_not_take_is_handed_out_again(status: str, raised: type[Exception]) -> None:
    """The client knows that the connection has gone only when it sends; with a connection, the error is another one."""
    crew = ClusterCrew("tcp://nowhere:1", planted.corner)
    client = SimpleNamespace(status=status, submit=closed)
    crew._cluster = SimpleNamespace(client=client, home={}, worker_count=lambda: 2)  # type: ignore[assignment]
    crew._packed["base"] = []
    crew._cost = 1.0
    waiting, again = iter(ORDERS), []
    with pytest.raises(raised):
        crew._hand_out(waiting, again, {}, queue.SimpleQueue())
    assert again == ([ORDERS[:2]] if status == "closed" else [])
    assert list(waiting) == ORDERS[2:]


@pytest.mark.parametrize(
    ("told", "count"), [({}, 0), ({"workers": {"a": {}}}, 1), ({"n_workers": 7, "workers": {"a": {}}}, 7)]
)
def test_workers_are_counted_also_while_the_connection_ends(told: dict[str, Any], count: int) -> None:
    cluster = Cluster.__new__(Cluster)
    cluster.client = SimpleNamespace(scheduler_info=lambda: told)
    assert cluster.worker_count() == count
