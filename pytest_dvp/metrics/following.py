"""Following and approaching: the time headway, and the deceleration that would still avoid a contact."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics._box_gaps import extents
from pytest_dvp.metrics._pairs import Course, pairs, worst_of
from pytest_dvp.metrics.metric import Measured, Positive, Range, metric

RESOLUTION = 0.1  # m; nearer than a log tells a gap, a contact counts as this
RESOLVED = Range(0.0, 1.0, above=True)  # m, chosen: a contact at 5 m/s still asks for 12.5 m/s^2, beyond any brake
Resolution: TypeAlias = Annotated[float, RESOLVED]


@metric(name="time_headway", unit="s", bigger_is_worse=False, note="ego faster than {slow} m/s")
def time_headway(log: Log, *, slow: Positive = 0.5) -> Measured:
    """Least time gap to what is straight ahead: free distance from front to rear bumper over the ego's own speed.

    Only while the ego drives forwards faster than `slow` [m/s]. Source: time gap of ISO 15622:2018 (clearance over
    speed). Straight ahead is the strip as wide as the ego. Undefined if nobody was ahead of the moving ego.
    """
    courses = []
    for name, t, ego, box in pairs(log):
        gap, speed, _ = _ahead(ego, box)
        courses.append(Course(name, t, np.where(speed > slow, gap / np.where(speed > slow, speed, 1.0), np.nan)))
    return worst_of(courses, "nobody was straight ahead of the moving ego", greatest=False)


@metric(
    name="required_deceleration",
    unit="m/s^2",
    bigger_is_worse=True,
    note="gaps below {resolution} m count as that",
)
def required_deceleration(log: Log, *, resolution: Resolution = RESOLUTION) -> Measured:
    """Greatest constant deceleration at which the ego would just not hit what is straight ahead: dv^2 / (2 gap).

    dv is the speed at which the gap closes along the ego's x axis; the other one keeps its velocity. 0 while no gap
    closes. Source: deceleration rate to avoid a crash (DRAC), Cooper and Ferguson, Traffic Engineering + Control 17
    (1976) 306. Undefined if nobody was ever ahead.
    """
    courses = []
    for name, t, ego, box in pairs(log):
        gap, _, closing = _ahead(ego, box)
        courses.append(Course(name, t, np.maximum(closing, 0.0) ** 2 / (2.0 * np.maximum(gap, resolution))))
    found = worst_of(courses, "nobody was ever straight ahead of the ego", greatest=True)
    return found if found.value > 0.0 else Measured(0.0, None, "", found.series)


def _ahead(ego: FloatArray, box: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gap [m] to the part ahead (NaN: none), the ego's speed along its x axis, and that at which the gap closes.

    A box whose middle is behind that of the ego is not ahead, whatever of it overlaps.
    """
    cos, sin = np.cos(ego[:, 2]), np.sin(ego[:, 2])
    low, _ = extents(ego, box, 0)
    middle = (box[:, 0] - ego[:, 0]) * cos + (box[:, 1] - ego[:, 1]) * sin
    gap = np.where(middle > 0.0, np.maximum(low - 0.5 * ego[:, 3], 0.0), np.nan)
    speed = ego[:, 5] * cos + ego[:, 6] * sin
    return gap, speed, speed - (box[:, 5] * cos + box[:, 6] * sin)
