"""A car on ROS 2 topics in real time: 50 commands a second by the wall clock, and how well that was kept.

Time of a run begins with the first observation. The car's own stamps are moved onto it by the estimated offset of its
clock; measured motion is interpolated to the 10 ms grid of the log, which at 10 ms costs less than a tenth of a
millimetre. A car that says nothing for SILENT is lost.
"""

from __future__ import annotations

import time
from math import degrees, hypot, nan
from pathlib import Path
from statistics import median
from typing import Any

import msgspec
import numpy as np

from vehicle.adapter import VehicleLost
from vehicle.adapters.process import CarProcess, DriveByWireProcess, told_of
from vehicle.adapters.ros2 import CALL, CAN, Ros2Vehicle
from vehicle.messages import (
    Command,
    FloatArray,
    Imu,
    Observation,
    Odometry,
    Surroundings,
    VehicleDescription,
    VehicleState,
)
from vehicle.wire import convert, topics
from vehicle.wire.can_map import SignalMap
from vehicle.wire.health import finite
from vehicle.wire.live import LiveEnd, Ping

SILENT = 0.15  # s without a message after which the car is lost
BUSY = 0.05  # s: a harness that was away for longer did not listen, and does not call it silence
LATE = 0.01  # s, half a command cycle: a command later than this missed its deadline
PINGS = 40  # before a run, for the clock
GRID = 0.01  # s
NEAR, TURNED = 2.0, 0.35  # m, rad that a real car may be from where the scenario places it
SETTLING = 15_000_000  # ns that the surrogate has to stand where it is put
PLACED = 0.5  # s until which motion of before it was put there does not count


class Punctuality:
    """How well a run kept real time: lateness [s] of each command, round trips, and the car's clock."""

    def __init__(self) -> None:
        self.lateness: list[float] = []
        self.pings: list[Ping] = []
        self.offset = 0

    def as_dict(self) -> dict[str, float | int | str]:
        """For the log's meta: times in [s], `missed` as share of all commands."""
        late = np.array(self.lateness or [0.0])
        trips = np.array([ping.round_trip for ping in self.pings] or [0]) / convert.SECOND
        drift = [
            abs(ping.offset - self.offset)
            for ping in self.pings
            if ping.round_trip <= 2.0 * min(p.round_trip for p in self.pings)
        ]
        return {
            "clock": "real",
            "commands": len(self.lateness),
            "missed": float(np.mean(late > LATE)),
            "lateness_median": float(np.median(late)),
            "lateness_99": float(np.quantile(late, 0.99)),
            "lateness_worst": float(late.max()),
            "round_trip_median": float(np.median(trips)),
            "round_trip_99": float(np.quantile(trips, 0.99)),
            "clock_offset_drift": max(drift, default=0) / convert.SECOND,
        }


class LiveCar(Ros2Vehicle):
    """What is different in real time; the rest is Ros2Vehicle. `punctuality` tells how it went."""

    stepped = False
    real_time = True  # its gate has a process of its own
    punctuality: Punctuality
    _begun = False

    def reset(self, state: VehicleState) -> None:
        """Learn the offset of the car's clock; the run begins with the first `observe`.

        Raises VehicleLost if no ping is answered, or if a real car does not stand about where `state` says.
        """
        self.punctuality = Punctuality()
        self._state, self._begun = state, False
        self._now = round(state.t * convert.SECOND)
        self._live().receive_until(time.monotonic_ns())
        self._spoke = self._forget()  # of a run before this one, or of the time between
        for _ in range(PINGS):
            self._ping()
            self._live().receive_until(time.monotonic_ns() + 5_000_000, self._pinged)
        if not self.punctuality.pings:
            self._lost = True
            raise VehicleLost("the car answers no ping: its clock is not known")
        best = sorted(self.punctuality.pings)[: max(1, len(self.punctuality.pings) // 4)]
        self.punctuality.offset = round(median(ping.offset for ping in best))
        self.punctuality.pings.clear()
        if self._real:
            self._state = self._placed_by_hand(state)
        self._spoke |= self._discard()

    def _placed_by_hand(self, state: VehicleState) -> VehicleState:
        """A car cannot be put anywhere: how it stands.

        Raises VehicleLost if it does not know, or if that is not about where it is to begin.
        """
        said = self._wire().take(topics.ODOMETRY)
        if not said:
            raise VehicleLost(f"the car does not say where it is: nothing on {topics.ODOMETRY.name}")
        there = convert.state_from_ros(said[-1])
        if not finite(there):
            raise VehicleLost(
                f"the car does not say where it is: {topics.ODOMETRY.name} holds what is no finite number"
            )
        away, turned = hypot(there.x - state.x, there.y - state.y), convert.unwrapped(there.yaw, state.yaw) - state.yaw
        if away > NEAR or abs(turned) > TURNED:
            raise VehicleLost(
                f"the car is {away:.1f} m from where the scenario places the ego (x={state.x:.1f}, y={state.y:.1f}, "
                f"yaw={state.yaw:.2f} rad), turned by {degrees(turned):.0f} deg; "
                f"allowed are {NEAR:g} m and {degrees(TURNED):.0f} deg"
            )
        return msgspec.structs.replace(there, t=state.t, steer=self._steered())

    def _steered(self) -> float:
        """Steering angle [rad] of the road wheel as the car reports it now. Raises VehicleLost if it reports none."""
        if self._by_wire is None:
            said = [convert.feedback_from_ros(message) for message in self._wire().take(topics.FEEDBACK)]
        else:
            self._by_wire.listen(0, 0)
            said = self._by_wire.reports()
        if not said:
            where = topics.FEEDBACK.name if self._by_wire is None else CAN
            raise VehicleLost(f"the car does not say how it steers: nothing on {where}")
        if not finite(said[-1]):
            raise VehicleLost("the car does not say how it steers: its report holds what is no finite number")
        return said[-1].steer

    def observe(self, surroundings: Surroundings) -> Observation:
        """Everything that came since the last call."""
        if not self._begun:
            self._begin()
        if not self._real:
            self._send(topics.OBJECTS, convert.objects_to_ros(surroundings, self._now))
            if surroundings.signals:
                self._send(topics.SIGNALS, convert.signals_to_ros(surroundings.signals))
        self._listen(0)
        return self._observed()

    def apply(self, command: Command) -> None:
        """Send the command, and note by how much it is late."""
        super().apply(command)
        if self._begun:
            self.punctuality.lateness.append((time.monotonic_ns() - self._epoch - self._now) / convert.SECOND)

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s] of wall time pass, counted from the last step's end.

        Returns the rows of TRACE_COLUMNS (k, 12) that have come. Raises VehicleLost if the car says nothing any more.
        """
        if not self._begun:
            self._begin()
        if self._by_wire is not None:
            self._by_wire.cycle(self._now)
        self._now += round(dt * convert.SECOND)
        self._ping()
        self._listen(self._epoch + self._now)
        return self._on_grid(self._rows())

    def _begin(self) -> None:
        end = self._live()
        if not self._real:
            self._send(topics.RESET, convert.state_to_ros(self._state, self._now))
            end.receive_until(time.monotonic_ns() + SETTLING)
        self._spoke |= self._discard()  # what was under way belongs to the time before
        self._begun = True
        self._epoch = time.monotonic_ns() - self._now
        end.shift = self.punctuality.offset + self._epoch
        state = self._state
        self._yaw, self._sigma, self._there = state.yaw, nan, None
        self._turns, self._alone = False, 0
        self._steers, self._force = [Odometry(state.t, state.v, state.steer)], Imu(state.t, 0.0, 0.0, 0.0)
        for before in (self._headings, self._forces, self._asked, self._wheels, self._noted):
            before.clear()
        self._health.reset(self._expected())
        self._raw = np.array(
            [[state.t, state.x, state.y, state.z, state.yaw, state.v, state.vx, 0, 0, 0, 0, state.steer]]
        )
        self._told = 0  # rows of the grid
        self._placed = self._real
        self._tell_unfit()
        end.heard = self._listened = time.monotonic_ns()

    def _rows(self) -> FloatArray:
        """As of any car; a surrogate on a busy machine may have gone on elsewhere for a while."""
        if not self._placed:
            self._placed = self._live().drop_until(topics.ODOMETRY, self._is_there) or self._clock() > PLACED
        return super()._rows()

    def _is_there(self, message: Any) -> bool:
        there, state = convert.state_from_ros(message), self._state
        return hypot(there.x - state.x, there.y - state.y) <= NEAR + PLACED * abs(state.v)

    def _on_grid(self, rows: FloatArray) -> FloatArray:
        """Measured rows (n, 12) at the car's stamps -> those of the 10 ms grid that they reach."""
        rows = rows[rows[:, 0] > self._raw[-1, 0]]
        self._raw = np.concatenate([self._raw, rows])
        # A harness that is late has motion of the time after its step: the next step's.
        reach = min(self._raw[-1, 0], self._now / convert.SECOND)
        last = max(self._told, int((reach - self._state.t) / GRID + 1e-6))
        grid = self._state.t + GRID * np.arange(self._told + 1, last + 1)
        known = self._raw
        self._told = last
        self._raw = known[max(np.searchsorted(known[:, 0], self._state.t + GRID * last, side="right") - 1, 0) :]
        return np.column_stack([grid, *(np.interp(grid, known[:, 0], known[:, k]) for k in range(1, 12))])

    def _stamp(self) -> int:
        return time.monotonic_ns() + self.punctuality.offset

    def _clock(self) -> float:
        """The wall clock's: a step may end late."""
        return (time.monotonic_ns() - self._epoch) / convert.SECOND if self._begun else super()._clock()

    def _discard(self) -> set[topics.Topic]:
        """Take what has come and leave it; who needs some of it overrides this. Returns the topics that spoke."""
        return self._forget()

    def _forget(self) -> set[topics.Topic]:
        """Take all that has come and leave it, over CAN too. Returns the topics that spoke."""
        if self._by_wire is not None:
            self._by_wire.listen(0, 0)
            self._by_wire.reset()
        return {topic for topic in self.reads if self._wire().take(topic)}

    def _expected(self) -> set[str]:
        """What any car must say, and each topic that spoke before the run.

        Feedback on its topic counts only where it does not come over CAN.
        """
        unread = set() if self._by_wire is None else {topics.FEEDBACK}
        return super()._expected() | {topic.name for topic in self._spoke & set(topics.SENSED) - unread}

    def _needed(self) -> set[topics.Topic] | None:
        """Topics without which there is no car; None: all of them. A real one need not have the others."""
        if not self._real:
            return None
        needed = {topics.STEP, topics.DONE, topics.DESCRIPTION, topics.ODOMETRY}
        return needed if self._by_wire is not None else needed | {topics.COMMAND, topics.FEEDBACK}

    def _live(self) -> LiveEnd:
        end = self._wire()
        assert isinstance(end, LiveEnd)
        return end

    def _ping(self) -> None:
        self._number += 1
        try:
            self._live().say(self._number, time.monotonic_ns())
        except VehicleLost:
            self._lost = True
            raise

    def _pinged(self, arrived: int, numbers: list[int]) -> None:
        if len(numbers) == 4:
            _, sent, received, answered = numbers
            round_trip = (arrived - sent) - (answered - received)
            self.punctuality.pings.append(Ping(round_trip, ((received - sent) + (answered - arrived)) // 2))

    def _listen(self, until: int) -> None:
        """Receive until `until` [ns, monotonic]. Raises VehicleLost if the car is gone or says nothing any more."""
        end, away = self._live(), time.monotonic_ns() - self._listened
        if away > BUSY * convert.SECOND:
            end.heard += away
        try:
            end.receive_until(until, self._pinged)
            if self._by_wire is not None and self._begun:
                self._by_wire.listen(self._epoch, time.monotonic_ns() - self._epoch)
        except VehicleLost:
            self._lost = True
            raise
        self._listened = time.monotonic_ns()
        quiet = (self._listened - end.heard) / convert.SECOND
        if quiet > SILENT:
            self._lost = True
            raise VehicleLost(f"the car has been silent for {quiet:.2f} s at t = {self._now / convert.SECOND:.2f} s")

    def _call(self, ready: float) -> VehicleDescription:
        end, deadline = self._live(), time.monotonic() + ready
        while time.monotonic() < deadline:
            if end.matched(self._needed()):
                end.say(0, time.monotonic_ns())
            end.receive_until(time.monotonic_ns() + round(CALL * convert.SECOND))
            said = end.take(topics.DESCRIPTION)
            if said:
                return msgspec.json.decode(said[-1].data, type=VehicleDescription)
        raise VehicleLost(self._nobody(ready))

    def _go_on(self) -> None:
        """Nothing waits for a step."""


class LiveCarProcess(LiveCar, CarProcess):
    """A car in real time that is a process of this machine: `python -m MODULE --dds DOMAIN --clock real ARGUMENTS`."""


class LiveDriveByWireProcess(LiveCar, DriveByWireProcess):
    """One with a drive-by-wire."""


def live_surrogate(
    seed: int = 0,
    hidden: Path | None = None,
    *,
    can: SignalMap | None = None,
    truth: Path | None = None,
    **options: Any,
) -> LiveCarProcess | LiveDriveByWireProcess:
    """The surrogate car in a process of its own, by the wall clock; arguments as of `process.surrogate`."""
    arguments = ["--clock", "real", "--seed", str(seed), *told_of(hidden, truth, options)]
    kind = LiveCarProcess if can is None else LiveDriveByWireProcess
    return kind("vehicle.surrogate", arguments, seed=seed, can=can, end=LiveEnd, **options)
