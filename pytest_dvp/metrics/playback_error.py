"""A stack against the recording that is played to it: is what it asks for what was asked for then?"""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="replay_steer_error", unit="rad", bigger_is_worse=True, note="root mean square", open_loop=True)
def replay_steer_error(log: Log) -> Measured:
    """Root mean square of the steering angle that the stack asks for less the recorded one (`replay.steer_cmd`).

    The greatest is in `extra`. Undefined unless a recording with commands was played.
    """
    return _error(log, "steer_cmd")


@metric(name="replay_accel_error", unit="m/s^2", bigger_is_worse=True, note="root mean square", open_loop=True)
def replay_accel_error(log: Log) -> Measured:
    """Root mean square of the acceleration that the stack asks for less the recorded one (`replay.accel_cmd`).

    The greatest is in `extra`. Undefined unless a recording with commands was played.
    """
    return _error(log, "accel_cmd")


def _error(log: Log, name: str) -> Measured:
    recorded = f"replay.{name}"
    if recorded not in log.columns or name not in log.columns:
        raise Undefined(f"no recording with commands was played ({recorded})")
    error = log[name] - log[recorded]
    known = np.isfinite(error)
    if not known.any():
        raise Undefined(f"{recorded} and {name} have no value at the same time")
    worst = int(np.argmax(np.where(known, np.abs(error), -1.0)))
    rms = float(np.sqrt(np.mean(error[known] ** 2)))
    return Measured(rms, float(log.t[worst]), "", Series(log.t, error), {"greatest": float(abs(error[worst]))})
