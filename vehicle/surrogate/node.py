"""The surrogate on the wire: it goes on when the harness says so, and sends what its sensors showed.

Ends with its parent: the pipe on its standard input closes when the parent dies, however it dies.
"""

from __future__ import annotations

import os
import sys
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

import msgspec

from vehicle.messages import (
    CameraFrame,
    Command,
    GnssFix,
    Imu,
    Odometry,
    VehicleDescription,
    VehicleState,
    no_surroundings,
)
from vehicle.surrogate.ecu import DriveByWire
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.perceiver import Perceiver
from vehicle.surrogate.reference import ReferenceSystem
from vehicle.surrogate.scanner import Scanner
from vehicle.surrogate.sensors import FACTOR, SIGMA
from vehicle.surrogate.surrogate import DoubleTrack
from vehicle.surrogate.truth import Truth
from vehicle.wire import convert, topics
from vehicle.wire.end import End, Opener, Silence
from vehicle.wire.ros2_types import String

MS = 1_000_000  # ns
SUBSTEP = 10 * MS  # the reference system's period
MOTION, GNSS, LOOK = 20 * MS, 100 * MS, 100 * MS  # periods of wheel odometry and IMU; of GNSS; of LiDAR and camera
REFERENCE_LATENCY, LIDAR_LATENCY, CAMERA_LATENCY = 20 * MS, 50 * MS, 100 * MS
PATIENCE = 100 * MS  # without a command, after the first: then it brakes by itself
IDLE = 3600.0  # s without a word after which it gives up


class Node:
    """A surrogate car on the wire that `opener` opens. Same seed and same messages in, same messages out.

    With a drive-by-wire `unit` its commands come, and its speed and steering angle go, over CAN. `truth`, if there is
    one, learns what was true since the car was last placed; nothing of that goes over the wire.
    """

    writes = topics.FROM_CAR
    stepped = True  # harness and car in lock-step

    def __init__(
        self,
        opener: Opener,
        hidden: Hidden,
        seed: int,
        unit: DriveByWire | None = None,
        *,
        truth: Truth | None = None,
        end: type[End] = End,
    ) -> None:
        self._unit, self._truth = unit, truth
        self._car = DoubleTrack(hidden, seed=seed, pedals=unit is not None and unit.pedals)
        self._hidden, self._seed, self._sigma = hidden, seed, FACTOR[hidden.noise]
        self.description: VehicleDescription = msgspec.structs.replace(
            self._car.description, lidar_x=1.18, lidar_z=1.5, camera_x=1.58, camera_z=1.4
        )
        self._car.step(SUBSTEP / convert.SECOND)  # compiles, on a busy machine for longer than a step may take
        self._end = end(opener, self.writes, topics.TO_CAR, (topics.DONE, topics.STEP), lambda: None)
        self._place(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))

    def close(self) -> None:
        """Leave the wire."""
        self._end.close()

    def serve(self) -> None:
        """Answer steps until nothing comes any more."""
        while True:
            try:
                number, until = self._end.next_step(IDLE)
            except Silence:
                return
            if number == 0:  # a call to see whether somebody is there: answered once every topic is
                if self._end.matched():
                    self._end.send(topics.DESCRIPTION, String(msgspec.json.encode(self.description).decode()))
                    self._end.step(0, until)
                continue
            self._obey()
            if self._unit is not None:
                self._unit.hear(number, self._now)
            self._advance(until)
            self._deliver()
            if self._unit is not None:
                self._unit.done(number)
            self._end.step(number, self._now)

    def _place(self, state: VehicleState) -> None:
        self._car.reset(state)
        if self._unit is not None:
            self._unit.reset()
        self._scanner = Scanner(self.description, self._seed)
        self._perceiver = Perceiver(self._hidden, self._seed)
        self._reference = ReferenceSystem(self._hidden.reference, self._seed, SUBSTEP / convert.SECOND)
        if self._truth is not None:
            self._truth.clear()
            self._truth.car(self._car.state)
        self._around, self._signals = no_surroundings(), None
        self._obeyed: Command | None = None
        self._commanded = 0
        self._now = self._start = round(state.t * convert.SECOND)
        self._looked = -1
        self._late: dict[Any, deque[tuple[int, Any]]] = {}

    def _obey(self) -> None:
        """Take what came with this step, and look around if new surroundings are among it."""
        take = self._end.take
        take(topics.CLOCK)
        for message in take(topics.RESET):
            self._place(convert.state_from_ros(message))
        for message in take(topics.SIGNALS):
            self._queue(topics.SEEN_SIGNALS, message, 0)
        for message in take(topics.COMMAND) if self._unit is None else ():
            self._obeyed, self._commanded = convert.command_from_ros(message), self._now
            self._car.apply(self._obeyed)
        for message in take(topics.OBJECTS):
            self._around = convert.objects_from_ros(message)
            if self._truth is not None:
                self._truth.around(self._now / convert.SECOND, self._around)
            self._look()

    def _look(self) -> None:
        due = (self._now - self._start) % LOOK == 0
        if not due or self._looked == self._now:
            return
        self._looked = self._now
        now, state = self._now, self._car.state
        around = self._perceiver.seen(now / convert.SECOND, state.x, state.y, state.yaw, self._around)
        cloud = self._scanner.points(state.x, state.y, state.yaw, around.seen_by("lidar"))
        frame = CameraFrame(state.t, self._scanner.boxes(state.x, state.y, state.yaw, around.seen_by("camera")))
        self._queue(topics.POINTS, convert.points_to_ros(cloud, now), LIDAR_LATENCY)
        self._queue(topics.CAMERA, convert.camera_to_ros(frame, now), CAMERA_LATENCY)

    def _advance(self, until: int) -> None:
        while self._now + SUBSTEP <= until:
            if self._unit is not None:
                self._unit.watch(self._now)
                asked = self._unit.command(self._now / convert.SECOND)
                if asked is not None:
                    self._car.apply(asked)
            elif self._obeyed is not None and self._now - self._commanded >= PATIENCE:
                self._obeyed = msgspec.structs.replace(self._obeyed, accel=-self.description.max_deceleration)
                self._car.apply(self._obeyed)
            self._car.step(SUBSTEP / convert.SECOND)
            self._now += SUBSTEP
            now, ran = self._now, self._now - self._start
            self._refer(now, ran // SUBSTEP)
            if ran % MOTION == 0:
                self._measure(now, ran % GNSS == 0)

    def _refer(self, now: int, step: int) -> None:
        """The motion, as the reference system measures it."""
        true = self._car.state
        if self._truth is not None:
            self._truth.car(true)
        state = self._reference.show(true)
        if not self._reference.due(step):
            return
        self._queue(topics.ODOMETRY, convert.state_to_ros(state, now), REFERENCE_LATENCY)
        felt = Imu(state.t, state.ax, state.ay, state.yaw_rate)
        self._queue(topics.REFERENCE_IMU, convert.imu_to_ros(felt, now), REFERENCE_LATENCY)
        self._queue(topics.TF, convert.transform(state, now), REFERENCE_LATENCY)

    def _measure(self, now: int, with_gnss: bool) -> None:
        shown = self._car.measure()
        turning = self._reference.wheels(shown["v"]) if self._car.state.v != 0.0 else 0.0
        wheels = Odometry(0.0, turning, self._car.state.steer)
        if self._unit is None:
            echo = 0.0 if self._obeyed is None else self._obeyed.accel
            self._queue(topics.FEEDBACK, convert.feedback_to_ros(wheels, now, echo), 0)
        else:
            self._unit.report(now, wheels, stamped=self.stepped)
        felt = Imu(0.0, shown["ax"], shown["ay"], shown["yaw_rate"])
        self._queue(topics.IMU, convert.imu_to_ros(felt, now), 0)
        if with_gnss:
            sigma = max(SIGMA["x"] * self._sigma, 0.005), max(SIGMA["yaw"] * self._sigma, 0.001)
            fix = GnssFix(0.0, shown["x"], shown["y"], sigma[0], shown["yaw"], sigma[1])
            place, heading = convert.fix_to_ros(fix, now)
            self._queue(topics.FIX, place, 0)
            self._queue(topics.HEADING, heading, 0)

    def _queue(self, topic: topics.Topic, message: Any, latency: int) -> None:
        self._late.setdefault(topic, deque()).append((self._now + latency, message))

    def _deliver(self) -> None:
        for topic, waiting in self._late.items():
            while waiting and waiting[0][0] <= self._now:
                self._end.send(topic, waiting.popleft()[1])


def end_with_parent(leave: Callable[[], None] = lambda: None) -> None:
    """End at once when standard input closes, after what `leave` does."""

    def watch() -> None:
        while os.read(sys.stdin.fileno(), 1):  # not through a buffer, whose lock would abort an ordinary end
            pass
        try:
            leave()
        finally:
            os._exit(0)

    threading.Thread(target=watch, daemon=True).start()
