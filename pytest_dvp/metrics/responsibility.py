"""Responsibility-sensitive safety (RSS): time in which both safe distances were violated."""

from __future__ import annotations

import math

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._box_gaps import corners_seen_by
from pytest_dvp.metrics._pairs import pairs
from pytest_dvp.metrics._presence import exposed
from pytest_dvp.metrics.metric import Measured, NotNegative, Positive, metric

_UNDECLARED = math.nan
_STANDS = 1e-6  # m/s; slower stands, and a car that stands drives neither way: rounding would give it one


@metric(name="rss_violation", unit="s", bigger_is_worse=True, note="axes of the ego instead of those of the lane")
def rss_violation(
    log: Log,
    *,
    response_time: NotNegative = _UNDECLARED,
    max_acceleration: NotNegative = _UNDECLARED,
    max_braking: Positive = _UNDECLARED,
    min_braking: Positive = _UNDECLARED,
    lateral_acceleration: NotNegative = _UNDECLARED,
    lateral_braking: Positive = _UNDECLARED,
    lateral_margin: NotNegative = _UNDECLARED,
) -> Measured:
    """Time in which the distance to a road user was below both its longitudinal and its lateral RSS safe distance.

    Who is behind answers after `response_time` [s], until then speeds up by `max_acceleration`, then brakes by
    `min_braking`, while the one ahead brakes by `max_braking` [m/s^2]; two who meet both brake by `min_braking`.
    Lateral likewise, with `lateral_margin` [m] left. Two road users count twice. Source: Shalev-Shwartz, Shammah and
    Shashua, arXiv:1708.06374v6 (2018), definitions 1, 2 and 6, with the ego's axes in place of the lane's.

    Undefined unless all seven are declared, or without any other road user.
    """
    given = {
        "response_time": response_time,
        "max_acceleration": max_acceleration,
        "max_braking": max_braking,
        "min_braking": min_braking,
        "lateral_acceleration": lateral_acceleration,
        "lateral_braking": lateral_braking,
        "lateral_margin": lateral_margin,
    }
    missing = [name for name, value in given.items() if math.isnan(value)]
    if missing:
        raise Undefined(f"RSS parameters are not declared: {', '.join(missing)}")
    total, worst, when, who = 0.0, 0.0, None, ""
    step = float(np.median(np.diff(log.t)))
    for name, t, ego, box in pairs(log):
        along, across, u, w, p, q = _seen(ego, box)
        need = safe_longitudinal(u, w, response_time, max_acceleration, min_braking, max_braking)
        aside = safe_lateral(p, q, response_time, lateral_acceleration, lateral_braking, lateral_margin)
        bad = (along < need) & (across < aside)
        total += exposed(t, bad, step)
        short = np.where(bad, need - along, 0.0)
        k = int(np.argmax(short))
        if short[k] > worst:
            worst, when, who = float(short[k]), float(t[k]), name
    return Measured(total, when, who, extra={"greatest shortfall along": worst})


def safe_longitudinal(
    rear: FloatArray, front: FloatArray, response: float, speeding: float, braking: float, hardest: float
) -> FloatArray:
    """Safe distance [m] of n pairs, (n,), from speeds [m/s] along the line from the one behind to the one ahead.

    front < 0: they meet (definition 2); else one follows (definition 1). Accelerations in [m/s^2].
    """
    fast = rear + response * speeding
    first = rear * response + 0.5 * speeding * response**2 + np.maximum(fast, 0.0) ** 2 / (2.0 * braking)
    follow = first - front**2 / (2.0 * hardest)
    other = -front + response * speeding
    second = -front * response + 0.5 * speeding * response**2 + other**2 / (2.0 * braking)
    return np.maximum(np.where(front < 0.0, first + second, follow), 0.0)


def safe_lateral(
    toward: FloatArray, away: FloatArray, response: float, speeding: float, braking: float, margin: float
) -> FloatArray:
    """Safe lateral distance [m] of n pairs, (n,): definition 6.

    toward, away: lateral speeds [m/s] of the one and of the other along the line from the one to the other.
    """
    one, two = toward + response * speeding, away - response * speeding
    travel = (toward + one) / 2.0 * response + _to_rest(one, braking)
    back = (away + two) / 2.0 * response + _to_rest(two, braking)
    return margin + np.maximum(travel - back, 0.0)


def _to_rest(speed: FloatArray, braking: float) -> FloatArray:
    return speed * np.abs(speed) / (2.0 * braking)


def _seen(ego: FloatArray, box: FloatArray) -> tuple[FloatArray, ...]:
    """Free distances along and across the ego, speeds of rear and front, and lateral ones of the one and the other.

    Speeds along the line from the one behind to the one ahead; laterally from the ego to the other one.
    """
    corners = corners_seen_by(ego, box)
    low, high = corners.min(axis=1), corners.max(axis=1)
    half = 0.5 * ego[:, 3:5]
    free = np.maximum(np.maximum(low - half, -half - high), 0.0)
    cos, sin = np.cos(ego[:, 2]), np.sin(ego[:, 2])
    mine = ego[:, 5] * cos + ego[:, 6] * sin, ego[:, 6] * cos - ego[:, 5] * sin
    its = box[:, 5] * cos + box[:, 6] * sin, box[:, 6] * cos - box[:, 5] * sin
    mine, its = ((np.where(np.abs(along) < _STANDS, 0.0, along), left) for along, left in (mine, its))
    middle = 0.5 * (low + high)
    ahead = middle[:, 0] >= 0.0
    rear, front = np.where(ahead, mine[0], its[0]), np.where(ahead, its[0], mine[0])
    # Two that both drive against the ego's axis are seen from the other end: who leads is then the one behind.
    swap = (rear < 0.0) & (front < 0.0)
    rear, front = np.where(swap, -front, rear), np.where(swap, -rear, front)
    side = np.where(middle[:, 1] >= 0.0, 1.0, -1.0)
    return free[:, 0], free[:, 1], rear, front, side * mine[1], side * its[1]
