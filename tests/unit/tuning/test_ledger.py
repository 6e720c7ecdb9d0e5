"""What an iteration leaves: figures with intervals, the judge's rule, the ledger, which knob moved what."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from pytest_dvp.tuning.held_out_judge import HeldOutScore, same_stack_change, stack_change, twin_change
from pytest_dvp.tuning.iteration_plan import State
from pytest_dvp.tuning.ledger import Entry, write_ledger
from pytest_dvp.tuning.objective import Objective, Score, Term
from pytest_dvp.tuning.sensitivity import sensitivity
from pytest_dvp.tuning.stage_gap import Gap, figure
from pytest_dvp.tuning.study import Study
from pytest_dvp.tuning.tune import Trial, Tuning
from pytest_dvp.tuning.tuned_parameter import Knob


def test_interval_is_that_of_student_over_the_repeats() -> None:
    """Means 1, 2, 3 of three seeds: s = 1, t(0.975, 2) = 4.303."""
    found = figure("max jerk", [(1, 0.5), (1, 1.5), (2, 2.0), (3, 3.0)])
    assert found.mean == 2.0
    assert found.half_width == pytest.approx(4.303 / math.sqrt(3.0), rel=1e-3)
    assert found.worst == 3.0


def test_one_repeat_has_no_interval() -> None:
    assert figure("max jerk", [(1, 0.5), (1, 1.5)]).half_width is None


def test_the_worst_mncc_is_the_least() -> None:
    assert figure("ego x", [(1, 0.9), (2, 0.99)]).worst == 0.9


def test_a_figure_tells_how_many_drives_do_not_define_it() -> None:
    found = figure("steer", [(1, None), (2, 0.9)])
    assert (found.known, found.count) == (1, 2)


@pytest.mark.parametrize(("old", "new", "told"), [(2.0, 1.98, "better"), (2.0, 1.995, "alike"), (2.0, 2.02, "worse")])
def test_a_twin_is_better_by_two_percent_of_the_error(old: float, new: float, told: str) -> None:
    assert twin_change(old, new) == told


@pytest.mark.parametrize(("new", "told"), [(0.99, "better"), (1.004, "alike"), (1.01, "worse"), (1e6, "worse")])
def test_a_stack_is_better_by_half_a_percent_of_the_score(new: float, told: str) -> None:
    assert stack_change(1.0, new) == told


def judged(*costs: float, broken: tuple[str, ...] = ()) -> HeldOutScore:
    score = Score(sum(costs) / len(costs), {}, broken)
    return HeldOutScore(State(Path("twin.toml"), {}, {}), score, 0.0, 0.0, 0.0, Gap({}, {}, {}), (), costs=costs)


@pytest.mark.parametrize(
    ("apart", "told"),
    [
        ((0.04, -0.02, 0.05, -0.01), "alike"),  # mean 0.015, t = 0.015 / (0.03512 / 2) = 0.85
        ((0.01, 0.02, 0.03, 0.00), "alike"),  # mean 0.015, t = 0.015 / (0.01291 / 2) = 2.324 < t(0.95, 3) = 2.353
        ((0.01, 0.02, 0.03, 0.001), "worse"),  # mean 0.01525, t = 0.01525 / (0.01253 / 2) = 2.43
        ((-0.01, -0.02, -0.03, -0.001), "better"),
        ((0.001, 0.001, 0.001, 0.001), "alike"),  # no scatter at all, but less than half a percent
    ],
)
def test_scatter_of_the_drives_is_no_loss_of_the_same_stack(apart: tuple[float, ...], told: str) -> None:
    old = judged(1.0, 1.0, 1.0, 1.0)
    assert same_stack_change(old, judged(*(1.0 + each for each in apart))) == told


def test_what_must_not_happen_is_never_chance() -> None:
    crash = judged(1.0, 1.0, 1.0, 1001001.0, broken=("collision > 0",))
    assert same_stack_change(judged(1.0, 1.0, 1.0, 1.0), crash) == "worse"


def test_of_two_drives_no_scatter_is_known() -> None:
    assert same_stack_change(judged(1.0, 1.0), judged(1.04, 0.99)) == "worse"


def test_ledger_holds_an_entry_a_line_and_no_nan(tmp_path: Path) -> None:
    entry = Entry(
        1,
        {"dt": {"LQR_q11": 20.0}},
        {"EGO_mass": 730.0},
        {},
        {},
        {},
        [],
        {"position": math.nan},
        {},
        ["why"],
        "twin",
        9,
    )
    write_ledger(tmp_path / "ledger.jsonl", [entry, entry])
    found = [json.loads(line) for line in (tmp_path / "ledger.jsonl").read_text().splitlines()]
    assert len(found) == 2
    assert found[0]["held_out"] == {"position": None}
    assert found[0]["changes"] == ["why"]


def test_elementary_effects_of_a_plane_are_its_slopes() -> None:
    """jerk = 3 a - b over the unit square, in units of a scale of 2: 1.5 and 0.5, without spread."""
    knobs = (Knob("P.MPC_w", "m", (0.0, 0.5, 1.0)), Knob("P.LQR_q11", "", (0.0, 1.0)))
    study = Study(
        "plane", Objective("performance", (Term("max_jerk", 2.0),)), knobs, {"P.MPC_w": 0.0, "P.LQR_q11": 0.0}
    )
    trials = []
    for a, b in ((0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 1.0)):
        point = {"P.MPC_w": a, "P.LQR_q11": b}
        trials.append(Trial(len(trials), point, Score(0.0, {}), 1, {"max_jerk": 3.0 * a - b}))
    found = sensitivity(Tuning(study, tuple(trials), "nothing improves"))
    assert found["P.MPC_w"]["max_jerk"].mean == pytest.approx(1.5)
    assert found["P.MPC_w"]["max_jerk"].spread == pytest.approx(0.0, abs=1e-12)
    assert found["P.MPC_w"]["max_jerk"].count == 2
    assert found["P.LQR_q11"]["max_jerk"].mean == pytest.approx(0.5)
