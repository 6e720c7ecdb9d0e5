"""An effect whose size stays open stays in a set, far from the car, if nearly all comes back without it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose.open_values import carries
from tests.unit.gap.linear_world import ROWS, a_trial


@pytest.mark.parametrize(
    ("left", "without", "kept"),
    [(10.0, 15.1, True), (10.0, 14.9, False), (2.1, 9.0, True), (1.9, 9.0, False)],
)
def test_it_stays_if_half_as_much_again_is_left_without_it_and_twice_the_noise_anyway(
    left: float, without: float, kept: bool
) -> None:
    best, less = a_trial(left * ROWS, "drive_gain", "drive_lag"), a_trial(without * ROWS, "drive_gain")
    search: Any = SimpleNamespace(
        target=SimpleNamespace(excused=False), count=ROWS, without=lambda trial, name: less,
        is_credible=lambda trial, name, certain: not certain, bare=False,
    )  # fmt: skip
    assert carries(search, best, "drive_lag", far=2.0) is kept
    search.target.excused = True  # what a twin is known to leave is no reason
    assert carries(search, best, "drive_lag", far=2.0) is False


@pytest.mark.parametrize(
    ("bare", "name", "kept"), [(True, "mass", True), (False, "mass", False), (True, "roll", False)]
)
def test_what_nearly_every_car_has_stays_where_a_search_began_with_it(bare: bool, name: str, kept: bool) -> None:
    search: Any = SimpleNamespace(
        target=SimpleNamespace(excused=False), count=ROWS, without=lambda trial, name: a_trial(10.5 * ROWS),
        is_credible=lambda trial, name, certain: not certain, bare=bare,
    )  # fmt: skip
    assert carries(search, a_trial(10.0 * ROWS, name), name, 2.0) is kept
    assert carries(search, a_trial(1.9 * ROWS, name), name, 2.0) is False


def test_a_value_at_an_end_of_its_range_stays_nonsense() -> None:
    search: Any = SimpleNamespace(
        target=SimpleNamespace(excused=False), count=ROWS, without=lambda trial, name: a_trial(99.0 * ROWS),
        is_credible=lambda trial, name, certain: False, bare=True,
    )  # fmt: skip
    assert carries(search, a_trial(10.0 * ROWS, "drive_lag"), "drive_lag", far=2.0) is False
