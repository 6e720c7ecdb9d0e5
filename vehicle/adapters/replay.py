"""A recording as the vehicle: its sensors are played to the stack, its motion is the ego's, and commands go nowhere.

It is open loop: what the stack asks for is held against what was asked for when the recording was made. While the two
agree, the recorded motion is about what this stack would have done; once they have been further apart than a bound for
a while, it is not, and nothing measured of the ego's motion says anything about the stack.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from vehicle.adapter import VehicleLost
from vehicle.messages import (
    CameraFrame,
    Command,
    FloatArray,
    GnssFix,
    Imu,
    LidarScan,
    Observation,
    Odometry,
    Surroundings,
    VehicleDescription,
    VehicleState,
)

STEER_BOUND = 0.05  # rad, of the road wheel
ACCEL_BOUND = 1.0  # m/s^2
FOR = 0.5  # s in a row beyond a bound
NEAR = 3.0  # m between the recording's begin and where the scenario places the ego
SAME = 1e-6  # s

Sensed: TypeAlias = GnssFix | Odometry | Imu | LidarScan | CameraFrame


class Arrived(NamedTuple):
    """A sensor's message and when it came, both in seconds since the recording's begin."""

    t: float
    message: Sensed


@dataclass(frozen=True, eq=False)
class Recording:
    """What a log gives to be played. Times since its begin.

    name      as errors call it
    rows      motion (n, 12) of TRACE_COLUMNS every 10 ms
    commands  (m, 3): t [s], steering angle [rad], acceleration [m/s^2] as asked for then; m may be 0
    messages  what its sensors sent, in the order of arrival; read once, as it is played
    """

    name: str
    description: VehicleDescription
    rows: FloatArray
    commands: FloatArray
    messages: Iterable[Arrived]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return float(self.rows[-1, 0])


class Difference(NamedTuple):
    """At `t` [s]: the recorded steering angle [rad] and acceleration [m/s^2], and how far off the stack's are."""

    t: float
    steer: float
    accel: float
    steer_off: float
    accel_off: float

    @property
    def beyond(self) -> bool:
        """Whether one of the two is off by more than its bound."""
        return abs(self.steer_off) > STEER_BOUND or abs(self.accel_off) > ACCEL_BOUND


class Replay:
    """Plays a recording once. `record` gets a Difference for each command, if the recording has commands."""

    is_real = False

    def __init__(self, recording: Recording, record: Callable[[Difference], None]) -> None:
        self._recording, self._record = recording, record
        self._messages = iter(recording.messages)
        self._next = next(self._messages, None)
        self._t, self._row = 0.0, 1

    @property
    def description(self) -> VehicleDescription:
        """Of the car that the recording was made with, as far as is known."""
        return self._recording.description

    def reset(self, state: VehicleState) -> None:
        """Raises VehicleLost if the recording does not begin at `state`, or has begun already."""
        first = self._recording.rows[0]
        away = float(np.hypot(first[1] - state.x, first[2] - state.y))
        if away > NEAR:
            raise VehicleLost(
                f"{self._recording.name}: begins at x={first[1]:.1f}, y={first[2]:.1f}, {away:.1f} m from where the "
                f"scenario places the ego; a log can be cut: LOG@FROM:TO"
            )
        if self._t > 0.0:
            raise VehicleLost(f"{self._recording.name}: a recording is played once")

    def observe(self, surroundings: Surroundings) -> Observation:
        """What has come by now; `surroundings` do not matter to a recording."""
        came: dict[type, list[Sensed]] = {}
        while self._next is not None and self._next.t <= self._t + SAME:
            came.setdefault(type(self._next.message), []).append(self._next.message)
            self._next = next(self._messages, None)
        scans, frames = came.get(LidarScan), came.get(CameraFrame)
        return Observation(
            self._t,
            gnss=tuple(came.get(GnssFix, ())),  # type: ignore[arg-type]
            odometry=tuple(came.get(Odometry, ())),  # type: ignore[arg-type]
            imu=tuple(came.get(Imu, ())),  # type: ignore[arg-type]
            lidar=scans[-1] if scans else None,  # type: ignore[arg-type]
            camera=frames[-1] if frames else None,  # type: ignore[arg-type]
        )

    def apply(self, command: Command) -> None:
        """Hold a command against the recorded one."""
        commands = self._recording.commands
        at = int(np.searchsorted(commands[:, 0], self._t + SAME, side="right")) - 1
        if at >= 0:
            _, steer, accel = commands[at].tolist()
            self._record(Difference(self._t, steer, accel, command.steer - steer, command.accel - accel))

    def step(self, dt: float) -> FloatArray:
        """Recorded motion of the next `dt` [s]: rows of TRACE_COLUMNS (k, 12), oldest first.

        Raises VehicleLost at the end of the recording.
        """
        self._t = round(self._t + dt, 9)
        rows, begin = self._recording.rows, self._row
        self._row = int(np.searchsorted(rows[:, 0], self._t + SAME, side="right"))
        if self._row == begin:
            raise VehicleLost(f"{self._recording.name}: the recording has ended")
        return rows[begin : self._row]

    def stop(self) -> None:
        """There is nothing to stop."""

    def close(self) -> None:
        """There is nothing to free."""


class Judge:
    """Says when commands have gone apart for good: `diverged` is the time [s] from which on they were, or None."""

    def __init__(self) -> None:
        self._beyond: deque[float] = deque()
        self.diverged: float | None = None

    def hear(self, difference: Difference) -> bool:
        """True at the moment at which it is known."""
        if not difference.beyond:
            self._beyond.clear()
            return False
        self._beyond.append(difference.t)
        if self.diverged is None and difference.t - self._beyond[0] >= FOR - SAME:
            self.diverged = self._beyond[0]
            return True
        return False
