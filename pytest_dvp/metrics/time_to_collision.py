"""Time to collision: its greatest inverse, and the time exposed to a small one."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._ego_box import pair_boxes
from pytest_dvp.metrics._presence import exposed
from pytest_dvp.metrics.metric import Measured, Positive, Range, Series, metric

RESOLUTION = 0.01  # s; step of the log: no TTC below it can be told, so a contact counts as this one
RESOLVED = Range(0.0, 0.1, above=True)  # s, chosen: a contact still counts as 10 1/s, beyond any bound in use
Resolution: TypeAlias = Annotated[float, RESOLVED]


@metric(
    name="max_ttc_inverse",
    unit="1/s",
    bigger_is_worse=True,
    note="TTC resolved to {resolution} s; overlapping boxes count as that",
)
def max_ttc_inverse(log: Log, *, resolution: Resolution = RESOLUTION) -> Measured:
    """Greatest inverse of the time to collision between the ego and any other road user.

    Oriented boxes, constant velocity, fixed orientation; 0 while nothing is on a collision course. A TTC below
    `resolution` [s], and a contact, count as `resolution`. Source: Arango et al., Sensors 2026, 26, 1338.
    Undefined without any object.
    """
    times, least, who = least_ttc(log)
    inverse = 1.0 / np.maximum(least, resolution)
    worst = int(np.argmax(inverse))
    name = list(log.objects)[who[worst]] if inverse[worst] > 0.0 else ""
    return Measured(float(inverse[worst]), float(times[worst]), name, Series(times, inverse))


@metric(name="tet", unit="s", bigger_is_worse=True, note="critical TTC {critical} s")
def tet(log: Log, *, critical: Positive = 2.0) -> Measured:
    """Time exposed to a critical time to collision: sum over steps and road users of the step where TTC < critical.

    Source: Arango et al., Sensors 2026, 26, 1338, whose table pins the threshold between 1.78 and 2.41 s. Two road
    users count twice, and one that is critical in its last sample alone counts a step. Undefined without any object.
    """
    total, worst, when, worst_name = 0.0, np.inf, None, ""
    step = float(np.median(np.diff(log.t)))
    for name, t, ttc in _ttc_of_objects(log):
        total += exposed(t, ttc < critical, step)
        least = int(np.argmin(ttc))
        if ttc[least] < min(worst, critical):
            worst, when, worst_name = float(ttc[least]), float(t[least]), name
    return Measured(total, when, worst_name)


def least_ttc(log: Log) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Times (n,), least TTC [s] over all objects (inf: none), and the index of that object in `log.objects`."""
    courses = _ttc_of_objects(log)
    times = np.unique(np.concatenate([t for _, t, _ in courses]))
    least = np.full(len(times), np.inf)
    who = np.zeros(len(times), dtype=np.int64)
    names = {name: i for i, name in enumerate(log.objects)}
    for name, t, ttc in courses:
        at = np.searchsorted(times, t)
        closer = ttc < least[at]
        least[at[closer]] = ttc[closer]
        who[at[closer]] = names[name]
    return times, least, who


def _ttc_of_objects(log: Log) -> list[tuple[str, FloatArray, FloatArray]]:
    from pytest_dvp.metrics._box_collision_time import time_to_collision

    if not log.objects:
        raise Undefined("no other road user in the log")
    courses = []
    for name, track in log.objects.items():
        t, ego, box = pair_boxes(log, name, track)
        if len(t):
            courses.append((name, t, time_to_collision(ego, box)))
    if not courses:
        raise Undefined("no other road user at a time at which the ego was recorded")
    return courses
