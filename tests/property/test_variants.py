"""Every variant within the declared ranges passes the gates of its scenario.

A failing variant ends with the command that replays it. Few examples here, always the same ones; `make nightly` takes
more (DVP_VARIANTS=12 for each scenario).
"""

from __future__ import annotations

import os

import pytest
from hypothesis import example, given, settings
from hypothesis.strategies import one_of

from pytest_dvp import Variant, scenario_variants
from pytest_dvp.plugin.fixtures import Gate, Run
from scenarios import path

FEW = settings(max_examples=int(os.environ.get("DVP_VARIANTS", "2")), derandomize=True, database=None)

SHORT = (
    "amber_close", "cut_in", "cyclist", "emergency_stop", "merging", "occluded_child", "red_ahead", "slope_stop",
    "stop_and_go", "vehicle_from_behind",
)  # fmt: skip

PEDESTRIAN, OVERTAKING, URBAN = (path(f"{name}.xosc") for name in ("pedestrian_crossing", "overtaking", "urban"))


@FEW
@example(variant=Variant(PEDESTRIAN, {"ego_speed": 5.37, "pedestrian_speed": 1.0, "trigger_distance": 19.0}))
@given(variant=scenario_variants("pedestrian_crossing.xosc"))
@pytest.mark.nightly
def test_no_pedestrian_is_hit_or_frightened(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@example(variant=Variant(OVERTAKING, {"ego_speed": 5.65}))  # once off the road for a tick where two roads meet
@given(variant=scenario_variants("overtaking.xosc"))
@pytest.mark.nightly
def test_the_standing_vehicle_is_passed_without_a_conflict(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@example(variant=Variant(URBAN, {"ego_speed": 3.0}))  # once met by traffic at 30 km/h in the bend
@given(variant=scenario_variants("urban.xosc"))
@pytest.mark.nightly
def test_the_whole_drive_is_safe(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@given(variant=scenario_variants("follow.xosc"))
@pytest.mark.nightly
def test_a_vehicle_that_stops_and_goes_is_followed_at_a_distance(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@given(variant=scenario_variants("traffic_light.xosc"))
@pytest.mark.nightly
def test_a_red_light_is_waited_for(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@given(variant=scenario_variants("junction.xosc"))
def test_who_comes_towards_us_is_let_pass(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@given(variant=one_of(*(scenario_variants(f"{name}.xosc") for name in SHORT)))
def test_a_short_scenario_is_passed_in_all_its_range(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))
