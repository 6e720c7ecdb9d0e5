"""By what a stretch of a long log is chosen: sums of squares about the mean of each stretch of 5 s, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.part_selection import LONGEST, Part, _Book, _energies, exciting_parts
from pytest_dvp.logs.log import Log

COMMANDS = ("steer_cmd",)


def test_ten_minutes_at_50_hz_are_looked_at_whole() -> None:
    t = 0.02 * np.arange(10 * 60 * 50 + 1)
    assert LONGEST == 10 * 60 * 50
    (whole,) = exciting_parts({"a": Log({"t": t[:-1], "v": t[:-1]})}, ())
    assert whole.whole
    assert not any(part.whole for part in exciting_parts({"a": Log({"t": t, "v": t})}, ()))


def test_a_change_is_that_over_a_fifth_of_a_second_and_over_a_row_where_rows_are_rarer() -> None:
    """A wheel that goes to and fro each second changes by 1 each time; one that turns by 3 rad/s by 0.6."""
    t = np.arange(10.0)
    rare = _energies(Log({"t": t, "steer_cmd": t % 2.0}), COMMANDS, np.array([0, 5, 10]))
    assert rare[:, 1].tolist() == [4.0, 5.0]  # nothing is known before the first row
    often = 0.02 * np.arange(100)
    found = _energies(Log({"t": often, "steer_cmd": 3.0 * often}), COMMANDS, np.array([0, 50, 100]))
    assert found[:, 1] == pytest.approx([40 * 0.36, 50 * 0.36])


def test_an_energy_is_the_sum_of_squares_about_the_mean_and_of_the_speed_itself() -> None:
    """Of 1, 2, 3, 4 that are 5 about 2.5; of 0, 6, 0, 6 they are 36 about 3, and 72 in all."""
    t = np.arange(8.0)
    steer = np.array([1.0, 2.0, 3.0, 4.0, 7.0, 7.0, 7.0, 7.0])
    v = np.array([5.0, 5.0, 5.0, 5.0, 0.0, 6.0, 0.0, 6.0])
    log = Log({"t": t, "steer_cmd": steer, "v": v, "yaw_rate": 0.1 * steer})
    found = _energies(log, COMMANDS, np.array([0, 4, 8]))
    assert found[:, [0, 2, 3, 4]] == pytest.approx(np.array([[5.0, 0.0, 100.0, 0.05], [0.0, 36.0, 72.0, 0.0]]))
    bare = _energies(Log({"t": t, "v": np.where(v == 0.0, np.nan, 5.0)}), COMMANDS, np.array([0, 4, 8]))
    assert bare == pytest.approx(np.array([[0.0, 0.0, 0.0, 100.0, 0.0]] * 2))  # gaps are bridged, what lacks is 0


def book(rows: int, begin: float = 12.0, seconds: float = 30.0) -> _Book:
    t = begin + 0.1 * np.arange(round(10.0 * seconds))
    return _Book(Log({"t": t, "v": t - begin}), (), rows)


def test_stretches_begin_at_multiples_of_five_seconds_and_have_a_third_of_the_rows() -> None:
    """From 12 s to 42 s there are cells from 10 s to 45 s, of which the first and the last are not full."""
    found = book(120)
    assert found.edges.tolist() == [10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0]
    assert found.rows.tolist() == [30, 50, 50, 50, 50, 50, 20]
    assert found.cells == 2  # 120 rows hold two cells of 50
    assert book(49).cells == book(0).cells == 1
    assert book(10_000).cells == 7
    assert [k for _, k, _ in found.options("a", 100)] == [0, 1, 2, 3, 4, 5]
    assert [k for _, k, _ in found.options("a", 99)] == [0, 5]
    assert [k for _, k, _ in found.options("a", 80)] == [0, 5]
    assert [k for _, k, _ in found.options("a", 79)] == [5]


def test_what_is_taken_is_not_offered_again_and_a_whole_log_is_not_cut() -> None:
    found = book(120)
    part = found.take("a", 2)
    assert (part.start, part.stop, part.called("a.mcap")) == (20.0, 30.0, "a.mcap@20:30")
    assert part.log.t[0] == pytest.approx(20.0)
    assert part.log.t[-1] == pytest.approx(29.9)
    assert [k for _, k, _ in found.options("a", 100)] == [0, 4, 5]
    whole = book(10_000)
    all_of_it = whole.take("a", 0)
    assert (all_of_it.whole, all_of_it.called("a.mcap")) == (True, "a.mcap")
    assert not Part("a", 0.0, np.inf, whole.log).whole


@pytest.mark.parametrize(("rows", "offered"), [(2, False), (3, True)])
def test_a_stretch_of_two_rows_tells_nothing(rows: int, offered: bool) -> None:
    t = np.array([10.0, 10.1, 10.2][:rows])
    assert bool(_Book(Log({"t": t, "v": t}), (), 100).options("a", 100)) is offered
