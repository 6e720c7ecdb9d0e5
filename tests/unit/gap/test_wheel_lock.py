"""A wheel that locks is told from a speed that is late, scaled or noisy."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import cut
from pytest_dvp.gap.compare.wheel_lock import locked
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Samples, Step
from pytest_dvp.gap.words.diagnosis import page
from pytest_dvp.logs.log_contents import FloatArray

T = np.arange(0.0, 20.0, 0.02)
BRAKES = np.clip(20.0 - 5.0 * np.maximum(T - 10.0, 0.0), 5.0, None)  # m/s, from 20 to 5 by 5 m/s^2
EVERY = np.ones(len(T), dtype=np.bool_)


def one_rear_wheel_locks(first: float, last: float) -> FloatArray:
    """The mean of two wheels, one of which stops within 0.1 s and runs up again as fast."""
    return np.asarray(BRAKES * (1.0 - 0.5 * np.interp(T, [first, first + 0.1, last, last + 0.1], [0, 1, 1, 0])))


def test_the_rows_in_which_a_wheel_is_locked_are_found() -> None:
    found = T[locked(T, one_rear_wheel_locks(11.0, 11.8), BRAKES, EVERY)]
    assert found[0] == pytest.approx(11.0, abs=0.05)
    assert found[-1] == pytest.approx(11.9, abs=0.05)
    assert np.diff(found).max() < 0.03


def test_a_wheel_that_stops_over_several_samples_is_locked_if_no_tyre_changes_a_car_s_speed_so_fast() -> None:
    """Half of 15 m/s within 0.4 s, and half of the 5 m/s^2 of the car: over 0.1 s as over 0.02 s about 20 m/s^2."""
    v = BRAKES * (1.0 - 0.5 * np.interp(T, [11.0, 11.4, 12.0, 12.4], [0, 1, 1, 0]))
    found = T[locked(T, v, BRAKES, EVERY)]
    assert found[0] == pytest.approx(11.1, abs=0.05)
    assert found[-1] == pytest.approx(12.3, abs=0.05)


@pytest.mark.parametrize("late", [0.0, 0.4])
@pytest.mark.parametrize("scale", [0.8, 1.0])
def test_a_late_scaled_and_noisy_speed_is_no_locked_wheel(late: float, scale: float) -> None:
    ground = np.interp(T - late, T, BRAKES) + np.random.default_rng(3).normal(0.0, 0.05, len(T))
    v = scale * BRAKES + np.random.default_rng(4).normal(0.0, 0.06, len(T))
    assert not locked(T, v, ground, EVERY).any()


@pytest.mark.parametrize("rows", [10, 20])
def test_a_slow_speed_that_a_fast_file_holds_is_no_locked_wheel(rows: int) -> None:
    """10 and 5 Hz in a file of 100 Hz, as a car brakes to a standstill by 9 m/s^2: steps of 0.9 and 1.8 m/s."""
    t = np.arange(0.0, 12.0, 0.01)
    ground = np.clip(20.0 - 9.0 * np.maximum(t - 5.0, 0.0), 0.0, None)
    held = np.repeat(ground[::rows], rows)
    assert not locked(t, held, ground, np.ones(len(t), dtype=np.bool_)).any()
    held[600:650] = 0.0  # and for half a second it is locked
    assert locked(t, held, ground, np.ones(len(t), dtype=np.bool_))[605:645].all()


def test_a_jump_of_the_position_is_none_either_and_nothing_is_said_of_what_was_not_measured() -> None:
    moved = BRAKES + np.where(np.abs(T - 5.0) < 0.2, 15.0, 0.0)
    assert not locked(T, BRAKES, moved, EVERY).any()
    assert not locked(T, one_rear_wheel_locks(11.0, 11.8), BRAKES, ~EVERY).any()


def test_from_half_a_second_before_to_the_end_of_its_segment_it_does_not_count() -> None:
    measured = np.full((len(T), 8), np.nan)
    measured[:, 0] = np.concatenate([[0.0], np.cumsum(0.5 * (BRAKES[1:] + BRAKES[:-1]) * np.diff(T))])
    measured[:, [1, 2, 4]] = 0.0
    measured[:, 3] = one_rear_wheel_locks(11.0, 11.8)
    found = cut(T, measured)
    assert 0.8 < 0.02 * found.slides.sum() < 1.0
    segment = next(s for s in itertools.pairwise([*found.starts, len(T)]) if T[s[0]] < 11.0 <= T[s[1] - 1])
    assert T[found.abandoned][0] == pytest.approx(max(10.5, T[segment[0]]), abs=0.05)
    assert T[found.abandoned][-1] == T[segment[1] - 1]
    assert not found.counted[found.abandoned].any()
    measured[:, 3] = BRAKES
    assert not cut(T, measured).abandoned.any()


def test_the_answer_says_how_much_of_the_drive_it_is_and_what_is_left_out() -> None:
    step = Step("", 1.0, {"v": 1.0}, {"v": 0.03})
    quiet = Diagnosis("NOTHING_MISSING", (), (), (step,), {"v": 0.03}, {}, samples=Samples(100, 100.0))
    slid = dataclasses.replace(quiet, samples=Samples(100, 100.0, slides=0.0569, left_out=0.238))
    assert "lock" not in page(quiet)
    text = " ".join(page(slid).split())
    assert "wheels lock or spin, or the car slides, in 5.7 % of the drives fitted" in text
    assert "24 % of them is left out of the fit" in text
    assert slid.as_dict()["samples"] == {
        "count": 100,
        "independent": 100.0,
        "slides": 0.0569,
        "left_out": 0.238,
        "slopes": 0.0,
    }
