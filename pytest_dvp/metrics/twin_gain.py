"""How strongly the car moved compared with what the twin makes of the same commands."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric
from pytest_dvp.metrics.twin_error import check_measured, compared

VARIES = 4.0  # times the noise: less variation of the twin's answer tells no slope


@metric(
    name="twin_gain",
    unit="-",
    bigger_is_worse=None,
    note="slope of the measured against the twin's, open loop",
    open_loop=True,
    ideal=1.0,
)
def twin_gain(model: Log, measured: Log, *, signal: str = "yaw_rate") -> Measured:
    """Slope of the measured `signal` against what the twin makes of the measured commands, least squares over a drive.

    `signal`: a column as in `dvp compare`. A wheelbase, a steering ratio or a mass that is wrong by some percent makes
    every answer too weak or too strong by as much; spread over a drive this is less than the noise of each sample, and
    `twin_chi2` does not see it. 1: as strong; below: the car does less than the twin. A constant offset does not count.
    Undefined if the first log is not of a twin, the signal is not compared, or the twin's answer hardly varies.
    """
    found = compared(model, measured)
    if signal not in found.signals:
        raise Undefined(f"{signal} is not compared: {found.not_compared.get(signal, 'no such signal')}")
    check_measured(found, signal)
    known = np.isfinite(found.residuals[signal])
    twin, car = found.modelled[signal][known], found.measured[signal][known]
    if len(twin) < 2 or float(np.std(twin)) < VARIES * found.noise[signal]:
        raise Undefined(f"{signal} of the twin hardly varies")
    apart = twin - twin.mean()
    slope = float(apart @ (car - car.mean()) / (apart @ apart))
    return Measured(slope, None, "", Series(found.t[known], car - twin))
