"""Sentences and tables of answers, whole: what is said where, and the figures in it."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose.dependence import Dependence
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Samples, Step
from pytest_dvp.gap.extend.extension import Extension, Rung
from pytest_dvp.gap.words import extension
from pytest_dvp.gap.words.diagnosis import (
    _and,
    _digits,
    _table,
    _wrapped,
    figure,
    headline,
    page,
    remainder_words,
    standing_lines,
    step_label,
    three,
)
from pytest_dvp.gap.words.second_opinion import second_opinion

# --- numbers


@pytest.mark.parametrize(
    ("number", "text"),
    [(None, "-"), (0.0, "0.00"), (9.994, "9.99"), (9.996, "10.0"), (99.94, "99.9"), (99.96, "100"), (1234.5, "1234")],
)
def test_a_figure_has_fewer_decimals_the_larger_it_is(number: float | None, text: str) -> None:
    assert figure(number) == text


@pytest.mark.parametrize(("number", "text"), [(0.5, "0.500"), (12.0, "12.0"), (123.4, "123"), (0.00123456, "0.00123")])
def test_three_figures_keep_their_zeros(number: float, text: str) -> None:
    assert three(number) == text


@pytest.mark.parametrize(
    ("value", "half", "digits"),
    [
        (0.5, 1.0, 0),
        (0.5, 0.95, 0),  # as good as one
        (0.5, 0.94, 1),
        (0.5, 0.096, 1),
        (0.5, 0.001, 3),
        (0.5, 0.0, 4),  # four figures of 0.5000
        (5.0, 0.0, 3),
        (5000.0, 0.0, 0),
        (1e-9, 0.0, 6),  # six decimals at most
        (0.0, 0.0, 3),
        (-0.05, 0.0, 5),
    ],
)
def test_decimals_show_half_the_width_of_an_interval(value: float, half: float, digits: int) -> None:
    assert _digits(Estimate(value, value - half, value + half, "m")) == digits


@pytest.mark.parametrize(("names", "text"), [(["a"], "a"), (["a", "b"], "a and b"), (["a", "b", "c"], "a, b and c")])
def test_names_are_joined_by_and(names: list[str], text: str) -> None:
    assert _and(names) == text


def test_a_long_line_is_broken_before_a_word_that_does_not_fit() -> None:
    """112 columns: ten words of 10 and their ", " after a start of 4 are 122 less the last comma."""
    found = _wrapped("it: ", ["x" * 10] * 10)
    assert [len(line) for line in found] == [4 + 8 * 12 + 11, 4 + 10]
    assert found[1] == "    " + "x" * 10
    assert _wrapped("it: ", ["x" * 54, "y" * 52])[0] == "it: " + "x" * 54 + ", " + "y" * 52
    assert len(_wrapped("it: ", ["x" * 54, "y" * 53])) == 2


def test_a_table_has_two_blanks_between_columns_and_each_side_its_own() -> None:
    assert _table([("a", "1"), ("long", "22")], "lr") == ["  a      1", "  long  22"]


# --- a diagnosis


def step(added: str, chi2: float, held: float | None, v: float, *, parts: int = 10, level: float = 1.0) -> Step:
    segments = (chi2 * 10.0,) * parts
    judged = () if held is None else (held * 10.0,) * parts
    return Step(added, chi2, {"v": level}, {"v": v}, held, {} if held is None else {"v": v}, segments, judged)


GIVEN, BETTER = step("", 21.0, 11.0, 0.5, level=20.0), step("drive_gain", 1.0, 2.0, 0.05)
GAIN = NamedEffect("drive_gain", {"g": Estimate(0.9, 0.88, 0.92, "-")}, gain=1.0, standing="confirmed",
                   held_out_gain=9.0)  # fmt: skip
FOUND = Diagnosis("NAMED", (GAIN,), (), (GIVEN, BETTER), {"v": 0.03}, {})


def test_the_whole_answer_of_a_diagnosis() -> None:
    """Of 20 beyond the noise all is explained, of 10 held out 9."""
    assert page(FOUND, model="car.toml", command="dvp extend").splitlines() == [
        "NAMED: car.toml lacks drive_gain; after that only sensor noise is left (chi²/N 21.0 -> 1.00)",
        "",
        "  effect           value  95 % interval  unit  explains  held out  standing   cannot be told from",
        "  + drive_gain  g   0.90  0.88 to 0.92   -        100 %      90 %  confirmed  -",
        "",
        "  error after each step  chi²/N  held out  v [m/s]",
        "  model as given           21.0      11.0    0.500",
        "  + drive_gain             1.00      2.00   0.0500",
        "  sensor noise                1         1   0.0300",
        "",
        "next: dvp extend",
    ]


def test_what_is_to_be_done_next_stands_last_and_only_what_there_is() -> None:
    open_still = dataclasses.replace(GAIN, rivals=("mass",), deciding_manoeuvre="step.xosc")
    found = dataclasses.replace(FOUND, effects=(open_still,))
    text = page(found, command="dvp extend", plan="dvp plan", trial="dvp try").splitlines()
    assert text[-3:] == [
        "to tell drive_gain from its rivals, drive step.xosc", "next: dvp extend",
        "to try what is provisional: dvp try",
    ]  # fmt: skip
    assert page(FOUND, plan="dvp plan").splitlines()[-1] == "what to drive to know more: dvp plan"
    assert page(FOUND).splitlines()[-1].startswith("  sensor noise")


@pytest.mark.parametrize(
    ("verdict", "changes", "text"),
    [
        ("NOTHING_MISSING", {}, "M lacks nothing that these data show: what is left is sensor noise (chi²/N 1.00)"),
        ("NOTHING_MISSING", {"remainder": {"v": {"cruise": 0.1}}},
         "M lacks nothing that these data show: what is left is no more than the twin's known remainder (chi²/N 1.00)"),
        ("NOT_EXCITED", {"not_excited": ("a", "b")},
         "nothing was found missing in M, but this drive could not have shown 2 of the effects"),
        ("UNKNOWN", {}, "M misses something that no effect of the catalogue explains (chi²/N 1.00, worst v 1.00)"),
        ("PARTIAL", {"ladder": (GIVEN,)},
         "M lacks drive_gain; what is left no effect of the catalogue explains (chi²/N 21.0, worst v 20.0)"),
        ("PARTIAL", {"ladder": (GIVEN, step("drive_gain", 6.0, None, 0.1, level=5.0))},
         "M lacks drive_gain; that explains 75 % of the error, and no effect of the catalogue explains the rest "
         "(chi²/N 6.00, worst v 5.00)"),
        ("PARTIAL", {"ladder": (GIVEN, dataclasses.replace(BETTER, chi2_per_n=11.0, channels={}))},
         "M lacks drive_gain; that explains 50 % of the error, and no effect of the catalogue explains the rest "
         "(chi²/N 11.0)"),
    ],
)  # fmt: skip
def test_a_verdict_in_one_sentence(verdict: Any, changes: dict[str, Any], text: str) -> None:
    assert headline(dataclasses.replace(FOUND, verdict=verdict, **changes), "M") == text


def effect(name: str, gain: float = 1.0, **more: Any) -> NamedEffect:
    return NamedEffect(name, {}, **{"gain": gain, "standing": "confirmed", **more})


@pytest.mark.parametrize(
    ("effects", "text"),
    [
        ((effect("a"), effect("b", 0.01)), "M lacks a and b"),
        ((effect("a"), effect("b", 0.0099)), "M lacks a, and by far less b"),
        ((effect("a"), effect("b", 0.001, rivals=("c", "d"))),
         "M lacks a, and by far less b (or c or d: these data cannot tell)"),
        ((effect("a"), *(effect(n, 0.001, rivals=("r",)) for n in "bc")),
         "M lacks a, and by far less b (or r: these data cannot tell) and c (or r: these data cannot tell)"),
        ((effect("a"), *(effect(n, 0.001, rivals=("r",)) for n in "bcd")), "M lacks a, and by far less b, c and d"),
        ((effect("a", 0.001),), "M lacks a"),
        (tuple(effect(n, 0.9 - 0.1 * k, rivals=("r",) if k else ()) for k, n in enumerate("abcde")),
         "M lacks a, b (or another), c (or another) and d (or another), and 1 more of less weight (in the table)"),
        ((*(effect(n, 0.5) for n in "abcde"), effect("f", 0.001)),
         "M lacks a, b, c and d, and 2 more of less weight (in the table)"),
        (tuple(effect(n, 0.5, rivals=("r",)) for n in "abcd"),
         "M lacks a (or r: these data cannot tell), b (or r: these data cannot tell), c (or r: these data cannot tell) "
         "and d (or r: these data cannot tell)"),
        ((effect("a", action="change"), effect("b", action="change", standing="provisional")),
         "M has another a than the car and may have another b than the car"),
        ((effect("a", action="remove", standing="provisional"),), "M may have a, which the car does not"),
    ],
)  # fmt: skip
def test_what_a_model_lacks_in_one_sentence(effects: tuple[NamedEffect, ...], text: str) -> None:
    assert headline(dataclasses.replace(FOUND, effects=effects), "M").startswith(f"{text}; after that")


def test_a_step_is_labelled_by_what_was_done() -> None:
    effects = (effect("a", action="remove"), effect("b", action="change"), effect("c"))
    found = dataclasses.replace(FOUND, effects=effects)
    labels = [step_label(found, dataclasses.replace(BETTER, added=name)) for name in ("", "a", "b", "c", "d")]
    assert labels == ["model as given", "- a", "~ b", "+ c", "+ d"]


def test_effects_that_go_have_no_value_and_further_keys_have_no_share() -> None:
    two = {"k": Estimate(1.0, 0.9, 1.1, "m"), "tau": Estimate(2.0, 1.9, 2.1, "s")}
    effects = (dataclasses.replace(GAIN, parameters=two), effect("mass", action="remove"))
    lines = page(dataclasses.replace(FOUND, effects=effects)).splitlines()
    assert [line.split() for line in lines[3:6]] == [
        ["+", "drive_gain", "k", "1.0", "0.9", "to", "1.1", "m", "100", "%", "90", "%", "confirmed", "-"],
        ["tau", "2.0", "1.9", "to", "2.1", "s"],
        ["-", "mass", "-", "-", "-", "-", "confirmed", "the", "car", "does", "not", "have", "it"],
    ]


def lines_of(**changes: Any) -> list[str]:
    return standing_lines(dataclasses.replace(FOUND, **changes))


def test_nothing_is_remarked_where_nothing_is_to_be() -> None:
    assert lines_of() == lines_of(samples=Samples(100, 90.0)) == []


def test_what_the_samples_were_is_remarked() -> None:
    assert lines_of(samples=Samples(1000, 899.0)) == [
        "neighbouring samples repeat each other's noise: 1000 samples tell as much as 899 independent ones"
    ]
    first, *others = lines_of(samples=Samples(100, 100.0, 0.024, 0.25))
    assert first.startswith("wheels lock or spin, or the car slides, in 2.4 % of the drives fitted; no effect of the")
    assert "25 % of them is left out of the fit" in " ".join([first, *(line.strip() for line in others)])


def test_what_speaks_against_an_effect_and_what_it_changes_with_is_remarked() -> None:
    falls = Dependence("g", "brake_energy", 1.0, 0.86, "brake_fade")
    rises = Dependence("g", "speed", 0.5, 0.75)
    doubted = dataclasses.replace(GAIN, standing="provisional", doubts=("a rival votes", "alike"), depends_on=falls)
    assert lines_of(effects=(doubted,)) == [
        "provisional, drive_gain: a rival votes; alike",
        "drive_gain falls from 1.00 to 0.860 with brake energy: brake_fade has that",
        "provisional, and so added by name only: drive_gain",
    ]
    two = {"g": Estimate(1.0, 0.9, 1.1, "-"), "h": Estimate(1.0, 0.9, 1.1, "-")}
    (line,) = lines_of(effects=(dataclasses.replace(GAIN, parameters=two, depends_on=rises),))
    assert line == "drive_gain.g rises from 0.500 to 0.750 with speed"


@pytest.mark.parametrize(("held", "told"), [(11.04, False), (11.06, True)])
def test_an_error_held_out_that_grows_by_half_a_percent_is_remarked(held: float, told: bool) -> None:
    """Of the 10 beyond the noise 0.05 more."""
    found = lines_of(ladder=(GIVEN, step("drive_gain", 1.0, held, 0.05)))
    assert any(line.startswith("held out below 0 %: with drive_gain the error") for line in found) is told


def test_nothing_held_out_is_remarked_only_where_something_was_named() -> None:
    alone = tuple(step(name, chi2, None, 0.1) for name, chi2 in (("", 21.0), ("drive_gain", 1.0)))
    assert lines_of(ladder=alone)[0].startswith("nothing was held out: ")
    assert lines_of(ladder=alone[:1]) == []


def test_the_remainder_of_a_twin_is_told_by_its_worst_regimes() -> None:
    remainder = {"ax": {"cruise": 0.1, "lift_off": 0.2215}, "v": {"cruise": 0.05}}
    assert remainder_words(remainder) == ["ax up to 0.222 m/s^2 (lift off)", "v up to 0.0500 m/s (cruise)"]
    assert lines_of(remainder=remainder) == [
        "the twin's known remainder counts as noise: ax up to 0.222 m/s^2 (lift off), v up to 0.0500 m/s (cruise)"
    ]


def test_notes_stand_between_the_ladder_and_the_commands() -> None:
    noted = dataclasses.replace(
        FOUND, vetoed=("mass", "roll"), not_excited=("pitch",),
        input_map={"full_throttle": Estimate(40.0, 39.0, 41.0, "m/s^2"), "steer_scale": Estimate(0.4, 0.3, 0.5, "-")},
        scale_notes=("full_throttle = 40 m/s^2 is not what a full pedal does, 0.5 to 15",),
    )  # fmt: skip
    assert page(noted).splitlines()[9:] == [
        "",
        "fitted along: full_throttle = 40 m/s^2, steer_scale = 0.4",
        "full_throttle = 40 m/s^2 is not what a full pedal does, 0.5 to 15",
        "not mass, roll: fits, but data it was not fitted on do not confirm it",
        "these data cannot show: pitch",
    ]


@pytest.mark.parametrize(
    ("names", "first", "text"),
    [
        ((), None, "agrees, it would name nothing"),
        (("a",), None, "would name nothing, not a either"),
        (("x",), None, "cannot judge x"),
        (("a",), "a", "agrees on a, which alone explains 75 % of the misfit in its equations"),
        (("b",), "a", "disagrees, it would name a, which alone explains 75 % of the misfit in its equations"),
    ],
)
def test_the_second_opinion_in_one_sentence(names: tuple[str, ...], first: str | None, text: str) -> None:
    votes = {"ranking": [("a", 0.75), ("b", 0.5)], "first": first}
    assert second_opinion(dataclasses.replace(FOUND, effects=tuple(map(effect, names)), votes=votes)) == text


# --- an extension


def extended(**changes: Any) -> Extension:
    model: Any = SimpleNamespace(remainder={})
    base: dict[str, Any] = {
        "model": model, "effects": (GAIN,), "refitted": {("mass", "ratio"): Estimate(1.1, 1.0, 1.2, "-")},
        "ladder": (Rung("", GIVEN), Rung("+ drive_gain", BETTER)), "noise_floor": {"v": 0.03}, "refusal": "",
        "notes": ("a note",), "explained": True,
    }  # fmt: skip
    return Extension(**{**base, **changes})


def test_the_whole_text_of_an_extension() -> None:
    assert extension.page(extended(), ["gate: as before"]).splitlines() == [
        "  + drive_gain: g = 0.90 (0.88 to 0.92), explains 100 % of the error",
        "  ~ mass.ratio: 1.1 (1.0 to 1.2)",
        "",
        "error (RMSE)              chi²/N    v [m/s]",
        "fit       model as given    21.0      0.500",
        "fit       + drive_gain      1.00     0.0500",
        "held out  model as given    11.0      0.500",
        "held out  + drive_gain      2.00     0.0500",
        "noise                          1     0.0300",
        "",
        "gate: as before",
        "",
        "note: a note",
        "",
        "over the whole drive what is left is no more than the sensors' noise (chi²/N 1.00): stop here, more effects "
        "would fit noise",
    ]


def test_a_refused_extension_does_not_say_what_to_do_next() -> None:
    lines = extension.page(extended(refusal="loses", notes=())).splitlines()
    assert lines[-1].startswith("noise")
    known: Any = SimpleNamespace(remainder={"v": {"cruise": 0.05}})
    assert extension.page(extended(model=known)).splitlines()[-1] == (
        "written as [remainder], what the new model does not explain in single driving regimes: "
        "v up to 0.0500 m/s (cruise)"
    )


@pytest.mark.parametrize(
    ("fit", "held", "text"),
    [
        (1.0, 1.31, "more is missing: chi²/N 1.00 where it was fitted, 1.31 on held-out data; perhaps"),
        (1.0, 1.3, "more is missing: chi²/N 1.00, most in v (4.00): dvp diagnose with the new model looks for it"),
        (2.0, 2.19, "more is missing: chi²/N 2.00, most in v (4.00): dvp diagnose with the new model looks for it"),
        (2.0, 2.21, "more is missing: chi²/N 2.00 where it was fitted, 2.21 on held-out data; perhaps"),
        (2.0, None, "more is missing: chi²/N 2.00, most in v (4.00): dvp diagnose with the new model looks for it"),
    ],
)
def test_what_is_left_after_an_extension(fit: float, held: float | None, text: str) -> None:
    last = dataclasses.replace(step("drive_gain", fit, held, 0.1), channels={"ax": 3.0, "v": 4.0})
    assert extension.rest(extended(explained=False, ladder=(Rung("", GIVEN), Rung("+", last)))).startswith(text)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"action": "remove"}, "  - drive_gain"),
        ({"action": "change"}, "  ~ drive_gain: g = 0.90 (0.88 to 0.92), explains 100 % of the error"),
        ({"rivals": ("a", "b")},
         "  + drive_gain: g = 0.90 (0.88 to 0.92), explains 100 % of the error; a, b would do as well"),
        ({"name": "detection_latency", "parameters": {"T": Estimate(0.2, 0.1, 0.3, "s")}},
         "  + detection_latency: T = 0.2 s (0.1 to 0.3), explains 100 % of what the detections show"),
    ],
)  # fmt: skip
def test_an_effect_of_an_extension_in_one_line(changes: dict[str, Any], text: str) -> None:
    assert extension.page(extended(effects=(dataclasses.replace(GAIN, **changes),))).splitlines()[0] == text
