"""Scores of the hidden-effects benchmark on answers made up here."""

from __future__ import annotations

import math
from typing import Any

import pytest

from benchmarks.hidden_effects import score
from benchmarks.hidden_effects.table import figures, missed, page


def named(name: str, *rivals: str, **values: tuple[float, float, float]) -> dict[str, Any]:
    """An effect of an answer; a parameter as value, low, high."""
    parameters = {key: {"value": v, "low": low, "high": high, "unit": "-"} for key, (v, low, high) in values.items()}
    return {"name": name, "rivals": list(rivals), "parameters": parameters, "gain": 1.0}


def line(category: str, truth: dict[str, Any], verdict: str, *effects: dict[str, Any], **other: Any) -> dict[str, Any]:
    """A line of a run."""
    usual = {"names": list(truth), "off": "", "noise": "mid", "dirt": "", "car": "", "cpu": 1.0}
    return {"category": category, "truth": truth, "verdict": verdict, "effects": list(effects), **usual, **other}


DELAY = {"steer_delay": {"T": 0.2}}
RIGHT = line("single", DELAY, "NAMED", named("steer_delay", T=(0.21, 0.19, 0.22)))
WRONG = line("single", DELAY, "NAMED", named("steer_lag", tau=(0.2, 0.1, 0.3)))
UNSURE = line("urban", DELAY, "AMBIGUOUS", named("steer_lag", "steer_delay", tau=(0.2, 0.1, 0.3)))


def row(lines: list[dict[str, Any]], name: str) -> Any:
    return next(figure for figure in figures(lines) if figure.name == name)


def test_named_first_counts_the_first_name_only() -> None:
    behind = line("single", DELAY, "NAMED", named("steer_lag"), named("steer_delay", T=(0.2, 0.1, 0.3)))
    assert [score.first_is_true(x) for x in (RIGHT, WRONG, behind)] == [True, False, False]
    assert score.first_two_hold_it(behind)
    assert row([RIGHT, WRONG], "one hidden effect, named first").found == "0.500 (1/2)"


def test_what_cannot_be_seen_is_not_counted() -> None:
    unseen = line("single", {}, "UNDETECTABLE", names=["brake_limit"])
    assert row([RIGHT, unseen], "one hidden effect, named first").count == 1
    assert not missed(unseen)
    assert "brake_limit 1x" in page([RIGHT, unseen], 1000, 2)


def test_a_rival_that_is_the_truth_is_in_the_set_and_costs_size() -> None:
    assert score.set_holds_truth(UNSURE)
    assert not score.set_holds_truth(WRONG)
    assert row([UNSURE], "urban data only, mean size of the set").found == "2"


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        (RIGHT, False),
        (WRONG, True),
        (UNSURE, False),
        (line("single", DELAY, "PARTIAL", named("steer_lag")), False),
        (line("single", DELAY, "NAMED", named("steer_lag", "drive_lag")), False),
    ],
)
def test_confident_and_wrong_is_one_name_without_rivals(answer: dict[str, Any], wrong: bool) -> None:
    assert score.confident_and_wrong(answer) is wrong


def test_each_confirmed_name_that_is_not_true_counts_under_any_verdict() -> None:
    """Of old records, which know no standing, only what was NAMED without rivals."""
    sure = {**named("steer_lag"), "standing": "confirmed"}
    open_one = {**named("roll"), "standing": "provisional"}
    true = {**named("steer_delay"), "standing": "confirmed"}
    lines = [line("single", DELAY, "PARTIAL", true, sure, open_one), WRONG, line("null", {}, "NOTHING_MISSING")]
    found = score.wrongly_confirmed(lines)
    assert (found.hits, found.count) == (2, 3)
    assert score.confirmed_and_true(lines[0])
    assert not score.confirmed_and_true(WRONG)


def test_the_bounds_are_those_of_clopper_and_pearson() -> None:
    """0 of 300: 1 - 0.05^(1/300) = 0.99 %; all of 300 the same from the other side."""
    assert score.Share(0, 300).high == pytest.approx(1.0 - 0.05 ** (1 / 300))
    assert score.Share(300, 300).low == pytest.approx(0.05 ** (1 / 300))
    assert (score.Share(0, 5).low, score.Share(5, 5).high) == (0.0, 1.0)


def test_any_name_on_a_null_is_a_false_positive() -> None:
    quiet, loud = line("null", {}, "NOTHING_MISSING"), line("null", {}, "AMBIGUOUS", named("roll", "pitch"))
    figure = row([quiet, loud], "names something when nothing is missing")
    assert (figure.found, figure.met) == ("0.500 (1/2)", False)
    assert row([quiet] * 99, figure.name).met is False  # none of 99 shows no rate below 3 %
    assert row([quiet] * 900, figure.name).met is True
    assert [missed(quiet), missed(loud)] == [False, True]


def test_pairs_are_exact_and_triples_may_hold_more() -> None:
    two = {"roll": {"gain": 0.1}, "pitch": {"gain": 0.1}}
    both, more = [named("pitch"), named("roll")], [named("pitch"), named("roll"), named("mass")]
    assert score.exact(line("pair", two, "NAMED", *both))
    assert not score.exact(line("pair", two, "NAMED", *more))
    assert not score.exact(line("pair", two, "NAMED", both[0]))
    assert score.all_found(line("triple", two, "NAMED", *more))
    assert not score.all_found(line("triple", two, "NAMED", both[0]))


@pytest.mark.parametrize(
    ("verdict", "flag"), [("PARTIAL", True), ("UNKNOWN", True), ("NAMED", False), ("ERROR", False)]
)
def test_outside_the_library_is_flagged_by_partial_or_unknown(verdict: str, flag: bool) -> None:
    assert score.flagged(line("outside", {"converter_gain": {"a": 0.6}}, verdict)) is flag


def test_error_is_of_the_effects_size_not_of_the_value() -> None:
    answer = line("single", {"drive_gain": {"g": 0.9}}, "NAMED", named("drive_gain", g=(0.92, 0.91, 0.93)))
    (error,) = score.parameter_errors(answer)
    assert error.of_effect == pytest.approx(0.2)  # 0.02 of the 0.1 that it is away from 1
    assert error.of_value == pytest.approx(0.02 / 0.9)
    assert error.covered is False


def test_a_limits_size_is_its_value() -> None:
    answer = line("single", {"jerk_limit": {"limit": 4.0}}, "NAMED", named("jerk_limit", limit=(4.4, 3.9, 4.9)))
    (error,) = score.parameter_errors(answer)
    assert (error.of_effect, error.covered) == (pytest.approx(0.1), True)


def test_a_slope_the_other_way_round_is_the_same_slope() -> None:
    answer = line(
        "single", {"road_grade": {"slope": 0.05, "heading": 0.4}}, "NAMED",
        named("road_grade", slope=(-0.05, -0.06, -0.04), heading=(0.4 + math.pi, 3.0, 4.0)),
    )  # fmt: skip
    (error,) = score.parameter_errors(answer)
    assert error.of_effect == pytest.approx(0.0, abs=1e-12)
    assert error.covered is True


def test_ablation_and_dirt() -> None:
    gone = line("ablation", DELAY, "NAMED", named("steer_delay", T=(0.2, 0.1, 0.3)), off="mass")
    still = line("ablation", DELAY, "NAMED", named("mass"), off="mass")
    crashed = line("ablation", DELAY, "ERROR", off="mass")
    assert [score.disappears(x) for x in (gone, still, crashed)] == [True, False, False]
    refused = line("dirty", DELAY, "REFUSED", dirt="sign_flip", refused="log.sign")
    fooled = line("dirty", DELAY, "NAMED", named("steer_ratio"), dirt="sign_flip")
    assert [score.no_wrong_name(x) for x in (refused, fooled)] == [True, False]
    assert missed(line("dirty", DELAY, "REFUSED", dirt="jitter", refused="log.jitter"))


def test_an_effect_that_the_bare_car_is_said_to_have_does_not_count_as_found() -> None:
    bare = line("multibody", {}, "PARTIAL", named("mass"), car="bmw_320i")
    found = line("multibody", {"gyro_bias": {"b": 0.01}}, "PARTIAL", named("mass"), named("gyro_bias"), car="bmw_320i")
    always = line("multibody", {"mass": {"ratio": 1.2}}, "PARTIAL", named("mass"), car="bmw_320i")
    other_car = line("multibody", {"roll": {"gain": 0.1}}, "PARTIAL", named("roll"), car="ford_escort")
    assert score.not_named_without([bare, found, always, other_car]) == score.Share(1, 2)


def test_what_the_bare_car_lacks_anyway_takes_no_place() -> None:
    bare = line("surrogate", {}, "PARTIAL", named("mass"), named("rolling_resistance"))
    hidden = {"gyro_bias": {"b": 0.01}}
    third = line("surrogate", hidden, "PARTIAL", named("mass"), named("rolling_resistance"), named("gyro_bias"))
    behind_new = line("surrogate", hidden, "PARTIAL", named("roll"), named("pitch"), named("gyro_bias"))
    assert not score.first_two_hold_it(third)
    assert score.first_two_new_hold_it([bare, third, behind_new]) == score.Share(1, 2)


def test_excess_error_is_what_is_above_the_noise_floor() -> None:
    def held_out(before: float | None, after: float | None) -> dict[str, Any]:
        return line("single", DELAY, "NAMED", chi2_per_n={"held_out": {"before": before, "after": after}})

    assert score.excess_removed(held_out(11.0, 2.0)) == pytest.approx(0.9)
    assert score.excess_removed(held_out(11.0, 0.98)) == 1.0
    assert score.excess_removed(held_out(3.0, 5.0)) == pytest.approx(-1.0)
    assert score.excess_removed(held_out(1.01, 1.0)) is None
    assert score.excess_removed(held_out(None, None)) is None


def test_quantiles_run_straight_between_ranks() -> None:
    assert score.quantile([4.0, 1.0, None, 3.0, 2.0], 0.5) == 2.5
    assert score.quantile([1.0, 2.0], 1.0) == 2.0
    assert score.quantile([], 0.5) is None


def test_the_page_lists_misses_by_how_often_they_happen() -> None:
    text = page([RIGHT, WRONG, WRONG, line("null", {}, "NAMED", named("roll"))], 1000, 10)
    misses = text.split("## Taken for something else")[1]
    assert misses.index("steer_delay | NAMED steer_lag | 2") < misses.index("nothing | NAMED roll | 1")
    assert "4 of 10 cases" in text


def test_figures_of_nothing_are_not_measured() -> None:
    assert all(figure.met is None for figure in figures([]))
