"""Sampled road geometry of an independent implementation (esmini 3.6.0): every lane point, heading, height and width.

Heading differs from theirs nowhere by more than 1 mrad; positions agree within 1 cm (in fact within 0.1 mm).
"""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

from openscenario.road.network import RoadNetwork, load_network
from openscenario.road.opendrive import examine_opendrive

MAX_POSITION = 0.01  # m
MAX_HEADING = 1e-3  # rad
ROADS = [
    "AB_RQ31_Straight",
    "StraightRoad_NCAP_Roadmarks",
    "X-Intersection_NCAP",
    "alks_road_different_curvatures",
    "alks_road_left_radius_250m",
    "alks_road_right_radius_1000m",
    "alks_road_straight",
    "circle_300m",
    "crest-curve",
    "curve_r100",
    "curves",
    "curves_elevation",
    "e6mini",
    "e6mini-lht",
    "fabriksgatan",
    "jolengatan",
    "multi_intersections",
    "parking_demo",
    "soderleden",
    "straight_500m",
    "straight_500m_signs",
    "tunnels",
    "two_plus_one",
    "velodrome",
    "ut_Junction_with_building0",
    "ut_find_closest_road_pos",
    "ut_highway_example_with_merge_and_split",
    "ut_highway_exit",
    "ut_mw_100m",
    "ut_offset",
    "ut_pitch_by_super_elevation",
    "ut_route_strategy_test_road",
    "ut_simple_4way_intersection",
    "ut_slope_up_leaning_right",
    "ut_slope_up_slope_down",
    "ut_star",
    "ut_straight_2x100m_opposite",
    "ut_straight_500_superelevation_elevation",
    "ut_straight_500_superelevation_elevation_curve",
    "ut_two_roads_overhang",
]


def road_file(shared: Path, name: str) -> Path:
    """The corpus file that a reference was sampled from; `ut_` marks those of esmini's unit tests."""
    unit = name.startswith("ut_")
    found = [
        path
        for path in sorted((shared / "openscenario" / "corpus").rglob(f"{name.removeprefix('ut_')}.xodr"))
        if ("Unittest" in path.parts) == unit
    ]
    return found[0]


def rows(shared: Path, name: str) -> list[dict[str, str]]:
    path = shared / "openscenario" / "reference" / "odr" / f"{name}.csv"
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def shift(net: RoadNetwork) -> tuple[float, float]:
    """How far [m] the header's offset takes us beside the reference, which shifts first and turns then.

    ASAM OpenDRIVE 1.8, 8.5: `xWorld = xODR * cos(hdg) - yODR * sin(hdg) + xOffset`, and y likewise.
    """
    dx, dy, _, turn = net.file.geo_offset
    c, s = math.cos(turn), math.sin(turn)
    return dx - (c * dx - s * dy), dy - (s * dx + c * dy)


def errors(net: RoadNetwork, reference: list[dict[str, str]]) -> tuple[float, float, float, float]:
    """Largest error of position, height, heading and lane width."""
    position = height = heading = width = 0.0
    dx, dy = shift(net)
    for row in reference:
        road, lane, s = row["road"], int(row["lane"]), float(row["s"])
        pose = net.lane_pose(road, lane, s)
        position = max(position, math.hypot(pose.x - dx - float(row["x"]), pose.y - dy - float(row["y"])))
        height = max(height, abs(pose.z - float(row["z"])))
        heading = max(heading, abs(math.remainder(pose.h - float(row["h"]), 2.0 * math.pi)))
        width = max(width, abs(net.lane_width(road, lane, s) - float(row["width"])))
    return position, height, heading, width


@pytest.mark.parametrize("name", ROADS)
def test_lane_points_agree(shared_dir: Path, name: str) -> None:
    reference = rows(shared_dir, name)
    position, height, heading, width = errors(load_network(road_file(shared_dir, name)), reference)
    assert len(reference) >= 12
    assert position < MAX_POSITION
    assert height < MAX_POSITION
    assert width < MAX_POSITION
    assert heading < MAX_HEADING


def test_no_sampled_road_is_left_out(shared_dir: Path) -> None:
    """Roads that are copies of each other are compared once."""
    sampled = {path.stem for path in (shared_dir / "openscenario" / "reference" / "odr").glob("*.csv")}
    copies = {
        *(
            "StraightRoad_NCAP_noRoadmarks",
            "StraightRoad_NCAP_noRoadmarks_Streetlights",
            "X-Intersection_NCAP_noRoadmarks",
        ),
        *("StraightRoad_NCAP_noRoadmarks_Streetlights_Nearside", "alks_road_left_radius_1000m"),
        *("alks_road_right_radius_250m", "fabriksgatan_traffic_lights", "ut_Weird_looking_building_road_coord"),
        *("ut_multi_intersections", "ut_simple_highway", "ut_some_signs", "ut_straight_3000m"),
        *("ut_straight_highway_500m", "ut_straight_road"),
    }
    assert sampled - set(ROADS) == copies


@pytest.mark.parametrize("name", ["fabriksgatan", "soderleden", "two_plus_one", "velodrome", "e6mini-lht"])
def test_lane_points_are_found_again(shared_dir: Path, name: str) -> None:
    net = load_network(road_file(shared_dir, name))
    for row in rows(shared_dir, name)[::3]:
        lane, s = int(row["lane"]), float(row["s"])
        if lane == 0 or net.lane_type(row["road"], lane, s) != "driving" or float(row["width"]) < 0.1:
            continue
        x, y, z = float(row["x"]), float(row["y"]), float(row["z"])
        h = float(row["h"]) + (0.0 if net.driving_sign(row["road"], lane, s) > 0 else math.pi)
        found = net.locate(x, y, h, z=z)
        pose = net.lane_pose(found.road, found.lane, found.s, found.offset)
        assert found.on_road
        assert math.hypot(pose.x - x, pose.y - y) < 1e-3
        if net.roads[row["road"]].junction == "-1":
            assert (found.road, found.lane) == (row["road"], lane)


def bad_roads(shared: Path) -> list[dict[str, Any]]:
    text = (shared / "bad_inputs" / "manifest.jsonl").read_text().splitlines()
    return [entry for entry in map(json.loads, text) if entry["kind"] in ("xodr", "xodr-asam")]


def last_step(element: str) -> str:
    """Tag and attribute of an element's path, without the number that tells it from its siblings."""
    return re.sub(r"\[\d+\]", "", element.rpartition("/")[2])


def test_bad_roads_are_refused_at_the_right_place(shared_dir: Path) -> None:
    entries = bad_roads(shared_dir)
    assert len(entries) >= 12
    for entry in entries:
        findings = examine_opendrive(shared_dir / "bad_inputs" / entry["file"])[1]
        faults = [finding for finding in findings if finding.severity == "error"]
        expected = entry["expect"]["line"], last_step(entry["expect"]["element"] or "")
        places = [(finding.line, last_step(finding.element) if expected[1] else "") for finding in faults]
        assert expected in places, (entry["id"], expected, places)


def test_good_roads_of_the_same_set_are_accepted(shared_dir: Path) -> None:
    for name in ("straight", "test"):
        assert examine_opendrive(shared_dir / "bad_inputs" / f"{name}.xodr")[1] == ()
