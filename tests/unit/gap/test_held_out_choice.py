"""Held-out data choose between what the fitted data cannot tell apart: only far from the noise, and only clearly."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import held_out_choice
from pytest_dvp.gap.diagnose.held_out_choice import chosen
from pytest_dvp.gap.diagnose.search import FAR, PRACTICAL, SearchResult
from pytest_dvp.gap.diagnose.search import RIVAL as RIVAL_GAP
from tests.unit.gap.held_out_sets import COUNT, HeldOutSets, judge

LATE, RIVAL = "yaw_rate_latency", "steer_delay"


class Found(HeldOutSets):
    """With one rival, and another effect that is none."""

    vague: tuple[str, ...] = ()
    more: tuple[str, ...] = ()

    def in_place_of(self, best: SimpleNamespace, name: str, among: tuple[str, ...]) -> list[SimpleNamespace]:
        rest = tuple(n for n in best.names if n != name)
        return [self.trial((*rest, other)) for other in (RIVAL, "mass") if other in among and other not in best.names]

    def is_credible(self, trial: Any, name: str) -> bool:
        return name not in self.vague

    def grown(self, trial: SimpleNamespace, turns: list[Any]) -> SimpleNamespace:
        return self.trial((*trial.names, *self.more))


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(held_out_choice, "refit_on_fold", lambda search, fold, trial: trial)
    monkeypatch.setattr(held_out_choice, "whole_actuators", lambda search, final: iter(()))


def after(search: Found, rivals: tuple[str, ...] = (RIVAL,)) -> SearchResult:
    begin = SearchResult(search.trial((LATE,)), {LATE: rivals}, ())  # type: ignore[arg-type]
    return chosen(search, begin, (judge(),))  # type: ignore[arg-type]


def held(late: float, rival: float) -> dict[str, float]:
    return {LATE: late, RIVAL: rival, "mass": 1.0, f"{RIVAL} understeer": rival}


@pytest.mark.parametrize(("gain", "taken"), [(1.1 * PRACTICAL, True), (0.9 * PRACTICAL, False), (-1.0, False)])
def test_a_rival_that_held_out_data_clearly_prefer_takes_the_place(gain: float, taken: bool) -> None:
    search = Found(held(10.0, 10.0 - 10.0 * gain))
    found = after(search)
    assert found.final.names == ((RIVAL,) if taken else (LATE,))
    assert found.rivals == ({RIVAL: (LATE,)} if taken else {LATE: (RIVAL,)})
    assert search.said == ([f"held-out data choose {RIVAL} in place of {LATE}"] if taken else [])


def test_of_two_rivals_the_one_that_held_out_data_prefer_takes_the_place() -> None:
    found = after(Found(held(10.0, 8.0)), (RIVAL, "mass"))
    assert (found.final.names, found.rivals) == (("mass",), {"mass": (LATE, RIVAL)})


@pytest.mark.parametrize(("vague", "told"), [("understeer", RIVAL), (RIVAL, LATE)])
def test_it_is_the_rival_whose_value_must_mean_something(vague: str, told: str) -> None:
    search = Found({f"understeer {LATE}": 10.0, f"{RIVAL} understeer": 5.0})
    search.vague = (vague,)
    names = ("understeer", LATE)
    begin = SearchResult(search.trial(names), {"understeer": (), LATE: (RIVAL,)}, ())  # type: ignore[arg-type]
    assert chosen(search, begin, (judge(),)).final.names == ("understeer", told)  # type: ignore[arg-type]


def test_what_pays_beside_it_comes_with_it() -> None:
    search = Found(held(10.0, 5.0))
    search.more = ("understeer",)
    assert after(search).final.names == (RIVAL, "understeer")


def test_only_a_rival_is_taken_and_only_a_credible_one() -> None:
    assert after(Found(held(10.0, 5.0)), rivals=()).final.names == (LATE,)
    search = Found(held(10.0, 5.0))
    search.vague = (RIVAL,)
    assert after(search).final.names == (LATE,)


def test_near_the_noise_and_beside_a_known_remainder_rivals_are_told_and_not_chosen() -> None:
    assert after(Found(held(10.0, 5.0), level=1.01 * FAR)).final.names == (RIVAL,)
    assert after(Found(held(10.0, 5.0), level=0.99 * FAR)).final.names == (LATE,)
    assert after(Found(held(10.0, 5.0), excused=True)).final.names == (LATE,)


def test_without_other_data_nothing_is_chosen() -> None:
    begin = SearchResult(Found(held(10.0, 5.0)).trial((LATE,)), {LATE: (RIVAL,)}, ())  # type: ignore[arg-type]
    assert chosen(Found(held(10.0, 5.0)), begin, ()) is begin  # type: ignore[arg-type]


@pytest.mark.parametrize(("level", "taken"), [(3.9, True), (4.07, True), (4.09, False)])
def test_a_whole_actuator_that_fits_as_well_may_take_the_place_of_what_stood_for_it(
    monkeypatch: pytest.MonkeyPatch, level: float, taken: bool
) -> None:
    """What leaves up to 2 % more of 4 fits as well."""
    search = Found({LATE: 10.0, "steer_delay steer_lag": 5.0})
    whole = search.trial(("steer_delay", "steer_lag"))
    whole.chi2 = level * COUNT
    search.cannot_tell_apart = lambda best, other: other.chi2 < (1.0 + RIVAL_GAP) * best.chi2  # type: ignore[attr-defined]
    monkeypatch.setattr(
        held_out_choice, "whole_actuators", lambda s, final: iter([whole] if LATE in final.names else [])
    )
    found = after(search, rivals=())
    assert found.final.names == (("steer_delay", "steer_lag") if taken else (LATE,))
    if taken:
        assert found.rivals == {"steer_delay": (LATE,), "steer_lag": (LATE,)}
