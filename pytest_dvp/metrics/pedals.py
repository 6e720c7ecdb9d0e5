"""How hard and how restlessly the ego is driven and braked."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._even_time import CUTOFF, Cutoff, uniform
from pytest_dvp.metrics.metric import Measured, Series, metric

_FILTER = "zero-phase Butterworth low pass of order 2, cut-off {cutoff} Hz"


@metric(name="max_deceleration", unit="m/s^2", bigger_is_worse=True, note=f"speed through a {_FILTER}")
def max_deceleration(log: Log, *, cutoff: Cutoff = CUTOFF) -> Measured:
    """Greatest deceleration: of the derivative of the speed `v`, filtered as in `max_jerk`, with the other sign.

    From the speed and not from `ax`, which also feels slopes. Source: longitudinal acceleration of ISO 8855:2011; ISO
    15622:2018 bounds what a comfort system does to 3.5 m/s^2. Undefined if `v` was not measured throughout.
    """
    t, a = _acceleration(log, cutoff)
    worst = int(np.argmin(a))
    return Measured(float(-a[worst]), float(t[worst]), "", Series(t, -a))


@metric(name="max_acceleration", unit="m/s^2", bigger_is_worse=True, note=f"speed through a {_FILTER}")
def max_acceleration(log: Log, *, cutoff: Cutoff = CUTOFF) -> Measured:
    """Greatest acceleration: of the derivative of the speed `v`, filtered as in `max_jerk`.

    Source: as `max_deceleration`; ISO 15622:2018 bounds what a comfort system does to 2.0 m/s^2. Undefined if `v` was
    not measured throughout.
    """
    t, a = _acceleration(log, cutoff)
    worst = int(np.argmax(a))
    return Measured(float(a[worst]), float(t[worst]), "", Series(t, a))


@metric(name="accel_roughness", unit="m/s^3", bigger_is_worse=True, note=f"rate of `{{signal}}` without a {_FILTER}")
def accel_roughness(log: Log, *, signal: str = "accel_cmd", cutoff: Cutoff = CUTOFF) -> Measured:
    """Root mean square of the rate of the commanded acceleration above `cutoff` [Hz]: chatter, steps and noise.

    As `steer_roughness`, of `signal`, from the first command on. Source: definition, of this project, after McLean and
    Hoffmann, Human Factors 17 (1975) 248. Undefined if `signal` was not measured from its first value on.
    """
    values = log[signal]
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        raise Undefined(f"{signal} was not measured")
    t, asked = uniform(Log({"t": log.t[known[0] :], signal: values[known[0] :]}), signal)
    step = float(t[1] - t[0])
    rate = np.gradient(asked, step)
    rough = rate - _smooth(rate, step, cutoff)
    worst = int(np.argmax(np.abs(rough)))
    return Measured(float(np.sqrt(np.mean(rough**2))), float(t[worst]), "", Series(t, rough))


def _acceleration(log: Log, cutoff: float) -> tuple[FloatArray, FloatArray]:
    t, v = uniform(log, "v")
    step = float(t[1] - t[0])
    return t, np.asarray(np.gradient(_smooth(v, step, cutoff), step))


def _smooth(values: FloatArray, step: float, cutoff: float) -> FloatArray:
    from pytest_dvp.metrics._low_pass import low_pass

    try:
        return low_pass(values, step, cutoff)
    except ValueError as error:
        raise Undefined(str(error)) from error
