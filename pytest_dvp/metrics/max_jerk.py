"""Greatest longitudinal jerk."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._even_time import CUTOFF, Cutoff, uniform
from pytest_dvp.metrics.metric import Measured, Series, metric

OTHER_CUTOFFS = (0.5, 2.0, 5.0)  # Hz
_FILTER = "zero-phase Butterworth low pass of order 2"


@metric(name="max_jerk", unit="m/s^3", bigger_is_worse=True, note=f"speed through a {_FILTER}, cut-off {{cutoff}} Hz")
def max_jerk(log: Log, *, cutoff: Cutoff = CUTOFF) -> Measured:
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
