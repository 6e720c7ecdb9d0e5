"""What the stack detects of road users ahead against what is there: how far off, and what it misses."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._objects_ahead import Beside, Reach, Within, objects_ahead
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="detection_error", unit="m", bigger_is_worse=True, open_loop=True, note="root mean square of the position")
def detection_error(log: Log, *, reach: Reach = 20.0, beside: Beside = 4.0, within: Within = 3.0) -> Measured:
    """Root mean square of the distance between road users ahead and the nearest detection of the same kind.

    Ahead: the middle of the box within `reach` [m] in front of the ego and `beside` [m] to a side, for SETTLED seconds.
    Farther than `within` [m] it is another one: see `missed_objects`. Undefined if none was ahead or none was seen.
    """
    ahead = objects_ahead(log, reach, beside, within)
    if not ahead:
        raise Undefined("no road user was ahead of the ego")
    t = np.concatenate([times for _, times, _ in ahead])
    error = np.concatenate([errors for _, _, errors in ahead])
    names = np.repeat([name for name, _, _ in ahead], [len(times) for _, times, _ in ahead])
    seen = np.isfinite(error)
    if not seen.any():
        raise Undefined("no road user ahead of the ego was seen")
    worst = int(np.argmax(np.where(seen, error, -1.0)))
    order = np.argsort(t, kind="stable")
    rms = float(np.sqrt(np.mean(error[seen] ** 2)))
    extra = {"greatest": float(error[worst]), "seen": float(seen.mean())}
    return Measured(rms, float(t[worst]), str(names[worst]), Series(t[order], error[order]), extra)


@metric(name="missed_objects", unit="s", bigger_is_worse=True, open_loop=True)
def missed_objects(log: Log, *, reach: Reach = 20.0, beside: Beside = 4.0, within: Within = 3.0) -> Measured:
    """Total time during which a road user ahead had no detection of its kind near it; arguments as `detection_error`.

    Hidden ones count: the log does not know what hides what. Undefined if none was ahead.
    """
    ahead = objects_ahead(log, reach, beside, within)
    if not ahead:
        raise Undefined("no road user was ahead of the ego")
    total, t_first, who = 0.0, None, ""
    for name, times, error in ahead:
        missed = ~np.isfinite(error)
        if missed.any():
            step = float(np.median(np.diff(log.objects[name].t))) if len(log.objects[name].t) > 1 else 0.0
            total += step * float(missed.sum())
            if t_first is None or times[missed][0] < t_first:
                t_first, who = float(times[missed][0]), name
    return Measured(total, t_first, who)
