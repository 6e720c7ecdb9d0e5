"""The matrix of hidden effects, and one case asked of a diagnosis that is made up here."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.hidden_effects.__main__ import known_lines, main
from benchmarks.hidden_effects.case import NOISES, Case, cases, strata
from benchmarks.hidden_effects.detectable import LEAST_GAIN, gain
from benchmarks.hidden_effects.ranges import FAMILIES, PERCEPTION, RANGES, draw
from benchmarks.hidden_effects.truth import Question, question, values_of
from benchmarks.hidden_effects.work import ask
from tests.truth.effects import CATALOGUE, OUTSIDE


def test_every_effect_meets_five_seeds_at_three_noise_levels() -> None:
    assert set(RANGES) == set(CATALOGUE)
    met = Counter((case.names[0], case.seed, case.noise) for case in strata()["single"])
    assert set(met) == {(name, seed, noise) for name in CATALOGUE for seed in range(5) for noise in NOISES}
    assert set(met.values()) == {1}


def test_the_matrix_holds_what_it_should_and_no_case_twice() -> None:
    count = {name: len(members) for name, members in strata().items()}
    assert count["null"] >= 30
    assert count["pair"] == 20
    assert count["triple"] == 10
    assert count["ablation"] == 30
    assert {case.names[0] for case in strata()["outside"]} == set(OUTSIDE)
    assert {case.names[0] for case in strata()["perception"]} == set(PERCEPTION)
    assert sum(1 for case in strata()["surrogate"] + strata()["multibody"] if case.names) >= 40
    assert len({case.key for case in cases()}) == sum(count.values())


def test_no_mixture_takes_two_of_a_family() -> None:
    for case in strata()["pair"] + strata()["triple"]:
        assert all(len(family & set(case.names)) <= 1 for family in FAMILIES)


@pytest.mark.parametrize("size", [40, 100, 300])
def test_every_beginning_is_a_fair_sample(size: int) -> None:
    first = cases()[:size]
    assert {case.category for case in first} == set(strata())
    singles = [case for case in first if case.category == "single"]
    by_effect = Counter(case.names[0] for case in singles)
    most = max(by_effect.values())
    assert min(by_effect.get(name, 0) for name in CATALOGUE) >= most - 1
    by_noise = Counter(case.noise for case in singles)
    assert max(by_noise.values()) <= 3 * max(1, min(by_noise[noise] for noise in NOISES))


@pytest.mark.nightly
def test_same_case_same_values_other_base_seed_other_values() -> None:
    case = Case("urban", ("steer_delay",), 0, "mid")
    fresh = Case("urban", ("steer_delay",), 0, "mid", base_seed=2000)
    assert values_of(case) == values_of(case)
    assert values_of(case) != values_of(fresh)


def test_values_stay_in_their_range() -> None:
    rng = np.random.default_rng(1)
    for name, keys in (RANGES | PERCEPTION).items():
        for _ in range(20):
            for key, value in draw(name, rng).items():
                low, high = keys[key]
                assert low - 1e-3 * abs(low) <= value <= high + 1e-3 * abs(high)


def test_an_effect_at_its_neutral_value_gains_nothing() -> None:
    assert gain({"steer_delay": {"T": 0.0}}, "steer_delay", ("urban",), 3, "low") < 1e-6


def test_a_bias_gains_its_square_over_the_noise() -> None:
    # the gyro is one of 7 channels, its sigma 0.005 rad/s, and no start of a segment looks like a constant yaw rate
    found = gain({"gyro_bias": {"b": 0.01}}, "gyro_bias", ("urban",), 3, "mid")
    assert found == pytest.approx((0.01 / 0.005) ** 2 / 7.0, rel=0.05)


def test_an_effect_that_its_drive_never_meets_gains_nothing() -> None:
    # urban driving steers at less than 0.5 rad
    assert gain({"steer_angle_limit": {"limit": 0.5}}, "steer_angle_limit", ("urban",), 3, "low") < LEAST_GAIN


@pytest.mark.nightly
def test_an_ablation_hides_all_but_one_of_its_mixture() -> None:
    pair = Case("pair", ("steer_offset", "drive_gain"), 0, "mid")
    without = Case("ablation", pair.names, 0, "mid", off="steer_offset")
    drawn, asked = values_of(pair), question(without)
    assert drawn is not None
    assert asked is not None
    assert asked.truth == {"drive_gain": drawn[0]["drive_gain"]}


def test_an_answer_is_kept_with_its_truth_and_a_crash_is_an_answer() -> None:
    case = Case("urban", ("gyro_bias",), 0, "mid")

    def right(asked: Question) -> dict[str, Any]:
        assert list(asked.logs) == ["urban.csv"]
        assert asked.model.effects == ()
        effects = [{"name": name, "parameters": {}, "rivals": []} for name in asked.truth]
        return {"verdict": "NAMED", "effects": effects, "cpu": 1.0, "chi2_per_n": {"fit": {"before": float("inf")}}}

    def crash(asked: Question) -> dict[str, Any]:
        raise ZeroDivisionError("a\nb")

    line = ask(case, right)
    assert line["effects"][0]["name"] == "gyro_bias"
    assert line["truth"]["gyro_bias"]["b"] != 0.0
    assert json.loads(json.dumps(line, allow_nan=False)) == line
    broken = ask(case, crash)
    assert (broken["verdict"], broken["refused"]) == ("ERROR", "ZeroDivisionError: a")


def test_a_run_goes_on_behind_a_line_cut_short(tmp_path: Path) -> None:
    path = tmp_path / "answers.jsonl"
    lines = [{"key": "a", "base_seed": 1000}, {"key": "b", "base_seed": 2000}]
    path.write_text("\n".join(json.dumps(line) for line in lines) + '\n{"key": "c", "base')
    assert list(known_lines(path, 1000)) == ["a"]
    assert known_lines(tmp_path / "none", 1000) == {}


@pytest.mark.parametrize(("share", "code"), [("0.5", 0), ("0.6", 1)])
def test_a_finished_run_is_judged_without_asking_again(tmp_path: Path, share: str, code: int) -> None:
    path = tmp_path / "answers.jsonl"
    chosen = [case for case in cases() if case.category == "null"][:2]
    wrong = [{"name": "roll", "parameters": {}}]
    verdicts: list[tuple[str, list[dict[str, Any]]]] = [("NOTHING_MISSING", []), ("NAMED", wrong)]
    with path.open("w") as file:
        for case, (verdict, effects) in zip(chosen, verdicts, strict=True):
            kept = {"key": case.key, "base_seed": 1000, "category": "null", "names": [], "off": "", "noise": case.noise}
            file.write(json.dumps(kept | {"dirt": "", "car": "", "truth": {}, "verdict": verdict, "effects": effects}))
            file.write("\n")
    page = tmp_path / "page.md"
    options = ["--only", "null", "--subset", "2", "--json", str(path), "--resume", "--out", str(page)]
    assert main([*options, "--at-least", share]) == code
    assert "names something when nothing is missing | 0.500 (1/2)" in page.read_text()
