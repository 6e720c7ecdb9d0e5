"""assert_matches: passes within its bounds, and its failure says how far apart and where."""

from __future__ import annotations

from pathlib import Path

import pytest
from gap_logs import baseline, drive

from pytest_dvp import assert_matches
from pytest_dvp.log import LogError
from pytest_dvp.reality_gap.bounds import Judged
from pytest_dvp.signals import SIGNALS


def test_right_model_matches() -> None:
    found = assert_matches(drive(), baseline(), rmse={"v": 0.04}, mncc={"v": 0.99}, lag=0.02, gain=0.05)
    assert found.signals["v"].rmse < 0.04


def test_failure_names_bound_value_and_place() -> None:
    with pytest.raises(AssertionError) as caught:
        assert_matches(drive(brake_gain=0.8), baseline(), rmse={"v": 0.05, "yaw_rate": 0.1})
    first, second = str(caught.value).splitlines()[:2]
    assert first == "car does not match the log: 1 of 2 bounds is broken"
    assert second.startswith("  rmse of v 0.")
    assert "> 0.05 m/s" in second
    assert "of it in braking" in second


def test_lag_is_bounded_for_every_signal_that_tells_it() -> None:
    with pytest.raises(AssertionError, match=r"lag of yaw_rate 0\.(19|2)\d* s > 0\.05 s"):
        assert_matches(drive(steer_delay=0.2), baseline(), lag=0.05)


def test_mncc_is_bounded_from_below() -> None:
    with pytest.raises(AssertionError, match=r"mncc of yaw_rate 0\.\d+ < 0\.9999"):
        assert_matches(drive(), baseline(), mncc={"yaw_rate": 0.9999})


def test_gain_of_one_signal() -> None:
    with pytest.raises(AssertionError, match="gain of ax"):
        assert_matches(drive(drive_gain=0.8, brake_gain=0.8), baseline(), gain={"ax": 0.1})


def test_signal_that_was_not_measured_does_not_pass() -> None:
    with pytest.raises(AssertionError, match=r"rmse of steer: not compared \(not measured\)"):
        assert_matches(drive(), baseline(), rmse={"steer": 1.0})


def test_value_that_breaks_its_bound_by_little_does_not_read_like_it() -> None:
    assert str(Judged("rmse", "v", 0.0500001, 0.05, "m/s", False)) == "rmse of v 0.0500001 m/s > 0.05 m/s"
    assert str(Judged("rmse", "v", 0.12345678, 0.05, "m/s", False)) == "rmse of v 0.1235 m/s > 0.05 m/s"


def test_without_a_bound_nothing_is_asserted_and_that_is_an_error() -> None:
    with pytest.raises(ValueError, match="no bound"):
        assert_matches(drive(), baseline())


def test_file_in_kilometres_an_hour_is_refused(tmp_path: Path) -> None:
    log = drive()
    columns = {**log.columns, "v": 3.6 * log["v"]}
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns.values(), strict=True)]
    head = ",".join(f"{name} [{SIGNALS[name].unit}]" for name in columns)
    (tmp_path / "kmh.csv").write_text("\n".join([head, *rows]) + "\n")
    with pytest.raises(LogError, match="km/h"):
        assert_matches(tmp_path / "kmh.csv", baseline(), rmse={"v": 100.0})
