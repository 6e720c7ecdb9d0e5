"""Dead band of the pedals."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, SPEED, ShownBy


@effect(
    name="pedal_deadband",
    slot="command",
    order=50,
    physics="small pedal travel asks for nothing",
    equation="a = 0 while abs(a_c) < d",
    source="G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities",
    parameters=(
        Key("width", "m/s^2", 0.05, 0.5, neutral=0.0, least=0.02, minimum=0.0, meaning="half width of the band"),
    ),
    ties=(
        "aero_drag",
        "steer_backlash",
        "lift_off_braking",
    ),
    reveals="small steps of the acceleration command around nought, both signs",
    shown_by=ShownBy(150, (DRIVE, SPEED), (("small_commands", 1.0, "1 s of small commands while moving"),)),
)
def pedal_deadband(x: Bus, p: Any, m: Any) -> None:
    if abs(x.accel) < p.width:
        x.accel = x.accel_lead = 0.0
