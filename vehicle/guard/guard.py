"""The only door to an adapter: every command of a driving stack is checked here before it may reach an actuator.

    gate = Gate(limits, vehicle="tabby", scenario="overtaking.xosc", record=log.append)
    gate.arm(now, measured, named="tabby", arming=take(Path("arming.toml")))  # without it: a dry run, nothing is live
    decision = gate.cycle(now, request, measured)  # every 20 ms; request None: no new one has come
    if decision.live: send(decision.output)        # and let go of the actuators unless decision.engaged

Order: finite -> fresh -> armed and not latched -> area -> speed -> angle -> rate -> lateral acceleration and jerk from
the measured speed -> driver override -> emit. What fails up to the area, or is far too fast, gets the stop profile: no
traction, the stop brake at once, the brake never released, the wheel held where it is. The rest is clamped, and each
clamp is named. More braking always passes, at once; only traction and the release of the brake are limited. While the
brake is on there is no traction, by throttle or by acceleration, whatever is asked for. A request holds until the next
one, for less than MAX_AGE; a bad one ends it, and the stop profile follows until a good one comes.
An override stands last because it alone takes the output away from all that was decided before: the driver has the
car, even where the stack has fallen silent.

Time is an argument: there is no clock here. A wire that counts modulo n unwraps its counter before it asks.
`vehicle.guard.guarded_vehicle.GuardedVehicle` puts the guard in front of any Vehicle;
`vehicle.guard.arming.take` reads the file that arms a real car.

This is not a safety device: it needs a trained driver, a hardware emergency stop, and a car that stops by itself when
its commands stay away.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import atan, atan2, copysign, cos, inf, sin, tan

from vehicle.guard.messages import (
    COMMAND,
    HARDEST,
    MOTION,
    Area,
    Arming,
    Decision,
    Limits,
    Measured,
    Outcome,
    Output,
    Request,
    State,
    number,
    numbers,
)

CYCLE = 0.02  # s; how often a decision is due
MAX_AGE = 0.1  # s; a command or a measurement this old is stale
LATERAL_ACCELERATION = 3.0  # m/s^2, ISO 11270
LATERAL_JERK = 5.0  # m/s^3, ISO 11270
JERK = 5.0  # m/s^3, ISO 15622, 5 m/s and slower: how fast traction may come and braking may go
OVERSPEED = 1.1  # of the highest speed: without traction, and still faster: brake
STANDING = 1e-3  # m/s; slower, any angle of the wheel is free of lateral jerk


class ArmingRefused(ValueError):
    """Why the gate stays shut, in one line."""


class _Stop(Exception):
    """Ends the examination: the stop profile, and why."""


class Guard:
    """Stands before one vehicle for one scenario. `record` gets every decision.

    `real` (the default) needs both keys, a declared area, and for each further arming one written later than the last.
    """

    def __init__(
        self, limits: Limits, *, vehicle: str, scenario: str, record: Callable[[Decision], None], real: bool = True
    ) -> None:
        self.limits, self.vehicle, self.scenario, self.real = limits, vehicle, scenario, real
        self._record = record
        self._last_arming: float = -inf
        self.disarm()

    def disarm(self) -> None:
        """Back to a dry run, with nothing remembered but the keys that were used."""
        self.state = State.DRY
        self._out = Output()
        self._held: Request | None = None
        self._now: float | None = None
        self._sequence = self._stamp = -inf

    def arm(self, now: float, measured: Measured, named: str | None = None, arming: Arming | None = None) -> None:
        """Make the outputs live, from the measured steering angle on. Raises ArmingRefused.

        Two keys, the vehicle's name and an arming, each newer than the last: for a real vehicle always, for others
        after a latch. No command from before counts.
        """
        if not number(now) or not numbers(measured, MOTION) or not -CYCLE <= now - measured.t < MAX_AGE:
            raise ArmingRefused("the car's own measurement is missing or stale")
        if measured.emergency_stop is not False or measured.override is not False:
            raise ArmingRefused("the emergency stop is pressed or the driver overrides")
        if self.real and self.limits.area is None:
            raise ArmingRefused("a real car needs a declared area")
        if self.real or self.state is not State.DRY:
            if named != self.vehicle:
                raise ArmingRefused(f"wrong vehicle: it is {self.vehicle!r}, but {named!r} was named")
            if arming is None or (arming.vehicle, arming.scenario) != (self.vehicle, self.scenario):
                raise ArmingRefused(f"arming file: no arming for {self.vehicle!r} and {self.scenario!r}: {arming}")
            if arming.written <= self._last_arming:
                raise ArmingRefused("arming file: this arming was used; a human writes a new one")
            self._last_arming = arming.written
        self.state, self._held = State.ARMED, None
        steer = min(max(float(measured.steer), -self.limits.max_steer), self.limits.max_steer)
        self._out = Output(steer, min(self._out.accel, 0.0), 0.0, self._out.brake)

    def emergency_stop(self) -> None:
        """Latch the stop profile, as the button does."""
        if self.state is not State.DRY:
            self.state = State.STOPPED

    def cycle(self, now: float, request: Request | None, measured: Measured | None) -> Decision:
        """Decide at `now` [s]. Never raises, whatever numbers or None stand in the messages."""
        dt = self._elapsed(now)
        reasons: list[str] = []
        self._watch(measured)
        try:
            held, motion = self._examine(now, dt, request, measured)
            output = self._limit(held, motion, min(dt, MAX_AGE), reasons)
            outcome = Outcome.CLAMPED if reasons else Outcome.PASSED
        except _Stop as stop:
            output, outcome = self._stop_profile(), Outcome.STOP
            reasons.append(str(stop))
        if self.state is State.OVERRIDDEN:
            output, outcome = self._hand_over(measured, min(max(dt, 0.0), MAX_AGE)), Outcome.HANDED_OVER
            reasons.append("override")
        if self.state is State.DRY:
            reasons.append("not_armed")
        self._out = output
        decision = Decision(now, request, output, outcome, tuple(dict.fromkeys(reasons)), self.state)
        self._record(decision)
        return decision

    def _elapsed(self, now: float) -> float:
        if not number(now):
            return 0.0
        last, self._now = self._now, now
        return 0.0 if last is None else now - last

    def _watch(self, measured: Measured | None) -> None:
        """Latches are set whatever else is wrong in this cycle."""
        if self.state is State.DRY or measured is None:
            return
        if measured.emergency_stop is not False:
            self.state = State.STOPPED
        elif self.state is State.ARMED and measured.override is not False:
            self.state = State.OVERRIDDEN

    def _examine(
        self, now: float, dt: float, request: Request | None, measured: Measured | None
    ) -> tuple[Request, Measured]:
        """Finite, fresh, not latched, in the area, not far too fast; raises _Stop."""
        held = self._held if request is None else request
        self._held = None  # what fails below is not held any longer
        if not number(now) or measured is None or not numbers(measured, MOTION):
            raise _Stop("measurement_not_finite")
        if request is not None and not numbers(request, COMMAND):
            raise _Stop("command_not_finite")
        if dt < 0.0:
            raise _Stop("clock_stepped_back")
        if not -CYCLE <= now - measured.t < MAX_AGE:
            raise _Stop("measurement_not_fresh")
        if held is None:
            raise _Stop("no_command")
        if not -CYCLE <= now - held.t < MAX_AGE:
            raise _Stop("command_not_fresh")
        if request is not None:
            if request.sequence <= self._sequence or request.t < self._stamp:
                raise _Stop("command_out_of_order")
            self._sequence, self._stamp = request.sequence, request.t
        self._held = held
        if self.state is State.STOPPED:
            raise _Stop("emergency_stop")
        if self.limits.area is not None:
            v = measured.v
            ahead = v * MAX_AGE + v * abs(v) / (2.0 * self.limits.stop_deceleration)
            stop = (measured.x + ahead * cos(measured.yaw), measured.y + ahead * sin(measured.yaw))
            if not (_inside(self.limits.area, measured.x, measured.y) and _inside(self.limits.area, *stop)):
                raise _Stop("area")
        if abs(measured.v) > OVERSPEED * self.limits.max_speed:
            raise _Stop("overspeed")
        return held, measured

    def _limit(self, asked: Request, measured: Measured, dt: float, reasons: list[str]) -> Output:
        """Clamped to what car and comfort allow; each clamp is named in `reasons`."""

        def clamp(value: float, low: float, high: float, reason: str) -> float:
            clamped = min(max(value, low), high)
            if clamped != value:
                reasons.append(reason)
            return clamped

        car, last, v = self.limits, self._out, measured.v
        steer, accel, throttle = float(asked.steer), float(asked.accel), float(asked.throttle)
        pressed = clamp(float(asked.brake), 0.0, 1.0, "brake")
        if pressed > 0.0 and accel > 0.0:  # a wire may carry the acceleration alone: then it brings the braking
            accel = -pressed * car.max_deceleration
            reasons.append("brake_wins")
        if abs(v) >= car.max_speed:
            accel, throttle = clamp(accel, -inf, 0.0, "speed"), clamp(throttle, -inf, 0.0, "speed")
        steer = clamp(steer, -car.max_steer, car.max_steer, "angle")
        accel = clamp(accel, -HARDEST, car.max_acceleration, "traction")
        throttle = clamp(throttle, 0.0, 1.0, "traction")
        turn = car.max_steer_rate * dt
        steer = clamp(steer, last.steer - turn, last.steer + turn, "steer_rate")
        accel = clamp(accel, -inf, last.accel + JERK * dt, "jerk")
        throttle = clamp(throttle, 0.0, last.throttle + JERK / car.max_acceleration * dt, "jerk")
        brake = clamp(pressed, last.brake - JERK / car.max_deceleration * dt, inf, "brake_release")
        if brake > 0.0 and (accel > 0.0 or throttle > 0.0):
            accel, throttle = min(accel, 0.0), 0.0
            reasons.append("brake_wins")
        steer = self._bend(steer, v, turn, dt, clamp)
        return Output(steer, accel, throttle, brake)

    def _bend(self, steer: float, v: float, turn: float, dt: float, clamp: Callable[..., float]) -> float:
        """Lateral acceleration v^2 tan(steer)/wheelbase and its jerk, at the measured speed."""
        last, base = self._out.steer, self.limits.wheelbase
        widest = atan2(LATERAL_ACCELERATION * base, v * v)
        # a car that became faster within the bend: the wheel goes back as fast as it turns, until that is enough
        start = copysign(max(abs(last) - turn, min(abs(last), widest)), last)
        most = max(abs(start), widest)
        steer = clamp(steer, -most, most, "lateral_acceleration")
        swing = LATERAL_JERK * base * dt / max(v * v, STANDING * STANDING)
        low, high = atan(tan(start) - swing), atan(tan(start) + swing)
        return clamp(steer, min(low, start), max(high, start), "lateral_jerk")  # atan(tan(start)) is rounded

    def _stop_profile(self) -> Output:
        """No traction, at least the stop brake, never less brake than before, the wheel as it was."""
        car, last = self.limits, self._out
        brake = max(last.brake, car.stop_deceleration / car.max_deceleration)
        return Output(last.steer, min(last.accel, -car.stop_deceleration), 0.0, brake)

    def _hand_over(self, measured: Measured | None, dt: float) -> Output:
        """The driver has the car: no traction, the brake fades as in comfort, the wheel follows the driver's hands."""
        car, last, steer = self.limits, self._out, self._out.steer
        if measured is not None and number(measured.steer):
            steer = min(max(float(measured.steer), -car.max_steer), car.max_steer)
        brake = max(last.brake - JERK / car.max_deceleration * dt, 0.0)
        return Output(steer, min(last.accel + JERK * dt, 0.0), 0.0, brake)


def _inside(area: Area, x: float, y: float) -> bool:
    """Whether a ray from the point to the right crosses the outline an odd number of times."""
    odd = False
    for (x0, y0), (x1, y1) in pairwise((*area, area[0])):
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) * (x1 - x0) / (y1 - y0):
            odd = not odd
    return odd
