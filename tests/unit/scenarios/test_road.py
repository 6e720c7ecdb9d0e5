"""urban.xodr: valid, closed and smooth; checked without the code that made it."""

from __future__ import annotations

from importlib.util import find_spec
from itertools import pairwise
from math import atan2, cos, hypot, pi, sin
from pathlib import Path

import pytest
from lxml import etree
from scipy.integrate import quad

SUM_OF_GAPS = 1e-6  # m and rad; what a road may be off where two pieces meet


@pytest.fixture(scope="module")
def road_file(scenarios_dir: Path) -> etree._Element:
    return etree.parse(str(scenarios_dir / "urban.xodr")).getroot()


def curvature(geometry: etree._Element) -> tuple[float, float]:
    shape = geometry[0]
    if shape.tag == "line":
        return 0.0, 0.0
    if shape.tag == "arc":
        return float(shape.get("curvature")), float(shape.get("curvature"))
    return float(shape.get("curvStart")), float(shape.get("curvEnd"))


def start_of(geometry: etree._Element) -> tuple[float, float, float]:
    return float(geometry.get("x")), float(geometry.get("y")), float(geometry.get("hdg"))


def end_of(geometry: etree._Element) -> tuple[float, float, float]:
    """Pose at the end by adaptive quadrature of the heading."""
    x, y, heading = start_of(geometry)
    length = float(geometry.get("length"))
    k0, k1 = curvature(geometry)

    def at(s: float) -> float:
        return heading + k0 * s + 0.5 * (k1 - k0) / length * s * s

    dx = quad(lambda s: cos(at(s)), 0.0, length, epsabs=1e-12)[0]
    dy = quad(lambda s: sin(at(s)), 0.0, length, epsabs=1e-12)[0]
    return x + dx, y + dy, at(length)


def gap(a: tuple[float, float, float], b: tuple[float, float, float], turned: float = 0.0) -> float:
    turn = a[2] - b[2] + turned
    return hypot(a[0] - b[0], a[1] - b[1]) + abs(atan2(sin(turn), cos(turn)))


def plan(root: etree._Element, road: str) -> list[etree._Element]:
    return list(root.find(f"road[@id='{road}']/planView"))


def test_valid_against_the_1_7_schema(road_file: etree._Element) -> None:
    spec = find_spec("scenariogeneration")
    if spec is None or spec.origin is None:
        pytest.skip("scenariogeneration, which brings the schemas, is not installed")
    schema = Path(spec.origin).parents[1] / "schemas" / "opendrive_17_core.xsd"
    etree.XMLSchema(etree.parse(str(schema))).assertValid(road_file)


def test_pieces_of_every_road_meet(road_file: etree._Element) -> None:
    for road in road_file.iter("road"):
        pieces = list(road.find("planView"))
        for before, after in pairwise(pieces):
            assert gap(end_of(before), start_of(after)) < SUM_OF_GAPS


def test_curvature_has_no_jumps_on_the_loop(road_file: etree._Element) -> None:
    pieces = [piece for road in "123456" for piece in plan(road_file, road)]
    for before, after in pairwise(pieces):
        assert curvature(before)[1] == pytest.approx(curvature(after)[0], abs=1e-9)


def test_linked_roads_meet_with_both_ends(road_file: etree._Element) -> None:
    for road in road_file.iter("road"):
        pieces = list(road.find("planView"))
        for tag, here in (("predecessor", start_of(pieces[0])), ("successor", end_of(pieces[-1]))):
            link = road.find(f"link/{tag}")
            if link is None or link.get("elementType") != "road":
                continue
            other = plan(road_file, link.get("elementId"))
            contact = link.get("contactPoint")
            there = start_of(other[0]) if contact == "start" else end_of(other[-1])
            # Entering at its end, or leaving it backwards, the other road runs against this one.
            against = contact == ("start" if tag == "predecessor" else "end")
            assert gap(here, there, pi if against else 0.0) < SUM_OF_GAPS


def test_loop_closes_and_measures_600_m(road_file: etree._Element) -> None:
    roads = [plan(road_file, road) for road in ("1", "2", "3", "4", "5", "6", "11")]
    assert gap(end_of(roads[-1][-1]), start_of(roads[0][0])) < SUM_OF_GAPS
    length = sum(float(piece.get("length")) for pieces in roads for piece in pieces)
    assert length == pytest.approx(600.0, abs=20.0)


def test_no_bend_of_the_loop_is_tighter_than_15_m(road_file: etree._Element) -> None:
    tightest = max(abs(k) for road in "123456" for piece in plan(road_file, road) for k in curvature(piece))
    assert 1.0 / tightest >= 15.0 - 1e-6


def test_junction_connects_every_arm_with_every_other(road_file: etree._Element) -> None:
    ways = set()
    for connection in road_file.iter("connection"):
        road = road_file.find(f"road[@id='{connection.get('connectingRoad')}']")
        ways.add((connection.get("incomingRoad"), road.find("link/successor").get("elementId")))
        assert connection.find("laneLink") is not None
    assert ways == {(a, b) for a in ("1", "6", "7") for b in ("1", "6", "7") if a != b}


def test_crosswalk_spans_the_carriageway(road_file: etree._Element) -> None:
    (crosswalk,) = [item for item in road_file.iter("object") if item.get("type") == "crosswalk"]
    across = [float(corner.get("v")) for corner in crosswalk.iter("cornerLocal")]
    assert (min(across), max(across)) == (-3.5, 3.5)


def test_file_is_what_its_script_makes(scenarios_dir: Path, tmp_path: Path) -> None:
    make_urban_road = pytest.importorskip("scripts.make_urban_road", reason="scripts/ is not on the path")
    make_urban_road.main([str(tmp_path / "urban.xodr")])
    assert (tmp_path / "urban.xodr").read_text() == (scenarios_dir / "urban.xodr").read_text()
