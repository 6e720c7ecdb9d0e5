"""A diagnosis in a terminal: one sentence, values with intervals, errors in the signals' units, the next command."""

from __future__ import annotations

import dataclasses
import shlex

import pytest

from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Samples, Step
from pytest_dvp.gap.words.diagnosis import (
    causes,
    extend_command,
    headline,
    interval,
    page,
    plan_command,
    standing_lines,
    trial_command,
    value,
)
from pytest_dvp.gap.words.second_opinion import second_opinion

DELAY = NamedEffect("steer_delay", {"T": Estimate(0.24912, 0.24701, 0.25123, "s")}, gain=1.0, standing="confirmed")
GIVEN = Step("", 65.6, {"x": 400.0, "v": 1.1, "yaw_rate": 299.0}, {"x": 0.4, "v": 0.031, "yaw_rate": 0.0872}, 7.06,
             {"x": 0.1, "v": 0.03, "yaw_rate": 0.0231}, (656.0,) * 10, (70.6,) * 10)  # fmt: skip
BETTER = Step("steer_delay", 1.17, {"x": 1.2, "v": 1.1, "yaw_rate": 1.13}, {"x": 0.02, "v": 0.031, "yaw_rate": 0.00536},
              1.14, {"x": 0.02, "v": 0.03, "yaw_rate": 0.00497}, (11.7,) * 10, (11.4,) * 10)  # fmt: skip
NAMED = Diagnosis("NAMED", (DELAY,), ("load_transfer",), (GIVEN, BETTER), {"x": 0.02, "v": 0.03, "yaw_rate": 0.00505},
                  {})  # fmt: skip
FOUND_NOTHING = dataclasses.replace(NAMED, effects=(), ladder=(GIVEN,))


def test_the_answer_names_value_interval_unit_and_shares() -> None:
    line = next(line for line in page(NAMED).splitlines() if "+ steer_delay  T" in line)
    assert line.split() == [
        "+", "steer_delay", "T", "0.249", "0.247", "to", "0.251", "s", "100", "%", "98", "%", "confirmed", "-",
    ]  # fmt: skip


def test_the_ladder_tells_the_errors_in_the_units_of_the_signals() -> None:
    lines = page(NAMED).splitlines()
    head = next(k for k, line in enumerate(lines) if "error after each step" in line)
    assert "yaw_rate [rad/s]" in lines[head]
    assert lines[head + 1].split()[:5] == ["model", "as", "given", "65.6", "7.06"]
    assert "0.0872" in lines[head + 1]
    assert "0.00536" in lines[head + 2]
    assert lines[head + 3].split()[:3] == ["sensor", "noise", "1"]
    assert "0.00505" in lines[head + 3]


def test_the_answer_fits_a_screen() -> None:
    many = tuple(f"effect_{k}" for k in range(30))
    lines = page(dataclasses.replace(NAMED, not_excited=many), command="dvp extend").splitlines()
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 120


@pytest.mark.parametrize(
    ("found", "says"),
    [
        (NAMED, "car.toml lacks steer_delay; after that only sensor noise is left (chi²/N 65.6 -> 1.17)"),
        (
            dataclasses.replace(NAMED, remainder={"v": {"cruise": 0.1}}),
            "; after that no more than the twin's known remainder is left (chi²/N 65.6 -> 1.17)",
        ),
        (dataclasses.replace(FOUND_NOTHING, verdict="NOTHING_MISSING", ladder=(BETTER,)), "car.toml lacks nothing"),
        (dataclasses.replace(FOUND_NOTHING, verdict="UNKNOWN"), "no effect of the catalogue explains"),
        (dataclasses.replace(FOUND_NOTHING, verdict="UNKNOWN", vetoed=("mass",)), "catalogue explains on all drives"),
        (
            dataclasses.replace(FOUND_NOTHING, verdict="NOTHING_MISSING", samples=Samples(10, 10.0, 0.46, 0.5)),
            "lacks nothing that the 54 % of these data that can be judged show",
        ),
        (dataclasses.replace(FOUND_NOTHING, verdict="NOT_EXCITED"), "could not have shown 1 of the effects"),
    ],
)
def test_the_verdict_is_a_sentence(found: Diagnosis, says: str) -> None:
    assert says in headline(found, "car.toml")


def test_a_headline_is_no_firmer_than_the_standing_of_what_it_names() -> None:
    delay = NamedEffect("steer_delay", {}, gain=9.0, standing="confirmed")
    roll = NamedEffect("roll", {}, gain=3.0)
    mass = NamedEffect("mass", {}, gain=3.0, action="change")
    for effects, said in (
        ((delay, roll), "car.toml lacks steer_delay and may lack roll; "),
        ((roll,), "car.toml may lack roll; "),
        ((delay, mass), "car.toml lacks steer_delay and may have another mass than the car; "),
    ):
        assert headline(dataclasses.replace(NAMED, effects=effects), "car.toml").startswith(said)


@pytest.mark.parametrize(("left", "share"), [(1.2, "more than 99 %"), (51.0, "50 %")])
def test_a_part_is_never_the_whole(left: float, share: str) -> None:
    """chi^2/N 101 -> 1.2 is 99.8 % of what was beyond the noise, and 51 half of it; the same sentence tells a rest."""
    ladder = (dataclasses.replace(BETTER, chi2_per_n=101.0), dataclasses.replace(BETTER, chi2_per_n=left))
    text = headline(dataclasses.replace(NAMED, verdict="PARTIAL", ladder=ladder), "car.toml")
    assert f"; that explains {share} of the error, and no effect of the catalogue explains the rest" in text


def test_what_is_no_step_of_the_ladder_is_not_said_to_lower_the_error() -> None:
    seen = NamedEffect("detection_latency", {"T": Estimate(0.2, 0.19, 0.21, "s")}, gain=1.0)
    found = dataclasses.replace(NAMED, effects=(seen,), ladder=(BETTER,))
    assert headline(found, "car.toml") == (
        "car.toml may lack detection_latency; apart from that only sensor noise is left (chi²/N 1.17)"
    )


def test_without_held_out_data_there_is_no_column_of_them() -> None:
    alone = [dataclasses.replace(s, held_out_chi2_per_n=None, held_out_rmse={}, held_out_segments=())
             for s in (GIVEN, BETTER)]  # fmt: skip
    lines = page(dataclasses.replace(NAMED, ladder=tuple(alone))).splitlines()
    head = next(line for line in lines if "error after each step" in line)
    assert "held out" not in head
    assert any(line.startswith("nothing was held out: ") for line in lines)
    assert "nothing was held out" not in page(NAMED)


def test_rivals_stand_in_the_sentence() -> None:
    rival = dataclasses.replace(DELAY, rivals=("steer_lag",))
    found = dataclasses.replace(NAMED, verdict="AMBIGUOUS", effects=(rival,))
    assert "lacks steer_delay (or steer_lag: these data cannot tell)" in headline(found)


def test_what_explains_next_to_nothing_is_told_apart() -> None:
    few = tuple(dataclasses.replace(DELAY, name=name, gain=0.004) for name in ("roll", "headwind"))
    found = dataclasses.replace(NAMED, effects=(DELAY, *few))
    assert headline(found, "car.toml").startswith("car.toml lacks steer_delay, and by far less roll and headwind; ")
    assert headline(dataclasses.replace(NAMED, effects=few), "car.toml").startswith(
        "car.toml lacks roll and headwind; "
    )


def test_what_is_left_of_a_part_is_said() -> None:
    """Of an excess of 64.6 there is 32.3 left: half is explained."""
    half = dataclasses.replace(BETTER, chi2_per_n=33.3, channels={"v": 50.0})
    found = dataclasses.replace(NAMED, verdict="PARTIAL", ladder=(GIVEN, half))
    assert "explains 50 % of the error" in headline(found)
    assert "chi²/N 33.3, worst v 50.0" in headline(found)


def test_what_only_data_held_out_show_is_told_by_their_figure() -> None:
    """Fitted data leave less than the known remainder: of a share of them nothing can be said."""
    given, after = (dataclasses.replace(s, chi2_per_n=c, held_out_chi2_per_n=h)
                    for s, c, h in ((GIVEN, 0.7, 1.8), (BETTER, 0.68, 1.76)))  # fmt: skip
    twin = dataclasses.replace(NAMED, remainder={"x": {"launch": 0.1}})
    part = headline(dataclasses.replace(twin, verdict="PARTIAL", ladder=(given, after)))
    assert "explains 5 % of the error" in part
    assert "(chi²/N 0.68, on data held out 1.76)" in part
    unknown = headline(dataclasses.replace(twin, effects=(), verdict="UNKNOWN", ladder=(given,)))
    assert unknown.endswith("(chi²/N 0.70, on data held out 1.80)")


def test_changes_and_removals_are_told_apart() -> None:
    change, removal = (
        dataclasses.replace(DELAY, name=n, action=a) for n, a in (("mass", "change"), ("roll", "remove"))
    )
    found = dataclasses.replace(NAMED, effects=(DELAY, change, removal))
    assert headline(found, "car.toml").startswith(
        "car.toml lacks steer_delay, has another mass than the car and has roll, which the car does not"
    )
    command = shlex.split(extend_command(found, "my car.toml", ["a.csv", "b.csv"], ["c.csv"]))
    assert command == [
        "dvp", "extend", "--model", "my car.toml", "--add", "steer_delay", "mass", "--remove", "roll",
        "--fit", "a.csv", "b.csv", "--held-out", "c.csv", "--out", "my car.extended.toml",
    ]  # fmt: skip


def test_rivals_send_the_reader_to_the_drive_that_decides() -> None:
    rival = dataclasses.replace(DELAY, rivals=("steer_lag",))
    found = dataclasses.replace(NAMED, verdict="AMBIGUOUS", effects=(rival,))
    plan = plan_command(found, "car.toml", ["a.csv"], ["b.csv"])
    assert plan == "dvp plan a.csv --held-out b.csv --model car.toml"
    assert f"what to drive to know more: {plan}" in page(found, plan=plan)
    planned = dataclasses.replace(found, effects=(dataclasses.replace(rival, deciding_manoeuvre="plan/step.xosc"),))
    assert plan_command(planned, "car.toml", ["a.csv"]) == ""
    assert "to tell steer_delay from its rivals, drive plan/step.xosc" in page(planned)
    assert plan_command(NAMED, "car.toml", ["a.csv"]) == ""


def test_commands_keep_the_options_with_which_the_logs_were_read() -> None:
    options = ["--map", "my map.toml", "--effects", "own.py"]
    added = extend_command(NAMED, "car.toml", ["a.csv"], options=options)
    assert added.endswith("--fit a.csv --out car.extended.toml --map 'my map.toml' --effects own.py")
    open_still = dataclasses.replace(NAMED, effects=(dataclasses.replace(DELAY, rivals=("steer_lag",)),))
    plan = plan_command(open_still, "car.toml", ["a.csv"], options=options)
    assert plan == "dvp plan a.csv --model car.toml --map 'my map.toml' --effects own.py"


def test_what_is_provisional_has_a_whole_command_of_its_own() -> None:
    lag = dataclasses.replace(DELAY, name="steer_lag", standing="provisional")
    found = dataclasses.replace(NAMED, effects=(dataclasses.replace(DELAY, standing="confirmed"), lag))
    assert "steer_lag" not in extend_command(found, "car.toml", ["a.csv"])
    trial = trial_command(found, "car.toml", ["a.csv"])
    assert trial == ("dvp extend --model car.toml --add steer_delay steer_lag --fit a.csv --out car.extended.toml")
    assert f"to try what is provisional: {trial}" in page(found, trial=trial)
    assert trial_command(NAMED, "car.toml", ["a.csv"]) == ""


def test_nothing_found_gives_no_command() -> None:
    assert extend_command(FOUND_NOTHING, "car.toml", ["a.csv"]) == ""


def test_causes_come_before_what_follows_from_them() -> None:
    assert causes(GIVEN) == ["yaw_rate", "x", "v"]  # x is off more, but because of the turn rate; v is not off


@pytest.mark.parametrize(
    ("estimate", "words"),
    [
        (Estimate(0.24912, 0.24701, 0.25123, "s"), ("0.249", "0.247 to 0.251")),
        (Estimate(12.0, 8.0, 16.0, "m/s^2"), ("12", "8 to 16")),
        (Estimate(0.575, 0.57499999, 0.57500001, "-"), ("0.5750", "0.5750 to 0.5750")),
        (Estimate(0.0, 0.0, 0.0, "rad"), ("0.000", "0.000 to 0.000")),
    ],
)
def test_figures_have_the_digits_that_their_interval_carries(estimate: Estimate, words: tuple[str, str]) -> None:
    assert (value(estimate), interval(estimate)) == words


@pytest.mark.parametrize(
    ("first", "told"), [("steer_delay", False), ("yaw_rate_latency", True), (None, False), ("steer_lag", False)]
)
def test_only_a_second_opinion_that_differs_is_told(first: str | None, told: bool) -> None:
    """What the first engine names, or cannot tell from it, is no disagreement; of two, the one named first is told."""
    ranking = [[name, 0.9] for name in ("steer_delay", "yaw_rate_latency", "steer_lag")]
    either = dataclasses.replace(DELAY, rivals=("steer_lag",))
    less = dataclasses.replace(DELAY, name="drive_gain", gain=0.1)
    lines = page(dataclasses.replace(NAMED, effects=(either, less), votes={"first": first, "ranking": ranking}))
    assert ("votes for yaw_rate_latency before steer_delay (90 %)" in lines) == told
    assert ("second opinion" in lines) == told


@pytest.mark.parametrize(
    ("first", "says"),
    [
        ("steer_delay", "agrees on steer_delay, which alone explains 71 % of the misfit"),
        ("steer_lag", "would take the rival of steer_delay: steer_lag"),
        ("mass", "disagrees, it would name mass"),
        (None, "would name nothing, not steer_delay either"),
    ],
)
def test_the_page_says_what_the_second_engine_says(first: str | None, says: str) -> None:
    scores = [["steer_delay", 0.71], ["steer_lag", 0.7], ["mass", 0.1]]
    either = dataclasses.replace(DELAY, rivals=("steer_lag",))
    found = dataclasses.replace(NAMED, effects=(either,), votes={"first": first, "ranking": scores, "not_judged": []})
    assert second_opinion(found).startswith(says)


def test_a_second_engine_that_votes_for_another_beside_the_rest_does_not_simply_agree() -> None:
    """Asked for the whole error it names the effect, asked once the others are taken away it names another one."""
    doubted = dataclasses.replace(DELAY, second_engine="disagrees")
    votes = {"first": "steer_delay", "ranking": [["steer_delay", 0.71]]}
    told = second_opinion(dataclasses.replace(NAMED, effects=(doubted,), votes=votes))
    assert told.startswith("agrees on steer_delay")
    assert told.endswith("but not beside the other effects: it then votes for another (see steer_delay)")
    agreed = dataclasses.replace(DELAY, second_engine="agrees")
    assert "votes for another" not in second_opinion(dataclasses.replace(NAMED, effects=(agreed,), votes=votes))


def test_a_second_engine_that_could_not_judge_says_nothing() -> None:
    votes = {"first": None, "ranking": [], "not_judged": ["steer_delay"]}
    assert second_opinion(dataclasses.replace(NAMED, votes=votes)) == ""


def test_one_reason_for_many_effects_is_told_once() -> None:
    """A reader of eight times the same sentence does not see the one that differs."""
    unlike = ("a rival votes", "much is left over in yaw, on which it acts")
    doubts = {
        "roll": ("much is left over in ay, on which it acts",),
        "headwind": ("much is left over in v, ay, on which it acts",),
        "mass": unlike,
    }
    effects = tuple(NamedEffect(name, {}, gain=1.0, doubts=each) for name, each in doubts.items())
    assert standing_lines(dataclasses.replace(NAMED, effects=effects))[:2] == [
        "provisional, mass: a rival votes; much is left over in yaw, on which it acts",
        "provisional, for the same reason: roll, headwind: much is left over in signals on which they act",
    ]
    alone = standing_lines(dataclasses.replace(NAMED, effects=effects[:1]))
    assert alone[0] == "provisional, roll: much is left over in ay, on which it acts"


def test_a_headline_begins_with_what_explains_most() -> None:
    effects = tuple(NamedEffect(name, {}, gain=gain) for name, gain in (("roll", 0.1), ("headwind", 0.6)))
    found = headline(dataclasses.replace(NAMED, verdict="PARTIAL", effects=effects), "car.toml")
    assert found.startswith("car.toml may lack headwind and roll;")


def test_held_out_data_that_chose_are_not_said_to_be_untouched() -> None:
    said = "the data held out took part in choosing the effects"
    assert not any(line.startswith(said) for line in standing_lines(NAMED))
    assert not NAMED.as_dict()["chosen_by_held_out"]
    found = dataclasses.replace(NAMED, chosen_by_held_out=True)
    assert any(line.startswith(said) for line in standing_lines(found))
    assert found.as_dict()["chosen_by_held_out"]


@pytest.mark.parametrize(("share", "told"), [(0.6, "60 %"), (0.0042, "0.42 %"), (0.997, "100 %")])
def test_what_slides_is_told_in_percent_with_two_figures(share: float, told: str) -> None:
    found = dataclasses.replace(NAMED, samples=Samples(1000, 1000.0, share, 0.25))
    (line,) = (line for line in standing_lines(found) if line.startswith("wheels lock"))
    assert f" slides, in {told} of the drives fitted; " in line
