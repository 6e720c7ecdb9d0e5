"""The Vehicle protocol: what the harness needs of whatever stands in for the car."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, runtime_checkable

from vehicle.messages import Command, FloatArray, Observation, Surroundings, VehicleDescription, VehicleState

STALE = 0.2  # s that what a car reports of its driver's hands, its mode or its steering angle counts; chosen


class VehicleLost(ValueError):
    """A car that died, hangs or never came; one line."""


@runtime_checkable
class Vehicle(Protocol):
    """A car: the digital twin, a real one, or a recording of one.

    Life: `reset`, then per tick `observe`, `apply`, `step`; `stop` brings it to a halt, `close` frees what it holds and
    may be called at any time, more than once. A car that is armed by keys is first reset, stepped without a command
    until it tells its motion, from which it is armed, and then reset again for the run.
    """

    @property
    def description(self) -> VehicleDescription:
        """Size, axles, limits and sensor mounting of this car."""

    @property
    def is_real(self) -> bool:
        """True if actuators of a real car hang on it: nothing automatic may drive it then."""

    def reset(self, state: VehicleState) -> None:
        """Stand (or drive) at `state` with empty actuators and sensors; a real car checks that it does."""

    def observe(self, surroundings: Surroundings) -> Observation:
        """Everything its sensors delivered since the last call. A real car's sensors ignore `surroundings`."""

    def apply(self, command: Command) -> None:
        """Hand over a command; it holds until the next one."""

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s] pass. Returns the motion measured since then: rows (n, 12) of TRACE_COLUMNS, oldest first."""

    def stop(self) -> None:
        """Bring the car to a halt with what the vehicle itself can do; does not wait."""

    def close(self) -> None:
        """Free processes, sockets and buses."""


class Hands(NamedTuple):
    """The driver: `override`, a hand or foot that takes over; `emergency_stop`, the button."""

    override: bool
    emergency_stop: bool


@runtime_checkable
class Supervised(Protocol):
    """What a vehicle with a driver also has; a real one without it is never armed."""

    @property
    def hands(self) -> Hands:
        """As last measured."""


class StatesItsPosition(Protocol):
    """What a vehicle whose reference system says how well it knows the place also has."""

    @property
    def position_sigma(self) -> float:
        """Standard deviation [m] of x and of y of the newest row of motion, as stated; NaN if it was not."""


def position_sigma_of(vehicle: Vehicle | StatesItsPosition) -> float:
    """What a vehicle states of the newest row of its motion [m]; NaN if it states nothing."""
    # Asked each tick, and isinstance looks at every member of a protocol: without it, a run of 40 s with a stack of ten
    # lines takes 10 % less CPU time.
    return float(getattr(vehicle, "position_sigma", math.nan))


@runtime_checkable
class KnowsItsMap(Protocol):
    """What a vehicle whose fixes are latitude and longitude also has."""

    def locate_map(self, origin: Any, why_not: str) -> None:
        """Where the map of the scenario lies (vehicle.wire.geodetic.Origin), as its road file says. None: it does not
        say, or, if there is a reason `why_not`, says it in a way that cannot be read.

        Raises VehicleLost if the vehicle needs what cannot be read.
        """


@runtime_checkable
class ReportsMessageFaults(Protocol):
    """What a vehicle that judges its own messages also has."""

    def tell(self, record: Callable[[Any], None]) -> None:
        """From now on `record` gets every trouble with its messages (vehicle.wire.health.Trouble)."""
