"""What goes into the guard and what comes out: frozen, SI units, standard library only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

HARDEST = 20.0  # m/s^2; no road car brakes harder: a bound for what encodes it, not for the car
BEYOND = 1e12  # no time, place or command is larger in its unit
COMMAND = ("t", "sequence", "steer", "accel", "throttle", "brake")
MOTION = ("t", "x", "y", "yaw", "v", "steer")

Area = tuple[tuple[float, float], ...]


def number(value: object) -> bool:
    """Whether it is a finite number that a car can mean; a bool is none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and -BEYOND < value < BEYOND


def numbers(message: object, names: tuple[str, ...]) -> bool:
    """Whether all these fields are there and numbers."""
    return all(number(getattr(message, name, None)) for name in names)


class State(Enum):
    """Who has the car: nobody's commands are live, the stack, the driver, or the stop profile for good."""

    DRY = "dry"
    ARMED = "armed"
    OVERRIDDEN = "overridden"
    STOPPED = "stopped"


class Outcome(Enum):
    """PASSED as asked; all others are findings."""

    PASSED = "passed"
    CLAMPED = "clamped"
    STOP = "stop"
    HANDED_OVER = "handed_over"


@dataclass(frozen=True, slots=True)
class Limits:
    """What the car and its place allow. Raises ValueError for a limit that is none.

    `max_steer` at the road wheel [rad, < 1.5], `max_steer_rate` [rad/s], `wheelbase` [m], `max_speed` [m/s],
    `max_acceleration`, `max_deceleration` and `stop_deceleration` (of the stop profile) [m/s^2, > 0]; `area` the
    corners [m] of the polygon that the car may not leave, None: anywhere, which a real car is never armed with.
    """

    max_steer: float
    max_steer_rate: float
    wheelbase: float
    max_speed: float
    max_acceleration: float
    max_deceleration: float
    stop_deceleration: float
    area: Area | None = None

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if name != "area" and not (number(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name} = {getattr(self, name)!r}: a positive number is needed")
        if self.max_steer >= 1.5:
            raise ValueError(f"max_steer = {self.max_steer!r} rad: no wheel turns as far; degrees?")
        if self.max_deceleration > HARDEST:
            raise ValueError(f"max_deceleration = {self.max_deceleration!r} m/s^2 is more than {HARDEST}")
        if self.stop_deceleration > self.max_deceleration:
            raise ValueError(f"stop_deceleration = {self.stop_deceleration!r} is more than the car can do")
        if self.area is None:
            return
        if len(self.area) < 3 or not all(number(value) for corner in self.area for value in corner):
            raise ValueError(f"area = {self.area!r}: three corners at least, of two numbers each")


@dataclass(frozen=True, slots=True)
class Request:
    """What a stack asks: as `vehicle.messages.Command`, and its number, which grows by one or more each time."""

    t: float
    sequence: int
    steer: float
    accel: float
    throttle: float
    brake: float


@dataclass(frozen=True, slots=True)
class Measured:
    """The car's own word: pose in the map [m, rad], signed speed [m/s], road-wheel angle [rad], the driver's hands.

    Anything but False in `override` or `emergency_stop` counts as pressed.
    """

    t: float
    x: float
    y: float
    yaw: float
    v: float
    steer: float
    override: bool = False
    emergency_stop: bool = False


@dataclass(frozen=True, slots=True)
class Output:
    """What may go to the actuators: [rad], [m/s^2; below zero is braking, never reverse], [0, 1], [0, 1]."""

    steer: float = 0.0
    accel: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0


@dataclass(frozen=True, slots=True)
class Decision:
    """One cycle: what was asked (None: nothing new), what may go out, and why, first reason first."""

    t: float
    request: Request | None
    output: Output
    outcome: Outcome
    reasons: tuple[str, ...]
    state: State

    @property
    def live(self) -> bool:
        """Whether the output is to be sent at all; never in a dry run."""
        return self.state is not State.DRY

    @property
    def engaged(self) -> bool:
        """False: the driver has the car; an adapter with a mode bit lets go of all actuators."""
        return self.state in (State.ARMED, State.STOPPED)


@dataclass(frozen=True, slots=True)
class Arming:
    """A human's word that this vehicle may drive this one scenario, and when it was written [ns]."""

    vehicle: str
    scenario: str
    written: int
