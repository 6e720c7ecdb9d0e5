"""Push of an idling automatic gearbox."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import BRAKES, DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import clip


@effect(
    name="creep",
    slot="command",
    order=86,  # after the drag of the released pedal: at walking pace the idling engine pushes in its place
    physics="with the pedal released, a torque converter, a slipping clutch or the motor's controller pushes the car",
    equation="a_k = a (1 - v/v0) for v < v0, not above a, else 0; a = max(a_c, a_k) for a_c >= 0; a = a_c + "
    "braking a_k for a_c < 0 (the brakes have to hold against it)",
    source="L. Guzzella, A. Sciarretta, Vehicle Propulsion Systems, 3rd ed., ch. 3 (torque converters)",
    parameters=(
        Key("a", "m/s^2", 0.1, 1.0, neutral=0.0, least=0.05, minimum=0.0, meaning="acceleration at standstill"),
        Key("v0", "m/s", 1.0, 6.0, neutral=2.0, least=0.5, minimum=0.2, meaning="speed at which it ends"),
        Key("braking", "-", 0.0, 1.0, neutral=1.0, least=0.1, minimum=0.0, maximum=1.0,
            meaning="share that is left while the brakes act; 0 where the clutch opens"),
    ),
    ties=("lift_off_braking", "brake_gain", "rolling_resistance"),
    reveals="gentle stops to standstill, and rolling with both pedals released",
    shown_by=ShownBy(165, (DRIVE, SPEED), (BRAKES,)),
)  # fmt: skip
def creep(x: Bus, p: Any, m: Any) -> None:
    push = p.a * clip(1.0 - x.vx / p.v0, 0.0, 1.0)  # of a car that rolls back: what it is at standstill
    start = x.accel + x.accel_lead
    x.accel = x.accel + p.braking * push if x.accel < 0.0 else max(x.accel, push)
    x.accel_lead = (start + p.braking * push if start < 0.0 else max(start, push)) - x.accel
