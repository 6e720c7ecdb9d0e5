"""The storyboard alone against recorded trajectories and storyboard events of an independent implementation.

Positions agree within the reference's own tolerance + 0.05 m, heading within 0.05 rad, speed within 0.2 m/s, and
every element reaches the same states at the same times within 30 ms. States are compared, not transitions: where
the reference ends an overridden event, the standard stops it (1.3, "Event priority"), and it stops instantaneous
global actions that the standard ends.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest

from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.nodes import Transition
from openscenario.storyboard.play import Row, play

HEADING = 0.05  # rad
SPEED = 0.2  # m/s
EVENTS = 0.03 + 1e-6  # s
SLACK = 0.05  # m

# the scenarios that the product's own closed loop is asked to run
FIRST = (
    "NCAP_AEB_VRU_CPNA_2023",
    "alks_scenario_4_2_3_crossing_pedestrian_template",
    "cut-in",
    "pedestrian",
)
# what else agrees so far; kept short enough for every run of the tests, the rest is for `make conformance`
MORE = (
    "NCAP_AEB_C2C_CCR_2023",
    "NCAP_AEB_VRU_CPNCO_2023",
    "alks_scenario_4_1_2_swerving_lead_vehicle_template",
    "alks_scenario_4_4_1_cut_in_no_collision_template",
    "cut-in_simple",
    "drop-bike",
    "lane-change_clothoid_based_trajectory",
    "lane-change_trajectory_wp",
    "lane_change_crest",
    "left-hand-traffic_using_road_rule",
    "ltap-od",
    "slow-lead-vehicle",
    "synch_with_steady_state",
    "ut_condition_delay",
    "ut_lateral_maneuvers_test",
    "ut_position_types",
    "ut_relative_lane_offset",
    "ut_variable_modify",
)


@pytest.fixture(scope="module")
def reference(shared_dir: Path) -> Path:
    folder = shared_dir / "openscenario" / "reference"
    if not folder.is_dir():
        pytest.skip(f"no reference trajectories at {folder}")
    return folder


@pytest.fixture(scope="module")
def index(reference: Path) -> dict[str, dict[str, str]]:
    with (reference / "INDEX.csv").open(newline="") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


@pytest.fixture(scope="module")
def networks() -> dict[Path, RoadNetwork]:
    return {}


@pytest.mark.parametrize("name", [*FIRST, *MORE])
def test_play_agrees_with_the_reference(
    name: str, reference: Path, index: dict[str, dict[str, str]], networks: dict[Path, RoadNetwork]
) -> None:
    corpus = reference.parent / "corpus"
    scenario = read_scenario(corpus / index[name]["xosc"], library=[corpus])
    road = scenario.road_network.logic_file
    if road is not None and road not in networks:
        networks[road] = load_network(road)
    played = play(scenario, networks[road] if road is not None else None, dt=0.01, duration=60.0)
    tolerance = float(index[name]["tol_pos_m"]) + SLACK
    folder = reference if (reference / f"{name}.csv").exists() else reference / "more"
    _compare_rows(folder / f"{name}.csv", played.rows, tolerance)
    _compare_events(folder / "events" / f"{name}.csv", played.transitions)


def _compare_rows(path: Path, rows: list[Row], tolerance: float) -> None:
    ours = {(round(row.time, 3), row.entity): row for row in rows}
    missing = []
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            key = (round(float(row["time"]), 3), row["entity"])
            mine = ours.get(key)
            if mine is None:
                missing.append(key)
                continue
            assert math.hypot(mine.x - float(row["x"]), mine.y - float(row["y"])) <= tolerance, key
            assert abs(math.remainder(mine.h - float(row["h"]), 2.0 * math.pi)) <= HEADING, key
            assert abs(mine.speed - float(row["speed"])) <= SPEED, key
    # a run may end one row earlier or later
    assert len({time for time, _ in missing}) <= 1, missing[:3]


def _compare_events(path: Path, transitions: list[Transition]) -> None:
    left = [(each.time, each.element, each.from_state, each.to_state) for each in transitions]
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            wanted = (row["element"], row["from"], row["to"])
            time = float(row["time"])
            same = [each for each in left if each[1:] == wanted]
            assert same, f"{row['element']} never went from {row['from']} to {row['to']}"
            nearest = min(same, key=lambda each: abs(each[0] - time))
            assert abs(nearest[0] - time) <= EVENTS, (wanted, time, nearest[0])
            left.remove(nearest)
