"""Quality of the tracks that the stack publishes: recall, false ones, errors of place, yaw and time, identity, NEES."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._objects_ahead import Beside, Reach, Within
from pytest_dvp.metrics._track_matches import BESIDE, REACH, WITHIN, Beyond, matches, offset_of, seen_of, worst_of
from pytest_dvp.metrics.metric import Measured, NotNegative, metric

MOVING = 1.0  # m/s; one that is slower tells little of a delay


@metric(name="detection_recall", unit="-", bigger_is_worse=False, open_loop=True, ideal=1.0)
def detection_recall(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Share of the instants of road users ahead at which a detection was assigned to them: 1 - misses / truth.

    Ahead: from `beyond` to `reach` [m] before the bumper and `beside` [m] to a side, within `reach` for 1 s. At each
    instant detections and road users are assigned one to one, the sum of distances least, none above `within` [m]; kind
    does not count, hidden ones do. Source: CLEAR MOT, Bernardin and Stiefelhagen, EURASIP J. Image and Video Processing
    2008, 246309 (misses). t, object: first miss. Undefined if nobody was ahead.
    """
    m = matches(log, reach, beside, within, beyond)
    if not len(m.t):
        raise Undefined("no road user was ahead of the ego")
    missed = np.flatnonzero(m.row < 0)
    first = missed[np.argmin(m.t[missed])] if len(missed) else None
    return Measured(
        1.0 - len(missed) / len(m.t),
        None if first is None else float(m.t[first]),
        "" if first is None else m.names[first],
    )


@metric(name="false_tracks", unit="s", bigger_is_worse=True, open_loop=True)
def false_tracks(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Time in which detections ahead belong to no road user, summed over them: two at once count twice.

    Ahead and assigned as in `detection_recall`; one within `within` [m] of any road user is no false one, but a double.
    Source: false positives of CLEAR MOT, Bernardin and Stiefelhagen 2008, times the step of the detections. t: the
    first. Undefined if the stack reported no detection at all.
    """
    if not len(log.detections.t):
        raise Undefined("the stack reported no detections")
    rows = matches(log, reach, beside, within, beyond).false_row
    step = _step(np.unique(log.detections.t), log)
    t = log.detections.t[rows]
    return Measured(len(rows) * step, float(t.min()) if len(t) else None)


@metric(name="track_position_error", unit="m", bigger_is_worse=True, open_loop=True, note="mean over assigned ones")
def track_position_error(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Mean distance between the middles of road users ahead and of the detections assigned to them.

    Assigned as in `detection_recall`. Source: multiple object tracking precision (MOTP), Bernardin and Stiefelhagen
    2008. The greatest is in `extra`. Undefined if nobody ahead was detected.
    """
    m, seen = seen_of(log, reach, beside, within, beyond)
    error = np.hypot(*offset_of(log, m, seen))
    return worst_of(m, seen, error, float(error.mean()), {"greatest": float(error.max())})


@metric(name="track_yaw_error", unit="rad", bigger_is_worse=True, open_loop=True, note="root mean square, of axes")
def track_yaw_error(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Root mean square of the angle between the axes of boxes ahead and of the detections assigned to them, 0 to pi/2.

    Of vehicles and bicycles only. A box turned by half a turn is the same box; the error with direction is in `extra`.
    Source: average orientation error of nuScenes, Caesar et al., CVPR 2020, of period pi. Undefined if none was
    detected.
    """
    m, seen = seen_of(log, reach, beside, within, beyond)
    seen = seen[[log.objects[m.names[k]].kind in ("vehicle", "bicycle") for k in seen]]
    if not len(seen):
        raise Undefined("no vehicle or bicycle ahead of the ego was detected")
    turn = log.detections.yaw[m.row[seen]] - m.truth[seen, 2]
    error = np.abs(np.remainder(turn + 0.5 * np.pi, np.pi) - 0.5 * np.pi)
    directed = np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi
    extra = {"with direction": float(np.sqrt(np.mean(directed**2)))}
    return worst_of(m, seen, error, float(np.sqrt(np.mean(error**2))), extra)


@metric(name="track_latency", unit="s", bigger_is_worse=True, open_loop=True, note="of those faster than {moving} m/s")
def track_latency(
    log: Log,
    *,
    reach: Reach = REACH,
    beside: Beside = BESIDE,
    within: Within = WITHIN,
    beyond: Beyond = 0.0,
    moving: NotNegative = MOVING,
) -> Measured:
    """By how much the detections of moving road users lie behind, along their motion: least-squares delay tau.

    tau = -sum(e . v) / sum(v . v) of the position errors e and the true velocities v of those faster than `moving`
    [m/s]: the delay that explains e = -tau v best. Negative: the stack reports them ahead of where they are. A delay
    that a tracker extrapolates away does not show. Source: linear least squares. Undefined if none moved.
    """
    m, seen = seen_of(log, reach, beside, within, beyond)
    v = m.truth[seen, 3:5]
    fast = np.hypot(v[:, 0], v[:, 1]) > moving
    if not fast.any():
        raise Undefined(f"no detected road user ahead was faster than {moving:g} m/s")
    seen, v = seen[fast], v[fast]
    behind = -np.sum(np.column_stack(offset_of(log, m, seen)) * v, axis=1)
    speed2 = np.sum(v**2, axis=1)
    return worst_of(m, seen, behind / speed2, float(behind.sum() / speed2.sum()), {})


@metric(name="identity_switches", unit="-", bigger_is_worse=True, open_loop=True)
def identity_switches(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """How often the track assigned to a road user ahead is another one than the last that was assigned to it.

    Source: mismatches of CLEAR MOT, Bernardin and Stiefelhagen 2008; assigned as in `detection_recall`, without their
    preference for the last one. t, object: the first switch. Undefined if the stack numbers no tracks.
    """
    numbers = log.detections.track
    if numbers is None or not np.isfinite(numbers).any():
        raise Undefined("the detections carry no number of their track (Detection.track)")
    m, seen = seen_of(log, reach, beside, within, beyond)
    last: dict[str, float] = {}
    count, when, who = 0, None, ""
    for k in seen[np.argsort(m.t[seen], kind="stable")]:
        number = float(numbers[m.row[k]])
        if not np.isfinite(number):
            continue
        if last.get(m.names[k], number) != number:
            count += 1
            if when is None:
                when, who = float(m.t[k]), m.names[k]
        last[m.names[k]] = number
    return Measured(float(count), when, who)


@metric(name="nees", unit="-", bigger_is_worse=None, open_loop=True, ideal=2.0, note="mean; 2 is consistent")
def nees(
    log: Log, *, reach: Reach = REACH, beside: Beside = BESIDE, within: Within = WITHIN, beyond: Beyond = 0.0
) -> Measured:
    """Mean normalised estimation error squared of the positions: e' P^-1 e with the covariance P that the stack states.

    Two degrees of freedom, so 2 where the stack is as sure as it may be; greater: too sure, less: not sure enough.
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section
    5.4.2. Assigned as in `detection_recall`. Undefined if the stack states no covariance.
    """
    table = log.detections
    if table.cov_xx is None or table.cov_xy is None or table.cov_yy is None:
        raise Undefined("the detections carry no covariance (Detection.covariance)")
    m, seen = seen_of(log, reach, beside, within, beyond)
    xx, xy, yy = (c[m.row[seen]] for c in (table.cov_xx, table.cov_xy, table.cov_yy))
    stated = (xx > 0.0) & (xx * yy - xy**2 > 0.0)
    if not stated.any():
        raise Undefined("no detection of a road user ahead carries a positive definite covariance")
    seen, xx, xy, yy = seen[stated], xx[stated], xy[stated], yy[stated]
    ex, ey = offset_of(log, m, seen)
    error = (yy * ex**2 - 2.0 * xy * ex * ey + xx * ey**2) / (xx * yy - xy**2)
    return worst_of(m, seen, error, float(error.mean()), {"greatest": float(error.max()), "samples": float(len(error))})


def _step(times: FloatArray, log: Log) -> float:
    """Time between two instants of detections [s]: the median; of the road users, where there is but one."""
    if len(times) > 1:
        return float(np.median(np.diff(times)))
    return next((float(np.median(np.diff(o.t))) for o in log.objects.values() if len(o.t) > 1), 0.0)
