"""The Gaussian process of the search: what it takes from earlier drives, and from parameters that do not matter."""

from __future__ import annotations

import numpy as np

from pytest_dvp.tuning.searchers.gaussian_process import BATCH, IDLE, LENGTHS, NOISE, GaussianProcess, chosen_lengths
from pytest_dvp.tuning.tuned_parameter import Knob


def test_a_knob_that_does_not_matter_gets_the_longest_length() -> None:
    at = np.random.default_rng(5).random((60, 3))
    lengths, noise = chosen_lengths(at, np.sin(6.0 * at[:, 1]), np.full(3, LENGTHS[1]))
    assert lengths[1] < 1.0
    assert lengths[0] == lengths[2] == IDLE
    assert noise == NOISE


def test_a_jagged_slope_is_seen_through_its_jumps() -> None:
    rng = np.random.default_rng(5)
    at = rng.random((60, 2))
    lengths, noise = chosen_lengths(at, at[:, 0] + 0.05 * rng.normal(size=60), np.full(2, LENGTHS[1]))
    assert noise > NOISE
    assert lengths.min() > LENGTHS[1]


def test_earlier_drives_spare_the_even_draws() -> None:
    knobs = [Knob(name, "", (0.0, 1.0)) for name in "ab"]
    rng = np.random.default_rng(5)
    earlier = [{"a": float(a), "b": float(b)} for a, b in rng.random((30, 2))]
    searcher = GaussianProcess(knobs, {"a": 0.5, "b": 0.5}, 3)
    searcher.learn(earlier, [abs(point["a"] - 0.8) + abs(point["b"] - 0.2) for point in earlier])
    asked = searcher.ask()
    assert len(asked) == BATCH
    assert min(abs(point["a"] - 0.8) + abs(point["b"] - 0.2) for point in asked) < 0.13


def test_every_second_point_of_a_batch_spreads_over_what_is_promising() -> None:
    # A margin that falls along a and says nothing of b: half of a batch lies where it is least, apart in b.
    knobs = [Knob(name, "", (0.0, 1.0)) for name in "ab"]
    earlier = [{"a": a / 6.0, "b": b / 3.0} for a in range(7) for b in range(4)]
    searcher = GaussianProcess(knobs, {"a": 0.5, "b": 0.5}, 3)
    searcher.learn(earlier, [1.0 - point["a"] for point in earlier])
    one, other = searcher.ask()[1::2]
    assert min(one["a"], other["a"]) > 0.8
    assert abs(one["b"] - other["b"]) > 0.05
