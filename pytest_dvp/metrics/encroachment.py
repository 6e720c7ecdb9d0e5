"""Post-encroachment time: how shortly after one another ego and others were at one place."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._box_gaps import overlap
from pytest_dvp.metrics._pairs import pairs
from pytest_dvp.metrics.metric import Measured, metric

LONGEST = 10.0  # s


@metric(name="pet", unit="s", bigger_is_worse=False, note="looked for up to {longest} s; resolved to a step of a track")
def pet(log: Log, *, longest: float = LONGEST) -> Measured:
    """Post-encroachment time: least time between one leaving a place and the other one coming to it; 0 at a contact.

    Over all places that the oriented boxes of the ego and another road user both covered, so also of one that follows
    the other. Source: Allen, Shin and Cooper, Transportation Research Record 667 (1978) 67. The value is too great by
    a step of the tracks at most. t is when the second one came. Undefined if no place was shared within `longest` [s].
    """
    best, when, who = np.inf, None, ""
    for name, t, ego, box in pairs(log):
        apart, at = _least_time(t, ego, box, min(best, longest))
        if apart < best:
            best, when, who = apart, at, name
    if when is None:
        raise Undefined(f"no road user was within {longest:g} s where the ego was")
    return Measured(best, when, who)


def _least_time(t: FloatArray, ego: FloatArray, box: FloatArray, longest: float) -> tuple[float, float | None]:
    """Least |t_i - t_j| [s] of rows i of the ego and j of the other one whose boxes overlap; inf if none is within."""
    best, at = np.inf, None
    reach2 = (0.5 * np.hypot(ego[0, 3], ego[0, 4]) + 0.5 * np.hypot(box[0, 3], box[0, 4])) ** 2
    for lag in range(len(t)):
        later = t[lag:] - t[: len(t) - lag]
        if float(later.min()) > min(best, longest):
            break  # rows farther apart are only later
        for first, second in ((ego, box), (box, ego)):
            a, b = first[: len(t) - lag], second[lag:]
            near = (a[:, 0] - b[:, 0]) ** 2 + (a[:, 1] - b[:, 1]) ** 2 <= reach2
            rows = np.flatnonzero(near & (later <= longest) & (later < best))
            rows = rows[overlap(a[rows], b[rows])]
            if len(rows):
                k = rows[np.argmin(later[rows])]
                best, at = float(later[k]), float(t[lag + k])
    return best, at
