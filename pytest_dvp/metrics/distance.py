"""How near the ego came to others: from bumper to bumper, ahead and behind, beside, and while it passed them."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics._box_gaps import distances, gaps
from pytest_dvp.metrics._pairs import Course, pairs, worst_of
from pytest_dvp.metrics.metric import Measured, NotNegative, metric


@metric(name="min_distance", unit="m", bigger_is_worse=False)
def min_distance(log: Log) -> Measured:
    """Least distance between the oriented box of the ego and that of any other road user; 0 at a contact.

    Source: Euclidean distance of two convex sets (Ericson, Real-Time Collision Detection, 2005, section 5.1).
    Undefined without any other road user.
    """
    courses = [Course(name, t, distances(ego, box)) for name, t, ego, box in pairs(log)]
    return worst_of(courses, "no other road user", greatest=False)


@metric(name="min_distance_longitudinal", unit="m", bigger_is_worse=False, note="in a straight strip as wide as ego")
def min_distance_longitudinal(log: Log) -> Measured:
    """Least free distance from bumper to bumper, along the ego's x axis, to what is before or behind it.

    Counts the part of another's box in the straight strip that is as wide as the ego; 0 at a contact. Source: relative
    distance "longitudinal" with freespace, ASAM OpenSCENARIO XML 1.3, in the frame of the ego. Undefined if none was
    ever in that strip.
    """
    courses = [Course(name, t, gaps(ego, box, 0)) for name, t, ego, box in pairs(log)]
    return worst_of(courses, "nobody was ever straight ahead of the ego or behind it", greatest=False)


@metric(name="min_distance_lateral", unit="m", bigger_is_worse=False, note="in a strip as long as the ego")
def min_distance_lateral(log: Log) -> Measured:
    """Least free distance across the ego's x axis, from side to side, to what is next to it; 0 at a contact.

    Counts the part of another's box in the strip that is as long as the ego. Source: relative distance "lateral" with
    freespace, ASAM OpenSCENARIO XML 1.3, in the frame of the ego. Undefined if none was ever in that strip.
    """
    courses = [Course(name, t, gaps(ego, box, 1)) for name, t, ego, box in pairs(log)]
    return worst_of(courses, "nobody was ever next to the ego", greatest=False)


@metric(name="passing_clearance", unit="m", bigger_is_worse=False, note="faster than {faster} m/s along the ego")
def passing_clearance(log: Log, *, faster: NotNegative = 1.0) -> Measured:
    """Least lateral free distance to what the ego passes or meets: next to it, speeds along the ego's x axis apart.

    As `min_distance_lateral`, but only while the longitudinal speeds differ by more than `faster` [m/s], so that two
    who drive or wait side by side do not count. Source: the wide berth that the Vienna Convention on Road Traffic
    (1968), article 11(4), asks for, as a length. Undefined if the ego passed nobody.
    """
    courses = []
    for name, t, ego, box in pairs(log):
        relative = (ego[:, 5] - box[:, 5]) * np.cos(ego[:, 2]) + (ego[:, 6] - box[:, 6]) * np.sin(ego[:, 2])
        courses.append(Course(name, t, np.where(np.abs(relative) > faster, gaps(ego, box, 1), np.nan)))
    return worst_of(courses, f"the ego passed nobody faster than {faster:g} m/s", greatest=False)
