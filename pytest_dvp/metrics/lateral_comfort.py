"""Lateral acceleration and lateral jerk."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._even_time import CUTOFF, Cutoff, uniform
from pytest_dvp.metrics.metric import Measured, Series, metric

_FILTER = "zero-phase Butterworth low pass of order 2, cut-off {cutoff} Hz"


@metric(name="max_lateral_acceleration", unit="m/s^2", bigger_is_worse=True, note=_FILTER)
def max_lateral_acceleration(log: Log, *, cutoff: Cutoff = CUTOFF) -> Measured:
    """Greatest magnitude of the lateral acceleration of the reference point: v * yaw_rate + d(vy)/dt, filtered.

    From the motion and not from `ay`, which also feels banked roads; without `vy` the second term is 0. Filter as in
    `max_jerk`. Source: lateral acceleration of ISO 8855:2011, in the body's axes. Undefined if `v` or
    `yaw_rate` was not measured throughout.
    """
    t, acceleration = _lateral(log, cutoff)
    worst = int(np.argmax(np.abs(acceleration)))
    return Measured(float(abs(acceleration[worst])), float(t[worst]), "", Series(t, acceleration))


@metric(name="max_lateral_jerk", unit="m/s^3", bigger_is_worse=True, note=_FILTER)
def max_lateral_jerk(log: Log, *, cutoff: Cutoff = CUTOFF) -> Measured:
    """Greatest magnitude of the time derivative of the lateral acceleration of `max_lateral_acceleration`.

    Source: UN Regulation No. 79, 5.6.2.1.3, which bounds its mean over 0.5 s by 5 m/s^3. Undefined as that one.
    """
    t, acceleration = _lateral(log, cutoff)
    jerk = np.gradient(acceleration, float(t[1] - t[0]))
    worst = int(np.argmax(np.abs(jerk)))
    return Measured(float(abs(jerk[worst])), float(t[worst]), "", Series(t, jerk))


def _lateral(log: Log, cutoff: float) -> tuple[FloatArray, FloatArray]:
    from pytest_dvp.metrics._low_pass import low_pass

    t, v = uniform(log, "v")
    _, rate = uniform(log, "yaw_rate")
    step = float(t[1] - t[0])
    total = v * rate
    if "vy" in log.columns and np.isfinite(log["vy"]).all():
        total = total + np.gradient(uniform(log, "vy")[1], step)
    try:
        return t, low_pass(total, step, cutoff)
    except ValueError as error:
        raise Undefined(str(error)) from error
