"""What a twin claims, which gates need a goal, and what of a log is too little: each by itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import log_of

from pytest_dvp.metrics import compute, tracking
from pytest_dvp.verdicts import scenario_gates
from pytest_dvp.verdicts.excited_parameters import _claimed
from pytest_dvp.verdicts.scenario_gates import NEED_A_GOAL, _without_goal

PLAIN = "[model]\nname = 'car'\n[parameters]\nwheelbase = 2.7\n"
LAG = "[[effect]]\nname = 'steer_lag'\n[effect.parameters]\ntau = 0.2\n"


def about(toml: Any) -> Any:
    return SimpleNamespace(meta={} if toml is None else {"model": toml})


@pytest.mark.parametrize(
    ("toml", "claimed"),
    [
        (None, {}),
        ("a name", {}),
        ({"toml": None}, {}),
        ({"toml": PLAIN}, {}),
        ({"toml": PLAIN + '[[effect]]\nname = "of_another_project"\n'}, {}),  # nobody here knows it
        ({"toml": PLAIN + LAG}, {"steer_lag": "steer_lag"}),
        ({"toml": PLAIN + LAG.replace("[effect.p", "fitted_on = ['a.csv']\n[effect.p")}, {}),
    ],
)
def test_a_twin_claims_the_effects_that_no_log_gave_it(toml: Any, claimed: dict[str, str]) -> None:
    assert _claimed(about(toml)) == claimed


@pytest.mark.parametrize(
    ("task", "route", "warned"),
    [
        (None, False, True),
        ("no goal", False, True),
        ("goal", False, False),
        (None, True, False),
        ("no goal", True, False),
    ],
)
def test_a_metric_that_needs_a_goal_is_warned_of_where_neither_file_names_one(
    task: str | None, route: bool, warned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scenario_gates, "_has_route", lambda scenario: route)
    metric = sorted(NEED_A_GOAL)[0]
    told = None if task is None else SimpleNamespace(goal=None if task == "no goal" else "there")
    gates: Any = SimpleNamespace(task=told, gates=[SimpleNamespace(metric="max_speed", line=3),
                                                   SimpleNamespace(metric=metric, line=5)])  # fmt: skip
    found = list(_without_goal(gates, SimpleNamespace(), None, "a.toml", "a.xosc"))  # type: ignore[arg-type]
    assert [(each.code, each.line, each.element) for each in found] == (
        [("dvp.gates.no_goal", 5, "gate[2].metric")] if warned else []
    )


@pytest.mark.parametrize("points", [0, 1])
def test_a_single_point_is_no_reference_line(points: int) -> None:
    log = log_of(columns={"x": 0.0, "y": 0.0}, reference=[[0.0, 0.0]] * points)
    assert compute("lateral_rmse", log).reason == "the log has no reference line: the task has neither lane nor route"


def test_an_error_of_position_counts_by_a_covariance_that_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """e' P^-1 e of (1, 2) m: with P = diag(4, 1) it is 1/4 + 4, with (2, 1; 1, 2) it is (2 - 4 + 8)/3. The others are
    no covariances: correlated by more than 1 (also with a small second variance), without a first variance,
    or with negative ones, whose determinant is positive again."""
    table = SimpleNamespace(cov_xx=np.array([4.0, 2.0, 1.0, 0.0, -0.5]), cov_xy=np.array([0.0, 1.0, 0.2, 0.0, 0.0]),
                            cov_yy=np.array([1.0, 2.0, 0.01, 1.0, -0.5]))  # fmt: skip
    rows: Any = SimpleNamespace(row=np.arange(5))
    monkeypatch.setattr(tracking, "seen_of", lambda *given: (rows, np.arange(5)))
    monkeypatch.setattr(tracking, "offset_of", lambda log, m, seen: (np.ones(len(seen)), np.full(len(seen), 2.0)))
    monkeypatch.setattr(
        tracking, "worst_of", lambda m, seen, error, value, more: (list(seen), list(error), value, more)
    )
    found: Any = tracking.nees(SimpleNamespace(detections=table))  # type: ignore[arg-type]
    assert found[0] == [0, 1]
    assert found[1] == pytest.approx([4.25, 2.0])
    assert found[2] == pytest.approx(3.125)
    assert found[3] == pytest.approx({"greatest": 4.25, "samples": 2.0})
