"""Moment of inertia of motor and gear."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy


@effect(
    name="motor_inertia",
    slot="force",
    physics="turning parts must be accelerated too and act as additional mass",
    equation="m_add = J (i/r)^2",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 3.2 (rotating masses)",
    parameters=(
        Key("J", "kg m^2", 0.005, 1.0, neutral=0.0, least=0.005, minimum=0.0, meaning="inertia at the motor shaft"),
    ),
    ties=("mass", "drive_gain"),
    reveals="equal steps of drive and brake force",
    shown_by=ShownBy(90, (DRIVE, SPEED), (ACCELERATES,)),
    diagnosed=Diagnosed(needs="drive_train"),
)
def motor_inertia(x: Bus, p: Any, m: Any) -> None:
    ratio = x.gear_ratio / x.wheel_radius
    x.rotating_mass += p.J * ratio * ratio
