"""A stack that takes time, in simulated time: its commands reach the car later, and some never.

    --compute-delay 0.08                  every command 80 ms after its tick
    --compute-delay 0.08+-0.03            50 to 110 ms, each evenly likely, drawn anew for each command
    --compute-delay 0.08+-0.03,drop=0.05  and 5 of 100 commands are lost

Commands keep their order: one that would overtake the one before it arrives together with it, and the newer one holds.
A lost command is lost on its way, as in middleware: the stack is asked in that cycle as in any other, and the car keeps
the last command that it got. Before the first one arrives it rolls, as after `reset`. The draws come from the seed of
the run, two for each tick whatever is asked for, so that the same seed gives the same bytes.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections import deque
from collections.abc import Callable

import numpy as np

from pytest_dvp.text.errors import SettingError
from vehicle.adapter import Vehicle
from vehicle.messages import Command, FloatArray, Observation, Surroundings, VehicleDescription, VehicleState

STREAM = 0xDE1A  # tells these draws from those of the sensors, which begin with the same seed
LONGEST = 10.0  # s
MS = 1000  # steps of the car in a second: an arrival is at one of them
ALLOWED = f"SECONDS[+-JITTER][,drop=SHARE], as 0.08, 0.08+-0.03 or 0.08+-0.03,drop=0.05; 0 to {LONGEST:g} s, 0 to 1"
_FORM = re.compile(r"([^,+]+?)(?:\+-([^,]+))?(?:,\s*drop=([^,]+))?")


@dataclasses.dataclass(frozen=True)
class ComputeDelay:
    """Seconds from tick to car, and by how much it varies to either side [s]; share of commands that are lost."""

    seconds: float
    jitter: float = 0.0
    drop: float = 0.0

    def __str__(self) -> str:
        varied = f"+-{self.jitter!r}" if self.jitter else ""
        return f"{self.seconds!r}{varied}" + (f",drop={self.drop!r}" if self.drop else "")


def parse_delay(text: str, origin: str = "--compute-delay") -> ComputeDelay:
    """Read what the option says. Raises SettingError with what is allowed."""
    match = _FORM.fullmatch(text.strip().replace("±", "+-"))
    if match is None:
        raise SettingError(f"{origin} is {text!r}, expected {ALLOWED}")
    seconds, jitter, drop = (0.0 if part is None else _number(part, text, origin) for part in match.groups())
    if not 0.0 <= seconds <= LONGEST:
        raise SettingError(f"{origin} is {text!r}: {seconds:g} s, expected 0 to {LONGEST:g} s")
    if not 0.0 <= jitter <= seconds:
        raise SettingError(f"{origin} is {text!r}: a jitter of {jitter:g} s, expected 0 to {seconds:g} s, the delay")
    if not 0.0 <= drop <= 1.0:
        raise SettingError(f"{origin} is {text!r}: drop={drop:g}, expected a share from 0 to 1")
    return ComputeDelay(seconds, jitter, drop)


class Delayed:
    """A simulated vehicle that hears of its commands late. `record` gets time [s] and command of each arrival."""

    def __init__(
        self, vehicle: Vehicle, delay: ComputeDelay, seed: int, record: Callable[[float, Command], None]
    ) -> None:
        self._vehicle, self._delay, self._record = vehicle, delay, record
        self._draws = np.random.default_rng([STREAM, seed])
        self._now = 0  # ms
        self._last = 0  # ms, the latest arrival so far
        self._under_way: deque[tuple[int, Command]] = deque()

    @property
    def description(self) -> VehicleDescription:
        """The vehicle's."""
        return self._vehicle.description

    @property
    def is_real(self) -> bool:
        """The vehicle's."""
        return self._vehicle.is_real

    def reset(self, state: VehicleState) -> None:
        """Reset the vehicle; nothing is under way to it."""
        self._vehicle.reset(state)
        self._under_way.clear()

    def place_on_road(self, z: float, grade: float = 0.0, bank: float = 0.0) -> None:
        """As of the vehicle, if it is one that must be told."""
        place = getattr(self._vehicle, "place_on_road", None)
        if place is not None:
            place(z, grade, bank)

    def limit_friction(self, friction: float | None) -> None:
        """As of the vehicle, if it is one that must be told."""
        limit = getattr(self._vehicle, "limit_friction", None)
        if limit is not None:
            limit(friction)

    def blow(self, x: float, y: float) -> None:
        """As of the vehicle, if it is one that must be told [m/s]."""
        blow = getattr(self._vehicle, "blow", None)
        if blow is not None:
            blow(x, y)

    def observe(self, surroundings: Surroundings) -> Observation:
        """The vehicle's sensors."""
        return self._vehicle.observe(surroundings)

    def apply(self, command: Command) -> None:
        """Send a command on its way."""
        varied, lost = self._draws.random(2).tolist()
        if lost >= self._delay.drop:
            late = self._delay.seconds + self._delay.jitter * (2.0 * varied - 1.0)
            self._last = max(self._last, self._now + round(MS * late))
            self._under_way.append((self._last, command))

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s] pass, a multiple of 1 ms; each command takes hold when it arrives.

        Returns the rows (n, 12) of TRACE_COLUMNS that the vehicle returned.
        """
        end = self._now + round(MS * dt)
        rows = []
        while self._now < end:
            self._arrive()
            until = min(self._under_way[0][0], end) if self._under_way else end
            rows.append(self._vehicle.step((until - self._now) / MS))
            self._now = until
        return np.concatenate(rows)

    def stop(self) -> None:
        """The vehicle's own; nothing that is under way counts after it."""
        self._under_way.clear()
        self._vehicle.stop()

    def close(self) -> None:
        """Free the vehicle."""
        self._vehicle.close()

    def _arrive(self) -> None:
        """Hand over what has arrived by now: of several at one instant the newest."""
        newest = None
        while self._under_way and self._under_way[0][0] <= self._now:
            newest = self._under_way.popleft()[1]
        if newest is not None:
            self._vehicle.apply(newest)
            self._record(self._now / MS, newest)


def _number(part: str, text: str, origin: str) -> float:
    try:
        if not part.isascii() or "_" in part:  # which only Python takes for one
            raise ValueError
        value = float(part)
    except ValueError:
        raise SettingError(f"{origin} is {text!r}: {part.strip()!r} is no number, expected {ALLOWED}") from None
    if not math.isfinite(value):
        raise SettingError(f"{origin} is {text!r}: {part.strip()!r} is not finite, expected {ALLOWED}")
    return value
