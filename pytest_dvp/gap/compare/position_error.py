"""How far a model is from the car some seconds after a start from the measured motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.compare.segments import posed
from pytest_dvp.gap.diagnose.experiment import Values, experiment_set
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

AHEAD = 2.0  # s


def position_error(logs: Mapping[str, Log], model: VehicleModel, values: Values, ahead: float = AHEAD) -> float:
    """RMS distance [m] between the measured and the modelled position `ahead` [s] after a start from the measured
    motion, over starts about 5 s apart; starts at a standstill and across gaps do not count. NaN without any start."""
    errors: list[float] = []
    for e in experiment_set(logs, model).experiments:
        moved = posed(e.motion(values), e.segments)  # a sensor's bias is none of the car's course
        for first, end in zip(e.segments.starts, e.segments.ends, strict=True):
            row = int(np.searchsorted(e.log.t, e.log.t[first] + ahead))
            if row < end and e.segments.counted[first : row + 1].all():
                errors.append(float(np.hypot(*(e.measured[row, :2] - moved[row, :2]))))
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else float("nan")
