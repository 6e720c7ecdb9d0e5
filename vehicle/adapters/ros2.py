"""A car on ROS 2 topics behind the Vehicle protocol, in stepped time: harness and car move in lock-step.

Motion in the log is what the car's reference system (`/vehicle/odom`, `/reference/imu`) measured, late as it comes;
the driving stack gets wheel odometry, IMU, GNSS, LiDAR and camera. Needs the extra `ros2`. With a drive-by-wire on CAN
command and feedback go there, all else stays.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from math import degrees, hypot, log10, nan
from typing import Any, TypeVar

import msgspec
import numpy as np

from vehicle.adapter import VehicleLost
from vehicle.adapters.can_bus import CanActuators
from vehicle.messages import (
    Command,
    FloatArray,
    GnssFix,
    Imu,
    Observation,
    Odometry,
    Surroundings,
    VehicleDescription,
    VehicleState,
    brake_first,
)
from vehicle.wire import convert, ros2_types, topics
from vehicle.wire.end import End, Opener, Silence
from vehicle.wire.geodetic import DEFAULT_ORIGIN
from vehicle.wire.health import Health, Trouble

M = TypeVar("M")

CALL = 0.2  # s between two calls to a car that does not answer yet
STEP_TIMEOUT = 20.0  # s of wall time that a car has for one step
CAN = "CAN"  # what its reports are called where topics have their names
ELSEWHERE = 100.0  # m between a fix and the car's own pose, which no error explains: another origin; chosen
ECHO = 10  # commands, 0.2 s: a car that obeys none of them obeys nobody


class Ros2Vehicle:
    """A car on the wire that `opener` opens.

    alive     raises VehicleLost if the car is known to be gone; asked while waiting
    ready     [s] wall time until it must have answered for the first time
    timeout   [s] wall time it has for one step
    is_real   whether actuators of a real car hang on it
    by_wire   what carries command and feedback instead of their topics
    record    gets every trouble with the car's messages; what cannot be used of them is kept back
    end       opens the end of the wire, as `End` does

    Raises VehicleLost if it does not come.
    """

    reads: tuple[topics.Topic, ...] = topics.FROM_CAR
    stepped = True  # in lock-step with the car

    def __init__(
        self,
        opener: Opener,
        alive: Callable[[], None],
        *,
        ready: float = 60.0,
        timeout: float = STEP_TIMEOUT,
        is_real: bool = False,
        by_wire: CanActuators | None = None,
        record: Callable[[Trouble], None] = lambda _: None,
        end: Callable[..., End] = End,
    ) -> None:
        self._real, self._timeout, self._by_wire = is_real, timeout, by_wire
        self._number, self._now, self._lost = 0, 0, False
        self._yaw, self._sigma = 0.0, nan
        self._there: tuple[float, float] | None = None  # x, y [m] of the newest row of motion
        self._steers: list[Odometry] = [Odometry(0.0, 0.0, 0.0)]  # feedback from the newest row of motion on
        self._wheels: list[Odometry] = []  # feedback that no observation has had yet
        self._headings: dict[float, convert.Heading] = {}  # that no fix has had yet, in their order
        self._turns, self._alone = False, 0  # whether headings come at all; fixes that found none
        self._forces: deque[Imu] = deque()  # felt after the newest row of motion
        self._force = Imu(0.0, 0.0, 0.0, 0.0)
        self._asked: deque[float] = deque([0.0], maxlen=ECHO)  # accelerations of the last cycles
        self._noted: set[str] = set()
        self._origin = DEFAULT_ORIGIN  # of the map, for its fixes
        self._record, self._health = record, Health(record)
        self._end: End | None = end(opener, topics.TO_CAR, self.reads, (topics.STEP, topics.DONE), alive)
        try:
            self._description = self._call(ready)
        except BaseException:
            self.close()
            raise

    @property
    def description(self) -> VehicleDescription:
        """As the car says it."""
        return self._description

    @property
    def is_real(self) -> bool:
        """Whether actuators of a real car hang on it."""
        return self._real

    @property
    def position_sigma(self) -> float:
        """Standard deviation [m] that the newest row's x and y were stated with; NaN without one."""
        return self._sigma

    def tell(self, record: Callable[[Trouble], None]) -> None:
        """From now on `record` gets every trouble with its messages."""
        self._record, self._health = record, Health(record)

    def reset(self, state: VehicleState) -> None:
        """Ask the car to stand or roll at `state`."""
        self._now = round(state.t * convert.SECOND)
        self._send(topics.RESET, convert.state_to_ros(state, self._now))
        if self._by_wire is not None:
            self._by_wire.reset()
        self._yaw, self._sigma = state.yaw, nan
        self._go_on()
        self._rows(), self._observed()  # what was under way belongs to the time before
        self._there, self._turns, self._alone = None, False, 0
        self._steers, self._force = [Odometry(state.t, state.v, state.steer)], Imu(state.t, 0.0, 0.0, 0.0)
        for before in (self._headings, self._forces, self._asked, self._noted):
            before.clear()
        self._health.reset(self._expected())
        self._tell_unfit()

    def observe(self, surroundings: Surroundings) -> Observation:
        """Everything that came since the last call; `surroundings` go to what renders a simulated car's sensors."""
        if not self._real:
            self._send(topics.OBJECTS, convert.objects_to_ros(surroundings, self._now))
            if surroundings.signals:
                self._send(topics.SIGNALS, convert.signals_to_ros(surroundings.signals))
            self._go_on()
        return self._observed()

    def apply(self, command: Command) -> None:
        """Send the command. Raises ValueError if it is not finite."""
        if not np.isfinite([command.steer, command.accel, command.throttle, command.brake]).all():
            raise ValueError(f"command at t = {command.t:.3f} s is not finite")
        command = brake_first(command, self._description.max_deceleration)  # the message has no pedals
        if self._by_wire is not None:
            self._by_wire.apply(command)
        else:
            self._send(topics.COMMAND, convert.command_to_ros(command, self._stamp()))
        self._asked.append(command.accel)

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s], a multiple of 10 ms, pass. Returns the rows of motion that have come, (n, 12), n may be 0."""
        if self._by_wire is not None:
            self._by_wire.cycle(self._now)
        self._now += round(dt * convert.SECOND)
        self._send(topics.CLOCK, ros2_types.Clock(convert.stamp(self._now)))
        self._go_on()
        return self._rows()

    def stop(self) -> None:
        """Ask for full braking, steering as it is; a car that is lost is asked nothing."""
        if not self._lost and self._end is not None:
            hard = -self._description.max_deceleration
            self.apply(Command(self._now / convert.SECOND, self._steers[-1].steer, hard, 0.0, 1.0))
            if self._by_wire is not None:
                self._by_wire.cycle(self._now)  # no step follows that would send it

    def close(self) -> None:
        """Leave the domain."""
        end, self._end = self._end, None
        if end is not None:
            end.close()
            if self._by_wire is not None:
                self._by_wire.close()

    def _call(self, ready: float) -> VehicleDescription:
        end, waited = self._wire(), 0.0
        while True:
            if end.matched():
                end.step(0, 0)
            try:
                end.next_step(CALL)
            except Silence:
                waited += CALL
                if waited >= ready:
                    raise VehicleLost(self._nobody(ready)) from None
                continue
            said = end.take(topics.DESCRIPTION)[-1].data
            return msgspec.json.decode(said, type=VehicleDescription)

    def _nobody(self, ready: float) -> str:
        """That no car answered, and what is there in its place."""
        unfit = "".join(f"; {topic.name} is {how}" for topic, how in self._wire().unmatched().items())
        return f"no car answered on the wire within {ready:g} s{unfit}"

    def _tell_unfit(self) -> None:
        """Name each topic that is there, and of which nothing can come: another type, or a QoS that does not match."""
        for topic, how in self._wire().unmatched().items():
            self._record(Trouble(self._clock(), topic.name, f"unfit: {how}", 1.0))

    def _wire(self) -> End:
        if self._end is None:
            raise VehicleLost("the vehicle is closed")
        return self._end

    def _send(self, topic: topics.Topic, message: Any) -> None:
        try:
            self._wire().send(topic, message)
        except VehicleLost:
            self._lost = True
            raise

    def _go_on(self) -> None:
        end = self._wire()
        self._number += 1
        if self._by_wire is not None:
            self._by_wire.step(self._number)
        end.step(self._number, self._now)
        try:
            number, reached = end.next_step(self._timeout, at_least=self._number)
            if self._by_wire is not None:
                self._by_wire.stepped(self._number, self._now)
        except Silence:
            self._lost = True
            raise VehicleLost(
                f"the car did not answer within {self._timeout:g} s at t = {self._now / convert.SECOND:.2f} s"
            ) from None
        except VehicleLost:
            self._lost = True
            raise
        if (number, reached) != (self._number, self._now):
            raise VehicleLost(f"the car answered step {number} at {reached} ns, expected {self._number} at {self._now}")

    def _observed(self) -> Observation:
        self._take_feedback()
        wheels, self._wheels = tuple(self._wheels), []
        clouds = self._sound(topics.POINTS, convert.points_from_ros)
        frames = self._sound(topics.CAMERA, convert.camera_from_ros)
        lights = self._wire().take(topics.SEEN_SIGNALS)
        self._wire().take(topics.TF)
        seen = Observation(
            self._now / convert.SECOND,
            gnss=self._fixes(),
            odometry=wheels,
            imu=self._felt(topics.IMU),
            lidar=clouds[-1] if clouds else None,
            camera=frames[-1] if frames else None,
            signals=convert.signals_from_ros(lights[-1]) if lights else (),
        )
        self._health.look(self._clock())
        return seen

    def _expected(self) -> set[str]:
        """What any car must say: its motion, speed and steering angle."""
        return {topics.ODOMETRY.name, topics.FEEDBACK.name if self._by_wire is None else CAN}

    def _stamp(self) -> int:
        """Now [ns] on the car's clock."""
        return self._now

    def _clock(self) -> float:
        """Time [s] at which what comes now is said to come."""
        return self._now / convert.SECOND

    def _sound(self, topic: topics.Topic, convert_one: Callable[[Any], M]) -> list[M]:
        """What came on a topic, as far as it can be used."""
        now, messages = self._clock(), []
        for message in self._wire().take(topic):
            try:
                messages.append(convert_one(message))
            except (ValueError, LookupError) as error:
                self._record(Trouble(now, topic.name, f"malformed: {error}", 1.0))
        return self._health.sift(topic.name, messages, now)

    def _fixes(self) -> tuple[GnssFix, ...]:
        """Places, each with the heading nearest to its stamp, if one within convert.PAIRED has come too.

        One that comes later finds its place handed on already. How many places had none is told, as headings are lost
        then: of the first, tenth and hundredth of them, and so on.
        """
        headings = self._sound(topics.HEADING, convert.heading_from_ros)
        if any(heading.yaw is not None and not heading.stated for heading in headings):
            sigma = convert.UNSTATED_YAW_SIGMA
            self._note(
                topics.HEADING, f"assumed: an accuracy, as none is stated: {sigma:g} rad ({degrees(sigma):.0f} deg)"
            )
        self._headings |= {heading.t: heading for heading in headings}
        self._turns |= bool(headings)
        fixes = []
        for fix in self._sound(topics.FIX, self._fix):
            if isinstance(fix, convert.NoFix) or self._is_elsewhere(fix):
                continue
            beside = convert.nearest(tuple(self._headings), fix.t)
            if beside is not None:
                heading = self._headings.pop(beside)
                fix = msgspec.structs.replace(fix, yaw=heading.yaw, yaw_sigma=heading.sigma)
            elif self._turns:
                self._alone += 1
                if log10(self._alone).is_integer():
                    places = "1 fix" if self._alone == 1 else f"{self._alone} fixes"
                    self._note(
                        topics.HEADING, f"unpaired: {places} so far, as none within {convert.PAIRED:g} s had come"
                    )
            fixes.append(fix)
        if fixes:
            since = fixes[-1].t - convert.PAIRED
            self._headings = {t: heading for t, heading in self._headings.items() if t > since}
        return tuple(fixes)

    def _fix(self, message: Any) -> GnssFix | convert.NoFix:
        fix = convert.fix_from_ros(message, origin=self._origin)
        if isinstance(fix, GnssFix) and not convert.states_accuracy(message):
            self._note(topics.FIX, f"assumed: an accuracy, as none is stated: {convert.UNSTATED_SIGMA:.1f} m per axis")
        return fix

    def _felt(self, topic: topics.Topic, *, turns: bool = True) -> tuple[Imu, ...]:
        """Readings of an IMU; none from one that says that it does not measure what is asked of it."""
        said = self._sound(topic, partial(convert.imu_from_ros, turns=turns))
        if any(isinstance(each, convert.NotMeasured) for each in said):
            what = "force or yaw rate" if turns else "force"
            self._note(topic, f"unmeasured: {what}, as its covariance of -1 says; its messages are not used")
        return tuple(each for each in said if isinstance(each, Imu))

    def _note(self, topic: topics.Topic, what: str) -> None:
        """Tell once a run how messages were understood."""
        if f"{topic.name} {what}" not in self._noted:
            self._noted.add(f"{topic.name} {what}")
            self._record(Trouble(self._clock(), topic.name, what, 1.0))

    def _is_elsewhere(self, fix: GnssFix) -> bool:
        """Whether a fix is far from where the car says that it is; then it is told."""
        away = 0.0 if self._there is None else hypot(fix.x - self._there[0], fix.y - self._there[1])
        if away > ELSEWHERE:
            self._record(Trouble(self._clock(), topics.FIX.name, "elsewhere", away))
        return away > ELSEWHERE

    def _take_feedback(self) -> None:
        if self._by_wire is not None:
            for trouble in self._by_wire.troubles():
                self._record(trouble)
            came = self._health.sift(CAN, self._by_wire.reports(), self._clock(), by_source=self.stepped)
        else:
            came = self._sound(topics.FEEDBACK, self._heard)
        for report in came:
            self._health.speed = report.v
            self._wheels.append(report)
            self._steers.append(report)

    def _heard(self, message: Any) -> Odometry:
        """Feedback; a car that acts on no command of the last cycles is told of."""
        echo = float(message.drive.acceleration)
        since = len(self._asked) == ECHO  # before, it may tell of the time before the first command
        if since and not any(abs(echo - asked) <= 1e-5 * max(1.0, abs(asked)) for asked in self._asked):
            self._record(Trouble(self._clock(), topics.COMMAND.name, "not_obeyed", echo))
        return convert.feedback_from_ros(message)

    def _rows(self) -> FloatArray:
        """Reference motion that has come, with the force felt and the steering angle reported last before."""
        self._take_feedback()
        self._forces.extend(self._felt(topics.REFERENCE_IMU, turns=False))
        motions = self._sound(topics.ODOMETRY, convert.state_from_ros)
        rows = np.zeros((len(motions), 12))
        for row, now in zip(rows, motions, strict=True):
            self._yaw = convert.unwrapped(now.yaw, self._yaw)
            while len(self._steers) > 1 and self._steers[1].t <= now.t + 1e-9:
                self._steers.pop(0)
            while self._forces and self._forces[0].t <= now.t + 1e-9:
                self._force = self._forces.popleft()
            felt, steer = self._force, self._steers[0].steer
            row[:] = now.t, now.x, now.y, now.z, self._yaw, now.v, now.vx, now.vy, now.yaw_rate, felt.ax, felt.ay, steer
        if motions:
            self._there = motions[-1].x, motions[-1].y
            self._sigma = motions[-1].position_sigma or nan
        return rows
