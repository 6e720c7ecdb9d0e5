"""Whether steering, yaw rate and speed of a log belong to a car of the model's size."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.compare.smoothed_motion import motion
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

_FACTOR = 2.0  # beyond any steering ratio error or understeer that an effect explains
_GENTLE = 3.0  # m/s^2, below which a car turns about as its geometry tells
_FEWEST = 100  # rows in a turn


def wrong_wheelbase(logs: Mapping[str, Log], model: VehicleModel) -> str:
    """A line if the wheelbase that v tan(steer) / yaw_rate implies in gentle turns is more than twice the model's or
    less than half of it; else "". Raises CompareError if a command that drives the model is not there."""
    tans, curvatures = [np.zeros(0)], [np.zeros(0)]
    for log in logs.values():
        m = motion(log, model)
        if m.steer is None:
            continue
        turns = m.moving & (np.abs(m.v) > 1.0) & (np.abs(m.v * m.yaw_rate) < _GENTLE) & (np.abs(m.steer) > 0.01)
        tans.append(np.tan(m.steer[turns]))
        curvatures.append(m.yaw_rate[turns] / m.v[turns])
    tan, curvature = np.concatenate(tans), np.concatenate(curvatures)
    product = float(tan @ curvature)
    if len(tan) < _FEWEST or product <= 0.0:
        return ""
    implied = float(tan @ tan) / product  # curvature = tan / wheelbase, least squares
    if 1.0 / _FACTOR < implied / model.car.wheelbase < _FACTOR:
        return ""
    return (
        f"steering, yaw rate and speed imply a wheelbase of {implied:.2g} m, the model has {model.car.wheelbase:g} m: "
        "another car's model, or the steering ratio or a unit is wrong"
    )
