"""The ego and each other road user as boxes over time, and the worst moment of a course over all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._ego_box import pair_boxes
from pytest_dvp.metrics._once_a_log import once_a_log
from pytest_dvp.metrics.metric import Measured, Series


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Course:
    """What one road user was to the ego: value (n,) at t (n,) [s]; NaN where it is not defined."""

    name: str
    t: FloatArray
    value: FloatArray


@once_a_log
def pairs(log: Log) -> list[tuple[str, FloatArray, FloatArray, FloatArray]]:
    """(name, t, boxes of the ego, boxes of the road user) of all that were there with the ego; see `pair_boxes`.

    t (n,) in [s], boxes (n, 7) in SI units. Raises Undefined if there is none.
    """
    if not log.objects:
        raise Undefined("no other road user in the log")
    of_each = [(name, *pair_boxes(log, name, track)) for name, track in log.objects.items()]
    found = [each for each in of_each if len(each[1])]
    if not found:
        raise Undefined("no other road user at a time at which the ego was recorded")
    return found


def worst_of(courses: Sequence[Course], reason: str, *, greatest: bool) -> Measured:
    """The greatest or the least value of all courses, with its time and road user, and the worst over time.

    Raises Undefined with `reason` if none is defined anywhere.
    """
    sign = 1.0 if greatest else -1.0
    known = [(c.name, c.t[ok], c.value[ok]) for c in courses if (ok := np.isfinite(c.value)).any()]
    if not known:
        raise Undefined(reason)
    times = np.unique(np.concatenate([t for _, t, _ in known]))
    worst = np.full(len(times), -np.inf)
    who = np.zeros(len(times), dtype=np.int64)
    for k, (_, t, value) in enumerate(known):
        at = np.searchsorted(times, t)
        more = sign * value > worst[at]
        worst[at[more]], who[at[more]] = sign * value[more], k
    i = int(np.argmax(worst))
    return Measured(sign * float(worst[i]), float(times[i]), known[who[i]][0], Series(times, sign * worst))
