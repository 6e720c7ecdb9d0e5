"""Jerk and yaw rate."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric

CUTOFF = 1.0  # Hz; averages over about the 0.5 s over which UN R79 takes the mean of jerk (-3 dB at 0.89 Hz)
OTHER_CUTOFFS = (0.5, 2.0, 5.0)  # Hz
_FILTER = "zero-phase Butterworth low pass of order 2"


@metric(name="max_jerk", unit="m/s^3", bigger_is_worse=True, note=f"speed through a {_FILTER}, cut-off {{cutoff}} Hz")
def max_jerk(log: Log, *, cutoff: float = CUTOFF) -> Measured:
    """Greatest magnitude of the longitudinal jerk: second time derivative of the filtered speed `v`.

    Filter: zero-phase Butterworth of order 2 with -3 dB at `cutoff` [Hz] a pass, two passes. From the speed and not
    from `ax`, which also feels slopes. The value depends on the filter, so `extra` gives it at other cut-offs too.
    Source: Arango et al., Sensors 2026, 26, 1338 (who do not state their filter).
    """
    t, v = uniform(log, "v")
    step = float(t[1] - t[0])
    jerk = _jerk(v, step, cutoff)
    worst = int(np.argmax(np.abs(jerk)))
    others = {
        f"at {other:g} Hz": float(np.abs(_jerk(v, step, other)).max())
        for other in OTHER_CUTOFFS
        if other != cutoff and other < 0.5 / step
    }
    return Measured(float(abs(jerk[worst])), float(t[worst]), "", Series(t, jerk), others)


def _jerk(v: FloatArray, step: float, cutoff: float) -> FloatArray:
    from pytest_dvp.metrics._low_pass import low_pass

    try:
        smooth = low_pass(v, step, cutoff)
    except ValueError as error:
        raise Undefined(str(error)) from error
    return np.asarray(np.gradient(np.gradient(smooth, step), step))


@metric(name="max_yaw_rate", unit="rad/s", bigger_is_worse=True, note="not filtered")
def max_yaw_rate(log: Log) -> Measured:
    """Greatest magnitude of the yaw rate, as measured: spikes of a sensor show. Source: Arango et al. 2026.

    Raises Undefined if it was not measured.
    """
    rate = log["yaw_rate"]
    measured = np.isfinite(rate)
    if not measured.any():
        raise Undefined("yaw_rate was not measured")
    worst = int(np.argmax(np.where(measured, np.abs(rate), -1.0)))
    return Measured(float(abs(rate[worst])), float(log.t[worst]), "", Series(log.t, rate))


def uniform(log: Log, name: str) -> tuple[FloatArray, FloatArray]:
    """Times and values of a column on an even time base; resampled linearly if that of the log is uneven.

    Raises Undefined if it was not measured throughout, or the time does not increase.

    Both (n,); times in [s], values in the unit of the column.
    """
    t, values = log.t, log[name]
    if not np.isfinite(values).all() or not np.isfinite(t).all():
        raise Undefined(f"{name} was not measured throughout")
    steps = np.diff(t)
    if len(t) < 4 or steps.min() <= 0.0:
        raise Undefined("too few samples" if len(t) < 4 else "the time of the log does not increase")
    step = float(t[-1] - t[0]) / (len(t) - 1)
    if np.abs(steps - step).max() <= 1e-3 * step:
        return t, values
    even = np.linspace(t[0], t[-1], max(4, round(float(t[-1] - t[0]) / float(np.median(steps))) + 1))
    return even, np.interp(even, t, values)
