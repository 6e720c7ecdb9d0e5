"""Contact with others."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._ego_box import pair_boxes
from pytest_dvp.metrics.metric import Measured, metric


@metric(name="collision", unit="-", bigger_is_worse=True)
def collision(log: Log) -> Measured:
    """Number of objects the ego hit.

    Counts both what the world reported (events "collision", whose element is the object) and boxes that overlap in the
    log, so that a measured log without a world is judged too. 0 in an empty world. Undefined if no contact is known and
    that of a road user cannot be: one that is known stays one, whatever was not measured of others.
    """
    from pytest_dvp.metrics._box_collision_time import time_to_collision

    first: dict[str, float] = {}
    for event in log.events:
        if event.kind == "collision":
            first[event.element] = min(event.t, first.get(event.element, np.inf))
    unknown: Undefined | LogError | None = None
    for name, track in log.objects.items():
        try:
            t, ego, box = pair_boxes(log, name, track)
        except (Undefined, LogError) as reason:
            unknown = unknown or reason
            continue
        ego[:, 5:], box[:, 5:] = 0.0, 0.0  # standing boxes: their TTC is 0 where they overlap, else infinite
        overlap = np.flatnonzero(time_to_collision(ego, box) == 0.0)
        if len(overlap):
            first[name] = min(float(t[overlap[0]]), first.get(name, np.inf))
    if unknown is not None and not first:
        raise unknown
    if not first:
        return Measured(0.0)
    earliest = min(first, key=lambda name: first[name])
    return Measured(float(len(first)), first[earliest], earliest)
