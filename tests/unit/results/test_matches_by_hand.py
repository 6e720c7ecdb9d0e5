"""Which detection is whom, pair by pair, and how a car answers its commands: on rows that are written down here."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics import _track_matches as module
from pytest_dvp.metrics._track_matches import Matches, _assigned, _Pairs, _side_by_side, offset_of, seen_of, worst_of
from pytest_dvp.metrics.command_response import response_gain, response_lag
from tests.unit.results.results_logs import log_of

# --- who is whom


def track(t: Any, x: Any = 0.0) -> Any:
    """A road user that stands at x; y, yaw, vx and vy tell the column and the row."""
    t = np.asarray(t, dtype=float)
    rows = np.arange(len(t))
    return SimpleNamespace(t=t, x=np.zeros(len(t)) + x, y=10.0 + rows, yaw=20.0 + rows, vx=30.0 + rows, vy=40.0 + rows)


def a_log(objects: dict[str, Any], t: Any = (), x: Any = 0.0, y: Any = 0.0) -> Any:
    t = np.asarray(t, dtype=float)
    return SimpleNamespace(objects=objects, detections=SimpleNamespace(t=t, x=np.zeros(len(t)) + x,
                                                                       y=np.zeros(len(t)) + y))  # fmt: skip


def test_instants_come_in_the_order_of_time_and_at_one_instant_in_that_of_the_road_users() -> None:
    there, pairs = _side_by_side(a_log({"b": track([0.1, 0.3], 1.0), "a": track([0.1, 0.2], 2.0)}))
    assert there.t == pytest.approx([0.1, 0.1, 0.2, 0.3])
    assert there.who.tolist() == [0, 1, 1, 0]
    assert there.k.tolist() == [0, 0, 1, 1]
    assert there.state.tolist() == [
        [1.0, 10.0, 20.0, 30.0, 40.0], [2.0, 10.0, 20.0, 30.0, 40.0], [2.0, 11.0, 21.0, 31.0, 41.0],
        [1.0, 11.0, 21.0, 31.0, 41.0],
    ]  # fmt: skip
    assert len(pairs.apart) == len(pairs.there) == 0


def test_of_two_rows_of_a_road_user_at_one_instant_the_later_one_counts() -> None:
    there, _ = _side_by_side(a_log({"a": track([0.1, 0.1 + 4e-7, 0.2])}))
    assert there.k.tolist() == [1, 2]
    there, _ = _side_by_side(a_log({"a": track([0.1, 0.1 + 1.4e-6, 0.2])}))  # more than a microsecond is another one
    assert there.k.tolist() == [0, 1, 2]


def test_each_detection_stands_beside_each_road_user_of_its_instant() -> None:
    """Detections at 0.1 s (two) and 0.3 s (one); at 0.2 s none."""
    log = a_log({"a": track([0.1, 0.2, 0.3], 0.0), "b": track([0.1], 3.0)}, [0.1, 0.1, 0.3], [0.0, 3.0, 4.0],
                [10.0, 14.0, 15.0])  # fmt: skip
    there, pairs = _side_by_side(log)
    assert there.who.tolist() == [0, 1, 0, 0]
    assert pairs.there.tolist() == [0, 0, 1, 1, 3]
    assert pairs.detection.tolist() == [0, 1, 0, 1, 2]
    assert pairs.instant.tolist() == [100_000, 100_000, 100_000, 100_000, 300_000]
    assert pairs.apart == pytest.approx([0.0, 5.0, 3.0, 4.0, 5.0])  # a is at y = 12 m then


def test_nobody_and_nothing_make_no_pairs() -> None:
    there, pairs = _side_by_side(a_log({}, [0.1]))
    assert len(there.t) == len(pairs.apart) == 0
    assert _assigned(pairs, pairs.apart <= 3.0, 0).tolist() == []
    there, pairs = _side_by_side(a_log({"a": track([0.1])}))
    assert _assigned(pairs, pairs.apart <= 3.0, 1).tolist() == [-1]


def pairs_of(*rows: tuple[int, int, int, float]) -> _Pairs:
    """instant, road user, detection, distance"""
    instant, there, detection, apart = np.array(rows, dtype=float).reshape(-1, 4).T
    return _Pairs(instant.astype(int), there.astype(int), detection.astype(int), apart)


@pytest.mark.parametrize(
    ("rows", "size", "found"),
    [
        ([(0, 0, 7, 1.0)], 1, [7]),
        ([(0, 0, 7, 3.0)], 1, [7]),  # as far as is allowed
        ([(0, 0, 7, 3.1)], 1, [-1]),
        ([(0, 1, 0, 1.0)], 3, [-1, 0, -1]),
        ([(0, 0, 0, 2.0), (0, 0, 1, 1.0)], 1, [1]),  # two boxes at one road user
        ([(0, 0, 0, 2.0), (0, 1, 0, 1.0)], 2, [-1, 0]),  # two road users at one box
        ([(0, 0, 0, 1.0), (0, 0, 1, 2.0), (0, 1, 0, 1.5), (0, 1, 1, 3.0)], 2, [1, 0]),  # 3.5 m in all, not 4
        ([(0, 0, 0, 0.1), (0, 0, 1, 2.9), (0, 1, 0, 0.2), (0, 1, 1, 9.0)], 2, [1, 0]),  # both rather than the nearest
        ([(0, 0, 0, 1.0), (0, 0, 1, 9.0), (0, 1, 0, 9.0), (0, 1, 1, 1.0)], 2, [0, 1]),
        # a choice at one instant says nothing of another one
        ([(0, 0, 0, 2.0), (0, 0, 1, 1.0), (5, 1, 2, 2.5), (5, 1, 3, 9.0)], 2, [1, 2]),
        ([(0, 0, 0, 9.0), (0, 0, 1, 9.0), (0, 1, 0, 9.0), (0, 1, 1, 9.0)], 2, [-1, -1]),
    ],
)  # fmt: skip
def test_most_are_matched_one_to_one_and_then_the_sum_of_distances_is_least(
    rows: list[tuple[int, int, int, float]], size: int, found: list[int]
) -> None:
    pairs = pairs_of(*rows)
    assert _assigned(pairs, pairs.apart <= 3.0, size).tolist() == found


def some_matches(*row: int) -> Matches:
    n = len(row)
    truth = np.zeros((n, 5))
    truth[:, 0], truth[:, 1] = 100.0 + np.arange(n), 200.0
    return Matches(0.5 * np.arange(float(n))[::-1], tuple("abcd"[:n]), np.array(row, dtype=int), truth,
                   np.zeros(0, dtype=int))  # fmt: skip


def test_who_was_ahead_and_who_of_them_was_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    log: Any = None
    for rows, says in (((), "no road user was ahead of the ego"), ((-1, -1), "no road user ahead of the ego was d")):
        monkeypatch.setattr(module, "matches", lambda *asked, rows=rows: some_matches(*rows))
        with pytest.raises(Undefined, match=says):
            seen_of(log, 20.0, 4.0, 3.0, 0.0)
    monkeypatch.setattr(module, "matches", lambda *asked: some_matches(-1, 0, -1, 5))
    found, seen = seen_of(log, 20.0, 4.0, 3.0, 0.0)
    assert seen.tolist() == [1, 3]
    detections = SimpleNamespace(x=np.array([102.0, 0.0, 0.0, 0.0, 0.0, 103.5]), y=np.full(6, 199.0))
    dx, dy = offset_of(SimpleNamespace(detections=detections), found, seen)  # type: ignore[arg-type]
    assert dx.tolist() == [1.0, 0.5]  # detected less true: 102 - 101 and 103.5 - 103
    assert dy.tolist() == [-1.0, -1.0]


def test_the_worst_error_is_the_largest_either_way_with_its_time_and_road_user() -> None:
    found = worst_of(some_matches(0, 1, 2, 3), np.array([0, 2, 3]), np.array([1.0, -2.0, 1.5]), 0.7, {"n": 3.0})
    assert (found.value, found.t, found.object, found.extra) == (0.7, 0.5, "c", {"n": 3.0})
    assert found.series is not None
    assert found.series.t.tolist() == [0.0, 0.5, 1.5]
    assert found.series.value.tolist() == [1.5, -2.0, 1.0]


# --- how a car answers


def answering(late: float, gain: float, *, hole: bool = False) -> Any:
    """A pulse of the command at 4 s, and the answer later and of another size; hole: each lacks a second."""
    log = log_of(10.0)
    t = log.t
    asked = np.exp(-(((t - 4.0) / 0.3) ** 2))
    got = gain * np.exp(-(((t - 4.0 - late) / 0.3) ** 2)) + 0.05
    if hole:
        asked[t < 1.0], got[t > 9.0] = np.nan, np.nan
    return log_of(10.0, columns={"steer_cmd": asked, "steer": got})


@pytest.mark.parametrize("hole", [False, True])
@pytest.mark.parametrize(("late", "gain"), [(0.2, 0.8), (0.0, 1.0), (-0.1, 1.5), (0.95, 0.5)])
def test_the_lag_and_the_gain_of_an_answer(late: float, gain: float, hole: bool) -> None:
    log = answering(late, gain, hole=hole)
    lag = response_lag(log)
    assert lag.value == pytest.approx(late, abs=2e-3)
    assert lag.extra["mncc"] == pytest.approx(1.0, abs=0.02)
    assert response_gain(log).value == pytest.approx(gain, rel=5e-3)
    assert lag.series is not None
    assert (lag.series.t[0], lag.series.t[-1]) == pytest.approx((-1.0, 1.0))
    assert len(lag.series.t) == 201


@pytest.mark.parametrize(("rows", "told"), [(2, False), (3, True)])
def test_three_samples_in_common_tell_an_answer(rows: int, told: bool) -> None:
    """Of three equal ones the lag is none, and the gain that of their sizes."""
    asked, got = np.full(101, np.nan), np.full(101, np.nan)
    asked[10 : 10 + rows], got[10 : 10 + rows] = np.array([0.0, 1.0, 0.0])[:rows], np.array([0.0, 2.0, 0.0])[:rows]
    asked[50], got[60] = 5.0, 5.0  # alone they are nothing in common
    log = log_of(1.0, columns={"steer_cmd": asked, "steer": got})
    if told:
        assert response_gain(log).value == pytest.approx(2.0)
        assert response_lag(log).value == pytest.approx(0.0, abs=1e-12)
    else:
        with pytest.raises(Undefined, match="steer_cmd and steer were not measured together"):
            response_gain(log)


def test_an_answer_is_compared_over_all_of_the_time_even_where_stamps_are_missing() -> None:
    """Every second stamp of a stretch is gone: the usual step stays, and the grid goes on to the last stamp."""
    asked, got = np.full(101, np.nan), np.full(101, np.nan)
    rows = np.array([0, 1, 2, 3, 4, 6, 8])
    asked[rows] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    got[rows] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0]
    log = log_of(1.0, columns={"steer_cmd": asked, "steer": got})
    assert response_gain(log).value == pytest.approx(3.0)
