"""Where a drive left the envelope."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.car import Car

SPAN = 5  # rows over which an acceleration is taken: 0.1 s at 50 Hz
_SLACK = 1e-6  # of rounding


def violations(t: FloatArray, motion: FloatArray, steer: FloatArray, envelope: Envelope, area: Area,
               car: Car) -> tuple[str, ...]:  # fmt: skip
    """What a drive exceeded, in words; empty if it kept within the envelope.

    t (n,) [s], evenly spaced; motion (n, 5): x, y [m] of the rear axle, yaw [rad], v [m/s], yaw rate [rad/s], as they
    were, not as sensors show them; steer (n,) asked for [rad].
    """
    x, y, yaw, v, rate = motion.T
    along = (v[SPAN:] - v[:-SPAN]) / (t[SPAN:] - t[:-SPAN])
    told = []
    for what, found, limit, unit in (
        ("speed", np.max(np.abs(v)), envelope.max_speed, "m/s"),
        ("acceleration", np.max(along, initial=0.0), envelope.max_acceleration, "m/s^2"),
        ("deceleration", -np.min(along, initial=0.0), envelope.max_deceleration, "m/s^2"),
        ("lateral acceleration", np.max(np.abs(v * rate)), envelope.max_lateral, "m/s^2"),
        ("steering", np.max(np.abs(steer)), envelope.max_steer, "rad"),
    ):
        if not found <= limit * (1.0 + _SLACK):
            told.append(f"{what} {found:.3g}, at most {limit:g} {unit}")
    ahead, behind, side = car.center_x + 0.5 * car.length, car.center_x - 0.5 * car.length, 0.5 * car.width
    out = 0.0
    for u, w in ((ahead, side), (ahead, -side), (behind, side), (behind, -side)):
        px, py = x + u * np.cos(yaw) - w * np.sin(yaw), y + u * np.sin(yaw) + w * np.cos(yaw)
        out = max(out, float(np.max([area.x_min - px, px - area.x_max, area.y_min - py, py - area.y_max])))
    if out > _SLACK:
        told.append(f"the area of {envelope.length:g} x {envelope.width:g} m, by {out:.2g} m")
    return tuple(told)
