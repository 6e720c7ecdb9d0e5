"""MPC of the lateral offset: a smooth way out of the lane, past an obstacle and back.

Horizon of N steps of equal length along the path; state l, l', l'' (offset and its derivatives by arc length), input
l''', constant over a step. Cost: distance to the wanted offset, curvature and its change; bounds on offset and
curvature; the plan ends in the lane. The QP is condensed to the N inputs and solved by daqp.
Source: Rawlings, Mayne, Diehl, Model Predictive Control (2017), sec. 1.3 and 8.2 (condensing); Arnstrom et al., A Dual
Active-Set Solver for Embedded Quadratic Programming, IEEE TAC 67 (2022). Valid for offsets well below the bend radius.
"""

from __future__ import annotations

import daqp
import numpy as np

from ads.control.spline import S
from machine_code import compiled
from vehicle.messages import FloatArray

N = 20  # steps of a plan; chosen, not measured
WEIGHT_OFFSET = 2.0  # 1/m^2
WEIGHT_SLOPE = 2.0  # chosen as its neighbours are; not measured
WEIGHT_CURVATURE = 2000.0  # m^2
WEIGHT_CHANGE = 4000.0  # m^4


class OffsetPlanner:
    """Solves for an offset over the next N steps. Works on scaled derivatives, so one set of matrices fits any step."""

    def __init__(self) -> None:
        a = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
        b = np.array([1.0 / 6.0, 0.5, 1.0])
        free = np.zeros((N, 3, 3))
        forced = np.zeros((N, 3, N))
        power, gains = np.eye(3), np.zeros((3, N))
        for k in range(N):
            gains = a @ gains
            gains[:, k] = b
            power = a @ power
            free[k], forced[k] = power, gains
        self._free = free
        self._l, self._d, self._c = (np.ascontiguousarray(forced[:, i, :]) for i in range(3))
        self._ll, self._dd, self._cc = (m.T @ m for m in (self._l, self._d, self._c))
        # rows: N offsets, N curvatures, then slope and curvature at the end
        self._rows = np.vstack((self._l, self._c, self._d[-1:], self._c[-1:]))
        self._sense = np.zeros(2 * N + 2, dtype=np.int32)

    def solve(
        self,
        start: tuple[float, float, float],
        step: float,
        wanted: FloatArray,
        low: FloatArray,
        high: FloatArray,
        largest_curvature: float,
    ) -> FloatArray | None:
        """Pieces (N, 4) of the plan: l, l', l'', l''' at the start of each step; None if no plan keeps the bounds.

        `start`: l [m], l' [-], l'' [1/m] now; `step` [m]; `wanted`, `low`, `high` (N,) [m] at the end of each step.
        """
        h = step
        x0 = np.array([start[0], start[1] * h, start[2] * h * h])
        free = self._free @ x0
        q, d = WEIGHT_OFFSET, WEIGHT_SLOPE / h**2
        c, u = WEIGHT_CURVATURE / h**4, WEIGHT_CHANGE / h**6
        hessian = q * self._ll + d * self._dd + c * self._cc + u * np.eye(N)
        gradient = q * self._l.T @ (free[:, 0] - wanted) + d * self._d.T @ free[:, 1] + c * self._c.T @ free[:, 2]
        bend = largest_curvature * h * h
        low, high = low.copy(), high.copy()
        low[-1] = high[-1] = 0.0
        lower = np.concatenate((low - free[:, 0], -bend - free[:, 2], -free[-1:, 1], -free[-1:, 2]))
        upper = np.concatenate((high - free[:, 0], bend - free[:, 2], -free[-1:, 1], -free[-1:, 2]))
        scale = 1.0 / u  # well-scaled inputs, whatever the step
        if np.any(lower > upper):
            return None
        inputs, _, flag, _ = daqp.solve(hessian * scale, gradient * scale, self._rows, upper, lower, self._sense)
        if flag < 1:
            return None
        states = np.vstack((x0, free[:-1] + np.stack((self._l, self._d, self._c), axis=1)[:-1] @ inputs))
        pieces = np.column_stack((states, inputs))
        pieces /= (1.0, h, h * h, h**3)
        result: FloatArray = np.ascontiguousarray(pieces)
        return result


@compiled
def offset_at(pieces: FloatArray, s_from: float, step: float, s: float) -> tuple[float, float, float]:
    """l [m], l' [-], l'' [1/m] of a plan at arc length `s` [m]; zero before its start and behind its end.

    `pieces` (n, 4): offset, slope, curvature and its rate at the start of each piece of length `step` [m] from
    `s_from`.
    """
    at = (s - s_from) / step
    n = len(pieces)
    if at < 0.0 or at >= n:
        return 0.0, 0.0, 0.0
    k = int(at)
    a = (at - k) * step
    o, d, c, u = pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3]
    return o + a * (d + a * (0.5 * c + a * u / 6.0)), d + a * (c + 0.5 * a * u), c + a * u


@compiled
def write_offsets(path: FloatArray, offsets: FloatArray, pieces: FloatArray, s_from: float, step: float) -> None:
    """Write a plan over `offsets` (n,) [m] of the points of `path`, from `s_from` [m] on; what lies before stays."""
    for i in range(len(path)):
        if path[i, S] >= s_from:
            offsets[i] = offset_at(pieces, s_from, step, path[i, S])[0]
