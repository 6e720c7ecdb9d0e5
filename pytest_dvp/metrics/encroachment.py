"""Post-encroachment time: how shortly after one another ego and others were at one place."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._pairs import pairs
from pytest_dvp.metrics.metric import Measured, Positive, metric

LONGEST = 10.0  # s


@metric(name="pet", unit="s", bigger_is_worse=False, note="looked for up to {longest} s; resolved to a step of a track")
def pet(log: Log, *, longest: Positive = LONGEST) -> Measured:
    """Post-encroachment time: least time between one leaving a place and the other one coming to it; 0 at a contact.

    Over all places that the oriented boxes of the ego and another road user both covered, so also of one that follows
    the other. Source: Allen, Shin and Cooper, Transportation Research Record 667 (1978) 67. The value is too great by
    a step of the tracks at most. t is when the second one came. Undefined if no place was shared within `longest` [s].
    """
    from pytest_dvp.metrics._encroachment import least_time  # compiled: a check of a gate file does not load it

    best, when, who = np.inf, np.nan, ""
    for name, t, ego, box in pairs(log):
        apart, at = least_time(t, ego, box, min(best, longest))
        if apart < best:
            best, when, who = apart, at, name
    if np.isinf(best):
        raise Undefined(f"no road user was within {longest:g} s where the ego was")
    return Measured(best, when, who)
