"""Pitch of the body under the accelerometer."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES_WELL, SPEED, ShownBy


@effect(
    name="pitch",
    slot="sensor",
    order=40,
    physics="squat and dive tip the accelerometer, gravity adds to what it shows",
    equation="ax_measured = (1 + k) ax",
    source="T. D. Gillespie, Fundamentals of Vehicle Dynamics, pitch in proportion to ax",
    parameters=(Key("gain", "-", 0.0, 0.3, neutral=0.0, least=0.01, minimum=-0.9, maximum=5.0, meaning="share added"),),
    ties=("drive_gain",),
    reveals="acceleration and brake steps with speeds logged",
    shown_by=ShownBy(460, (("ax",), SPEED), (ACCELERATES_WELL,)),
)
def pitch(x: Bus, p: Any, m: Any) -> None:
    x.meas_ax *= 1.0 + p.gain
