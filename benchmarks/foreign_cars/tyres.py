"""Forces of four tyres: slip with relaxation, a magic formula in the combined slip, load sensitivity.

Source of the form: H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 4 and 7; numbers are our choice.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from machine_code import compiled

FloatArray = NDArray[np.float64]

STIFFNESS, DAMPING = 220e3, 800.0  # N/m, N s/m: of a tyre under load
RELAXATION = (0.25, 0.45)  # m, along and across
LOAD_LOSS = 0.12  # of friction, at twice the usual load
SLOW, AT_REST = (
    2.0,
    0.04,
)  # m/s; s/m: below that speed slip follows the sliding itself, too, or a standing car would swing
MOST = 2.5  # slip


@compiled
def forces(centre: FloatArray, carrier: FloatArray, velocity: FloatArray, spin: FloatArray, slip: FloatArray,
           step: float, shape: FloatArray, force: FloatArray, torque: FloatArray) -> None:  # fmt: skip
    """Fill force [N] and torque [N m] (4, 3) about the wheel centres, and advance the slip states (4, 2).

    centre, velocity (4, 3) of the wheels in the world; carrier (4, 9) rotation matrices; spin (4,) [rad/s]; shape:
    wheel radius, friction, lateral stiffness and shape, longitudinal stiffness and shape, usual load.
    """
    radius, friction, by, cy, bx, cx, usual = shape
    for i in range(4):
        c, s = carrier[i, 0], carrier[i, 3]
        n = np.hypot(c, s)
        c, s = c / n, s / n
        load = max(STIFFNESS * (radius - centre[i, 2]) - DAMPING * velocity[i, 2], 0.0)
        ahead = velocity[i, 0] * c + velocity[i, 1] * s
        aside = velocity[i, 1] * c - velocity[i, 0] * s
        sliding, speed = spin[i] * radius - ahead, abs(ahead)
        slip[i, 0] = (slip[i, 0] + step * sliding / RELAXATION[0]) / (1.0 + step * speed / RELAXATION[0])
        slip[i, 1] = (slip[i, 1] - step * aside / RELAXATION[1]) / (1.0 + step * speed / RELAXATION[1])
        for k in range(2):
            slip[i, k] = min(max(slip[i, k], -MOST), MOST)
        along, across = slip[i, 0], slip[i, 1]
        if speed < SLOW:
            along += AT_REST * (SLOW - speed) * sliding
            across -= AT_REST * (SLOW - speed) * aside
        most = friction * (1.0 - LOAD_LOSS * (load / usual - 1.0)) * load
        both = np.hypot(bx * along, by * across) + 1e-9
        fx = most * np.sin(cx * np.arctan(both)) * bx * along / both
        fy = most * np.sin(cy * np.arctan(both)) * by * across / both
        force[i, 0], force[i, 1], force[i, 2] = fx * c - fy * s, fx * s + fy * c, load
        torque[i, 0], torque[i, 1], torque[i, 2] = centre[i, 2] * force[i, 1], -centre[i, 2] * force[i, 0], 0.0
