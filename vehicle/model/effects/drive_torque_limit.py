"""Torque limit of the drive."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, ACCELERATES_WELL, DRIVE, SPEED, ShownBy


@effect(
    name="drive_torque_limit",
    slot="actuator",
    order=72,  # after lag and controllers, as brake_limit
    physics="the motor or its controller gives no more than its greatest torque, at any speed",
    equation="a <= limit: traction <= limit m",
    source="L. Guzzella, A. Sciarretta, Vehicle Propulsion Systems, 3rd ed. (range of constant torque)",
    parameters=(
        Key(
            "limit",
            "m/s^2",
            0.8,
            6.0,
            neutral=inf,
            least=0.1,
            minimum=0.0,
            meaning="greatest drive force over mass, before turning parts take their share",
        ),
    ),
    ties=(
        "drive_gain",
        "power_limit",
    ),
    reveals="acceleration steps of growing size at 2 and at 8 m/s",
    shown_by=ShownBy(138, (DRIVE, SPEED), (ACCELERATES,), usual=(ACCELERATES_WELL,)),
    diagnosed=Diagnosed(seen_as=(("drive_gain", "acceleration"),), by_gear=True),
)
def drive_torque_limit(x: Bus, p: Any, m: Any) -> None:
    if x.accel + abs(x.accel_lead) > p.limit:
        start = min(x.accel + x.accel_lead, p.limit)
        x.accel = 0.5 * (start + min(x.accel - x.accel_lead, p.limit))
        x.accel_lead = start - x.accel
