"""Borders of what a detector sees: their intervals, and what is clipped, with rows of which each is counted by hand."""

from __future__ import annotations

from math import inf, log, sqrt
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.perception.diagnose_perception import _Seen, _t


def rows(far: Any, seen: Any, thing: Any, block: Any = None) -> _Seen:
    found = object.__new__(_Seen)
    found.far, found.seen = np.asarray(far, dtype=float), np.asarray(seen, dtype=bool)
    found.thing = np.asarray(thing)
    found.block = np.arange(len(found.far)) if block is None else np.asarray(block)
    return found


def test_each_of_three_objects_left_out_leaves_the_border_of_the_other_two() -> None:
    """Without the first: 36 | 47; without the second: 40 | 52; without the third: 40 | 47."""
    far = {0: (20.0, 40.0, 60.0, 90.0), 1: (10.0, 32.0, 47.0, 80.0), 2: (15.0, 36.0, 52.0, 70.0), 3: (11.0, 12.0)}
    found = sorted((at, thing) for thing, places in far.items() for at in places)
    places = np.array([at for at, _ in found])
    one = rows(places, places < 45.0, [thing for _, thing in found])
    borders = np.array([41.5, 46.0, 43.5])
    spread = sqrt(2.0 / 3.0 * float(np.sum((borders - borders.mean()) ** 2)))
    assert one._between_objects(45.0) == pytest.approx(1.96 * spread)


def test_where_the_others_show_no_border_it_lies_between_their_last_two_rows() -> None:
    """One object is always seen, the other never: each alone has its border at the end."""
    places = np.array([10.0, 12.0, 20.0, 22.0, 60.0, 62.0, 70.0, 75.0])
    one = rows(places, [1, 0] * 4, [0, 1] * 4)
    borders = np.array([0.5 * (62.0 + 75.0), 65.0])
    assert one._between_objects(40.0) == pytest.approx(
        1.96 * sqrt(0.5 * float(np.sum((borders - borders.mean()) ** 2)))
    )


def test_an_object_crosses_a_border_that_lies_between_its_rows_and_not_at_one_of_them() -> None:
    one = rows([10.0, 20.0, 30.0], [1, 1, 0], [0, 0, 0])
    assert [one._crosses(0, at) for at in (10.0, 10.1, 29.9, 30.0)] == [False, True, True, False]


def likelihood_by_hand(seen: list[bool], border: int) -> float:
    hit = sum(seen[:border])
    miss, unseen = border - hit, len(seen) - border - sum(seen[border:])
    if sum(seen[border:]) > 0.05 * (len(seen) - border):
        return -inf
    share = min(max(miss / border, 1e-4), 1.0 - 1e-4)
    return hit * log(1.0 - share) + miss * log(share) + sum(seen[border:]) * log(0.005) + unseen * log(0.995)


def test_a_range_goes_from_the_first_border_that_is_likely_to_the_last() -> None:
    """Two objects side by side, so that none moves it: every other pair is seen up to 40 m, then none up to 80 m."""
    far = np.repeat(np.arange(1.0, 81.0), 2)
    seen = [bool(at <= 40.0 and at % 2 == 0) for at in far]
    one = rows(far, seen, np.tile([0, 1], 80))
    values = [likelihood_by_hand(seen, k) for k in range(1, 161)]
    best = max(values)
    likely = [k for k, value in enumerate(values, start=1) if value > best - 3.0]
    assert (likely[0], values.index(best) + 1, likely[-1]) == (80, 80, 84)
    reach, low, high, gained, never = one._range()
    assert (reach, low, high, never) == (40.5, 40.0, 43.0, 0.0)
    assert gained == pytest.approx(best - values[-1])


def test_a_clean_border_of_objects_side_by_side_lies_between_its_two_rows() -> None:
    far = np.repeat(np.arange(1.0, 81.0), 2)
    one = rows(far, far < 40.5, np.tile([0, 1], 80))
    assert one._range()[:3] == (40.5, 40.0, 41.0)


@pytest.mark.parametrize("blocks", [[0] * 10, list(range(10)), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]])
def test_misses_have_the_error_of_their_blocks_and_at_least_that_of_single_frames(blocks: list[int]) -> None:
    """Three of ten are missed: the first three. An eleventh row lies beyond the range."""
    seen = [False] * 3 + [True] * 7 + [False]
    one = rows(np.arange(1.0, 12.0), seen, np.zeros(11), [*blocks, 77])
    sums = [sum((not seen[i]) - 0.3 for i in range(10) if blocks[i] == k) for k in set(blocks)]
    m = len(sums)
    clustered = sqrt(sum(s * s for s in sums) * m / max(m - 1, 1)) / 10
    rate, spread, gained = one._misses(10.0)
    assert rate == pytest.approx(0.3)
    assert spread == pytest.approx(max(clustered, sqrt(0.3 * 0.7 / 10)))
    assert gained == pytest.approx(3 * log(0.3 / 0.005) + 7 * log(0.7))


@pytest.mark.parametrize(
    ("seen", "expected"),
    [([True] * 4, (0.0, 0.25, 0.0)), ([False] * 4, (1.0, 0.25, 4 * log(1.0 / 0.005) + 0.0)),
     ([False, *[True] * 999], (0.001, 0.001, 0.0))],
)  # fmt: skip
def test_of_misses_none_and_all_are_known_to_one_frame_and_few_are_worth_nothing(seen: Any, expected: Any) -> None:
    """One of a thousand is less than the chance of a stray box, and would bring less than nothing."""
    one = rows(np.ones(len(seen)), seen, np.zeros(len(seen)), np.arange(len(seen)))
    rate, spread, gained = one._misses(2.0)
    assert (rate, gained) == pytest.approx((expected[0], expected[2]))
    assert spread == pytest.approx(expected[1], rel=1e-3)


def hidden(share: Any, seen: Any) -> _Seen:
    found = rows([], [], [])
    found.p = SimpleNamespace(  # type: ignore[assignment]
        hidden=np.array([share]), seen=np.array([seen], dtype=bool), distance=np.full((1, len(share)), 5.0)
    )
    found.partly = np.ones((1, len(share)), dtype=bool)
    return found


def test_a_border_of_occlusion_goes_from_the_row_before_the_first_that_is_likely_to_the_last() -> None:
    """Every other of 21 rows up to 0.63 is seen, of 19 more none: the border is likely until 0.71."""
    share = 0.02 * np.arange(1.0, 41.0)
    seen = [k % 2 == 0 and k <= 20 for k in range(40)]
    values = [likelihood_by_hand(seen, k) for k in range(1, 41)]
    best = max(values)
    likely = [k for k, value in enumerate(values, start=1) if value > best - 3.0]
    value, low, high, gained = hidden(share, seen)._occlusion(5.0)
    at = values.index(best) + 1
    assert value == pytest.approx(0.5 * (share[at] + share[at - 1]))
    assert low == pytest.approx(min(share[likely[0] - 1], value - 0.1))
    assert high == pytest.approx(max(share[likely[-1]], value + 0.1))
    assert gained == pytest.approx(best - values[-1])


def test_occlusion_that_hides_everything_is_known_from_nought_to_a_tenth() -> None:
    """None of 30 is seen; without a border all would be missed, which is more likely."""
    share = np.linspace(0.3, 0.9, 30)
    assert hidden(share, [False] * 30)._occlusion(5.0) == (1.0, 0.05, 1.0, 0.0)


class PutTogether(_Seen):
    """Parts of which noise, misses and latency may be nought, with wide errors."""

    def __init__(self) -> None:
        self.fitted: Any = SimpleNamespace(
            spread=np.array([0.1, 0.2, 0.3]), noise=np.array([0.01, 0.002]), noise_spread=np.array([0.5, 0.6]),
            blocks=np.arange(10), levels=lambda: None,
            loss=lambda place, without: 1.0, noise_worth=lambda: 2.0,
        )  # fmt: skip
        self.place = np.array([0.05, 0.0, 0.0])
        self.boxes: Any = SimpleNamespace(objects=0)
        self.far, self.block = np.array([1.0, 2.0, 50.0, 51.0]), np.arange(4)
        self.p: Any = SimpleNamespace(false=0)
        self.f: Any = SimpleNamespace(duration=20.0)

    def _range(self) -> Any:
        return 50.0, 48.0, 53.0, 0.0, 0.0

    def _misses(self, reach: float) -> Any:
        return 0.1, 0.2, 4.0

    def _behind(self) -> Any:
        return None

    def _occlusion(self, reach: float) -> Any:
        return float("nan"), 0.0, 1.0, 0.0


def test_no_interval_of_a_size_reaches_below_nought_and_one_of_an_offset_does() -> None:
    values = PutTogether().perceived().values
    lows = {key: values[key][1] for key in values}
    assert lows["detection_latency", "T"] == lows["detection_misses", "rate"] == 0.0
    assert lows["detection_noise", "sigma0"] == lows["detection_noise", "slope"] == 0.0
    assert lows["detection_offset", "x"] == pytest.approx(-_t(10) * 0.2)
    assert values["detection_misses", "rate"][2] == pytest.approx(0.1 + _t(3) * 0.2)  # three blocks up to 50 m
