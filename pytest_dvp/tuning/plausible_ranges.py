"""What values a parameter of S may have on a real car, and which effects would show in it if the twin lacked them.

A tuner turns any knob that makes the error smaller. Arango et al. (Sensors 2026, 26, 1338) ended at 8500 kg for a car
of 730 kg; the guard holds each tuned value against this table.
"""

from __future__ import annotations

import dataclasses

from pytest_dvp.workers.errors import TuneError
from vehicle.model.effect_catalogue import catalogue


@dataclasses.dataclass(frozen=True, slots=True)
class Plausible:
    """Range of a parameter on the TABBY EVO, and why."""

    low: float
    high: float
    why: str


S_RANGES = {
    "EGO_mass": Plausible(
        650.0, 1100.0, "730 kg with batteries, and up to four people"
    ),
    "EGO_max_steer_angle": Plausible(
        18.0, 25.0, "+-20 deg by the data sheet"
    ),
    "EGO_dr_full_throttle": Plausible(
        0.0, 0.10, "friction of motor and gearbox: at most a tenth of 128 N m at top speed"
    ),
    "EGO_dr_zero_throttle": Plausible(
        0.0, 0.60, "recuperation, at most 0.6 of what the motor drives with"
    ),
    "EGO_moi": Plausible(
        0.0, 0.20, "rotor and gears of a 29.5 kW motor"
    ),
    "THROTTLE_delay": Plausible(0.0, 0.5, "bus and inverter"),
    "GNSS_x": Plausible(-1.52, 1.52, "the antenna is on the car, 3.03 m long"),
    "CAMERA_x": Plausible(-1.52, 1.52, "the camera is on the car, 3.03 m long"),
}  # fmt: skip
"""By name; parameters of software (the pedal controller) have no plausible range but their declared one."""

ACROSS = {"EGO_max_steer_angle": ("yaw", "yaw_rate", "ay", "steer")}
ALONG = ("v", "ax")
"""Channels in which a parameter of S shows; ALONG where ACROSS has none. What it stands in for is judged on these: an
error across the road that no such parameter touches would hide what it does along it."""


def stands_for(name: str) -> tuple[str, ...]:
    """Effects that "S.NAME" may stand in for, in the order in which they are tried: those that say it of themselves."""
    bare = name.removeprefix("S.")
    places = [
        (place, effect)
        for effect in catalogue().values()
        for hidden, place in effect.diagnosed.hides_in
        if hidden == bare
    ]
    return tuple(effect.name for _, effect in sorted(places, key=lambda pair: (pair[0], pair[1].name)))


def shows_in(name: str) -> tuple[str, ...]:
    """Channels in which "S.NAME" shows."""
    return ACROSS.get(name.removeprefix("S."), ALONG)


def of_s(name: str) -> tuple[float, float] | None:
    """Plausible range of "S.NAME", None if nothing is known."""
    found = S_RANGES.get(name.removeprefix("S."))
    return None if found is None or not name.startswith("S.") else (found.low, found.high)


def unit_of(name: str) -> str:
    """Unit of "P.NAME" or "S.NAME". Raises TuneError, or what P and S say of an unknown name."""
    from ads.parameters import declaration
    from vehicle.model.simulator_parameters import S_PARAMETERS, check_s

    group, dot, rest = name.partition(".")
    if not dot or group not in ("P", "S"):
        raise TuneError(f"{name!r}: expected P.NAME or S.NAME")
    if group == "P":
        return declaration(rest).unit
    check_s({rest: 1.0} if rest not in {p.name for p in S_PARAMETERS} else {})
    return next(p.declaration.unit for p in S_PARAMETERS if p.name == rest)
