"""urban.net.xml: SUMO reads it, its lanes lie on those of urban.xodr, and it says nothing about where it was made."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from openscenario.road.network import load_network

DRIVE = """
import libsumo
libsumo.start(["sumo", "-n", {net!r}, "-r", {routes!r}, "--step-length", "0.1", "--no-step-log", "true", "--seed", "7"])
seen = set()
while libsumo.simulation.getMinExpectedNumber() and libsumo.simulation.getTime() < 120:
    libsumo.simulationStep()
    seen.update(libsumo.vehicle.getIDList())
print(sorted(seen), libsumo.simulation.getMinExpectedNumber(), libsumo.simulation.getCollidingVehiclesNumber())
"""


def points(lane: ElementTree.Element) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in (pair.split(",")[:2] for pair in lane.attrib["shape"].split())]


def test_lanes_lie_in_the_middle_of_those_of_the_road(scenarios_dir: Path) -> None:
    network = load_network(scenarios_dir / "urban.xodr")
    root = ElementTree.parse(scenarios_dir / "urban.net.xml").getroot()
    for edge in root.iter("edge"):
        if edge.get("function") == "internal":
            continue
        for x, y in points(edge[0]):
            place = network.locate(x, y)
            assert place.on_road
            # The net's bends are polygons with half a metre between their corners, its ends are cut straight.
            assert abs(place.offset) < 0.1


def test_nobody_walks_or_drives_where_he_must_not(scenarios_dir: Path) -> None:
    root = ElementTree.parse(scenarios_dir / "urban.net.xml").getroot()
    for lane in root.iter("lane"):
        assert float(lane.attrib["width"]) == 3.5  # sidewalks have 2 m
        assert "passenger" in lane.attrib["allow"].split()
        assert "pedestrian" not in lane.attrib["allow"].split()


def test_file_knows_no_time_and_no_machine(scenarios_dir: Path) -> None:
    text = (scenarios_dir / "urban.net.xml").read_text()
    assert "generated on" not in text
    assert "/home" not in text
    assert ".xodr" not in text


def test_both_cars_drive_their_routes_to_the_end(scenarios_dir: Path) -> None:
    pytest.importorskip("libsumo")
    files = {"net": str(scenarios_dir / "urban.net.xml"), "routes": str(scenarios_dir / "urban.rou.xml")}
    # In a process of its own: libsumo holds one simulation a process.
    run = subprocess.run([sys.executable, "-c", DRIVE.format(**files)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "['ahead', 'towards'] 0 0"


def test_file_is_what_its_script_makes(scenarios_dir: Path, tmp_path: Path) -> None:
    pytest.importorskip("sumo", reason="eclipse-sumo, which brings netconvert, is not installed")
    make_sumo_net = pytest.importorskip("scripts.make_sumo_net", reason="scripts/ is not on the path")
    make_sumo_net.main([str(scenarios_dir / "urban.xodr"), str(tmp_path / "urban.net.xml")])
    assert (tmp_path / "urban.net.xml").read_text() == (scenarios_dir / "urban.net.xml").read_text()
