"""Braking without pedal."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, SPEED, ShownBy

RELEASED = 0.05  # m/s^2, commands below count as a released pedal


@effect(
    name="lift_off_braking",
    slot="command",
    order=85,  # after dead time and gains, before a lag smears the lift-off
    physics="with the pedal released, regeneration or engine drag slows the car",
    equation="a = -a_r while abs(a_c) < 0.05 m/s^2, -braking a_r while a_c < -0.05 m/s^2, when moving",
    source="L. Guzzella, A. Sciarretta, Vehicle Propulsion Systems, 3rd ed. (coasting)",
    parameters=(
        Key("a", "m/s^2", 0.2, 1.0, neutral=0.0, least=0.05, minimum=0.0, meaning="deceleration at released pedal"),
        Key(
            "braking",
            "-",
            0.0,
            1.0,
            neutral=0.0,
            least=0.1,
            minimum=0.0,
            maximum=1.0,
            meaning="share of it that adds to a braking command; 0 where the brakes allow for it",
        ),
    ),
    ties=(
        "rolling_resistance",
        "motor_damping",
        "pedal_deadband",
    ),
    reveals="lift-off from several speeds, held for 3 s",
    shown_by=ShownBy(160, (DRIVE, SPEED), (("coasting", 2.0, "2 s of coasting (command about zero)"),)),
    diagnosed=Diagnosed(hides_in=(("EGO_dr_zero_throttle", 10),)),
)
def lift_off_braking(x: Bus, p: Any, m: Any) -> None:
    if abs(x.accel) < RELEASED:
        x.resistance += p.a * x.mass_ref
    elif x.accel < 0.0:
        x.resistance += p.braking * p.a * x.mass_ref
