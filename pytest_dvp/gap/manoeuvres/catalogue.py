"""The manoeuvres that a test driver or a robot knows, with the standards that describe them."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Callable, Iterable

from pytest_dvp.gap.manoeuvres import circle_manoeuvres, pedal_manoeuvres, steering_manoeuvres
from pytest_dvp.gap.manoeuvres.simulated_driver import Driver, Driving


@dataclasses.dataclass(frozen=True, slots=True)
class Manoeuvre:
    """name: of files; title: for people; source: the standard it follows in kind (sizes are those of the envelope);
    drive: what the driver does; round_about: it needs the ground's middle, not a straight."""

    name: str
    title: str
    source: str
    drive: Callable[[Driver], Driving]
    round_about: bool = False

    @property
    def what(self) -> str:
        """One line of what is driven."""
        return (self.drive.__doc__ or "").split("\n")[0]


MANOEUVRES: tuple[Manoeuvre, ...] = (
    Manoeuvre("step_steer", "Step steer", "ISO 7401", steering_manoeuvres.step_steer),
    Manoeuvre("growing_steps", "Steering steps of growing size", "ISO 7401", steering_manoeuvres.growing_steps),
    Manoeuvre("full_lock", "Full-lock turns", "", steering_manoeuvres.full_lock),
    Manoeuvre("slow_ramp", "Slowly increasing steer", "ISO 4138, constant speed", steering_manoeuvres.slow_ramp),
    Manoeuvre("sine_sweep", "Sine sweep", "ISO 7401, continuous sinusoidal input", steering_manoeuvres.sine_sweep),
    Manoeuvre("sine_with_dwell", "Sine with dwell", "ISO 19365", steering_manoeuvres.sine_with_dwell),
    Manoeuvre("slalom", "Slalom by the clock", "ISO 13674-1 in kind", steering_manoeuvres.slalom),
    Manoeuvre("small_steer", "On-centre weave", "ISO 13674-1", steering_manoeuvres.small_steer),
    Manoeuvre("small_steps", "Stairs of small steering steps", "ISO 13674-2 in kind", steering_manoeuvres.small_steps),
    Manoeuvre("circles_left", "Steady circles to the left", "ISO 4138, constant steering angle",
              circle_manoeuvres.circles_left, True),
    Manoeuvre("circles_both", "Steady circles to both sides", "ISO 4138, constant steering angle",
              circle_manoeuvres.circles_both, True),
    Manoeuvre("figure_eight", "Figure of eight at walking speed", "", circle_manoeuvres.tight_circles, True),
    Manoeuvre("coast_down", "Coast down, both directions", "SAE J1263, ISO 10521-1", pedal_manoeuvres.coast_down),
    Manoeuvre("full_throttle", "Full acceleration from standstill", "ISO 8714 in kind", pedal_manoeuvres.full_throttle),
    Manoeuvre("brake_steps", "Brake steps of growing size", "ISO 21994 in kind", pedal_manoeuvres.brake_steps),
    Manoeuvre("brake_ramps", "Brake ramps to a standstill", "ISO 21994 in kind", pedal_manoeuvres.brake_ramps),
    Manoeuvre("pedal_steps", "Throttle and brake on and off", "", pedal_manoeuvres.pedal_steps),
    Manoeuvre("held_steps", "Pedal steps held for two seconds", "", pedal_manoeuvres.held_steps),
    Manoeuvre("small_pedal", "Small pedal steps", "", pedal_manoeuvres.small_pedal),
    Manoeuvre("lift_offs", "Lift-offs from several speeds", "", pedal_manoeuvres.lift_offs),
    Manoeuvre("both_directions", "Straights in both directions", "SAE J1263 in kind", pedal_manoeuvres.both_directions),
    Manoeuvre("standing_starts", "Standstill and starts", "", pedal_manoeuvres.standing_starts),
)  # fmt: skip
"""Everything that can be advised."""

CITY = Manoeuvre("city", "About town", "", pedal_manoeuvres.city)
"""What a usual log holds; never advised, but the drive on which rivals without a value are made alike."""


def chosen(names: Iterable[str]) -> tuple[Manoeuvre, ...]:
    """The manoeuvres of these names, in the order of the catalogue. Raises ValueError with the nearest name."""
    known = {m.name: m for m in MANOEUVRES}
    wanted = set(names)
    for name in sorted(wanted - set(known)):
        near = difflib.get_close_matches(name, known, n=1)
        hint = f", did you mean {near[0]!r}?" if near else f"; there are {', '.join(known)}"
        raise ValueError(f"no manoeuvre called {name!r}{hint}")
    return tuple(m for m in MANOEUVRES if m.name in wanted)
