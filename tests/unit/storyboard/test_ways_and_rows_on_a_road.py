"""Who wanders about a road network, and what a scenario that is played writes of it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork
from openscenario.storyboard.play import play
from openscenario.storyboard.routes import wander

from .conftest import Make, lane_position, speed, teleport

# --- routes

ROADS = {"1": 100.0, "2": 50.0, "3": 70.0}
SIGNS = {("1", -1): 1, ("2", -1): 1, ("3", 1): -1}
AFTER = {("1", -1): [("2", -1)], ("2", -1): [("3", 1)], ("3", 1): []}


@pytest.mark.parametrize(("length", "lanes"), [(90.0, 1), (100.0, 1), (101.0, 2), (150.0, 2), (151.0, 3), (1e6, 3)])
def test_who_wanders_has_so_many_metres_of_lanes_ahead_of_it(length: float, lanes: int) -> None:
    """Each from its beginning to its end as its traffic drives, until no other follows."""
    network = SimpleNamespace(
        roads={name: SimpleNamespace(length=end) for name, end in ROADS.items()},
        driving_sign=lambda road, lane, s: SIGNS[road, lane],
        lane_successors=lambda road, lane: AFTER[road, lane],
    )
    board: Any = SimpleNamespace(network=network, random=SimpleNamespace(choice=lambda ways: ways[0]))
    entity: Any = SimpleNamespace(road="1", lane=-1, s=60.0)
    found = [(each.road, each.lane, each.s_from, each.s_to) for each in wander(board, entity, length)]
    assert found == [("1", -1, 0.0, 100.0), ("2", -1, 0.0, 50.0), ("3", 1, 70.0, 0.0)][:lanes]


def test_play_has_a_row_of_each_entity_each_twentieth_of_a_second(make: Make, road: Path, network: RoadNetwork) -> None:
    make(A=[teleport(lane_position(100.0)), speed(10.0)], B=[teleport(lane_position(200.0, 1)), speed(10.0)])
    for dt in (0.01, 0.05, 0.1):
        rows = play(read_scenario(road.parent / "scenario.xosc"), network, dt, 1.0).rows
        step = max(dt, 0.05)
        for name, x, way in (("A", 100.0, 1.0), ("B", 200.0, -1.0)):
            mine = [row for row in rows if row.entity == name]
            assert [row.time for row in mine] == pytest.approx([step * k for k in range(round(1.0 / step) + 1)])
            assert [row.x for row in mine] == pytest.approx([x + way * 10.0 * row.time for row in mine], abs=1e-6)
            assert all(row.speed == 10.0 for row in mine)
