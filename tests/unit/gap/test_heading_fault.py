"""A heading that its yaw rate contradicts does not count; a late or biased yaw rate is no such fault."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.heading_check import heading_faults
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.log_contents import FloatArray

T = np.arange(0.0, 60.0, 0.02)
STARTS = np.arange(0, len(T), 250)
ENDS = np.append(STARTS[1:], len(T))
RATE = 0.3 * np.sin(0.7 * T)  # rad/s
YAW = -0.3 / 0.7 * np.cos(0.7 * T)  # rad, its integral


def faults(yaw: FloatArray, rate: FloatArray) -> BoolArray:
    return heading_faults(T, yaw, rate, STARTS, ENDS, np.ones(len(T), dtype=np.bool_))


def test_a_heading_that_aligns_itself_while_the_car_sets_off_is_one() -> None:
    """It turns by a radian between 2 and 4 s, which the gyroscope did not see."""
    found = faults(YAW - np.clip(0.5 * (4.0 - T), 0.0, 1.0), RATE)
    assert np.flatnonzero(found).tolist() == [0]


@pytest.mark.parametrize(
    ("rate", "why"),
    [
        (0.3 * np.sin(0.7 * (T - 0.4)), "0.4 s late"),
        (RATE + 0.06, "biased by 0.06 rad/s: 0.3 rad in each segment"),
        (1.5 * RATE, "half as much again"),
        (np.full(len(T), np.nan), "not measured"),
    ],
)
def test_what_every_segment_has_is_none(rate: FloatArray, why: str) -> None:
    assert not faults(YAW, rate).any(), why


@pytest.mark.parametrize(("late", "told"), [(-1.2, []), (-0.4, [0]), (0.0, [0]), (0.4, [0]), (1.2, [])])
def test_a_yaw_rate_is_half_a_second_early_or_late_at_most(late: float, told: list[int]) -> None:
    """By 1.2 s it is no late one: each segment is off by 0.4 rad then, and a radian is no more than ten times that."""
    aligned = YAW - np.clip(0.5 * (4.0 - T), 0.0, 1.0)
    assert np.flatnonzero(faults(aligned, 0.3 * np.sin(0.7 * (T - late)))).tolist() == told


@pytest.mark.parametrize(("segments", "told"), [(4, []), (5, [0]), (6, [0])])
def test_what_segments_usually_show_is_known_from_five_of_them_on(segments: int, told: list[int]) -> None:
    aligned = YAW - np.clip(0.5 * (4.0 - T), 0.0, 1.0)
    few, early = slice(None, segments), np.arange(len(T)) < 250 * segments
    assert np.flatnonzero(heading_faults(T, aligned, RATE, STARTS, ENDS, early)).tolist() == told
    every = np.ones(len(T), dtype=np.bool_)
    assert np.flatnonzero(heading_faults(T, aligned, RATE, STARTS[few], ENDS[few], every)).tolist() == told


@pytest.mark.parametrize(("rows", "told"), [(4, []), (5, [0])])
def test_a_segment_is_judged_from_five_rows_on(rows: int, told: list[int]) -> None:
    """The first one, in which the heading aligns itself, is seen at rows half a second apart from 1.98 s on."""
    aligned = YAW - np.clip(0.5 * (4.0 - T), 0.0, 1.0)
    counted = T >= 5.0
    counted[99 : 99 + 25 * rows : 25] = True
    assert np.flatnonzero(heading_faults(T, aligned, RATE, STARTS, ENDS, counted)).tolist() == told
