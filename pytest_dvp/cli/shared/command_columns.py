"""Which log columns drive a model: said where its file leaves it open, looked for in every log before any physics."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from vehicle.model.vehicle_model import VehicleModel


def check_command_columns(command: str, model: VehicleModel, file: str, *groups: Mapping[str, Log]) -> None:
    """Tell on stderr which columns are assumed to drive the model of `file`, and of runs whose car obeyed others.

    groups: logs by name.

    Raises CompareError if a log lacks one that drives it.
    """
    from pytest_dvp.gap.compare.compared_model import CompareError, command_at_stamps
    from pytest_dvp.logs.obeyed_commands import command_mismatch_warning

    said = assumed(model, Path(file).name)
    for name, log in (pair for logs in groups for pair in logs.items()):
        for column in model.inputs.columns:
            try:
                command_at_stamps(log, column, Path(file).name, name)
            except CompareError as error:
                raise CompareError(f"{error} ({said})" if said else str(error)) from None
    if said:
        print(f"{command}: {said}", file=sys.stderr)
    for name, log in (pair for logs in groups for pair in logs.items()):
        other = command_mismatch_warning(log, name, model, Path(file).name)
        if other:
            print(f"{command}: warning: {other}", file=sys.stderr)


def missing(model: VehicleModel, log: Log) -> list[str]:
    """Columns that drive the model and that the log does not have, or has no value of."""
    from pytest_dvp.gap.compare.compared_model import CompareError, command_at_stamps

    found = []
    for column in model.inputs.columns:
        try:
            command_at_stamps(log, column, "")
        except CompareError:
            found.append(column)
    return found


def assumed(model: VehicleModel, file: str) -> str:
    """What the file leaves open of its inputs and what is taken instead; "" if it states them."""
    given = model.given if model.given is not None else {"steer", "longitudinal"}
    taken = {"steer": model.inputs.steer, "longitudinal": " + ".join(model.inputs.longitudinal)}
    left = [key for key in taken if key not in given]
    if not left:
        return ""
    words = ", ".join(f'{key} = "{taken[key]}"' for key in left)
    return f"{file} does not say which columns drive it; [inputs] {words} is assumed"
