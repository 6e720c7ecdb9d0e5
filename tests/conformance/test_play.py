"""The storyboard alone against recorded trajectories and storyboard events of an independent implementation.

What agreement means is in `scripts.conformance`; all references are compared by `make conformance`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.conformance import Case, cases, judge

# the scenarios that the product's own closed loop is asked to run
FIRST = (
    "NCAP_AEB_VRU_CPNA_2023",
    "alks_scenario_4_2_3_crossing_pedestrian_template",
    "cut-in",
    "pedestrian",
)
# what else agrees so far; kept short enough for every run of the tests, the rest is for `make conformance`
MORE = (
    "NCAP_AEB_C2C_CCFhol_2023",
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
    "light_state",
    "ltap-od",
    "pedestrian_traj_synch",
    "slow-lead-vehicle",
    "speed-profile",
    "synch_with_steady_state",
    "trailers",
    "trajectory-test",
    "ut_condition_delay",
    "ut_emergency_vehicle",
    "ut_lateral_maneuvers_test",
    "ut_position_types",
    "ut_relative_lane_offset",
    "ut_relative_pos_over_intersection",
    "ut_traj_heading_and_interpolation",
    "ut_trajectory_speed",
    "ut_variable_modify",
)


# where a clause of the standard decides against the reference, which `--reading standard` follows
AS_ESMINI = ("cut-in_cr", "highway_merge_advanced")


@pytest.fixture(scope="module")
def references(shared_dir: Path) -> dict[str, Case]:
    folder = shared_dir / "openscenario" / "reference"
    if not folder.is_dir():
        pytest.skip(f"no reference trajectories at {folder}")
    return {case.name: case for case in cases(folder, tier=None)}


@pytest.mark.parametrize("name", [*FIRST, *MORE])
@pytest.mark.nightly(by_day=8)
def test_play_agrees_with_the_reference(name: str, references: dict[str, Case]) -> None:
    outcome = judge(references[name])
    assert outcome.passed, outcome.first


@pytest.mark.parametrize("name", AS_ESMINI)
def test_in_its_own_reading_alone_it_agrees(name: str, references: dict[str, Case]) -> None:
    outcome = judge(references[name], "esmini")
    assert outcome.passed, outcome.first
    assert not judge(references[name], "standard").passed
