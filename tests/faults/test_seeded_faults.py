"""Faults seeded into the reference stack make a gate fail; the stack as it is fails none, whatever the seed.

`make nightly` drives all faults and 1,000 clean seeds; here, a sample of both.
"""

from __future__ import annotations

import os

import pytest
from mutation import Fault, failed, faults, place, seeded

SEED = 7
SCENARIOS = ("overtaking", "pedestrian_crossing", "urban", "follow", "traffic_light", "junction")
ALL = faults()
FAULTS = ALL if os.environ.get("DVP_FAULTS") == "all" else ALL[::12]
CLEAN_SEEDS = int(os.environ.get("DVP_CLEAN_SEEDS", "6"))
CHUNK = 25  # seeds an item


def test_there_are_fifty_faults_in_every_part_and_95_percent_are_caught() -> None:
    assert len(ALL) >= 50
    assert {fault.part for fault in ALL} == {"localization", "perception", "map", "behaviour", "control"}
    assert sum(not fault.missed for fault in ALL) >= 0.95 * len(ALL)


@pytest.mark.parametrize("fault", ALL, ids=lambda fault: fault.name)
def test_what_is_spoilt_exists(fault: Fault) -> None:
    owner, name = place(fault.where)
    before = vars(owner)[name]
    with seeded(fault):
        assert vars(owner)[name] is not before
    assert vars(owner)[name] is before


@pytest.mark.parametrize("fault", [f for f in FAULTS if not f.missed], ids=lambda fault: fault.name)
@pytest.mark.nightly(by_day=3)
def test_the_gate_named_for_it_sees_the_fault(fault: Fault) -> None:
    with seeded(fault):
        verdicts = failed(fault.scenario, SEED)
    assert fault.gate in {verdict.metric for verdict in verdicts}
    assert "ERROR" not in {verdict.status for verdict in verdicts}, "a stack that breaks is no small fault"


@pytest.mark.parametrize("fault", [f for f in ALL if f.missed], ids=lambda fault: fault.name)
def test_a_fault_that_is_said_to_be_missed_is(fault: Fault) -> None:
    with seeded(fault):
        assert failed(fault.scenario, SEED) == []


@pytest.mark.parametrize("first", range(0, CLEAN_SEEDS, CHUNK))
def test_no_false_alarm(first: int) -> None:
    alarms = {}
    for seed in range(first, min(first + CHUNK, CLEAN_SEEDS)):
        scenario = SCENARIOS[seed % len(SCENARIOS)]
        alarms[f"{scenario} --seed {seed}"] = [verdict.message for verdict in failed(scenario, seed)]
    assert {run: found for run, found in alarms.items() if found} == {}
