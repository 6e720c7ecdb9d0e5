"""What tracks say of a road user besides its place: speed, size and kind."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics._objects_ahead import Beside, Reach, Within
from pytest_dvp.metrics._track_matches import BESIDE, REACH, WITHIN, Beyond, seen_of, worst_of
from pytest_dvp.metrics.metric import Measured, metric


@metric(name="track_speed_error", unit="m/s", bigger_is_worse=True, open_loop=True, note="root mean square")
def track_speed_error(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Root mean square of the difference between the velocity vectors of road users ahead and of their detections.

    Assigned as in `detection_recall`. Source: average velocity error of nuScenes, Caesar et al., CVPR 2020, as a root
    mean square. Undefined if nobody ahead was detected.
    """
    m, seen = seen_of(log, reach, beside, within, beyond)
    rows = m.row[seen]
    error = np.hypot(log.detections.vx[rows] - m.truth[seen, 3], log.detections.vy[rows] - m.truth[seen, 4])
    return worst_of(m, seen, error, float(np.sqrt(np.mean(error**2))), {"greatest": float(error.max())})


@metric(name="track_size_error", unit="-", bigger_is_worse=True, open_loop=True, note="mean of 1 - overlap of sizes")
def track_size_error(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Mean of 1 - IoU of the true and the detected rectangle laid on each other, middle on middle and axis on axis.

    0: sizes are equal; 0.5: half of what both cover is in both. Assigned as in `detection_recall`. Source: average
    scale error of nuScenes, Caesar et al., CVPR 2020, of areas. Undefined if nobody ahead was detected.
    """
    m, seen = seen_of(log, reach, beside, within, beyond)
    rows = m.row[seen]
    true = np.array([(log.objects[m.names[k]].length, log.objects[m.names[k]].width) for k in seen])
    told = np.column_stack((log.detections.length[rows], log.detections.width[rows]))
    common = np.minimum(true, told).prod(axis=1)
    error = 1.0 - common / (true.prod(axis=1) + told.prod(axis=1) - common)
    return worst_of(m, seen, error, float(error.mean()), {"greatest": float(error.max())})


@metric(name="kind_error", unit="-", bigger_is_worse=True, open_loop=True, note="share of assigned detections")
def kind_error(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Share of the detections of road users ahead that are called another kind than the road user is.

    Assigned as in `detection_recall`. Source: 1 - accuracy of a classification; average attribute error of nuScenes,
    Caesar et al., CVPR 2020. Undefined if nobody ahead was detected.
    """
    m, seen = seen_of(log, reach, beside, within, beyond)
    wrong = np.array([float(log.detections.kind[m.row[k]] != log.objects[m.names[k]].kind) for k in seen])
    return worst_of(m, seen, wrong, float(wrong.mean()), {})
