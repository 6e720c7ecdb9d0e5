"""Where the lateral accelerometer is, fitted along: logs seldom say it, and a wrong place looks like a filter.

Effects are tried with the accelerometer at the rear axle and at the centre of gravity (`candidates`). It may be
anywhere between the bumpers. Of a car of 1:10 with slipping tyres that had it a third of the wheelbase ahead of the
rear axle, an accelerometer filter of 0.03 s was confirmed that is none.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.candidates import Point
    from pytest_dvp.gap.diagnose.fitting import Fitting
    from pytest_dvp.gap.diagnose.trial import Trial

PLACE = ("parameters", "ay_x")
BEHIND, AHEAD = -0.4, 1.4  # wheelbases from the rear axle: the bumpers of usual cars; chosen
_REACH = 0.02  # wheelbases: a step by which its derivative is taken; the reading is linear in the place


def placed(search: Fitting, now: Trial, worth: float) -> Trial:
    """The set with the accelerometer where it fits best, refitted, if that takes `worth` of max(1, chi^2/N) away.

    As it is where the model says the place, where no tyre slips (there the turning is that of the path), and where no
    lateral acceleration is measured.
    """
    if not any(search.known[name].effect.tyres for name in now.names) or "ay" not in search.target.channels:
        return now
    model = search.target.experiments[0].model
    if model.car.ay_x != 0.0:
        return now
    at, reach = now.values.get(PLACE, 0.0), _REACH * model.car.wheelbase
    slope = (search.target.whitened(now.values | {PLACE: at + reach}) - now.fit.residual) / reach
    basis = orthonormal(now.fit.jacobian)  # all values adapt to first order
    shadow, rest = row_products(basis, slope), row_products(basis, now.fit.residual)
    size = square(slope) - square(shadow)
    pull = float(np.dot(slope, now.fit.residual) - np.dot(shadow, rest))
    least = worth * max(float(search.count), now.chi2)
    if size <= 0.0 or pull * pull <= least * size:
        return now
    place = float(np.clip(at - pull / size, BEHIND * model.car.wheelbase, AHEAD * model.car.wheelbase))
    other = search.trial(now.names, now.values | {PLACE: place}, like=now)
    return other if now.chi2 - other.chi2 > least else now


def points_there(now: Trial, points: Iterable[Point]) -> list[Point]:
    """The points of an effect; without their places of the accelerometer if the set has one that was fitted."""
    points = list(points)
    if PLACE not in now.values or now.values[PLACE] in {point.get(PLACE) for point in points}:
        return points
    bare = [{key: value for key, value in point.items() if key != PLACE} for point in points]
    return [point for k, point in enumerate(bare) if point not in bare[:k]]
