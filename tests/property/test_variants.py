"""Every variant within the declared ranges passes the gates of its scenario.

A failing variant ends with the command that replays it. Few examples here, always the same ones; more are a matter of
time: `pytest tests/property --hypothesis-seed=random`, or `@settings(max_examples=1000)`.
"""

from __future__ import annotations

from hypothesis import given, settings

from pytest_dvp import Variant, scenario_variants
from pytest_dvp.fixtures import Gate, Run

FEW = settings(max_examples=12, derandomize=True, database=None)


@FEW
@given(variant=scenario_variants("pedestrian_crossing.xosc"))
def test_no_pedestrian_is_hit_or_frightened(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@FEW
@given(variant=scenario_variants("overtaking.xosc"))
def test_the_standing_vehicle_is_passed_without_a_conflict(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))


@settings(FEW, max_examples=6)
@given(variant=scenario_variants("urban.xosc"))
def test_the_whole_drive_is_safe(run: Run, gate: Gate, variant: Variant) -> None:
    gate(run(variant))
