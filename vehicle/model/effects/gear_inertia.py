"""Inertia of an engine that turns faster in lower gears."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, SPEEDS_3_APART, ShownBy


@effect(
    name="gear_inertia",
    slot="force",
    physics="an engine must be sped up with the car; the lower the gear, the more mass it stands for",
    equation="m_add = share m min(1, (v1/v)^2): a gearbox keeps the engine near one speed, so its ratio goes with 1/v",
    source="T. D. Gillespie, Fundamentals of Vehicle Dynamics, ch. 2 (mass factor 1 + 0.04 + 0.0025 N^2 of a ratio N)",
    parameters=(
        Key("share", "-", 0.05, 0.6, neutral=0.0, least=0.03, minimum=0.0, meaning="mass added in the lowest gear"),
        Key("v1", "m/s", 2.0, 9.0, neutral=5.0, least=1.0, minimum=0.5, meaning="speed up to which that gear is used"),
    ),
    ties=("mass", "drive_gain", "power_limit", "drive_torque_limit"),
    reveals="equal steps of drive and brake command at 2, 5, 10 and 15 m/s",
    shown_by=ShownBy(92, (DRIVE, SPEED), (ACCELERATES, SPEEDS_3_APART)),
    diagnosed=Diagnosed(
        contains="mass",  # below v1 it is one
        seen_as=(("mass", "speed"), ("drive_gain", "speed")),
    ),
)
def gear_inertia(x: Bus, p: Any, m: Any) -> None:
    low = p.v1 / abs(x.vx) if abs(x.vx) > p.v1 else 1.0
    x.rotating_mass += p.share * x.mass_ref * low * low  # a load leaves the engine as it is
