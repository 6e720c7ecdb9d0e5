"""Sentences and tables of comparisons, whole: what is said where, and the figures in it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.compare import SignalScore
from pytest_dvp.gap.compare.error_location import Where
from pytest_dvp.gap.compare.match_bounds import BoundCheck
from pytest_dvp.gap.words import comparison as words


def score(chi2: float, **more: Any) -> SignalScore:
    fields: dict[str, Any] = {"nrmse": 0.1, "mncc": 0.9, "lag": 0.0, "gain": 1.0, "iso18571": 0.5}
    return SignalScore(rmse=0.25, unit="m/s", chi2_per_n=chi2, **fields | more)


def compared(signals: dict[str, SignalScore], where: tuple[Where, ...] = (), **more: Any) -> Any:
    """A comparison of 8 s, or where a signal has a lag, of 8 s of a pulse at 100 Hz that comes as late as that."""
    wave = np.array([1.0, -1.0] * 4)
    if any(one.lag for one in signals.values()):
        t = np.arange(0.0, 8.0, 0.01)

        def pulse(late: float | None) -> Any:
            return np.exp(-(((t - 4.0 - (late or 0.0)) / 0.5) ** 2))

        measured = {name: pulse(one.lag) for name, one in signals.items()}
        more = {
            "t": t,
            "measured": measured,
            "modelled": {name: pulse(0.0) for name in signals},
            "residuals": {name: np.resize(wave, len(t)) for name in signals},
            "slid": np.zeros(len(t), bool),
        } | more
    base = {"model": "M", "signals": signals, "where": where, "residuals": dict.fromkeys(signals, wave),
            "noise": dict.fromkeys(signals, 0.05), "t": np.arange(8.0), "alignment": SimpleNamespace(coverage=1.0),
            "slid": np.zeros(8, bool)}  # fmt: skip
    return SimpleNamespace(**{**base, **more})


def test_of_a_log_that_is_judged_in_part_no_more_is_said() -> None:
    half = compared({"v": score(1.3)}, slid=np.arange(8) > 3)
    assert words.headline(half).endswith("nothing is left to find in the 57 % of this log that is judged")


@pytest.mark.parametrize(
    ("signals", "text"),
    [
        ({}, "M: no sample could be compared"),
        ({"v": score(float("nan"))}, "M: no sample could be compared"),
        ({"v": score(1.3), "x": score(1.2)},
         "M explains every signal to its noise (worst: v, chi²/N 1.30); nothing is left to find in this log"),
        ({"v": score(4.0)}, "M misses v by 0.25 m/s, 2.0 times its noise"),
        ({"v": score(4.0), "yaw_rate": score(9.0)}, "M misses yaw_rate by 0.25 m/s, 3.0 times its noise"),
        ({"v": score(4.0), "x": score(16.0)},
         "M misses v by 0.25 m/s, 2.0 times its noise (x misses by 4.0 times its noise, but follows from speed and "
         "turn rate)"),
        ({"v": score(1.3), "x": score(16.0)}, "M misses x by 0.25 m/s, 4.0 times its noise"),
        ({"v": score(4.0, lag=0.02)}, "M misses v by 0.25 m/s, 2.0 times its noise; it comes 0.02 s later than in the "
         "model"),
        ({"v": score(4.0, lag=-0.5)}, "M misses v by 0.25 m/s, 2.0 times its noise; it comes 0.50 s earlier than in "
         "the model"),
        ({"v": score(4.0, lag=0.019)}, "M misses v by 0.25 m/s, 2.0 times its noise"),
        ({"v": score(4.0, lag=0.5, mncc=0.49)}, "M misses v by 0.25 m/s, 2.0 times its noise"),
    ],
)  # fmt: skip
def test_a_comparison_in_one_sentence(signals: dict[str, SignalScore], text: str) -> None:
    assert words.headline(compared(signals)) == text


def test_a_signal_that_a_shift_does_not_mend_is_not_called_late() -> None:
    """What is too weak ends later, too: a best shift is there, and takes back next to nothing."""
    one = compared({"v": score(4.0, lag=0.05)})
    assert words.late(one, "v") == ["it comes 0.05 s later than in the model"]
    noise = np.random.default_rng(1).normal(0.0, 1.0, len(one.t))
    noisy = compared({"v": score(4.0, lag=0.05)}, measured={"v": one.measured["v"] + noise})
    assert words.late(noisy, "v") == []


@pytest.mark.parametrize(
    ("left", "text"),
    [
        ([2.0, 2.0, np.nan], ["100 % of it is one offset: measured minus modelled is +2 m/s"]),
        ([-1.0, -3.0], ["80 % of it is one offset: measured minus modelled is -2 m/s"]),  # 4 of 5
        ([0.0, 2.0], ["50 % of it is one offset: measured minus modelled is +1 m/s"]),
        ([-0.1, 2.0], []),
        ([1.0, -1.0], []),
        ([np.nan], []),
    ],
)
def test_most_of_an_error_may_be_one_offset(left: list[float], text: list[str]) -> None:
    assert words.offset(compared({"v": score(4.0)}, residuals={"v": np.array(left)}), "v") == text


@pytest.mark.parametrize(
    ("t", "share", "text"),
    [
        (np.arange(9.0) * 0.02, 1.0, "coverage 100 %"),
        (np.arange(9.0) * 0.02, 0.9999, "coverage 99.9 %"),
        (np.arange(9.0) * 0.02, 0.925, "coverage 92.5 %"),
        (np.arange(9.0) * 0.02, 0.0, "coverage 0 %"),
        (np.r_[0.0, 0.02, 0.04, 3.04, 3.06, 3.08], 0.5, "coverage 50.0 %, 1 gap of 3.0 s"),
        (np.r_[0.0, 0.02, 0.04, 3.04, 3.06, 5.06], 0.5, "coverage 50.0 %, 2 gaps of 5.0 s together"),
    ],
)
def test_how_much_was_compared(t: Any, share: float, text: str) -> None:
    assert words.covered(compared({}, t=t, alignment=SimpleNamespace(coverage=share))) == text


def test_what_is_not_judged_is_told_by_its_longest_stretches() -> None:
    t = np.arange(41.0)
    slid = np.zeros(41, bool)
    for first, long in ((1, 2), (5, 1), (10, 3), (15, 1), (20, 4), (30, 5)):
        slid[first : first + long] = True
    found = compared({}, t=t, slid=slid)
    assert words.slid(found)[:2] == [(1.0, 3.0), (5.0, 6.0)]
    assert words.not_judged(found).startswith(
        "not judged: 40 % of the time (1.0-3.0 s, 5.0-6.0 s, 10.0-13.0 s, 20.0-24.0 s, 30.0-35.0 s and 1 more): the car"
    )
    slid[:] = False
    slid[40] = True
    assert words.slid(found) == [(40.0, 40.0)]
    slid[40] = False
    assert words.not_judged(found) == ""


def place(regime: str, error: float, time: float, kind: str = "regime", channel: str = "v") -> Where:
    return Where(channel, regime, error, time, kind)


@pytest.mark.parametrize(
    ("where", "text"),
    [
        ((place("lift_off", 0.5, 0.39),), "50 % of it in lift off, 39 % of the time"),
        ((place("lift_off", 0.5, 0.41),), None),
        ((place("segment 3", 0.5, 0.1, "segment"), place("lift_off", 0.3, 0.1)),
         "30 % of it in lift off, 10 % of the time"),
        ((place("segment 3", 0.5, 0.1, "segment"), place("speed 0-5 m/s", 0.3, 0.1, "speed")),
         "30 % of it at speed 0-5 m/s, 10 % of the time"),
        ((place("braking", 0.9, 0.1, channel="ax"), place("segment 3", 0.5, 0.1, "segment")),
         "50 % of it in segment 3, 10 % of the time"),
    ],
)  # fmt: skip
def test_the_worst_place_of_a_signal(where: tuple[Where, ...], text: str | None) -> None:
    found = words.worst_place(where, "v")
    assert (words.sentence(found) if found else None) == text


def test_the_table_of_signals_and_places() -> None:
    bare = SignalScore(rmse=1.0, unit="m", chi2_per_n=2.0, nrmse=None, mncc=None, lag=None, gain=None, iso18571=None)
    found = compared({"v": score(4.0, lag=-0.0001), "x": bare})
    assert words.table(found) == [
        "signal  rmse  unit  noise  chi²/N    nrmse    mncc  lag [s]   gain  ISO 18571",
        "v       0.25  m/s    0.05    4.00  10.00 %  0.9000   +0.000  1.000      0.500",
        "x          1  m      0.05    2.00        -       -        -      -          -",
    ]
    where = [place("lift_off", 0.5, 0.44), place("cruise", 0.5, 0.46), *(
        place(f"segment {k}", 0.5, 0.1, "segment") for k in range(3))]  # fmt: skip
    rows = [line.split() for line in words.places(where)]
    assert rows[1:] == [["v", "lift_off", "50", "%", "44", "%"]] + [
        ["v", "segment", str(k), "50", "%", "10", "%"] for k in range(2)
    ]
    assert words.places([]) == ["the error is spread evenly"]
    assert words.skipped({"x": "none", "y": "none"}) == "x: none; y: none"


def test_a_failed_match_tells_its_broken_bounds() -> None:
    found = compared({"v": score(4.0)}, (place("braking", 0.5, 0.1),))
    checks = [BoundCheck("rmse", "v", 0.25, 0.1, "m/s", False), BoundCheck("mncc", "v", 0.5, 0.9, "-", False),
              BoundCheck("lag", "v", 0.0, 0.1, "s", True)]  # fmt: skip
    lines = words.failure(found, checks).splitlines()
    assert lines[0] == "M does not match the log: 2 of 3 bounds are broken"
    assert lines[1].endswith("; 50 % of it in braking, 10 % of the time")
    assert "of it in" not in lines[2]
    assert lines[3].startswith("M misses v by")
    assert words.failure(found, checks[1:]).splitlines()[0] == "M does not match the log: 1 of 2 bounds is broken"
