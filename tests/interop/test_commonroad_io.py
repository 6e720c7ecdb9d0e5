"""Our reader of CommonRoad against commonroad-io, which needs an old protobuf and so an environment of its own:

python -m venv cr && cr/bin/pip install commonroad-io
DVP_COMMONROAD_PYTHON=cr/bin/python pytest tests/interop/test_commonroad_io.py
"""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from openscenario.commonroad.roads import Map
from openscenario.commonroad.source import read
from openscenario.read import read_scenario
from openscenario.road.network import load_network
from openscenario.storyboard.engine import Storyboard
from openscenario.xml import read_xml
from tests.unit.commonroad.commonroad_files import (
    after,
    before,
    beside,
    dynamic,
    lanelet,
    problem,
    scenario,
    static,
    two_lanes,
)

PYTHON = os.environ.get("DVP_COMMONROAD_PYTHON", "")
ORACLE = Path(__file__).with_name("commonroad_oracle.py")
pytestmark = pytest.mark.skipif(not PYTHON, reason="DVP_COMMONROAD_PYTHON names no Python with commonroad-io")


def bends() -> list[str]:
    """Two lanes side by side on a bend of 60 m, and what follows them."""
    angles = [math.radians(4.0 * n) for n in range(16)]
    rings = [[(60 + r * math.sin(a), 60 - r * math.cos(a)) for a in angles] for r in (56.5, 60.0, 63.5)]
    ends = [ring[-1] for ring in rings]
    on = [[end, (end[0] + 40 * math.cos(1.0472), end[1] + 40 * math.sin(1.0472))] for end in ends]
    return [
        lanelet(21, rings[0], rings[1], more=after(23) + beside("Right", 22)),
        lanelet(22, rings[1], rings[2], more=after(24) + beside("Left", 21)),
        lanelet(23, on[0], on[1], more=before(21) + beside("Right", 24)),
        lanelet(24, on[1], on[2], more=before(22) + beside("Left", 23)),
    ]


CAR = [(k, 50.0 + 0.8 * k, -1.75, 0.01 * k, 8.0) for k in range(60)]


def test_lanelets_obstacles_and_the_start_agree(tmp_path: Path) -> None:
    path = tmp_path / "x.xml"
    parts = *two_lanes(), *bends(), dynamic(10, CAR), static(11, 150.0, -5.25)
    path.write_text(scenario(*parts, problem(40.0, -5.25, 8.0, '<lanelet ref="3"/>')))
    told = subprocess.run([PYTHON, str(ORACLE), str(path)], capture_output=True, text=True, check=True)
    theirs: dict[str, Any] = json.loads(told.stdout.splitlines()[-1])
    net, ours = load_network(path), Map(read(read_xml(path).root, str(path)))
    for name, lane in theirs["lanelets"].items():
        road, number = ours.places[int(name)]
        way = 0.0
        ways = [0.0]
        for a, b in zip(lane["centre"], lane["centre"][1:], strict=False):
            way += math.dist(a, b)
            ways.append(way)
        for part, (x, y) in zip(ways, lane["centre"], strict=True):
            share = part / way if number < 0 else 1.0 - part / way
            pose = net.lane_pose(road, number, share * net.roads[road].length)
            assert math.dist((pose.x, pose.y), (x, y)) < 0.05
        assert {each for each, _ in net.lane_successors(road, number)} == {
            ours.places[each][0] for each in lane["successors"]
        }
    board = Storyboard(read_scenario(path), net)
    board.start()
    ego = board.entities["Ego"]
    middle = ego.x + ego.center_x * math.cos(ego.h), ego.y + ego.center_x * math.sin(ego.h)
    assert [*middle, ego.h, ego.speed] == pytest.approx(theirs["ego"])
    board.settle()
    for step, x, y, h in theirs["obstacles"]["10"][1:50]:
        while board.time < step * theirs["dt"] - 1e-9:
            board.step(0.05)
        car = board.entities["obstacle10"]
        assert [car.x, car.y, math.remainder(car.h - h, 2.0 * math.pi)] == pytest.approx([x, y, 0.0], abs=6e-3)
