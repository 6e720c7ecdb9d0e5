"""How fast and how restlessly the wheels are steered."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._even_time import CUTOFF, Cutoff, uniform
from pytest_dvp.metrics.metric import Measured, Series, metric

RATE_CUTOFF = 5.0  # Hz; faster than a steering actuator, slower than the noise of its sensor
_FILTER = "zero-phase Butterworth low pass of order 2, cut-off {cutoff} Hz"


@metric(name="max_steer_rate", unit="rad/s", bigger_is_worse=True, note=f"`steer` through a {_FILTER}")
def max_steer_rate(log: Log, *, cutoff: Cutoff = RATE_CUTOFF) -> Measured:
    """Greatest magnitude of the time derivative of the road-wheel angle `steer`, filtered.

    Source: definition, of this project. Undefined if `steer` was not measured throughout.
    """
    t, steer = uniform(log, "steer")
    step = float(t[1] - t[0])
    rate = np.gradient(_smooth(steer, step, cutoff), step)
    worst = int(np.argmax(np.abs(rate)))
    return Measured(float(abs(rate[worst])), float(t[worst]), "", Series(t, rate))


@metric(name="steer_roughness", unit="rad/s", bigger_is_worse=True, note=f"rate of `{{signal}}` without a {_FILTER}")
def steer_roughness(log: Log, *, signal: str = "steer_cmd", cutoff: Cutoff = CUTOFF) -> Measured:
    """Root mean square of the steering rate above `cutoff` [Hz]: of the derivative of `signal` less its low-passed one.

    A steady curve and slow steering leave 0; steps, chatter and noise do not. From the first command on. Source: high
    frequency component of steering, McLean and Hoffmann, Human Factors 17 (1975) 248, of the rate. Undefined if
    `signal` was not measured from its first value on.
    """
    values = log[signal]
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        raise Undefined(f"{signal} was not measured")
    part = Log({"t": log.t[known[0] :], signal: values[known[0] :]})
    t, angle = uniform(part, signal)
    step = float(t[1] - t[0])
    rate = np.gradient(angle, step)
    rough = rate - _smooth(rate, step, cutoff)
    worst = int(np.argmax(np.abs(rough)))
    return Measured(float(np.sqrt(np.mean(rough**2))), float(t[worst]), "", Series(t, rough))


def _smooth(values: FloatArray, step: float, cutoff: float) -> FloatArray:
    from pytest_dvp.metrics._low_pass import low_pass

    try:
        return low_pass(values, step, cutoff)
    except ValueError as error:
        raise Undefined(str(error)) from error
