"""Which cases a matched twin is asked: those of the matrix, on drives that it has not learnt from."""

from __future__ import annotations

from benchmarks.hidden_effects.case import ON_TOP
from benchmarks.hidden_effects.matched import OTHER_DRIVES, cases


def test_every_effect_is_hidden_in_both_simulators_cars() -> None:
    for category in ("surrogate", "multibody"):
        assert {case.names for case in cases() if case.category == category} == {(name,) for name in ON_TOP}


def test_any_beginning_has_as_many_of_either() -> None:
    for count in (2, 10, 40):
        assert sum(case.category == "surrogate" for case in cases()[:count]) == count / 2


def test_no_case_drives_what_the_twin_has_learnt_from() -> None:
    assert OTHER_DRIVES not in {case.seed for case in cases()}
