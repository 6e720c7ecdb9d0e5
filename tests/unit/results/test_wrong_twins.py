"""Wrong twins of `make gate-power`: each differs from the right one in one property, and a draw repeats itself."""

from __future__ import annotations

import pytest

from scripts.stage_twins import WIRES, twin_of
from scripts.wrong_twins import FAULTS, Fault, drawn, little_and_much


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_changes_one_property_and_leaves_no_evidence_for_it(fault: Fault) -> None:
    right = twin_of("extended", WIRES["ros2"])
    effects = {applied.name: dict(applied.values) for applied in right.effects}
    for size in (fault.little, fault.much):
        wrong = fault.made(right, size)
        apart = {n: v for n, v in wrong.car.values().items() if v != right.car.values()[n]}
        changed = {a.name: a for a in wrong.effects if dict(a.values) != effects.get(a.name)}
        assert (set(apart), set(changed)) == (
            ({fault.key}, set()) if fault.effect == "car" else (set(), {fault.effect})
        )
        assert all(not applied.fitted_on for applied in changed.values())


def test_there_are_at_least_thirty_by_a_little_and_by_much() -> None:
    assert len(little_and_much()) >= 60


def test_a_draw_repeats_itself_takes_each_fault_in_turn_and_stays_between_little_and_much() -> None:
    twins = drawn(5, 60)
    assert twins == drawn(5, 60) != drawn(6, 60)
    assert {twin.fault for twin in twins[: len(FAULTS)]} == set(FAULTS)
    for twin in twins:
        low, high = sorted((twin.fault.little, twin.fault.much))
        assert low <= twin.size <= high
