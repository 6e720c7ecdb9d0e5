"""Where a log says that its car did not obey its commands, because somebody else drove."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.held_values import held
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.unmeasured import unmeasured

ENGAGED = "engaged"
STACK, DRIVER = 1.0, 0.0  # who drives: the values that the column may have


def asks(name: str) -> bool:
    """Whether a column's name says that it is a command, in whatever unit: steer_cmd, steer_cmd_norm."""
    return "_cmd" in name


def driven_by_others(log: Log) -> NDArray[np.bool_]:
    """Rows (n,) in which the car did not obey its commands: `engaged` (0 or 1, no unit) is 0 there, also before it is
    first stated; none where the log does not state it. A state holds until the next one is stated."""
    engaged = log.columns.get(ENGAGED)
    if engaged is None or not np.isfinite(engaged).any():
        return np.zeros(len(log.t), dtype=np.bool_)
    return np.asarray(np.nan_to_num(held(engaged), nan=DRIVER) < 0.5 * (STACK + DRIVER))


def while_engaged(log: Log) -> Log:
    """The log without the commands (NaN) that its car did not obey; the log itself if it obeyed all.

    What was measured stays: a model that is driven by the measured steering and speed needs no command.
    """
    return unmeasured(log, dict.fromkeys(filter(asks, log.columns), driven_by_others(log)))
