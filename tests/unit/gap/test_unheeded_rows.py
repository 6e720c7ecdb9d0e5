"""Rows in which somebody else drove do not count, however the model's input is called."""

from __future__ import annotations

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.doctor import comparable
from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.diagnose.experiment import Experiment
from pytest_dvp.logs.log import Log
from vehicle.model.model_file import model_text, parse_model

NAMES = ("steer_cmd", "steer_cmd_norm", "wanted_angle")


def by_hand(name: str) -> Log:
    """From 20 to 30 s somebody steers otherwise than the stack, whose command goes on; it comes in a column `name`."""
    log = drive(60.0)
    hands = (log.t >= 20.0) & (log.t < 30.0)
    columns = {key: values for key, values in log.columns.items() if key != "steer_cmd"}
    return Log({**columns, name: np.where(hands, 0.4, log["steer_cmd"]), "engaged": np.where(hands, 0.0, 1.0)})


@pytest.mark.parametrize("name", NAMES)
def test_what_the_car_did_not_obey_is_no_error_of_a_model(name: str) -> None:
    log = comparable(by_hand(name))
    text = model_text(baseline()).replace('"steer_cmd"', f'"{name}"\nsteer_scale = 1.0').replace('"accel_cmd"', '"v"')
    found = compare(log, parse_model(text))
    assert np.isnan(found.residuals["yaw_rate"][(log.t >= 20.0) & (log.t < 30.0)]).all()
    assert found.signals["yaw_rate"].chi2_per_n == pytest.approx(1.0, abs=0.2)
    assert found.alignment.coverage == pytest.approx(5.0 / 6.0, abs=0.01)


def test_the_first_row_of_a_driver_counts_neither_in_a_diagnosis() -> None:
    log = comparable(by_hand("steer_cmd"))
    segments = Experiment("log", log, baseline()).segments
    assert not segments.counted[log["engaged"] == 0.0].any()
    assert segments.counted[np.flatnonzero(log["engaged"] == 0.0)[0] - 1]


def test_a_model_that_is_driven_by_what_was_measured_is_compared_with_all() -> None:
    log = comparable(by_hand("steer_cmd"))
    log = Log({**log.columns, "steer": log["yaw_rate"] * 0.0})
    model = model_text(baseline()).replace('"steer_cmd"', '"steer"').replace('"accel_cmd"', '"v"')
    assert compare(log, parse_model(model)).alignment.coverage == pytest.approx(1.0, abs=0.01)
