"""Braking without pedal."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import lag

RELEASED = 0.05  # m/s^2, commands below count as a released pedal
MIDDLE = 10.0  # m/s at which `a` holds, in the middle of the speeds of town; what grows with speed turns about it


@effect(
    name="lift_off_braking",
    slot="command",
    order=85,  # after dead time and gains, before the brakes' lag: what the motor does already, the brakes need not
    physics="with the pedal released, regeneration or engine drag slows the car",
    equation="a_r = (a + rise (v - 10 m/s)) min(1, v/fade), late by lag; a = a_c - s a_r, s = 1 for abs(a_c) < 0.05 "
    "m/s^2, falling straight to 0 at a_c = 0.05 m/s^2 + blend; while a_c < -0.05 m/s^2 the brakes add what is missing "
    "to a_c - braking a_r, or the drive takes off its share `drive` of what is too much; when moving",
    source="L. Guzzella, A. Sciarretta, Vehicle Propulsion Systems, 3rd ed. (coasting); J. B. Heywood, Internal "
    "Combustion Engine Fundamentals, ch. 13 (friction grows with engine speed)",
    parameters=(
        Key("a", "m/s^2", 0.2, 1.0, neutral=0.0, least=0.05, minimum=0.0,
            meaning="deceleration at released pedal, at 10 m/s"),
        Key("braking", "-", 0.0, 1.0, neutral=0.0, least=0.1, minimum=0.0, maximum=1.0,
            meaning="share of it that adds to a braking command; 0 where the brakes allow for it"),
        Key("rise", "1/s", -0.03, 0.06, neutral=0.0, least=0.005, minimum=-0.03, maximum=0.06, late=True,
            meaning="growth of it with speed: an engine's friction grows, a motor's power is limited"),
        Key("fade", "m/s", 0.0, 5.0, neutral=0.0, least=0.5, minimum=0.0, maximum=5.0, late=True, step=1.0,
            meaning="speed below which it fades: a motor cannot regenerate, an engine idles"),
        Key("lag", "s", 0.0, 0.6, neutral=0.0, least=0.03, minimum=0.0, maximum=0.6, late=True,
            meaning="time constant with which it comes and goes"),
        Key("drive", "-", 0.0, 1.0, neutral=1.0, least=0.1, minimum=0.0, maximum=1.0, late=True,
            meaning="share that the drive takes off where less is asked for; 0 where the motor brakes all the same"),
        Key("blend", "m/s^2", 0.0, 0.6, neutral=0.0, least=0.05, minimum=0.0, maximum=2.0, late=True, step=0.2,
            meaning="range of the asked acceleration in which it grows to its full size; 0: all at once"),
    ),
    memory=(Memory("a"),),
    ties=(
        "rolling_resistance",
        "motor_damping",
        "pedal_deadband",
    ),
    reveals="lift-off from several speeds, held for 3 s",
    shown_by=ShownBy(160, (DRIVE, SPEED), (("coasting", 2.0, "2 s of coasting (command about zero)"),)),
    diagnosed=Diagnosed(hides_in=(("EGO_dr_zero_throttle", 10),)),
)  # fmt: skip
def lift_off_braking(x: Bus, p: Any, m: Any) -> None:
    drag = 0.0
    if x.accel < RELEASED + p.blend:
        speed = abs(x.vx)
        drag = max(p.a + p.rise * (speed - MIDDLE), 0.0)
        if speed < p.fade:
            drag *= speed / p.fade
        if x.accel >= RELEASED:
            drag *= 1.0 - (x.accel - RELEASED) / p.blend
    start, mean = m.a, drag
    if p.lag > 0.0:
        mean, m.a = lag(start, drag, 0.0, p.lag, x.dt)
    else:
        start = m.a = drag
    x.resistance += mean * x.mass_ref
    x.drive_drag += mean * x.mass_ref
    if x.accel <= -RELEASED:  # the brakes take off what they allow for
        relief = 1.0 - p.braking
        first, now = x.accel + x.accel_lead + relief * start, x.accel + relief * mean
        x.accel = now if now < 0.0 else p.drive * now
        x.accel_lead = (first if first < 0.0 else max(p.drive * first, first - relief * start)) - x.accel
