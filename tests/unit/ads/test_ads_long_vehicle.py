"""A bus or a truck stands in the lane: from behind, only its rear is in sight, and the rest is longer than a car's."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from ads_loop import TABBY

from ads.planning.following import find_lead
from pytest_dvp.drive.run import run
from vehicle.messages import Detection


def with_target(scenarios_dir: Path, folder: Path, length: float, width: float, height: float) -> Path:
    """overtaking.xosc with another standing vehicle; its rear is where the passenger car's is."""
    shutil.copytree(scenarios_dir, folder, ignore=shutil.ignore_patterns("__pycache__", "mcrpg"))
    catalogue = folder / "catalogs" / "vehicles" / "vehicle_catalog.xosc"
    text = catalogue.read_text()
    start = text.index('<Vehicle name="passenger_car"')
    car = text[start : text.index("</Vehicle>", start) + len("</Vehicle>")]
    for old, new in (
        ('name="passenger_car"', 'name="long"'),
        ('x="1.35"', f'x="{0.5 * length - 0.8}"'),
        ('width="1.8" length="4.3" height="1.5"', f'width="{width}" length="{length}" height="{height}"'),
        ('positionX="2.6"', f'positionX="{0.5 * length}"'),
    ):
        assert old in car
        car = car.replace(old, new)
    catalogue.write_text(text.replace("</Catalog>", car + "</Catalog>"))
    scenario = folder / "overtaking.xosc"
    head, tail = scenario.read_text().split('<ScenarioObject name="Target">')
    tail = tail.replace('entryName="passenger_car"', 'entryName="long"', 1)
    scenario.write_text(head + '<ScenarioObject name="Target">' + tail)
    return scenario


@pytest.mark.parametrize(
    ("length", "width", "height"), [(12.0, 2.5, 3.2), (16.5, 2.5, 3.8)], ids=["bus", "articulated truck"]
)
@pytest.mark.nightly(by_day=2)
def test_a_long_vehicle_is_overtaken_as_calmly_as_a_car(
    scenarios_dir: Path, tmp_path: Path, length: float, width: float, height: float
) -> None:
    file = with_target(scenarios_dir, tmp_path / "s", length, width, height)
    metrics = run(file, seed=0, rootdir=file.parent).metrics
    assert (metrics["collision"], metrics["tet"], metrics["goal_reached"]) == (0.0, 0.0, 1.0)
    assert metrics["max_jerk"] < 2.5


def lead(offset: float, back_at: float) -> tuple[float, float] | None:
    """What limits a car beside a bus, 10 m behind to 20 m before it; from `back_at` [m] its path is in the lane."""
    bus = Detection(0.0, "vehicle", 5.0, 0.0, 0.0, 30.0, 2.5, 0.0, 0.0, track=1)
    row = [-10.0, 20.0, -1.25, 1.25, 0.0, 0.0]
    return find_lead(0.0, 2.0, TABBY, lambda s: offset if s < back_at else 0.0, (bus,), [row])


def test_beside_a_long_vehicle_it_is_in_nobodys_way_while_the_path_leads_past_it() -> None:
    assert lead(3.0, 25.0) is None


def test_where_the_path_leads_back_into_a_long_vehicle_it_stops_before_that_place() -> None:
    free, speed = lead(3.0, 12.0)
    assert speed == 0.0
    front = TABBY.center_x + 0.5 * TABBY.length
    assert 12.0 - front - 4.0 <= free <= 14.0 - front - 4.0  # 4 m between bumpers, looked for every 2 m
