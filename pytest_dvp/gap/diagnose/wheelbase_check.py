"""Whether steering, yaw rate and speed of a log belong to a car of the model's size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.compare.smoothed_motion import Motion, motion
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

_FACTOR = 2.0  # beyond any steering ratio error or understeer that an effect explains
_GENTLE = 3.0  # m/s^2, below which a car turns about as its geometry tells
_FEWEST = 100  # rows in a turn
_DELAYS = np.arange(0.0, 1.01, 0.05)  # s by which a car may answer its steering late


def wrong_wheelbase(logs: Mapping[str, Log], model: VehicleModel) -> str:
    """A line if the wheelbase that v tan(steer) / yaw_rate implies in gentle turns is more than twice the model's or
    less than half of it; else "". The car may answer late: the delay at which the two are most alike is taken out, for
    with it the turns of a slalom seem too small. Raises CompareError if a command that drives the model is not there.
    """
    motions = [one for log in logs.values() if (one := motion(log, model)).steer is not None]
    best = max((_implied(motions, delay) for delay in _DELAYS), key=lambda found: found[0], default=(0.0, 0.0))
    implied = best[1]
    if implied <= 0.0 or 1.0 / _FACTOR < implied / model.car.wheelbase < _FACTOR:
        return ""
    return (
        f"steering, yaw rate and speed imply a wheelbase of {implied:.2g} m, the model has {model.car.wheelbase:g} m: "
        "another car's model, or the steering ratio or a unit is wrong"
    )


def _implied(motions: Sequence[Motion], delay: float) -> tuple[float, float]:
    """How alike steering and curvature are (-1 to 1) if the car answers `delay` [s] late, and the wheelbase [m] that
    they imply; 0, 0 where the turns are too few."""
    tans, curvatures = [np.zeros(0)], [np.zeros(0)]
    for m in motions:
        assert m.steer is not None
        v, rate = (np.interp(m.t + delay, m.t, values) for values in (m.v, m.yaw_rate))
        turns = m.moving & (np.abs(v) > 1.0) & (np.abs(v * rate) < _GENTLE) & (np.abs(m.steer) > 0.01)
        tans.append(np.tan(m.steer[turns]))
        curvatures.append(rate[turns] / v[turns])
    tan, curvature = np.concatenate(tans), np.concatenate(curvatures)
    product = float(tan @ curvature)
    if len(tan) < _FEWEST or not product > 0.0:
        return 0.0, 0.0
    size = float(tan @ tan)
    return product / (size * float(curvature @ curvature)) ** 0.5, size / product  # curvature = tan / wheelbase
