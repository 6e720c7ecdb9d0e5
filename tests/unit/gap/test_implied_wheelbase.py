"""A model of another car is told before anything is diagnosed."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from gap_logs import WHEELBASE, drive

from pytest_dvp.gap.diagnose.equation_error import votes
from pytest_dvp.gap.diagnose.wheelbase_check import wrong_wheelbase
from pytest_dvp.logs.log import Log
from vehicle.model.model_file import parse_model


@pytest.mark.parametrize(("share", "told"), [(1.0, False), (0.7, False), (1.5, False), (0.1, True), (3.0, True)])
def test_a_wheelbase_more_than_twice_off_is_told(share: float, told: bool) -> None:
    model = parse_model(f"[parameters]\nwheelbase = {share * WHEELBASE}\n")
    line = wrong_wheelbase({"a": drive(40.0)}, model)
    assert (f"imply a wheelbase of {WHEELBASE:g} m" in line) is told
    assert bool(line) is told


def test_a_late_answer_is_no_other_wheelbase() -> None:
    t = np.arange(0.0, 40.0, 0.02)
    steer = 0.1 * np.sin(2.0 * np.pi * t / 4.0)  # a slalom, answered a sixth of its period late
    late = 0.1 * np.sin(2.0 * np.pi * (t - 0.7) / 4.0)
    v = np.full(len(t), 3.0)
    log = Log({"t": t, "steer_cmd": steer, "accel_cmd": 0.0 * t, "v": v, "yaw_rate": v * np.tan(late) / 0.33})
    assert wrong_wheelbase({"a": log}, parse_model("[parameters]\nwheelbase = 0.33\n")) == ""
    assert "imply a wheelbase of 0.33 m" in wrong_wheelbase({"a": log}, parse_model("[parameters]\nwheelbase = 1.2\n"))


def test_a_model_of_another_car_gives_no_warning_of_numpy() -> None:
    log = drive(40.0)
    log.columns["v"][:] *= 1e160  # its square is beyond any float
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert votes({"a": log}, parse_model("[parameters]\nwheelbase = 0.26\n"))["first"] is None
