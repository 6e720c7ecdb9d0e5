"""Steering by a linear-quadratic regulator whose gains are tabled over speed.

Kinematic error model at the rear axle, sampled at DT: e' = v th, th' = v/L (delta - delta_ff), with e the lateral
error [m], th the heading error [rad]. Cost: q11 e^2 + q22 th^2 + r11 (v/V_0)^4 delta^2 above V_0, that is, at speed the
effort is priced by the lateral acceleration it causes, which keeps the bandwidth where tyres and actuators can follow.
Source: Rajamani, Vehicle Dynamics and Control (2012), sec. 2.5-3.1. The Riccati equation is iterated until it stands.
"""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray

DT = 0.05  # s
V_0 = 8.0  # m/s
V_STEP = 0.5  # m/s between table rows
V_TOP = 50.0  # m/s
INTEGRAL_TIME = 4.0  # s
INTEGRAL_LIMIT = 0.03  # rad
LARGEST_ERROR = 2.0  # m; beyond it the car aims at the path at a constant angle


@compiled
def riccati_gain(v: float, wheelbase: float, q11: float, q22: float, r11: float) -> tuple[float, float]:
    """Gains [rad/m, rad/rad] at speed `v` [m/s] > 0 for weights q11, q22 >= 0, r11 > 0."""
    a = v * DT
    b1, b2 = 0.5 * a * a / wheelbase, a / wheelbase
    r = r11 * max(1.0, v / V_0) ** 4
    p11, p12, p22 = q11, 0.0, q22
    k1 = k2 = 0.0
    for _ in range(20_000):
        # P B, B' P B, B' P A of the 2 x 2 system
        pb1, pb2 = p11 * b1 + p12 * b2, p12 * b1 + p22 * b2
        s = r + b1 * pb1 + b2 * pb2
        n1, n2 = pb1 / s, (pb1 * a + pb2) / s
        m11 = p11
        m12 = p11 * a + p12
        m22 = p11 * a * a + 2.0 * p12 * a + p22
        p11 = q11 + m11 - s * n1 * n1
        p12 = m12 - s * n1 * n2
        p22 = q22 + m22 - s * n2 * n2
        done = abs(n1 - k1) <= 1e-10 * (1e-6 + abs(n1)) and abs(n2 - k2) <= 1e-10 * (1e-6 + abs(n2))
        k1, k2 = n1, n2
        if done:
            break
    return k1, k2


@compiled
def gain_table(wheelbase: float, q11: float, q22: float, r11: float) -> FloatArray:
    """Gains (n, 2) at V_STEP, 2 V_STEP, ... V_TOP [m/s]."""
    n = int(V_TOP / V_STEP)
    table = np.zeros((n, 2))
    for i in range(n):
        table[i, 0], table[i, 1] = riccati_gain((i + 1) * V_STEP, wheelbase, q11, q22, r11)
    return table


@compiled
def steer_law(
    table: FloatArray, wheelbase: float, v: float, lateral: float, heading: float, curvature: float, integral: float
) -> tuple[float, float]:
    """Road-wheel angle [rad] for the errors at the predicted pose, and the new integral [rad].

    `table` (n, 2) from gain_table. The integral takes out what the kinematic model lacks
    (understeer, side slip, an offset of the steering).
    """
    at = min(max(v / V_STEP - 1.0, 0.0), len(table) - 1.001)
    i = int(at)
    r = at - i
    k1 = table[i, 0] + r * (table[i + 1, 0] - table[i, 0])
    k2 = table[i, 1] + r * (table[i + 1, 1] - table[i, 1])
    e = min(max(lateral, -LARGEST_ERROR), LARGEST_ERROR)
    if v > 1.0 and abs(lateral) < 0.6:
        integral -= k1 * e * DT / INTEGRAL_TIME
        integral = min(max(integral, -INTEGRAL_LIMIT), INTEGRAL_LIMIT)
    return math.atan(wheelbase * curvature) - k1 * e - k2 * heading + integral, integral
