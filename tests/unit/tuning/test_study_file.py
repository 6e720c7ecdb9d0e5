"""Study and plan files: what is wrong in them is said in one line, with file, line and what is allowed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pytest_dvp.tuning.iteration_plan_file import read_plan
from pytest_dvp.tuning.study_file import read_study
from pytest_dvp.workers.errors import TuneError
from scenarios import path as shipped

SOUND = """[study]
objective = "performance"
preset = 1
model = "models/surrogate.toml"
seeds = [7, 8]

[[scenario]]
file = "overtaking.xosc"
set = { target_position = 60 }

[parameters]
"P.LQR_q11" = [20, 30]
"S.EGO_mass" = { values = [730, 1000], plausible = [650, 900] }
"""


def written(folder: Path, text: str) -> Path:
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_start_is_the_preset_and_a_candidate(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SOUND.replace("[20, 30]", "[30, 50]")))
    assert study.start["P.LQR_q11"] == 20.0  # Arango et al., 1st iteration
    assert study.knobs[0].values == (20.0, 30.0, 50.0)
    assert study.knobs[1].plausible == (650.0, 900.0)


def test_every_scenario_meets_every_seed(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SOUND))
    jobs = study.jobs(study.start)
    assert [job.seed for job in jobs] == [7, 8]
    assert dict(jobs[0].P)["LQR_r11"] == 9000.0
    assert dict(jobs[0].S)["EGO_mass"] == 1000.0


def test_the_pedestrian_is_the_scenarios(tmp_path: Path) -> None:
    assert "PEDESTRIAN_speed" not in read_study(written(tmp_path, SOUND)).fixed_S


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('"P.LQR_q11"', '"P.LQR_q12"', 12, "unknown ADS parameter 'LQR_q12'; did you mean"),
        ("[study]", "[iterate]", 1, "this is a plan (dvp iterate), not a study"),
        ("[study]", "[model]", 1, "this is a vehicle model, not a study"),
        ('"models/surrogate.toml"', "5", 4, "model is 5, expected the name of a model in quotes"),
        (
            "[parameters]",
            '[[constraint]]\nmetric = "tet"\nmx = 0\n[parameters]',
            13,
            "unknown key of [[constraint]] 'mx'",
        ),
        ("values = [730, 1000]", "values = 730", 13, "S.EGO_mass: values is 730, expected a list of numbers"),
        ("plausible = [650, 900]", "plausible = 650", 13, "plausible is 650, expected a list of numbers"),
        ('"P.LQR_q11"', '"Q.LQR_q11"', 12, "expected P.NAME or S.NAME"),
        ("[20, 30]", "[20, 30e9]", 12, "outside its range [0, 10000]"),
        ("[20, 30]", "[]", 12, "fewer than two candidates"),
        ("[20, 30]", '["a", 30]', 12, "expected a number"),
        ("[650, 900]", "[900, 650]", 13, "expected [low, high]"),
        ("overtaking.xosc", "overtake.xosc", 8, "no scenario 'overtake.xosc'"),
        ("overtaking.xosc", "overtakin.xosc", 8, "did you mean 'overtaking.xosc'?"),
        ("models/surrogate.toml", "models/surogate.toml", 4, "did you mean 'models/surrogate.toml'?"),
        ('"performance"', '"performing"', 2, "did you mean 'performance'"),
        ('"performance"', '"alignment"', 2, "needs recorded logs"),
        ("preset = 1", "preset = 2", 3, "expected 1, 5, 10"),
        ("seeds = [7, 8]", "seed_s = [7, 8]", 5, "did you mean"),
        ("preset = 1", 'stage = "rw"', 13, "states no start"),
        ("[parameters]", '[fixed]\n"P.LQR_q11" = 25\n[parameters]', 12, "stands in [parameters] and in [fixed]"),
        ('"P.LQR_q11" =', "P.LQR_q11 =", 12, 'P.LQR_q11 needs quotes: "P.LQR_q11" = [...]'),
        ("preset = 1", "preset = 1\nbudget = 0", 4, "budget is 0, expected a whole number >= 1"),
        ("preset = 1", "preset = 1\nbudget = 1", 4, "budget is 1, and one point takes 2 simulations"),
        ("[7, 8]", "[]", 5, "seeds is [], expected a list of whole numbers, one at least"),
        ("overtaking.xosc", "overtaking.gates.toml", 8, "'overtaking.gates.toml', expected an .xosc file"),
    ],
)
def test_a_slip_is_one_line(tmp_path: Path, old: str, new: str, line: int, words: str) -> None:
    file = written(tmp_path, SOUND.replace(old, new, 1))
    with pytest.raises(TuneError) as caught:
        read_study(file)
    text = str(caught.value)
    assert text.startswith(f"{file}:{line}: ")
    assert words in text
    assert "\n" not in text


def test_a_scenario_parameter_outside_its_constraints_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="target_position: found 10"):
        read_study(written(tmp_path, SOUND.replace("target_position = 60", "target_position = 10")))


def test_a_budget_below_one_point_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TuneError, match="one point takes 2 simulations"):
        read_study(written(tmp_path, SOUND), budget=1)


def test_terms_of_mncc_alone_are_refused_with_their_line(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"")
    text = SOUND.replace('"performance"', '"alignment"').replace("seeds = [7, 8]", 'logs = ["a.mcap"]')
    text = text.replace('"P.LQR_q11" = [20, 30]\n', "") + '[[term]]\nmetric = "mncc.v"\ntarget = 1.0\n'
    with pytest.raises(TuneError, match=r"study.toml:13: .* alone is blind"):
        read_study(written(tmp_path, text))


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *(("performance", name) for name in ("min_distance", "goal_reached", "detection_recall", "nees")),
        *(("alignment", name) for name in ("mncc.v", "gain.v")),
    ],
)
@pytest.mark.parametrize(("table", "key"), [("term", "target"), ("constraint", "max")])
def test_what_is_not_best_at_0_must_say_what_it_is_to_be(
    tmp_path: Path, kind: str, name: str, table: str, key: str
) -> None:
    """A search that brings the distance to others to 0 looks for a crash."""
    text = SOUND
    if kind == "alignment":
        (tmp_path / "a.mcap").write_bytes(b"")
        text = SOUND.replace('"performance"', '"alignment"').replace("seeds = [7, 8]", 'logs = ["a.mcap"]')
        text = text.replace('"P.LQR_q11" = [20, 30]\n', "") + '[[term]]\nmetric = "nrmse.v"\n'
    text += f'[[{table}]]\nmetric = "{name}"\n'
    with pytest.raises(TuneError, match=rf"study.toml:\d+: {name}: without a {key}"):
        read_study(written(tmp_path, text))
    assert name in read_study(written(tmp_path, text + f"{key} = 1.0\n")).objective.metrics


@pytest.mark.parametrize(
    ("bounds", "low", "high"),
    [("min = 0.9", 0.9, math.inf), ("max = 2", -math.inf, 2.0), ("min = 0.5\nmax = 2", 0.5, 2.0)],
)
def test_a_constraint_has_a_min_a_max_or_both(tmp_path: Path, bounds: str, low: float, high: float) -> None:
    text = f'{SOUND}[[constraint]]\nmetric = "detection_recall"\n{bounds}\n'
    (constraint,) = read_study(written(tmp_path, text)).objective.constraints
    assert (constraint.low, constraint.high) == (low, high)


def test_a_constraint_that_allows_no_value_is_refused(tmp_path: Path) -> None:
    text = f'{SOUND}[[constraint]]\nmetric = "tet"\nmin = 2\nmax = 1\n'
    with pytest.raises(TuneError, match=r"tet: min = 2 is more than max = 1, so no value is allowed$"):
        read_study(written(tmp_path, text))


@pytest.mark.parametrize("name", ["max_jerk", "completion_time", "missed_events", "events_fired"])
def test_what_is_best_at_0_needs_no_target(tmp_path: Path, name: str) -> None:
    text = f'{SOUND}[[term]]\nmetric = "{name}"\n[[constraint]]\nmetric = "{name}"\n'
    assert read_study(written(tmp_path, text)).objective.metrics == (name,)


def test_an_error_below_the_noise_is_no_better_and_no_worse_than_the_noise(tmp_path: Path) -> None:
    """A term of one's own counts as the one that ships: whoever tunes for less, or back up to 0, fits noise."""
    (tmp_path / "a.mcap").write_bytes(b"")
    text = SOUND.replace('"performance"', '"alignment"').replace("seeds = [7, 8]", 'logs = ["a.mcap"]')
    text = text.replace('"P.LQR_q11" = [20, 30]\n', "") + '[[term]]\nmetric = "log10.chi2_per_n"\n'
    (term,) = read_study(written(tmp_path, text)).objective.terms
    assert [term.cost(value) for value in (-0.3, 0.0, 0.3)] == [0.0, 0.0, 0.3]


def test_plan_of_the_paper_learns_nothing_from_its_judges() -> None:
    plan = read_plan(shipped("mcrpg/paper.toml"))
    drives = {(v.title, seed) for v in plan.variants for seed in plan.seeds}
    judges = {(v.title, seed) for v in plan.held_out for seed in (*plan.held_out_seeds, *plan.last_seeds)}
    assert not drives & judges
    assert not {v.title for v in plan.variants} & {v.title for v in plan.held_out}
    assert not set(plan.held_out_seeds) & set(plan.last_seeds)
    assert len(plan.last_seeds) >= 5


def test_a_judge_that_was_learnt_from_is_refused(tmp_path: Path) -> None:
    text = shipped("mcrpg/paper.toml").read_text(encoding="utf-8")
    text = text.replace("held_out_seeds = [101, 102]", "held_out_seeds = [7]")
    text += '\n[[held_out]]\nfile = "overtaking.xosc"\n'
    with pytest.raises(TuneError, match="would judge itself"):
        read_plan(written(tmp_path, text))
