"""How a car answers its commands within one drive: by how much later, and how strongly."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.likeness import Likeness, likeness, peak
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.obeyed_commands import with_obeyed_commands
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric

MAX_LAG = 1.0  # s; a car that answers later cannot be driven


@metric(name="response_lag", unit="s", bigger_is_worse=None, note="lag within +-1 s", open_loop=True)
def response_lag(log: Log, *, command: str = "steer_cmd", signal: str = "steer") -> Measured:
    """Lag at which a measured signal is most alike to its command: dead time and slowness of the actuator together.

    Other than the lag between two drives it does not depend on when a driving stack did something. Of a
    recording that was played to a stack, its own commands count.
    """
    found = _compare(log, command, signal)
    lag = peak(found.lags, found.overlap)
    return Measured(lag, None, "", Series(found.lags, found.overlap), {"mncc": found.mncc, "gain": found.gain})


@metric(
    name="response_gain",
    unit="-",
    bigger_is_worse=None,
    note="at the best lag within +-1 s",
    open_loop=True,
    ideal=1.0,
)
def response_gain(log: Log, *, command: str = "steer_cmd", signal: str = "steer") -> Measured:
    """Slope of a measured signal against its command at the lag at which they are most alike."""
    found = _compare(log, command, signal)
    return Measured(found.gain, None, "", Series(found.lags, found.overlap), {"mncc": found.mncc})


def _compare(log: Log, command: str, signal: str) -> Likeness:
    log = with_obeyed_commands(log)
    both = np.isfinite(log[command]) & np.isfinite(log[signal])
    if both.sum() < 3:
        raise Undefined(f"{command} and {signal} were not measured together")
    t = log.t[both]
    step = float(np.median(np.diff(t)))
    if step <= 0.0:
        raise Undefined("the time of the log does not increase")
    grid = t[0] + step * np.arange(int((t[-1] - t[0]) / step + 1e-6) + 1)
    asked, got = np.interp(grid, t, log[command][both]), np.interp(grid, t, log[signal][both])
    return likeness(asked, got, step, MAX_LAG)
