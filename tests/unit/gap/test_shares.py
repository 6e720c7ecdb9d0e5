"""Shares of the error: of the excess over the noise, with intervals that widen when one segment decides."""

from __future__ import annotations

import pytest

from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.gap.diagnose.error_shares import percents, shares

N = 100.0  # samples of a segment


def step(added: str, segments: list[float]) -> Step:
    chi2 = sum(segments) / (N * len(segments))
    return Step(added, chi2, {}, {}, held_out_chi2_per_n=chi2, segments=tuple(segments),
                held_out_segments=tuple(segments))  # fmt: skip


EVEN = [step("", [1100.0] * 20), step("a", [350.0] * 20), step("b", [100.0] * 20)]
"""chi^2/N 11, 3.5, 1: of an excess of 10 the first takes away 7.5, the second 2.5."""


def test_a_share_is_that_of_the_excess_over_the_noise() -> None:
    found = shares(EVEN)
    assert list(found) == ["a", "b"]
    assert found["a"].value == pytest.approx(0.75)
    assert found["b"].value == pytest.approx(0.25)


def test_an_error_that_is_everywhere_alike_leaves_no_doubt() -> None:
    one = shares(EVEN)["a"]
    assert (one.low, one.high) == (pytest.approx(0.75), pytest.approx(0.75))


def test_an_effect_of_a_single_segment_is_in_doubt() -> None:
    """Drawn with replacement, the segment is missing in (1 - 1/20)^20 = 36 % of the draws: the share may be nothing."""
    ladder = [step("", [8100.0] + [500.0] * 19), step("a", [100.0] + [500.0] * 19)]
    one = shares(ladder)["a"]
    assert one.value == pytest.approx(8000.0 / (8100.0 + 19 * 500.0 - 2000.0))
    assert one.low == 0.0
    assert one.high > one.value + 0.1


def test_held_out_data_may_lose() -> None:
    ladder = [EVEN[0], Step("a", 1.0, {}, {}, held_out_chi2_per_n=12.0, segments=(100.0,) * 20,
                            held_out_segments=(1200.0,) * 20)]  # fmt: skip
    assert shares(ladder, held_out=True)["a"].value == pytest.approx(-0.1)


@pytest.mark.parametrize("ladder", [[step("", [100.0] * 9), step("a", [99.0] * 9)], [Step("", 9.0, {}, {})]])
def test_nothing_to_explain_has_no_shares(ladder: list[Step]) -> None:
    assert shares(ladder) == {}
    assert shares(ladder, held_out=True) == {}


def test_what_is_shown_adds_up() -> None:
    """88.6 and 11.4 would be 89 and 11, but 87.5, 10.6 and 1.9 would be 88, 11 and 2: 101 %."""
    assert percents([0.886, 0.114]) == ["89 %", "11 %"]
    assert percents([0.875, 0.106, 0.019]) == ["87 %", "11 %", "2 %"]
    assert percents([0.13, 0.87]) == ["13 %", "87 %"]
    assert percents([]) == []


def test_where_one_is_too_small_for_a_whole_percent_all_have_a_decimal() -> None:
    assert percents([0.9876, 0.0096, 0.0028]) == ["98.8 %", "0.9 %", "0.3 %"]
    assert percents([1.0, 0.0]) == ["100 %", "0 %"]
    assert percents([1.1, -0.1]) == ["110 %", "-10 %"]


def test_shares_are_of_what_can_be_explained() -> None:
    """A fit that ends below its noise, chi^2/N 0.9, explains the error and no more."""
    found = shares([step("", [1100.0] * 20), step("a", [350.0] * 20), step("b", [90.0] * 20)])
    assert [one.shown for one in found.values()] == ["75 %", "25 %"]
