"""Yaw rate and sideslip of a car on tyres, driven by measured speed and commanded steering."""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.gap.diagnose.regression_signals import Signals
from pytest_dvp.logs.log_contents import FloatArray

RIGID = 0.0021  # rad s^2/m, slip angle over lateral acceleration of an axle that hardly slips
_SLOW = 1.0  # m/s, below which tyres roll without slip
_SUBSTEPS = 2  # of one sample; chosen for logs of 50 Hz, and the steps are implicit, so that slower logs stay stable


def on_tyres(s: Signals, front: float, rear: float, *, limit: float = np.inf,
             length: float = 0.0) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Yaw rate (n,) [rad/s] and sideways speed (n,) [m/s] of the rear axle.

    front, rear: slip angle over lateral acceleration [rad s^2/m] of each axle; limit [m/s^2] at which its lateral force
    levels off; length [m] over which it builds up. Linear single-track car, implicit steps of half a sample.
    Source: Mitschke, Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 20.
    """
    assert s.steer is not None
    return _track(s.v, s.steer, s.step, s.wheelbase, s.cg_front, s.gyration, front, rear, limit, length)


@compiled
def _track(v: FloatArray, steer: FloatArray, step: float, wheelbase: float, a: float, gyration: float, front: float,
           rear: float, limit: float, length: float) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    b = wheelbase - a
    rate, side = np.empty_like(v), np.empty_like(v)
    stiff_front, stiff_rear = b / wheelbase / front, a / wheelbase / rear  # m/s^2 per rad
    most_front, most_rear = limit * b / wheelbase, limit * a / wheelbase
    h = step / _SUBSTEPS
    r = v[0] * steer[0] / wheelbase
    w = b * r  # sideways speed of the centre of gravity
    f = 0.0
    g = 0.0
    for i in range(len(v)):
        rate[i], side[i] = r, w - b * r
        speed, d = v[i], steer[i]
        if speed < _SLOW:
            r = speed * np.tan(d) / wheelbase
            w = b * r
            f, g = speed * r * b / wheelbase, speed * r * a / wheelbase
            rate[i], side[i] = r, 0.0
            continue
        for _ in range(_SUBSTEPS):
            # forces f = k (slip), with the secant stiffness of where they are now
            slip_front, slip_rear = d - (w + a * r) / speed, -(w - b * r) / speed
            kf = stiff_front / np.sqrt(1.0 + (stiff_front * slip_front / most_front) ** 2)
            kr = stiff_rear / np.sqrt(1.0 + (stiff_rear * slip_rear / most_rear) ** 2)
            share = 1.0 - np.exp(-speed * h / length) if length > 0.0 else 1.0
            # f' = f + share (k slip' - f), slip' at the end of the step
            cf, cr = share * kf / speed, share * kr / speed
            m11 = 1.0 + h * (cf + cr)
            m12 = h * (cf * a - cr * b + speed)
            m21 = h * (a * cf - b * cr) / gyration
            m22 = 1.0 + h * (a * a * cf + b * b * cr) / gyration
            known_front, known_rear = (1.0 - share) * f + share * kf * d, (1.0 - share) * g
            y1 = w + h * (known_front + known_rear)
            y2 = r + h * (a * known_front - b * known_rear) / gyration
            det = m11 * m22 - m12 * m21
            w, r = (y1 * m22 - m12 * y2) / det, (m11 * y2 - m21 * y1) / det
            f = known_front - cf * (w + a * r)
            g = known_rear - cr * (w - b * r)
    return rate, side
