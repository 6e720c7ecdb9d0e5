"""Whether an effect may stay in an extended model, and what is said of it: each bound from both sides."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import fitted_values
from pytest_dvp.gap.diagnose.candidates import candidates, candidates_of
from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.fitted_twin import values_of
from pytest_dvp.gap.diagnose.fitted_values import estimates, rounded
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.extend import acceptance as module
from pytest_dvp.gap.extend.acceptance import _percent, judge_addition, judge_removal, worse_together
from pytest_dvp.gap.extend.extend import _fitted, _present, _search
from pytest_dvp.gap.extend.fit_notes import assumed, edges
from pytest_dvp.gap.extend.ladder import shares
from tests.unit.gap.linear_world import BRAKE, DRIVE, ROWS, Applied, Having, World, a_search, direction, tried
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError
from vehicle.model.model_file import parse_model

SURE = {DRIVE: Estimate(0.9, 0.88, 0.92, "-"), BRAKE: Estimate(0.8, 0.7, 0.9, "-")}
(CANDIDATE,) = tried("drive_gain")


def hides(gain: float, beside: float = 0.0) -> World:
    """A car whose drive's gain is 0.1 too low, and its brake's, each leaves so much of chi^2."""
    does = {DRIVE: 10.0 * np.sqrt(gain) * direction(0), BRAKE: 10.0 * np.sqrt(beside) * direction(1)}
    return World(does, {DRIVE: 0.9, BRAKE: 0.9})


def asked(gain: float, *judges: World, beside: float = 0.0, model: Any = None, monkeypatch: Any = None) -> Any:
    """What is said of the drive's gain, fitted where it gains so much, judged by other data as they are."""
    world = hides(gain, beside)
    search = a_search(world, "drive_gain", "brake_gain")
    names = ("brake_gain", "drive_gain") if beside else ("drive_gain",)
    final = search.trial(names, dict.fromkeys((DRIVE, BRAKE)[: len(names)], 0.9))
    folds = tuple(Fold(None, judge) for judge in judges)  # type: ignore[arg-type]
    return judge_addition(search, final, CANDIDATE, folds, model or Applied(), SURE)


@pytest.mark.parametrize(("gain", "beside", "pays"), [(31.0, 0.0, True), (29.0, 0.0, False), (51.0, 400.0, True),
                                                       (49.0, 400.0, False)])  # fmt: skip
def test_an_effect_must_pay_where_it_is_fitted(gain: float, beside: float, pays: bool) -> None:
    found = asked(gain, beside=beside)
    assert (found.wrong == "") is pays
    if not pays:
        also = " beside brake_gain" if beside else ""
        level = "1.05" if beside else "1.03"
        assert found.wrong.startswith(f"drive_gain explains too little{also} to be worth an effect: chi²/N {level}")
        assert found.wrong.endswith(find_effect("drive_gain").reveals)
    assert found.effect.action == "add"
    assert found.effect.parameters == {"g": SURE[DRIVE]}


def test_another_value_that_gains_too_little_leaves_the_model_as_it_is() -> None:
    found = asked(20.0, model=Applied(drive_gain=0.95))
    assert found.effect.action == "change"
    assert (
        "drive_gain is in the model already, and another value gains too little: chi²/N 1.02 as it stands"
        in found.wrong
    )
    assert "1.00 with g = 0.9; it stays as it is" in found.wrong


def test_without_data_held_out_an_effect_is_not_judged() -> None:
    found = asked(100.0)
    assert found.wrong == ""
    assert found.note.startswith("drive_gain is not judged on held-out data")


@pytest.mark.parametrize(
    ("gain", "wrong", "note"), [(1.1, False, False), (0.9, False, True), (-0.9, False, True), (-1.1, True, False)]
)
def test_an_effect_must_not_lose_on_data_held_out(gain: float, wrong: bool, note: bool) -> None:
    """A thousandth of 1,000 is 1: by less nothing is said of the effect. A car with 0.95 + d loses (a (0.05 - d))^2
    with a gain of 0.9, and (a (0.05 + d))^2 without it: a^2 0.2 d of difference."""
    judge = World({DRIVE: 10.0 * direction(0)}, {DRIVE: 0.95 - gain / 20.0})
    found = asked(100.0, judge)
    assert (bool(found.wrong), bool(found.note)) == (wrong, note)
    assert found.effect.held_out_gain == pytest.approx(gain / 1000.0, abs=1e-4)
    if wrong:
        assert found.wrong.startswith(
            "drive_gain loses on held-out data, chi²/N 1.00 -> 1.00 (+0.11 %), though it gains"
        )
        assert "(-9.1 %): leave it out" in found.wrong
        changed = asked(100.0, judge, model=Applied(drive_gain=0.95))
        assert changed.wrong.startswith("the new value of drive_gain loses")
    if note:
        assert found.note == "held-out data do not show drive_gain: they neither gain nor lose by it"


@pytest.mark.parametrize(("loss", "wrong"), [(9.0, False), (11.0, True)])
def test_a_hundredth_of_what_it_gains_may_be_lost_and_is_told(loss: float, wrong: bool) -> None:
    """As in a diagnosis: what it names can be added. It gains 1,000."""
    found = asked(1000.0, World({DRIVE: 10.0 * direction(0)}, {DRIVE: 0.95 + loss / 20.0}))
    assert (found.wrong != "") is wrong
    told = "loses on held-out data" if wrong else "loses a little on held-out data"
    assert told in (found.wrong or found.note)


def test_data_held_out_count_by_their_samples() -> None:
    one = World({DRIVE: 30.0 * direction(0)}, {DRIVE: 0.9})
    other = World({}, count=500)
    assert asked(100.0, one, other).effect.held_out_gain == pytest.approx(9.0 / 1500.0, abs=1e-4)


def test_where_much_is_left_a_thousandth_of_it_counts() -> None:
    judge = World({DRIVE: 10.0 * direction(0)}, {DRIVE: 0.95 + 1.9 / 20.0}, noise=3.0 * hides(0.0).noise)
    assert asked(100.0, judge).wrong == ""
    more = World({DRIVE: 10.0 * direction(0)}, {DRIVE: 0.95 + 9.5 / 20.0}, noise=3.0 * hides(0.0).noise)
    assert asked(100.0, more).wrong != ""


def test_data_that_do_not_show_an_effect_do_not_judge_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "fold_excites", lambda search, fold, final, name: fold.judge.count == 500)
    lost = World({DRIVE: 100.0 * direction(0)}, {DRIVE: 1.0})
    assert asked(100.0, lost, World({}, count=500)).wrong == ""
    assert asked(100.0, lost).note.startswith("drive_gain is not judged")


@pytest.mark.parametrize(("lost", "kept"), [(49.0, False), (51.0, True)])
def test_what_was_taken_out_must_not_be_missed(lost: float, kept: bool) -> None:
    """In the data fitted on or in those held out it may grow by 5 %."""
    model: Any = Applied(drive_gain=0.9)
    missed, other = hides(lost), hides(0.0)
    for target, judges, where in ((missed, (), "the data fitted on"), (other, (Fold(None, missed),), "held-out data")):  # type: ignore[arg-type]
        search = a_search(target)
        final = search.trial((), {DRIVE: 1.0})
        found = judge_removal(search, final, "drive_gain", model, judges)
        assert (found.wrong != "") is kept
        assert found.effect.action == "remove"
        assert found.effect.parameters == {"g": Estimate(1.0, 1.0, 1.0, "-")}
        if kept:
            assert (
                found.wrong == f"without drive_gain the error on {where} grows, chi²/N 1.00 -> 1.05 (+5.1 %): keep it"
            )
        assert found.effect.held_out_gain == (pytest.approx(-lost / 1000.0) if judges else None)
    ignored = judge_removal(
        a_search(other), a_search(other).trial((), {}), "drive_gain", model, (Fold(missed, missed),)
    )  # type: ignore[arg-type]
    assert ignored.wrong == ""


def a_step(added: str, chi2: float, held_out: float | None = None) -> Any:
    return SimpleNamespace(added=added, chi2_per_n=chi2, held_out_chi2_per_n=held_out)


@pytest.mark.parametrize(
    ("before", "after", "worse"), [(1.0, 1.0011, True), (1.0, 1.0009, False), (4.0, 4.0039, False), (4.0, 4.0041, True),
                                   (0.5, 1.0, False), (0.5, 1.002, True), (None, 2.0, False), (2.0, None, False)],
)  # fmt: skip
def test_the_new_model_as_a_whole_must_not_lose(before: float | None, after: float | None, worse: bool) -> None:
    """What stays within the noise, chi^2/N of 1, has lost nothing."""
    found = worse_together([a_step("", 9.0, before), a_step("x", 9.0, 99.0), a_step("y", 9.0, after)])
    assert bool(found) is worse
    assert not worse or found[0].startswith("the new model loses on held-out data, chi²/N ")


def test_changes_are_told_in_percent() -> None:
    assert [_percent(1.0, x) for x in (1.5, 0.9, 1.0501, 1.0999, 1.1)] == ["+50 %", "-10 %", "+5 %", "+10 %", "+10 %"]
    assert (_percent(0.0, 1.0), _percent(2.0, 2.003)) == ("from nothing", "+0.15 %")
    assert (rounded(1.23456789), rounded(0.000123456789)) == (1.23457, 0.000123457)


def test_shares_of_the_excess_are_those_beyond_the_noise() -> None:
    steps = [a_step("", 3.0), a_step("a", 2.0), a_step("b", 0.5), a_step("c", 0.4), a_step("d", 1.2)]
    assert shares(steps) == pytest.approx({"a": 0.5, "b": 0.5, "c": 0.0, "d": 0.0})
    assert shares([a_step("", 0.9), a_step("a", 0.8)]) == {"a": 0.0}


def test_values_are_told_as_they_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interval holds the rounded value, too."""
    monkeypatch.setattr(fitted_values, "intervals", lambda fit, starts, exact: {DRIVE: (0.912345678, 0.912345679)})
    monkeypatch.setattr(fitted_values, "widen_dead_times", lambda target, fit, values, sure: sure)
    world: Any = hides(100.0)
    world.exact = lambda values: None
    search = a_search(world, "drive_gain")
    final = search.trial(("drive_gain",), {DRIVE: 0.9})
    final.fit.values[DRIVE] = final.values[DRIVE] = 0.9123456
    assert estimates(final, search) == {DRIVE: Estimate(0.912346, 0.912346, 0.912346, "-")}


def test_what_stands_at_the_end_of_the_search_and_what_was_assumed_is_told() -> None:
    (key,) = find_effect("drive_gain").parameters
    c = Coordinate("drive_gain", key)
    end = c.value(-0.25)
    for value, told in ((end, True), (0.9, False)):
        fit = Fit((c,), {}, np.zeros(1), 1.0, np.zeros((1, 1)))
        trial = Trial(("drive_gain",), {DRIVE: value, ("parameters", "ay_x"): 0.3}, fit, np.zeros(1))
        found = list(edges(trial))
        assert bool(found) is told
        assert not told or found[0].startswith(f"drive_gain.g = {end:.4g} - stands where the search ends")
    model = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\n")
    (said,) = assumed(trial, model)
    assert said == "[parameters] ay_x is 0.3 in the new model instead of 0: fits better"
    assert list(assumed(Trial((), {("parameters", "ay_x"): 0.0}, trial.fit, np.zeros(1)), model)) == []


def test_effects_are_fitted_one_after_another_from_where_each_takes_most() -> None:
    world = World({DRIVE: 200.0 * direction(0), BRAKE: 300.0 * direction(1)}, {DRIVE: 0.8, BRAKE: 0.9})
    search = a_search(world, "drive_gain", "brake_gain")
    found = _fitted(
        search, {DRIVE: 0.95, ("parameters", "ay_x"): 0.3}, [], tried("drive_gain", "brake_gain"), together=False
    )
    assert found.names == ("drive_gain", "brake_gain")
    assert found.values[DRIVE] == pytest.approx(0.8, abs=1e-3)
    assert found.values[BRAKE] == pytest.approx(0.9, abs=1e-3)
    assert found.chi2 == pytest.approx(ROWS, rel=1e-3)
    assert 3 <= len(world.settled) <= 2 + 5


MODEL = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n")


def test_what_the_model_has_is_kept_set_and_switched_off_by_name() -> None:
    model = MODEL.with_effect("drive_gain", {"g": 0.9}).with_effect("brake_limit", {"limit": 5.0})
    assert values_of(model) == {DRIVE: 0.9, ("brake_limit", "limit"): 5.0}
    assert [c.name for c in candidates_of(model, {"drive_gain"})] == ["drive_gain"]
    assert [c.name for c in candidates_of(model, {"drive_gain", "brake_limit"})] == ["drive_gain", "brake_limit"]
    (kept,) = candidates_of(model, {"drive_gain"})
    assert [c.name for c in kept.coordinates] == [DRIVE]
    off = model.with_effect("brake_limit", {"limit": float("inf")})
    assert [c.name for c in candidates_of(off, {"drive_gain", "brake_limit"})] == ["drive_gain"]
    assert values_of(off) == {DRIVE: 0.9}
    assert _present(model, "brake_limit").values == {"limit": 5.0}
    with pytest.raises(ModelError, match="drive_gain"):
        _present(model, "drive_gian")
    search = _search(Having({}), model, (), ["drive_gain"])  # type: ignore[arg-type]
    assert (search.fixed, search.nuisance, search.start) == ({DRIVE: 1.0}, (), {})


def test_scales_of_pedals_are_fitted_beside_effects_and_without_any_stay_as_the_model_has_them() -> None:
    pedals = parse_model('[inputs]\nlongitudinal = "throttle_cmd + brake_cmd"\nfull_throttle = 4.0\nfull_brake = 8.0\n'
                         "[parameters]\nwheelbase = 2.5\nmass = 1200.0\n")  # fmt: skip
    known = {("inputs", "full_throttle"): 4.0, ("inputs", "full_brake"): 8.0}
    for names, free in (((), []), (("steer_ratio",), list(known)), (("brake_gain",), [("inputs", "full_throttle")])):
        meant = [one for name in names for one in candidates(pedals, [find_effect(name)], ay=True)]
        search = _search(Having({}), pedals, meant, ())  # type: ignore[arg-type]
        assert [c.name for c in search.nuisance] == free
        assert search.start == known
