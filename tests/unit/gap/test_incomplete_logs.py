"""Logs that lack a channel, for a while or altogether: what is left is compared, and the model is not charged."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from gap_logs import WHEELBASE, baseline, drive

from pytest_dvp.gap.assert_matches import assert_matches
from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.compare.compared_model import CompareError, LogSubject
from pytest_dvp.gap.compare.python_model import StepSubject
from pytest_dvp.gap.words.comparison import covered
from pytest_dvp.logs.log import Log

COMMANDS = ("accel_cmd", "steer_cmd")


def lacking(log: Log, *names: str) -> Log:
    return Log({name: column for name, column in log.columns.items() if name not in names})


def blank(log: Log, begin: float, end: float, name: str) -> Log:
    """The log with nothing in this column from begin to end [s]."""
    gone = (log.t >= begin) & (log.t < end)
    return Log({**log.columns, name: np.where(gone, np.nan, log[name])})


def between(log: Log, begin: float, end: float, shift: float = 0.0) -> Log:
    """Rows of begin..end [s], stamped `shift` [s] later."""
    kept = (log.t >= begin - 1e-9) & (log.t <= end + 1e-9)
    columns = {name: column[kept] for name, column in log.columns.items()}
    return Log({**columns, "t": columns["t"] + shift})


def test_log_without_speed_is_compared_by_the_rest() -> None:
    found = compare(lacking(drive(), "v"), baseline())
    assert found.not_compared["v"] == "not measured"
    assert {"x", "y", "yaw", "yaw_rate"} <= set(found.signals)
    for name in ("x", "y", "yaw", "yaw_rate"):
        assert found.signals[name].chi2_per_n < 1.3, name
    true = np.abs(drive(noise=0.0)["v"] - found.speed)
    assert np.quantile(true, 0.95) < 0.5  # the path's: 2 cm of noise at either end of 0.4 s are 0.07 m/s


def test_log_without_speed_passes_bounds() -> None:
    assert_matches(lacking(drive(), "v"), baseline(), rmse={"yaw_rate": 0.01})


def test_log_without_speed_and_path_says_so() -> None:
    with pytest.raises(CompareError, match="no speed for a model to start with: neither v nor x and y are measured"):
        compare(lacking(drive(), "v", "x", "y"), baseline())


@pytest.mark.parametrize("name", ["v", "yaw", "yaw_rate"])
@pytest.mark.parametrize("begin", [0.0, 21.0, 33.3])
def test_hole_in_what_a_start_needs_is_not_charged_to_the_model(name: str, begin: float) -> None:
    found = compare(blank(drive(), begin, begin + 8.0, name), baseline())
    for channel, score in found.signals.items():
        assert score.chi2_per_n < 1.2, channel
    assert found.alignment.coverage == pytest.approx(1.0 - 8.0 / 59.98, abs=0.002)
    assert "86.7 %" in covered(found) or "86.6 %" in covered(found)
    assert not np.isfinite(found.residuals["ax"][(found.t > begin + 0.1) & (found.t < begin + 7.9)]).any()
    if begin:
        assert begin + 8.0 in np.round(found.t[found.segments.starts], 6)


@pytest.mark.parametrize("name", ["x", "y"])
def test_lost_position_costs_nothing_but_the_position(name: str) -> None:
    found = compare(blank(drive(), 21.0, 29.0, name), baseline())
    for channel, score in found.signals.items():
        assert score.chi2_per_n < 1.2, channel
    assert found.alignment.coverage == 1.0


def test_slower_channel_has_no_hole() -> None:
    log = drive()
    slow = np.where(np.arange(len(log.t)) % 5 == 0, log["v"], np.nan)
    found = compare(Log({**log.columns, "v": slow}), baseline())
    assert found.alignment.coverage == 1.0
    assert found.signals["v"].chi2_per_n < 1.3


@pytest.mark.parametrize("names", [("yaw_rate",), ("yaw_rate", "ax", "ay"), ("v",), ("v", "yaw_rate")])
def test_second_log_need_not_have_every_channel(names: tuple[str, ...]) -> None:
    other = lacking(drive(noise=0.0), *names, *COMMANDS)
    found = compare(drive(), LogSubject(other))
    for name in names:
        assert found.not_compared[name] == "the model does not give it"
    for name, score in found.signals.items():
        assert score.chi2_per_n < 1.3, name


@pytest.mark.parametrize("late", [0.013, 10.0])
def test_second_log_may_start_later(late: float) -> None:
    drive_of_model = drive(noise=0.0, rate=1000.0)
    found = compare(drive(), LogSubject(between(drive_of_model, late, 60.0)))
    # By 0.1 s or less nothing is missing, but the row in which the model is not there yet
    assert found.alignment.coverage == pytest.approx(1.0 - late / 59.98, abs=0.001)
    for name in ("v", "yaw_rate"):
        assert found.signals[name].chi2_per_n < 1.5, name


def test_hole_in_a_second_log_is_not_bridged() -> None:
    model = drive(noise=0.0)
    gone = (model.t > 22.0) & (model.t < 30.0)
    found = compare(drive(), LogSubject(Log({name: column[~gone] for name, column in model.columns.items()})))
    assert found.alignment.coverage == pytest.approx(1.0 - 8.0 / 59.98, abs=0.002)
    for name, score in found.signals.items():
        assert score.chi2_per_n < 1.2, name


def test_second_log_of_a_standstill_alone_is_refused(tmp_path: Path) -> None:
    still = Log({**drive(10.0).columns, **{name: np.zeros(500) for name in ("x", "y", "yaw", "v", "yaw_rate")}})
    with pytest.raises(CompareError, match="the car stands or slides"):
        compare(between(still, 3.0, 7.0), LogSubject(between(still, 4.5, 5.5)))


def test_python_step_that_returns_no_speed_is_not_judged_by_the_measured_one() -> None:
    def step(state: Mapping[str, float], inputs: Mapping[str, float], dt: float) -> dict[str, float]:
        v = max(state.get("own", state["v"]) + inputs["accel_cmd"] * dt, 0.0)
        bend = np.tan(inputs["steer_cmd"]) / WHEELBASE
        turned = state["yaw"] + v * dt * bend
        return {"x": state["x"] + v * dt * np.cos(turned), "y": state["y"] + v * dt * np.sin(turned), "yaw": turned,
                "own": v}  # fmt: skip

    found = compare(drive(20.0), StepSubject(step))
    assert found.not_compared["v"] == "the model does not give it"
    assert found.not_compared["yaw_rate"] == "the model does not give it"
