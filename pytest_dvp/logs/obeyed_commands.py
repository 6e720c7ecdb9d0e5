"""Which commands the car of a run obeyed, and whether a model that is held against its log is driven by the same."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING

from pytest_dvp.logs.log import Log
from pytest_dvp.text.paths import shown
from scenarios import path

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.log_contents import FloatArray
import dataclasses
from typing import TYPE_CHECKING

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.signals import COMMAND_COLUMNS

ACCELERATION, PEDALS = ("accel_cmd",), ("throttle_cmd", "brake_cmd")
ON_TOPICS = ("surrogate", "ros1_car", "ros2_car")  # cars whose command is a message without pedals


def obeyed_columns(log: Log) -> tuple[str, ...]:
    """Columns of the longitudinal commands that the car of a run obeyed; () where the log does not tell.

    A stack commands an acceleration and two pedals in one; the log of a run has all three, and a car obeys one kind.
    """
    meta = log.meta
    text = meta.get("model", {}).get("toml")
    if text is not None:
        inputs = tomllib.loads(text).get("inputs", {}).get("longitudinal", "")
        return tuple(word.strip() for word in str(inputs).split("+") if word.strip())
    car = meta.get("vehicle", {})
    if str(car.get("name", "")).partition(":")[0] not in ON_TOPICS:
        return ()
    if car.get("wire") != "can":
        return ACCELERATION
    return () if car.get("dbc_sha256") else PEDALS  # of a DBC of the user's own the log does not tell


def twin_command_mismatch(twin: Log, measured: Log) -> str:
    """What a twin was asked by and what a car was, if those are not the same; "" else, or where a log does not tell."""
    one, other = obeyed_columns(twin), obeyed_columns(measured)
    if one not in (ACCELERATION, PEDALS) or other not in (ACCELERATION, PEDALS) or one == other:
        return ""
    file = twin.meta.get("model", {}).get("file", "the model")
    shipped = {ACCELERATION: "surrogate.toml", PEDALS: "surrogate_can.toml"}[other]
    ours = measured.meta.get("vehicle", {}).get("name") == "surrogate"
    cure = (
        f"--model {shown(path(f'models/{shipped}'))}" if ours else f'a model with longitudinal = "{" + ".join(other)}"'
    )
    return f"what asks the car: {file} is driven by {' + '.join(one)}, the car by {' + '.join(other)}; take {cure}"


def command_mismatch_warning(log: Log, name: str, model: VehicleModel, model_name: str) -> str:
    """A line if the model is driven by the pedals and the log's car was by an acceleration, or the other way round."""
    told, taken = obeyed_columns(log), model.inputs.longitudinal
    if told not in (ACCELERATION, PEDALS) or taken not in (ACCELERATION, PEDALS) or told == taken:
        return ""
    return (
        f"{name}: its car obeyed {' + '.join(told)}, {model_name} is driven by {' + '.join(taken)}, which that car was "
        f"not: gains and pedal scales found with it mean nothing; take a model with longitudinal = "
        f'"{" + ".join(told)}"'
    )


GATE = "gate."  # of its columns


ARRIVED = "arrived."  # of those of commands that reached the car late: `pytest_dvp.drive.compute_delay`


def obeyed_command(log: Log, name: str) -> FloatArray | None:
    """A command (n,) as the car got it: what the gate let out, where one stood before the car, or what arrived, where
    commands took their time, else what was asked. None if the log does not have it.

    The unit is that of the command's column.
    """
    asked = log.columns.get(name)
    passed = log.columns.get(GATE + name, log.columns.get(ARRIVED + name))
    if asked is None or passed is None:
        return asked
    return np.where(np.isfinite(passed), passed, asked)


REPLAY = "replay"


def divergence_time(log: Log) -> float | None:
    """When [s] the stack and the recording went apart; None if they did not, or nothing was replayed."""
    return min((event.t for event in log.events if event.kind == REPLAY), default=None)


def with_obeyed_commands(log: Log) -> Log:
    """A log with the commands that its car obeyed: of a replay those of the recording, not what this stack asked for,
    else those that a guard let out, where one stood before the car.

    Raises LogError if the recording that was played holds no commands.
    """
    if log.meta.get("vehicle", {}).get("name") != REPLAY:
        passed = {name: obeyed_command(log, name) for name in COMMAND_COLUMNS}
        return dataclasses.replace(log, columns={**log.columns, **{n: c for n, c in passed.items() if c is not None}})
    recorded = {name.removeprefix("replay."): values for name, values in log.columns.items() if "replay." in name}
    if not recorded:
        raise LogError("the recording that was played holds no commands")
    kept = {name: values for name, values in log.columns.items() if name not in COMMAND_COLUMNS}
    return dataclasses.replace(log, columns={**kept, **recorded})
