"""assert_matches: passes within its bounds, and its failure says how far apart and where."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp import assert_matches
from pytest_dvp.gap.compare.match_bounds import BoundCheck
from pytest_dvp.gap.diagnosis_switch import diagnosis
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.signals import SIGNALS
from vehicle.model.errors import ModelError
from vehicle.model.model_file import model_text


def csv_of(log: Log, names: Mapping[str, str] | None = None) -> str:
    """The log as a CSV whose columns say their unit, but for those with another name."""
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*log.columns.values(), strict=True)]
    head = [(names or {}).get(name, f"{name} [{SIGNALS[name].unit}]") for name in log.columns]
    return "\n".join([",".join(head), *rows]) + "\n"


def test_right_model_matches() -> None:
    found = assert_matches(drive(), baseline(), rmse={"v": 0.04}, mncc={"v": 0.99}, lag=0.02, gain=0.05)
    assert found.signals["v"].rmse < 0.04


def test_failure_names_bound_value_and_place() -> None:
    with diagnosis(False), pytest.raises(AssertionError) as caught:
        assert_matches(drive(brake_gain=0.8), baseline(), rmse={"v": 0.05, "yaw_rate": 0.1})
    first, second = str(caught.value).splitlines()[:2]
    assert first == "car does not match the log: 1 of 2 bounds is broken"
    assert second.startswith("  rmse of v 0.")
    assert "> 0.05 m/s" in second
    assert "of it in braking" in second


@pytest.mark.nightly
def test_lag_is_bounded_for_every_signal_that_tells_it() -> None:
    with pytest.raises(AssertionError, match=r"lag of yaw_rate 0\.(19|2)\d* s > 0\.05 s"):
        assert_matches(drive(steer_delay=0.2), baseline(), lag=0.05)


def test_mncc_is_bounded_from_below() -> None:
    with diagnosis(False), pytest.raises(AssertionError, match=r"mncc of yaw_rate 0\.\d+ < 0\.9999"):
        assert_matches(drive(), baseline(), mncc={"yaw_rate": 0.9999})


def test_gain_of_one_signal() -> None:
    with diagnosis(False), pytest.raises(AssertionError, match="gain of ax"):
        assert_matches(drive(drive_gain=0.8, brake_gain=0.8), baseline(), gain={"ax": 0.1})


def test_signal_that_was_not_measured_does_not_pass() -> None:
    with pytest.raises(AssertionError, match=r"rmse of steer: not compared \(not measured\)"):
        assert_matches(drive(), baseline(), rmse={"steer": 1.0})


def test_value_that_breaks_its_bound_by_little_does_not_read_like_it() -> None:
    assert str(BoundCheck("rmse", "v", 0.0500001, 0.05, "m/s", False)) == "rmse of v 0.0500001 m/s > 0.05 m/s"
    assert str(BoundCheck("rmse", "v", 0.12345678, 0.05, "m/s", False)) == "rmse of v 0.1235 m/s > 0.05 m/s"


MINE = """
from vehicle.model.effect import Key, effect

@effect(
    name="weak_brakes", slot="command", physics="brakes that fade", equation="a = g a_c", source="none",
    parameters=(Key("g", "-", 0.5, 1.0, neutral=1.0, least=0.01, meaning="share"),), reveals="braking",
)
def weak_brakes(x, p, m):
    if x.accel < 0.0:
        x.accel *= p.g
"""


def test_model_with_an_effect_of_the_users_own(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MINE)
    added = model_text(baseline()) + '[[effect]]\nname = "weak_brakes"\nparameters = { g = 0.8 }\n'
    (tmp_path / "car.toml").write_text(added)
    log = drive(brake_gain=0.8)
    assert_matches(log, tmp_path / "car.toml", rmse={"v": 0.04}, effects=[tmp_path / "mine.py"])
    with pytest.raises(ModelError, match="weak_brakes"):
        assert_matches(log, tmp_path / "car.toml", rmse={"v": 0.04})


def test_log_with_a_mapping(tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text(csv_of(drive(), {"v": "geschwindigkeit"}))
    (tmp_path / "map.toml").write_text('[[signal]]\nname = "v"\nfield = "geschwindigkeit"\nunit = "m/s"\n')
    assert_matches(tmp_path / "drive.csv", baseline(), rmse={"v": 0.04}, map=tmp_path / "map.toml", channels=["v"])


def test_table_in_memory_is_taken_in_si() -> None:
    assert_matches(drive().to_frame(), baseline(), rmse={"v": 0.04}, lag=0.02)


def test_table_in_memory_may_name_other_units() -> None:
    frame = drive().to_frame()
    frame["v"] *= 3.6
    assert_matches(frame.rename(columns={"v": "v [km/h]"}), baseline(), rmse={"v": 0.04})
    with pytest.raises(LogError, match="km/h"):
        assert_matches(frame, baseline(), rmse={"v": 100.0})


def test_table_in_memory_may_be_the_model() -> None:
    assert_matches(drive().to_frame(), drive(noise=0.0).to_frame(), rmse={"v": 0.04})


def test_frame_of_a_model_is_examined_like_its_file() -> None:
    frame = drive(noise=0.0).to_frame()[["t", "x", "y", "yaw", "v", "yaw_rate"]]
    frame["v"] *= 3.6
    with pytest.raises(LogError, match=r"DataFrame of the model: error log\.unit_suspect column v"):
        assert_matches(drive(), frame, rmse={"v": 100.0})


def test_mapping_that_no_file_is_read_with_is_refused() -> None:
    with pytest.raises(ValueError, match=r"no file that the mapping wheel\.toml could read"):
        assert_matches(drive(20.0).to_frame(), baseline(), rmse={"v": 1.0}, map="wheel.toml")


def test_log_in_memory_is_compared_as_its_file_is() -> None:
    """The stack stands by for 10 s, and one value of v stands alone."""
    log = drive()
    hands = (log.t >= 20.0) & (log.t < 30.0)
    log = Log({**log.columns, "engaged": np.where(hands, 0.0, 1.0)})
    log.columns["steer_cmd"][hands] = 0.3
    log.columns["v"][500] += 20.0
    found = assert_matches(log, baseline(), rmse={"v": 0.04, "yaw_rate": 0.02})
    assert found.alignment.coverage < 0.9
    assert np.isnan(found.measured["v"][500])


def test_table_without_times_is_refused_in_one_line() -> None:
    with pytest.raises(LogError, match="no time column") as caught:
        assert_matches(drive(20.0).to_frame().drop(columns="t"), baseline(), rmse={"v": 1.0})
    assert "\n" not in str(caught.value)


def test_table_whose_signal_holds_words_is_refused_in_one_line() -> None:
    frame = drive(20.0).to_frame().astype({"v": str})
    with pytest.raises(LogError, match=r"column v holds no numbers .*allowed: numbers \[m/s\]"):
        assert_matches(frame, baseline(), rmse={"v": 1.0})


def test_what_is_no_log_and_no_model_is_refused_in_one_line() -> None:
    with pytest.raises(TypeError, match="log is a dict; allowed"):
        assert_matches({"t": [0.0]}, baseline(), rmse={"v": 1.0})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="model is a dict; allowed"):
        assert_matches(drive(20.0), {}, rmse={"v": 1.0})  # type: ignore[arg-type]


def test_without_a_bound_nothing_is_asserted_and_that_is_an_error() -> None:
    with pytest.raises(ValueError, match="no bound"):
        assert_matches(drive(), baseline())


@pytest.mark.parametrize(
    ("bounds", "told"),
    [
        ({"lag": -0.1}, r"^lag must be a finite number >= 0; found -0\.1$"),
        ({"gain": {"v": float("nan")}}, r"^gain of v must be a finite number >= 0; found nan$"),
        ({"gain": True}, r"^gain must be a finite number >= 0; found True$"),
        ({"rmse": {"v": "wide"}}, r"^rmse of v must be a finite number >= 0; found 'wide'$"),
        ({"mncc": {"v": 1.5}}, r"^mncc of v must be a number from 0 to 1; found 1\.5$"),
    ],
)
def test_bound_that_nothing_could_keep_is_refused(bounds: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        assert_matches(drive(), baseline(), **bounds)


def test_file_in_kilometres_an_hour_is_refused(tmp_path: Path) -> None:
    log = drive()
    (tmp_path / "kmh.csv").write_text(csv_of(Log({**log.columns, "v": 3.6 * log["v"]})))
    with pytest.raises(LogError, match="km/h"):
        assert_matches(tmp_path / "kmh.csv", baseline(), rmse={"v": 100.0})
