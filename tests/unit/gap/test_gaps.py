"""A gap in a log is no error of the model, and no time that was compared."""

from __future__ import annotations

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.compare.segments import cut, measured_array
from pytest_dvp.gap.words.comparison import covered
from pytest_dvp.logs.log import Log
from vehicle.model.vehicle_model import VehicleModel

COMMANDS = ("accel_cmd", "steer_cmd")


def without(log: Log, begin: float, end: float) -> Log:
    """The log without the rows of begin..end [s]."""
    keep = (log.t < begin) | (log.t >= end)
    return Log({name: column[keep] for name, column in log.columns.items()})


def blank(log: Log, begin: float, end: float, names: tuple[str, ...]) -> Log:
    """The log with nothing in these columns from begin to end [s]."""
    gone = (log.t >= begin) & (log.t < end)
    return Log({name: np.where(gone, np.nan, c) if name in names else c for name, c in log.columns.items()})


def late() -> VehicleModel:
    """The car with a dead time, which still does in a gap what was before it."""
    return baseline().with_effect("steer_delay", {"T": 0.2})


@pytest.mark.parametrize(("begin", "end"), [(7.3, 7.6), (7.1, 7.55), (13.0, 14.0), (7.0, 9.0), (3.0, 15.0)])
@pytest.mark.parametrize("delay", [0.0, 0.2])
def test_gap_is_not_charged_to_the_model(begin: float, end: float, delay: float) -> None:
    found = compare(without(drive(steer_delay=delay), begin, end), late() if delay else baseline())
    for name, score in found.signals.items():
        assert score.chi2_per_n < 1.2, name


@pytest.mark.parametrize("names", [("accel_cmd",), ("steer_cmd",), COMMANDS])
def test_lost_command_is_not_charged_to_the_model(names: tuple[str, ...]) -> None:
    found = compare(blank(drive(), 7.0, 14.0, names), baseline())
    for name, score in found.signals.items():
        assert score.chi2_per_n < 1.2, name
    # 7 s without a command, and up to half a second until the actuators are awake, of 59.98 s
    assert 1.0 - 7.5 / 59.98 <= found.alignment.coverage <= 1.0 - 6.98 / 59.98


def test_coverage_counts_missing_time() -> None:
    found = compare(without(drive(), 20.0, 35.0), baseline())
    assert 1.0 - 15.5 / 59.98 <= found.alignment.coverage <= 1.0 - 14.98 / 59.98


def test_time_in_which_nothing_was_measured_is_not_covered() -> None:
    measured = tuple(name for name in drive(1.0).columns if name not in ("t", *COMMANDS))
    found = compare(blank(drive(), 20.0, 35.0, measured), baseline())
    assert found.alignment.coverage == pytest.approx(1.0 - 15.0 / 59.98, abs=0.001)


def test_segment_after_a_gap_starts_anew() -> None:
    log = without(drive(), 7.3, 7.6)
    segments = cut(log.t, measured_array(log.columns))
    assert 7.6 in np.round(log.t[segments.starts], 6)


def test_command_logged_seldom_but_evenly_has_no_gap() -> None:
    log = drive()
    seldom = np.where(np.arange(len(log.t)) % 25 == 0, log["accel_cmd"], np.nan)
    found = compare(Log({**log.columns, "accel_cmd": seldom}), baseline())
    assert found.alignment.coverage == 1.0


def test_log_of_two_rows_a_second_has_no_gap() -> None:
    log = drive(120.0, rate=2.0)
    assert compare(log, baseline()).alignment.coverage == 1.0
    assert len(cut(log.t, measured_array(log.columns)).starts) == pytest.approx(24, abs=1)


def test_gaps_are_told_beside_the_coverage() -> None:
    twice = without(without(drive(), 20.0, 25.0), 40.0, 43.0)
    assert covered(compare(twice, baseline())).endswith(" %, 2 gaps of 8.0 s together")
    assert covered(compare(drive(), baseline())) == "coverage 100 %"
    # A log that is not whole never reads 100 %
    assert covered(compare(without(drive(600.0), 20.0, 20.14), baseline())).startswith(
        "coverage 99.9 %, 1 gap of 0.2 s"
    )
