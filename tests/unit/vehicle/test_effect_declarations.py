"""What effects declare of each other, of parameters and of facts names things that exist."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from pytest_dvp.doctor.excitation import excitation
from pytest_dvp.logs.log import Log
from pytest_dvp.tuning.plausible_ranges import stands_for
from vehicle.model.command_inputs import INPUT_KEYS
from vehicle.model.effect_catalogue import catalogue, run_setups
from vehicle.model.simulator_parameters import S_PARAMETERS

EFFECTS = tuple(catalogue().values())


def test_effects_that_are_detailed_or_contained_exist() -> None:
    named = {e.diagnosed.details for e in EFFECTS} | {e.diagnosed.contains for e in EFFECTS}
    assert named - {""} <= set(catalogue())


def test_effects_that_are_refined_and_keys_that_are_held_exist() -> None:
    assert {name for e in EFFECTS for name in e.diagnosed.refines} <= set(catalogue())
    assert not any(catalogue()[name].diagnosed.refines for e in EFFECTS for name in e.diagnosed.refines)
    assert all(set(e.diagnosed.held) < {key.name for key in e.parameters} for e in EFFECTS if e.diagnosed.held)


def test_parameters_of_s_and_scales_of_the_input_map_exist() -> None:
    assert {name for e in EFFECTS for name, _ in e.diagnosed.hides_in} <= {p.name for p in S_PARAMETERS}
    assert {scale for e in EFFECTS for scale in e.diagnosed.input_scales} <= {key.name for key in INPUT_KEYS}


def test_no_two_effects_claim_one_place() -> None:
    """Where two do, their order depends on their names, and a page changes its order with a new name."""
    shown = Counter((e.slot == "perception", e.shown_by.place) for e in EFFECTS)
    hidden = Counter(claim for e in EFFECTS for claim in e.diagnosed.hides_in)
    assert [claim for claim, count in (shown + hidden).items() if count > 1] == []


def test_what_must_be_driven_is_a_fact_that_the_doctor_knows() -> None:
    t = np.arange(0.0, 20.0, 0.02)
    wave = np.sin(t)
    columns = {"t": t, "v": 8.0 + 2.0 * wave, "yaw_rate": 0.2 * wave, "steer_cmd": 0.1 * wave, "accel_cmd": 2.0 * wave}
    facts = {fact.name for fact in excitation(Log(columns)).facts}
    asked = {name for e in EFFECTS for name, _, _ in (*e.shown_by.drives, *e.shown_by.usual)}
    assert asked <= facts


def test_zeros_of_sensors_and_steering_belong_to_a_run_and_delays_do_not() -> None:
    assert {"gyro_bias", "steer_offset"} <= run_setups()
    assert not run_setups() & {"gnss_latency", "steer_delay", "steer_ratio"}


def test_effects_tried_for_a_value_that_is_not_plausible_come_in_the_order_of_their_places() -> None:
    tried = stands_for("S.EGO_moi")
    places = [dict(catalogue()[name].diagnosed.hides_in)["EGO_moi"] for name in tried]
    assert len(tried) > 1
    assert places == sorted(places)


def test_what_must_be_driven_is_said_with_its_bound() -> None:
    asked = {drive for e in EFFECTS for drive in (*e.shown_by.drives, *e.shown_by.usual)}
    assert asked
    for fact, bound, text in asked:
        assert [float(number) for number in re.findall(r"(?<!\^)\b\d+(?:\.\d+)?", text)] == [bound], (fact, text)
