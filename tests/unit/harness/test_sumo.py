"""Background traffic: SUMO's cars in our frame, and our boxes in SUMO's."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import libsumo
import pytest

from pytest_dvp.drive.sumo_traffic import Car, Mirrored, SumoTraffic, TrafficError
from pytest_dvp.drive.world import World
from vehicle.messages import OBJECT_KINDS

Traffic = SumoTraffic


@pytest.fixture
def traffic(scenarios_dir: Path) -> Iterator[Traffic]:
    opened = SumoTraffic(scenarios_dir / "urban.net.xml", scenarios_dir / "urban.rou.xml", 7)
    yield opened
    opened.close()


def drive(traffic: Traffic, ticks: int, *mirrored: Mirrored) -> list[list[Car]]:
    return [traffic.step(k / 20, lambda: mirrored) for k in range(ticks)]


def test_the_cars_of_the_route_file_drive(traffic: Traffic) -> None:
    seen = drive(traffic, 40)
    assert {car.name for cars in seen for car in cars} == {"ahead", "towards"}


def test_boxes_have_the_sizes_of_their_type(traffic: Traffic) -> None:
    car = drive(traffic, 1)[0][0]
    assert (car.length, car.width, car.height) == (4.3, 1.8, 1.5)


@pytest.mark.parametrize(
    ("sumo", "kind"),
    [("bicycle", "bicycle"), ("motorcycle", "bicycle"), ("truck", "vehicle"), ("passenger", "vehicle")],
)
def test_who_drives_is_of_the_kind_of_its_class(scenarios_dir: Path, tmp_path: Path, sumo: str, kind: str) -> None:
    """A camera must not take a cyclist of the route file for a car."""
    text = (scenarios_dir / "urban.rou.xml").read_text()
    routes = tmp_path / "classes.rou.xml"
    routes.write_text(text.replace('vClass="passenger"', f'vClass="{sumo}"'))
    net = tmp_path / "classes.net.xml"
    net.write_text((scenarios_dir / "urban.net.xml").read_text().replace('allow="passenger delivery bus"', ""))
    traffic = SumoTraffic(net, routes, 7)
    ego: Any = SimpleNamespace(name="Ego", kind="vehicle", active=True, x=0.0, y=0.0, z=0.0, h=0.0, speed=0.0)
    ego.visible = SimpleNamespace(traffic=False)
    storyboard: Any = SimpleNamespace(entities={"Ego": ego})
    size: Any = SimpleNamespace(length=4.0, width=2.0, center_x=1.0, mass=1000.0)
    world = World(storyboard, "Ego", size, {}, traffic)
    try:
        around = world.look(0.0)
    finally:
        world.close()
    assert around.names
    assert {OBJECT_KINDS[k] for k in around.kinds.tolist()} == {kind}


def test_a_route_that_nobody_can_drive_is_one_line_that_names_the_file(scenarios_dir: Path, tmp_path: Path) -> None:
    """SUMO lets a bicycle in, and finds out when it departs that the road is for cars."""
    routes = tmp_path / "bicycles.rou.xml"
    routes.write_text((scenarios_dir / "urban.rou.xml").read_text().replace('"passenger"', '"bicycle"'))
    traffic = SumoTraffic(scenarios_dir / "urban.net.xml", routes, 7)
    try:
        with pytest.raises(TrafficError, match=r"SUMO ends at t=0\.00 s: Vehicle 'ahead' is not allowed") as refused:
            traffic.step(0.0, list)
    finally:
        traffic.close()
    assert str(refused.value).startswith(f"{routes}: ")
    assert "\n" not in str(refused.value)


def test_a_car_moves_along_its_heading_at_its_speed(traffic: Traffic) -> None:
    cars = [next(car for car in cars if car.name == "ahead") for cars in drive(traffic, 21)]
    first, last = cars[0], cars[20]
    assert math.hypot(last.x - first.x, last.y - first.y) == pytest.approx(math.hypot(first.vx, first.vy), rel=0.05)
    assert math.atan2(last.y - first.y, last.x - first.x) == pytest.approx(first.yaw, abs=0.05) or first.yaw < -3.1


def test_a_car_stops_behind_a_mirrored_box(traffic: Traffic) -> None:
    start = next(car for car in drive(traffic, 1)[0] if car.name == "ahead")
    cos, sin = math.cos(start.yaw), math.sin(start.yaw)
    wall = Mirrored("Wall", start.x + 40 * cos, start.y + 40 * sin, start.yaw, 4.0, 1.8, 0.0)
    for k in range(1, 400):
        cars = traffic.step(k / 20, lambda: [wall])
    car = next(car for car in cars if car.name == "ahead")
    gap = math.hypot(car.x - wall.x, car.y - wall.y) - 0.5 * (car.length + wall.length)
    assert math.hypot(car.vx, car.vy) < 0.1
    assert 1.0 < gap < 4.0


def test_mirrored_boxes_are_not_given_back(traffic: Traffic) -> None:
    box = Mirrored("Ego", -1.75, 60.0, -math.pi / 2, 3.0, 1.5, 5.0)
    seen = drive(traffic, 10, box)
    assert set(libsumo.vehicle.getIDList()) == {"ahead", "towards", "dvp.Ego"}  # SUMO's drivers see it
    assert [{car.name for car in cars} for cars in seen] == [{"ahead", "towards"}] * 10


def test_the_same_seed_gives_the_same_traffic(scenarios_dir: Path) -> None:
    found = []
    for _ in range(2):
        traffic = SumoTraffic(scenarios_dir / "urban.net.xml", scenarios_dir / "urban.rou.xml", 7)
        found.append(drive(traffic, 100))
        traffic.close()
    assert found[0] == found[1]


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(TrafficError, match=r"net\.xml: no such file"):
        SumoTraffic(tmp_path / "net.xml", None, 7)


def test_a_file_that_is_no_net_is_named(scenarios_dir: Path) -> None:
    with pytest.raises(TrafficError, match=r"urban\.rou\.xml: no SUMO net"):
        SumoTraffic(scenarios_dir / "urban.rou.xml", None, 7)


def test_routes_that_are_none_are_named_and_a_mistake_in_them_with_its_line(
    tmp_path: Path, scenarios_dir: Path
) -> None:
    net, routes = scenarios_dir / "urban.net.xml", tmp_path / "a.rou.xml"
    with pytest.raises(TrafficError, match=r"urban\.net\.xml: no SUMO routes, it has no element <routes>"):
        SumoTraffic(net, net, 7)
    routes.write_text('<?xml version="1.0"?>\n<routes>\n<vType id="car"\n')
    with pytest.raises(TrafficError, match=r"a\.rou\.xml:\d: SUMO refuses it: unexpected end of input$"):
        SumoTraffic(net, routes, 7)


def test_a_second_simulation_in_one_process_is_refused(traffic: Traffic, scenarios_dir: Path) -> None:
    with pytest.raises(TrafficError, match="another SUMO simulation"):
        SumoTraffic(scenarios_dir / "urban.net.xml", None, 7)
