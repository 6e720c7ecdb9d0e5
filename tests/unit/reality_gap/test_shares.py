"""Shares of the error: of the excess over the noise, with intervals that widen when one segment decides."""

from __future__ import annotations

import pytest

from pytest_dvp.reality_gap.diagnosis import Step
from pytest_dvp.reality_gap.shares import shares

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
