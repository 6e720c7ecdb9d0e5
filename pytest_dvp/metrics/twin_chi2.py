"""How far the twin's answer to the car's commands is from what the car's sensors showed, in units of their noise."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, NotNegative, Series, metric
from pytest_dvp.metrics.twin_error import check_measured, compared

WORST = "worst"
LEAST = 2.0  # s in a regime, from which on it is judged by itself


@metric(
    name="twin_chi2",
    unit="-",
    bigger_is_worse=True,
    note="1: only the noise of the sensors is left; of the {regime} regime",
    open_loop=True,
)
def twin_chi2(
    model: Log, measured: Log, *, signal: str = "yaw_rate", regime: str = WORST, least: NotNegative = LEAST
) -> Measured:
    """Mean square of what the twin's answer to the measured commands leaves of `signal`, over the sensor's variance.

    `signal`: a column as in `dvp compare`: yaw_rate, ax, ay, steer (the wheel's response), v, x, y or yaw. `regime`:
    "worst", the one of those driven for `least` [s] in which it is greatest; "all", the whole drive; or its name:
    launch, cruise, lift_off, braking, standstill, turn_in, steady_turn, reverse. Each regime's value is in `extra`.
    The noise is that of the measured signal, and no finer than the best sensors of road cars.

    Source: reduced chi-squared, P. R. Bevington and D. K. Robinson, Data Reduction and Error Analysis (2003), section
    4.4. Undefined if the first log is not of a twin, the signal is not compared, or the regime was not driven for
    `least`.
    """
    found = compared(model, measured)
    if signal not in found.signals:
        raise Undefined(f"{signal} is not compared: {found.not_compared.get(signal, 'no such signal')}")
    check_measured(found, signal)
    square = np.square(found.residuals[signal] / found.noise[signal])
    known = np.isfinite(square)
    step = float(np.median(np.diff(found.t)))
    every = {"all": known, **{name: known & mask for name, mask in found.regimes.items()}}
    if regime != WORST and regime not in every:
        raise Undefined(f"no regime {regime!r}; there are {', '.join(found.regimes)}, all and {WORST}")
    driven = {name: rows for name, rows in every.items() if rows.sum() * step >= least}
    values = {name: float(square[rows].mean()) for name, rows in driven.items()}
    apart = [name for name in values if name != "all"]
    chosen = regime if regime != WORST else max(apart, key=values.__getitem__, default="all")
    if chosen not in values:
        raise Undefined(f"{'the drive' if chosen == 'all' else chosen} lasted less than {least:g} s")
    rows = np.flatnonzero(driven[chosen])
    worst = int(rows[np.argmax(square[rows])])
    return Measured(values[chosen], float(found.t[worst]), chosen, Series(found.t, square), values)
