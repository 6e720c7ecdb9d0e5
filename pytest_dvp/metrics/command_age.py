"""How old the observation was on which a command rests."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="command_age", unit="s", bigger_is_worse=True, open_loop=True)
def command_age(log: Log) -> Measured:
    """Greatest age of a command when the stack hands it over: the time of that tick minus the command's own stamp.

    From the column `command_age`. The stamp (`Command.t`) is that of the observation it rests on; 0 is a command of the
    same tick. What `--compute-delay` and the wire add comes on top. Source: age of information, Kaul, Yates and
    Gruteser, IEEE INFOCOM 2012. The mean is in `extra`. Undefined in logs without that column.
    """
    age = log.columns.get("command_age")
    if age is None or not np.isfinite(age).any():
        raise Undefined("the log does not tell the stamps of the commands (command_age)")
    known = np.isfinite(age)
    worst = int(np.argmax(np.where(known, age, -np.inf)))
    return Measured(float(age[worst]), float(log.t[worst]), "", Series(log.t, age), {"mean": float(age[known].mean())})
