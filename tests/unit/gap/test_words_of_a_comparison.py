"""A comparison in words: shares in per cent, the worst place of an error, and what is not worth a word."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.words.comparison import WORTH_SAYING, not_judged, places, sentence, slid, table, worst_place


def a_place(kind: str = "regime", excess: float = 0.5, channel: str = "v", **more: Any) -> Any:
    given = {"regime": f"{kind}_x", "share_of_error": 0.73, "share_of_time": 0.18} | more
    return SimpleNamespace(kind=kind, excess=excess, channel=channel, **given)


@pytest.mark.parametrize(("first", "end", "told"), [(0, 91, "91 % of the time (0.0-91.0 s)"),
                                                    (10, 101, "90 % of the time (10.0-100.0 s)"),
                                                    (0, 101, "100 % of the time (0.0-100.0 s)"),
                                                    (50, 51, "1 % of the time (50.0-51.0 s)")])  # fmt: skip
def test_how_long_a_drive_was_not_judged(first: int, end: int, told: str) -> None:
    """A stretch ends at the first row that is judged again, or with the log."""
    rows = np.zeros(101, dtype=bool)
    rows[first:end] = True
    comparison: Any = SimpleNamespace(t=np.arange(101.0), slid=rows)
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
        ("regime", "turn_in", "73 % of it in turn-in, 18 % of the time"),
        ("segment", "12.0_s", "73 % of it in 12.0 s, 18 % of the time"),
        ("speed", "speed 5-10 m/s", "73 % of it at speed 5-10 m/s, 18 % of the time"),
        ("place", "x 0..50", "73 % of it at x 0..50, 18 % of the time"),
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
    assert lines[1].split() == ["v", "r0", "73", "%", "18", "%"]
    assert len(places(regimes, limit=3)) == 4
    for kind in ("regime", "speed"):
        assert len(places([a_place(kind, 0.05), a_place(kind, 0.0499)])) == 2
        assert places([a_place(kind, 0.0499)]) == ["the error is spread evenly"]


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
