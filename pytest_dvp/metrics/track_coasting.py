"""How much of what the stack tracks nobody saw: a tracker that moves its tracks on hides what its sensors miss."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics._objects_ahead import Beside, Reach, Within
from pytest_dvp.metrics._track_matches import BESIDE, REACH, WITHIN, Beyond, seen_of, worst_of
from pytest_dvp.metrics.metric import Measured, metric


@metric(name="track_coasting", unit="-", bigger_is_worse=True, open_loop=True, note="share of assigned detections")
def track_coasting(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Share of the detections of road users ahead that no measurement stands behind: the track was only moved on.

    A tracker moves a track on at the velocity that it had, so a velocity that is that of the row before, and a place to
    which it leads, say that nothing was seen; in a log without numbers of tracks this cannot be told, and the share
    is 0. Some coasting is usual: a sensor that measures at half the rate of the stack leaves every second row without.
    Assigned as in `detection_recall`, which stays 1 as long as a tracker bridges what sensors miss. Undefined if nobody
    was detected.
    """
    from pytest_dvp.gap.perception.fresh_detections import fresh

    m, seen = seen_of(log, reach, beside, within, beyond)
    coasts = (~fresh(log.detections)[m.row[seen]]).astype(np.float64)
    return worst_of(m, seen, coasts, float(coasts.mean()), {})
