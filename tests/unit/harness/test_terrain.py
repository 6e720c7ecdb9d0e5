"""The ground under the car on a road that climbs 5 %."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network
from pytest_dvp.drive.run import run
from pytest_dvp.drive.terrain import Terrain
from tests.plugin.conftest import XODR, write_scenario
from tests.unit.harness.conftest import OneTrick, coast

CLIMB = math.atan(0.05)
HILL = XODR.replace(
    "    <lanes>", '    <elevationProfile><elevation s="0" a="2" b="0.05" c="0" d="0"/></elevationProfile>\n    <lanes>'
)


@pytest.fixture
def hill(tmp_path: Path) -> RoadNetwork:
    (tmp_path / "hill.xodr").write_text(HILL)
    return load_network(tmp_path / "hill.xodr")


def test_height_follows_the_profile(hill: RoadNetwork) -> None:
    assert Terrain(hill).under(100.0, -1.75, 0.0)[0] == pytest.approx(2.0 + 0.05 * 100.0, abs=0.01)


@pytest.mark.parametrize(
    ("yaw", "grade", "bank"),
    [(0.0, CLIMB, 0.0), (math.pi, -CLIMB, 0.0), (math.pi / 2, 0.0, -CLIMB), (-math.pi / 2, 0.0, CLIMB)],
)
def test_slopes_are_those_along_and_across_the_car(hill: RoadNetwork, yaw: float, grade: float, bank: float) -> None:
    assert Terrain(hill).under(100.0, -1.75, yaw)[1:] == pytest.approx((grade, bank), abs=1e-3)


def test_a_flat_road_need_not_be_asked(tmp_path: Path) -> None:
    (tmp_path / "flat.xodr").write_text(XODR)
    assert Terrain(load_network(tmp_path / "flat.xodr")).flat


def test_a_coasting_car_slows_down_uphill_by_the_component_of_gravity(tmp_path: Path) -> None:
    def loss(road: str) -> float:
        path = write_scenario(tmp_path)
        (tmp_path / "straight.xodr").write_text(road)
        speed = run(path, ads=OneTrick(coast), duration=2.0).log["v"]
        return float(speed[100] - speed[200])

    # 1 s at g sin(slope), less what the turning motor adds to the mass (0.03 kg m^2 at 5.8:1: 1.7 %)
    assert loss(HILL) - loss(XODR) == pytest.approx(9.81 * math.sin(CLIMB), rel=0.03)
