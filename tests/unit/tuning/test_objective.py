"""What is to become small, and what may not decide alone."""

from __future__ import annotations

import itertools
import math

import pytest

from pytest_dvp.tuning.held_out_judge import twin_change
from pytest_dvp.tuning.objective import ALIGNMENT, FORBIDDEN, Constraint, Objective, Term
from pytest_dvp.tuning.tuned_parameter import Knob
from pytest_dvp.workers.errors import TuneError


def test_an_alignment_that_only_mncc_judges_is_refused() -> None:
    with pytest.raises(TuneError, match=r"mncc alone is blind to gain, delay and bias"):
        Objective("alignment", (Term("mncc.v", 0.01, target=1.0),))


def test_a_sighted_term_without_weight_does_not_count() -> None:
    with pytest.raises(TuneError, match="alignment needs a term"):
        Objective("alignment", (Term("mncc.v", 0.01, target=1.0), Term("chi2_per_n", 1.0, 0.0)))


def test_the_alignment_that_ships_sees_lag_and_gain() -> None:
    words = {word for term in ALIGNMENT.terms for word in term.metric.split(".")}
    assert {"chi2_per_n", "nrmse", "mncc", "lag", "gain"} <= words


def test_a_score_is_the_weighted_mean_over_simulations() -> None:
    objective = Objective("performance", (Term("max_jerk", 2.0, 3.0), Term("completion_time", 10.0, target=100.0)))
    score = objective.score([{"max_jerk": 1.0, "completion_time": 90.0}, {"max_jerk": 3.0, "completion_time": 120.0}])
    assert dict(score.parts) == {"max_jerk": 3.0, "completion_time": 1.5}
    assert score.value == 4.5


def test_two_terms_of_one_metric_both_count() -> None:
    objective = Objective("performance", (Term("max_jerk", 1.0), Term("max_jerk", 0.1, target=5.0)))
    assert objective.score([{"max_jerk": 4.0}]).value == pytest.approx(4.0 + 10.0)


def test_a_twin_within_the_noise_is_not_tuned_towards_it() -> None:
    """chi^2/N is 1 for a true twin; 0.4 (log10 -0.4) is not worse than 1 and not better."""
    term = next(term for term in ALIGNMENT.terms if term.metric == "log10.chi2_per_n")
    assert [term.cost(value) for value in (-0.4, 0.0, 1.0)] == [0.0, 0.0, 1.0]
    assert twin_change(math.log10(0.9), math.log10(0.2)) == "alike"
    assert twin_change(math.log10(1.5), math.log10(0.2)) == "better"


@pytest.mark.parametrize("value", [None, math.nan])
def test_what_is_not_defined_is_no_good_result(value: float | None) -> None:
    score = Objective("performance", (Term("max_jerk", 1.0),)).score([{"max_jerk": value}])
    assert score.broken == ("max_jerk undefined",)
    assert score.value >= FORBIDDEN


def test_no_scale_is_so_small_that_a_point_which_breaks_nothing_stands_behind_one_that_does() -> None:
    """A jerk of 2 over a scale of 1e-6 is two million; the point with a jerk of 0 has hit somebody."""
    objective = Objective("performance", (Term("max_jerk", 1e-6),), (Constraint("collision", 0.0),))
    jerks = (0.0, 0.4, 0.5, 0.6, 2.0, 3.0, 1e3)
    keeps = [objective.score([{"max_jerk": jerk, "collision": 0.0}]).value for jerk in jerks]
    assert keeps[:3] == [0.0, pytest.approx(4e5), pytest.approx(5e5)]
    assert all(one < other for one, other in itertools.pairwise(keeps))
    assert keeps[-1] < objective.score([{"max_jerk": 0.0, "collision": 1.0}]).value


def test_of_two_forbidden_points_the_one_that_breaks_less_is_better() -> None:
    objective = Objective("performance", (Term("max_jerk", 1.0),), (Constraint("tet", 0.0),))
    near, far = (objective.score([{"max_jerk": 0.0, "tet": tet}]).value for tet in (0.2, 3.0))
    assert FORBIDDEN < near < far


def test_a_constraint_may_bound_from_below() -> None:
    """A recall of 0.95 keeps at least 0.9; of two that do not, the one that lacks less is better."""
    objective = Objective("performance", (Term("max_jerk", 1.0),), (Constraint("recall", low=0.9),))
    keeps, near, far = (objective.score([{"max_jerk": 0.0, "recall": recall}]) for recall in (0.95, 0.8, 0.5))
    assert keeps.allowed
    assert near.broken == far.broken == ("recall < 0.9",)
    assert FORBIDDEN < near.value < far.value


def test_a_constraint_of_two_bounds_says_which_one_is_broken() -> None:
    objective = Objective("performance", (Term("max_jerk", 1.0),), (Constraint("gap", 3.0, 1.0),))
    drives = [{"max_jerk": 0.0, "gap": gap} for gap in (0.5, 2.0, 5.0)]
    assert [objective.score([drive]).broken for drive in drives] == [("gap < 1",), (), ("gap > 3",)]
    assert objective.score(drives).broken == ("gap > 3", "gap < 1")


@pytest.mark.parametrize(
    ("values", "share", "value"),
    [((0.0, 10.0), 0.25, 2.5), ((1.0, 100.0), 0.5, 10.0), ((5.0, 10.0), 1.5, 10.0), ((5.0, 10.0), -1.0, 5.0)],
)
def test_range_of_a_knob_is_even_or_by_decades(values: tuple[float, ...], share: float, value: float) -> None:
    knob = Knob("P.LQR_r11", "", values)
    assert knob.at(share) == pytest.approx(value)
    assert knob.share(knob.at(share)) == pytest.approx(min(max(share, 0.0), 1.0))
