"""A model that is driven by other commands than the car of a run obeyed is told of, not fitted in silence."""

from __future__ import annotations

import numpy as np
import pytest

import scenarios
from pytest_dvp.cli.shared.command_columns import check_command_columns
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.obeyed_commands import obeyed_columns
from vehicle.model.model_file import model_text, read_model

ACCELERATION, PEDALS = ("accel_cmd",), ("throttle_cmd", "brake_cmd")
DATA_SHEET = scenarios.path("models/surrogate.toml")  # longitudinal = "accel_cmd"
ON_CAN = scenarios.path("models/surrogate_can.toml")  # longitudinal = "throttle_cmd + brake_cmd"


def log(**meta: object) -> Log:
    names = ("v", "steer_cmd", "accel_cmd", "throttle_cmd", "brake_cmd")
    return Log({"t": np.arange(20) * 0.02, **{name: np.zeros(20) for name in names}}, meta=meta)


@pytest.mark.parametrize(
    ("meta", "told"),
    [
        ({"vehicle": {"name": "surrogate"}}, ACCELERATION),
        ({"vehicle": {"name": "surrogate", "wire": "ros1"}}, ACCELERATION),
        ({"vehicle": {"name": "ros2_car:7"}}, ACCELERATION),
        ({"vehicle": {"name": "surrogate", "wire": "can", "dbc_sha256": ""}}, PEDALS),
        ({"vehicle": {"name": "surrogate", "wire": "can", "dbc_sha256": "ab"}}, ()),  # the DBC decides
        ({"vehicle": {"name": "tabby"}}, ()),  # a car of somebody's own
        ({"model": {"toml": model_text(read_model(DATA_SHEET))}}, ACCELERATION),
        ({"model": {"toml": model_text(read_model(ON_CAN))}}, PEDALS),
        ({}, ()),  # a measured log
    ],
)
def test_a_run_tells_what_its_car_obeyed(meta: dict[str, object], told: tuple[str, ...]) -> None:
    assert obeyed_columns(log(**meta)) == told


def test_a_twin_by_pedals_against_a_car_by_accelerations_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    run = log(vehicle={"name": "surrogate"})
    check_command_columns("dvp extend", read_model(ON_CAN), str(ON_CAN), {"0002-s-rw-surrogate": run})
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("dvp extend: warning: 0002-s-rw-surrogate: its car obeyed accel_cmd, surrogate_can.toml is")
    check_command_columns("dvp extend", read_model(DATA_SHEET), str(DATA_SHEET), {"0002-s-rw-surrogate": run})
    assert capsys.readouterr().err == ""
