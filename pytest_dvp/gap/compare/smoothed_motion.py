"""What a car did and was asked to do in a log, smoothed: the quantities that regressions of an error are built from."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.compare.compared_model import command_at_stamps
from pytest_dvp.gap.compare.segments import measured_array, still_speed
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

_SMOOTH = 0.1  # s on either side


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """Arrays (n,) at the stamps t [s] of a log, without gaps.

    v [m/s], yaw [rad], yaw_rate [rad/s], x, y [m] measured; accel [m/s^2] and steer [rad at the road wheel] as
    commanded, None if the model is not driven that way; moving: rows that are no standstill; way [m] driven so far;
    braked, driven [m^2/s^2] energy per mass taken out by the brakes and put in by the drive so far.
    """

    t: FloatArray
    step: float
    x: FloatArray
    y: FloatArray
    yaw: FloatArray
    v: FloatArray
    yaw_rate: FloatArray
    accel: FloatArray | None
    steer: FloatArray | None
    moving: BoolArray
    way: FloatArray
    braked: FloatArray
    driven: FloatArray
    wheelbase: float


def motion(log: Log, model: VehicleModel) -> Motion:
    """Motion and commands of a log. Raises CompareError if a command that drives the model is not there."""
    t = log.t
    step = float(np.median(np.diff(t)))
    measured = measured_array(log.columns)
    x, y, yaw = (bridged(t, measured[:, k]) for k in range(3))
    v, rate = bridged(t, measured[:, 3]), bridged(t, measured[:, 4])
    if not np.isfinite(measured[:, 3]).any() and len(t) > 2:
        v = np.hypot(np.gradient(x, t), np.gradient(y, t))
    if not np.isfinite(measured[:, 4]).any() and len(t) > 2:
        rate = np.gradient(yaw, t)
    window = max(1, round(_SMOOTH / step))
    v, rate = mean_around(v, window), mean_around(rate, window)
    accel, steer = _demand(log, model, v), None
    if model.inputs.steer != "steer" or "steer" in log.columns:
        steer = model.inputs.steer_zero + model.inputs.steer_scale * command_at_stamps(log, model.inputs.steer, "model")
    dt = np.append(np.diff(t), 0.0)
    way = np.cumsum(np.abs(v) * dt)
    moving = np.abs(v) > max(still_speed(v), 0.1)
    power = (accel if accel is not None else np.gradient(v, t)) * v * dt * moving
    return Motion(t, step, x, y, yaw, v, rate, accel, steer, moving, way, np.cumsum(np.maximum(-power, 0.0)),
                  np.cumsum(np.maximum(power, 0.0)), model.car.wheelbase)  # fmt: skip


def _demand(log: Log, model: VehicleModel, v: FloatArray) -> FloatArray | None:
    """The acceleration that is asked for [m/s^2], whatever the input; None if the speed is imposed."""
    inputs, names = model.inputs, model.inputs.longitudinal
    if names == ("v",):
        return None
    first = command_at_stamps(log, names[0], "model")
    if names == ("accel_cmd",):
        return first
    if names == ("speed_cmd",):
        return first - v
    if names == ("motor_current",):
        share = first / inputs.full_current
        return np.where(share > 0.0, share * inputs.full_throttle, share * inputs.full_brake)
    wanted = first * inputs.full_throttle
    if len(names) == 2:
        full = inputs.full_pressure if names[1] == "brake_pressure" else 1.0
        wanted = wanted - command_at_stamps(log, names[1], "model") * inputs.full_brake / full
    return wanted


def bridged(t: FloatArray, values: FloatArray) -> FloatArray:
    """values (n,) of any unit at t (n,) [s], with gaps filled by straight lines; zeros if no value is known."""
    known = np.isfinite(values)
    return np.asarray(np.interp(t, t[known], values[known])) if known.any() else np.zeros(len(t))


def mean_around(y: FloatArray, window: int) -> FloatArray:
    """Mean (n,) of y (n,) over 2 window + 1 samples, fewer at the ends, in the unit of y."""
    total = np.concatenate([[0.0], np.cumsum(y)])
    i = np.arange(len(y))
    low, high = np.maximum(i - window, 0), np.minimum(i + window + 1, len(y))
    return np.asarray((total[high] - total[low]) / (high - low))
