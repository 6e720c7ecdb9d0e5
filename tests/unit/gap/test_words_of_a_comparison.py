"""A comparison in words: shares in per cent, the worst place of an error, and what is not worth a word."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.words.comparison import (
    WORTH_SAYING,
    columns,
    covered,
    headline,
    late,
    not_judged,
    offset,
    places,
    sentence,
    slid,
    table,
    worst_place,
)
from pytest_dvp.gap.words.comparison_page import _error


def a_place(kind: str = "regime", excess: float = 0.5, channel: str = "v", **more: Any) -> Any:
    given = {"regime": f"{kind}_x", "share_of_error": 0.73, "share_of_time": 0.58} | more
    return SimpleNamespace(kind=kind, excess=excess, channel=channel, **given)


@pytest.mark.parametrize(("first", "end", "told"), [(0, 91, "91 % of the time (50.0-141.0 s)"),
                                                    (10, 101, "90 % of the time (60.0-150.0 s)"),
                                                    (0, 101, "100 % of the time (50.0-150.0 s)"),
                                                    (50, 51, "1 % of the time (100.0-101.0 s)")])  # fmt: skip
def test_how_long_a_drive_was_not_judged(first: int, end: int, told: str) -> None:
    """A stretch ends at the first row that is judged again, or with the log."""
    rows = np.zeros(101, dtype=bool)
    rows[first:end] = True
    comparison: Any = SimpleNamespace(t=50.0 + np.arange(101.0), slid=rows)
    assert not_judged(comparison).startswith(f"not judged: {told}: the car slides")
    comparison.slid = np.zeros(101, dtype=bool)
    assert (not_judged(comparison), slid(comparison)) == ("", [])


def test_the_worst_place_is_a_regime_before_a_speed_before_a_segment_and_holds_much_for_its_time() -> None:
    where = [a_place("segment"), a_place("speed"), a_place("regime", channel="x"), a_place("regime"), a_place("place")]
    assert worst_place(where, "v") is where[3]
    assert worst_place(where[:3], "v") is where[1]
    assert worst_place(where[:1], "v") is where[0]
    assert worst_place(where[4:], "v") is None
    assert worst_place(where, "yaw") is None
    just, less = a_place(excess=WORTH_SAYING), a_place(excess=WORTH_SAYING - 1e-9)
    assert worst_place([less, just], "v") is just
    assert worst_place([less], "v") is None


@pytest.mark.parametrize(
    ("kind", "regime", "told"),
    [
        ("regime", "turn_in", "73 % of it in turn-in, 58 % of the time"),
        ("segment", "12.0_s", "73 % of it in 12.0 s, 58 % of the time"),
        ("speed", "speed 5-10 m/s", "73 % of it at speed 5-10 m/s, 58 % of the time"),
        ("place", "x 0..50", "73 % of it at x 0..50, 58 % of the time"),
    ],
)
def test_a_place_in_a_sentence(kind: str, regime: str, told: str) -> None:
    assert sentence(a_place(kind, regime=regime)) == told


def test_places_are_told_from_a_twentieth_beyond_their_time_on_two_of_each_kind() -> None:
    regimes = [a_place("regime", regime=f"r{k}") for k in range(9)]
    others = [a_place(kind, regime=f"{kind}{k}") for kind in ("place", "segment", "speed") for k in range(3)]
    lines = places([*others, *regimes])
    assert [line.split()[1] for line in lines[1:]] == [
        *(f"r{k}" for k in range(8)), "speed0", "speed1", "segment0", "segment1", "place0", "place1",
    ]  # fmt: skip
    assert lines[1].split() == ["v", "r0", "73", "%", "58", "%"]
    assert len(places(regimes, limit=3)) == 4
    for kind in ("regime", "speed"):
        assert len(places([a_place(kind, 0.05), a_place(kind, 0.0499)])) == 2
        assert places([a_place(kind, 0.0499)]) == ["the error is spread evenly"]


def test_columns_are_as_wide_as_their_longest_word_and_numbers_stand_to_the_right() -> None:
    """Names and units to the left; of one row, too, and no line ends in blanks."""
    rows = [("a", "b", "c", "d"), ("long", "2.25", "m/s", "1"), ("x", "10", "m", "")]
    assert columns(rows) == ["a        b  c    d", "long  2.25  m/s  1", "x       10  m"]
    assert columns(rows[:1]) == ["a  b  c  d"]


def test_signals_in_a_table() -> None:
    """What was not rated is a dash, and a delay of less than half a millisecond is no negative one."""
    rated = SimpleNamespace(rmse=0.12345, unit="m/s", chi2_per_n=1.234, nrmse=0.0734, mncc=0.98765, lag=-0.0004,
                            gain=1.0456, iso18571=0.8765)  # fmt: skip
    plain = SimpleNamespace(rmse=2.0, unit="m", chi2_per_n=9.0, nrmse=None, mncc=None, lag=None, gain=None,
                            iso18571=None)  # fmt: skip
    comparison: Any = SimpleNamespace(signals={"v": rated, "x": plain}, noise={"v": 0.0512, "x": 0.01})
    head, first, second = (line.split() for line in table(comparison))
    assert head[:4] == ["signal", "rmse", "unit", "noise"]
    assert first == ["v", "0.1235", "m/s", "0.051", "1.23", "7.34", "%", "0.9877", "+0.000", "1.046", "0.876"]
    assert second == ["x", "2", "m", "0.01", "9.00", *5 * ["-"]]


@pytest.mark.parametrize(
    ("lag", "mncc", "told"),
    [
        (0.02, 0.9, ["it comes 0.02 s later than in the model"]),
        (-0.02, 0.5, ["it comes 0.02 s earlier than in the model"]),
        (0.0199, 0.9, []),
        (0.3, 0.4999, []),
        (0.3, None, []),
        (None, 0.9, []),
    ],
)
def test_a_lag_is_told_from_two_hundredths_of_a_second_of_signals_that_are_alike_by_half(
    lag: float | None, mncc: float | None, told: list[str]
) -> None:
    t = np.arange(0.0, 8.0, 0.01)
    modelled, measured = (np.exp(-(((t - 4.0 - late) / 0.5) ** 2)) for late in (0.0, lag or 0.0))
    one: Any = SimpleNamespace(
        signals={"v": SimpleNamespace(lag=lag, mncc=mncc)}, t=t, residuals={"v": 0.0 * t}, modelled={"v": modelled},
        measured={"v": measured},
    )  # fmt: skip
    assert late(one, "v") == told


def compared(left: Any, **more: Any) -> Any:
    score = SimpleNamespace(rmse=0.5, unit="m/s", chi2_per_n=9.0, lag=None, mncc=None)
    given = {"model": "car.toml", "signals": {"v": score}, "residuals": {"v": np.array(left)},
             "where": [a_place(regime="braking")]}  # fmt: skip
    return SimpleNamespace(**given | more)


@pytest.mark.parametrize(
    ("left", "told"),
    [
        ([2.0, 0.0, 2.0, 0.0], ["50 % of it is one offset: measured minus modelled is +1 m/s"]),
        ([-3.0, -1.0, np.nan], ["80 % of it is one offset: measured minus modelled is -2 m/s"]),
        ([3.0, -1.0], []),  # 1 of 5
        ([1.0, -1.0], []),
        ([np.nan], []),
    ],
)
def test_an_offset_is_told_if_half_of_the_squared_error_is_its_square(left: list[float], told: list[str]) -> None:
    assert offset(compared(left), "v") == told


def test_an_offset_is_everywhere_so_no_place_is_told_with_it() -> None:
    misses = "car.toml misses v by 0.5 m/s, 3.0 times its noise"
    assert headline(compared([3.0, -1.0])) == f"{misses}; 73 % of it in braking, 58 % of the time"
    assert headline(compared([1.0, 1.0])) == (f"{misses}; 100 % of it is one offset: measured minus modelled is "
                                              "+1 m/s")  # fmt: skip


@pytest.mark.parametrize(
    ("share", "gap", "told"),
    [
        (1.0, 0.0, "coverage 100 %"),
        (0.99999, 0.0, "coverage 99.9 %"),
        (0.925, 0.0, "coverage 92.5 %"),
        (0.0, 0.0, "coverage 0 %"),
        (0.5, 20.0, "coverage 50.0 %, 1 gap of 20.0 s"),
    ],
)
def test_a_log_that_is_not_whole_never_reads_100_percent(share: float, gap: float, told: str) -> None:
    t = 0.02 * np.arange(100)
    t[50:] += max(gap - 0.02, 0.0)
    comparison: Any = SimpleNamespace(t=t, alignment=SimpleNamespace(coverage=share))
    assert covered(comparison) == told
    if gap:
        comparison.t = np.concatenate([t, t[-1] + 5.0 + 0.02 * np.arange(50)])
        assert covered(comparison) == told.replace("1 gap of 20.0 s", "2 gaps of 25.0 s together")


def test_the_error_over_time_is_the_root_of_the_mean_square_over_half_a_second_and_all_signals() -> None:
    """3 and 4 times the noise are 5 / sqrt(2) together; a signal that is not known does not count."""
    t = 0.05 * np.arange(60)
    late = np.where(t < 1.5 - 1e-9, 0.0, 8.0)
    late[45:] = np.nan
    residuals = {"v": np.full(60, 0.3), "x": late}
    comparison: Any = SimpleNamespace(t=t, residuals=residuals, noise={"v": 0.1, "x": 2.0}, signals={"v": 0, "x": 0})
    found = _error(comparison)
    assert found[:25] == pytest.approx(3.0 / math.sqrt(2.0))
    assert found[36] == pytest.approx(5.0 / math.sqrt(2.0))
    assert found[50:] == pytest.approx(3.0)
    assert found[30] == pytest.approx(math.sqrt((11 * 9.0 + 6 * 16.0) / 22.0))  # five rows on either side
    comparison.residuals = {"v": np.full(60, np.nan), "x": np.full(60, np.nan)}
    assert np.isnan(_error(comparison)).all()
