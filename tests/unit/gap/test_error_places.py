"""Where an error sits: groups, cells of the map and their order, on residuals that are worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.error_location import Where, _places, _segments, _top, locate
from pytest_dvp.gap.compare.segments import Segments
from pytest_dvp.logs.log_contents import FloatArray


def pieces(*starts: int, n: int) -> Segments:
    """Segments that begin at these rows."""
    nothing = np.zeros(n, dtype=bool)
    ends = np.array([*starts[1:], n])
    return Segments(np.array(starts), ends, np.zeros((len(starts), 6)), ~nothing, nothing, nothing, nothing)


@pytest.mark.parametrize(
    ("wide", "side"),
    [(8.0, 1.0), (8.1, 2.0), (16.0, 2.0), (16.1, 5.0), (40.0, 5.0), (40.1, 10.0), (80.0, 10.0), (81.0, 20.0),
     (0.8, 0.1), (0.81, 0.2)],
)  # fmt: skip
@pytest.mark.parametrize("along_y", [False, True])
def test_eight_cells_of_a_round_size_cover_the_longer_side(wide: float, side: float, along_y: bool) -> None:
    long, short = np.array([0.0, wide]), np.array([0.0, 0.5 * side])
    x, y = (short, long) if along_y else (long, short)
    index, names = _places(x, y)
    last = np.floor(wide / side + 1e-9)
    begins = [(0.0, 0.0), (0.0, side * last) if along_y else (side * last, 0.0)]
    assert index.tolist() == [0.0, 1.0]
    assert names == [f"place x {a:g}..{a + side:g}, y {b:g}..{b + side:g} m" for a, b in begins]


def test_cells_lie_on_round_numbers_and_what_has_no_place_is_in_none() -> None:
    x = np.array([-0.5, 7.5, np.nan, 7.4, 1.0])
    y = np.array([-3.0, 3.5, 0.0, 3.1, np.nan])
    index, names = _places(x, y)
    assert index.tolist() == [0.0, 1.0, -1.0, 1.0, -1.0]
    assert names == ["place x -1..0, y -3..-2 m", "place x 7..8, y 3..4 m"]


def test_a_car_that_stands_is_in_one_cell_and_a_log_without_places_has_none() -> None:
    index, names = _places(np.full(3, 4.0), np.full(3, 5.0))
    assert index.tolist() == [0.0, 0.0, 0.0]
    assert len(names) == 1
    index, names = _places(np.full(2, np.nan), np.zeros(2))
    assert index.tolist() == [-1.0, -1.0]
    assert names == []


def test_segments_are_called_by_their_first_and_last_stamp() -> None:
    index, names = _segments(pieces(0, 2, n=5), np.array([0.5, 1.0, 1.5, 2.0, 2.5]))
    assert index.tolist() == [0.0, 0.0, 1.0, 1.0, 1.0]
    assert names == ["segment 0.5-1.0 s", "segment 1.5-2.5 s"]


def test_of_a_partition_the_three_groups_with_most_error_for_their_time_are_named() -> None:
    index = np.repeat(np.arange(5.0), 2)
    power = np.repeat([1.0, 6.0, 2.5, 8.0, 2.5], 2)  # of 40
    known = np.ones(10, dtype=bool)
    found = _top("v", "segment", index, list("abcde"), power, known)
    assert [(w.regime, w.kind, w.channel) for w in found] == [("d", "segment", "v"), ("b", "segment", "v")]
    assert [w.share_of_error for w in found] == pytest.approx([0.4, 0.3])
    assert [w.share_of_time for w in found] == pytest.approx([0.2, 0.2])
    more = _top("v", "segment", index, list("abcde"), np.repeat([1.0, 6.0, 5.0, 8.0, 7.0], 2), known)
    assert [w.regime for w in more] == ["d", "e", "b"]


def test_rows_outside_all_groups_and_rows_that_are_not_known_count_as_such() -> None:
    index = np.array([0.0, 0.0, 1.0, -1.0])
    known = np.array([True, False, True, True])
    (only,) = _top("v", "place", index, ["a", "b"], np.array([4.0, 0.0, 1.0, 3.0]), known)
    assert (only.regime, only.share_of_error, only.share_of_time) == ("a", 0.5, pytest.approx(1.0 / 3.0))


def test_a_group_with_as_much_error_as_time_is_not_named() -> None:
    index = np.repeat([0.0, 1.0], 2)
    assert _top("v", "place", index, ["a", "b"], np.ones(4), np.ones(4, dtype=bool)) == []


def found(rest: dict[str, FloatArray], chi2: dict[str, float], n: int = 10) -> tuple[Where, ...]:
    late = np.arange(n) >= n // 2
    nowhere = np.full(n, np.nan), np.full(n, np.nan)
    return locate(rest, chi2, {"late": late}, 0.1 * np.arange(n), np.full(n, 3.0), nowhere, pieces(0, n=n))


def test_what_holds_most_error_for_its_time_comes_first_and_channels_far_off_before_near_ones() -> None:
    """The excess is weighed by the root of the channel's chi^2/N over the greatest: a quarter of that halves it."""
    late = np.where(np.arange(10) < 5, 0.0, 2.0)
    mixed = np.where(np.arange(10) < 5, 1.0, 2.0)  # 20 of 25 late: an excess of 0.3
    order = [(w.channel, w.regime) for w in found({"v": late, "ax": mixed}, {"v": 1.0, "ax": 4.0})]
    assert order[0] == ("ax", "late")  # 0.3 before 0.5 / 2
    order = [(w.channel, w.regime) for w in found({"v": late, "ax": mixed}, {"v": 1.69, "ax": 4.0})]
    assert order[0] == ("v", "late")  # 0.5 * 0.65 = 0.325 before 0.3
    (entry,) = [w for w in found({"v": late}, {"v": 2.0}) if w.regime == "late"]
    assert (entry.kind, entry.share_of_error, entry.share_of_time, entry.excess) == ("regime", 1.0, 0.5, 0.5)
    assert entry.as_dict() == {"channel": "v", "regime": "late", "share_of_error": 1.0, "share_of_time": 0.5}


def test_equal_ones_come_by_name_and_a_channel_without_error_or_samples_has_no_entry() -> None:
    late = np.where(np.arange(10) < 5, 0.0, 2.0)
    nothing = {"r": np.zeros(10), "ay": np.full(10, np.nan)}
    order = [w.channel for w in found({"v": late, "ax": late, **nothing}, {"v": 2.0, "ax": 2.0}) if w.regime == "late"]
    assert order == ["ax", "v"]
    assert {w.channel for w in found({"v": late, **nothing}, {"v": 2.0, "r": 0.0})} == {"v"}


def test_only_rows_that_are_compared_count_in_a_share() -> None:
    rest = np.where(np.arange(10) < 5, 1.0, 2.0)
    rest[:3] = np.nan  # two rows of 1 and five of 2 are left
    (entry,) = [w for w in found({"v": rest}, {"v": 2.0}) if w.regime == "late"]
    assert entry.share_of_error == pytest.approx(20.0 / 22.0)
    assert entry.share_of_time == pytest.approx(5.0 / 7.0)


def test_entries_by_kind() -> None:
    late = np.where(np.arange(12) < 9, 1.0, 3.0)
    x = np.where(np.arange(12) < 9, 0.0, 8.0)
    where = locate({"v": late}, {"v": 2.0}, {}, 0.1 * np.arange(12), np.full(12, 3.0), (x, 0.0 * x), pieces(0, 9, n=12))
    kinds = {w.kind: w.regime for w in where if w.excess > 0.0}
    assert kinds["segment"] == "segment 0.9-1.1 s"
    assert kinds["place"] == "place x 8..9, y 0..1 m"
    assert {w.kind for w in where} >= {"speed", "segment", "place"}
