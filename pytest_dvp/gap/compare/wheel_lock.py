"""Where wheels lock or spin: their speed leaves that of the car over the ground, faster than a car can.

A late or scaled speed differs from the way over ground, too, but no more quickly than the car speeds up or slows down;
a wheel without grip weighs a hundredth of the car and stops in a tenth of a second.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import FloatArray

BoolArray: TypeAlias = NDArray[np.bool_]

SLIP = 0.1  # of the speed over ground: tyres have their greatest force at a slip of 0.08 to 0.15 (H. Pacejka, Tyre and
# Vehicle Dynamics, ch. 1.2.1); of two wheels whose mean is logged one may slip by twice that
LEAST = 0.5  # m/s, by which they must differ as well: an antenna off the axle shows less in a bend driven slowly
NO_CAR = 12.0  # m/s^2, 1.2 g: no road car changes its speed so fast by its tyres
_SPAN = 0.1  # s, over which the change of the speed is taken
_HELD = 0.25  # s for which a slow channel in a fast file repeats a value, at most; what stays longer stands. Chosen
_REACH = 0.2  # s around slip in which the wheels must have stopped or run up


def locked(t: FloatArray, v: FloatArray, ground: FloatArray, known: BoolArray) -> BoolArray:
    """Rows (n,) in which wheels lock or spin. t (n,) [s]; v, ground (n,) [m/s] speeds of the wheels and over ground;
    known (n,): rows in which both were measured."""
    n = len(t)
    v_seen = _unheld(t, v)
    ahead = np.minimum(np.searchsorted(t, t + 0.5 * _SPAN), n - 1)
    behind = np.maximum(np.searchsorted(t, t - 0.5 * _SPAN, side="right") - 1, 0)
    change = (v_seen[ahead] - v_seen[behind]) / np.maximum(t[ahead] - t[behind], _SPAN)
    quick = t[(np.abs(change) > NO_CAR) & known]
    off = np.abs(v - ground)
    slips = np.asarray((off > SLIP * np.abs(ground)) & (off > LEAST) & known)
    found = np.zeros(n, dtype=np.bool_)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], slips.astype(np.int8), [0]]))).reshape(-1, 2)
    for first, end in edges:
        low, high = np.searchsorted(quick, [t[first] - _REACH, t[end - 1] + _REACH])
        found[first:end] = high > low
    return found


def _unheld(t: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """The speed v (n,) [m/s] at t (n,) [s] by straight lines between its samples, each of which a file may hold for
    several rows: the steps between those are no jerks of a wheel."""
    new = np.concatenate([[True], np.diff(v) != 0.0])[: len(v)]
    starts = np.append(np.flatnonzero(new), len(v))
    run = np.cumsum(new) - 1
    since, until = t[starts[run]], np.append(t, np.inf)[starts[run + 1]]
    seen = new | ((t - since > _HELD) & (until - t > _HELD))
    return np.asarray(np.interp(t, t[seen], v[seen]))
