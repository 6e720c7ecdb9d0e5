"""Any vehicle behind the guard: a Vehicle that wraps a Vehicle.

    car = Gated(adapter, limits_of(adapter.description), name="tabby", scenario="overtaking.xosc", record=log.append)
    car.reset(state)                                    # a vehicle that is not real is armed by this
    car.reset(state, arming=take(Path("arming.toml")), named="tabby")   # a real one; without keys: a dry run
    car.observe(...); car.apply(command); car.step(0.05)                # as with any vehicle

Nobody else holds the adapter. `step` passes time in cycles of 20 ms at most and asks the gate in each, so that the
watchdog acts within one cycle. In a dry run nothing is handed to the adapter but `reset`, `observe` and `step`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from vehicle.adapter import Hands, Supervised, Vehicle, position_sigma_of
from vehicle.guard.guard import CYCLE, ArmingRefused, Guard
from vehicle.guard.messages import MOTION, Area, Arming, Decision, Limits, Measured, Request, State, numbers
from vehicle.messages import (
    TRACE_COLUMNS,
    Command,
    FloatArray,
    Observation,
    Surroundings,
    VehicleDescription,
    VehicleState,
    brake_first,
)

MEASURING = 10  # cycles that a car has for its first measurement; chosen: ten cycles of 20 ms
STEER_RATE = 0.4  # rad/s; CommonRoad vehicle models (Althoff, Wuersching 2020), all cars


def limits_of(
    car: VehicleDescription, *, max_speed: float | None = None, area: Area | None = None, steer_rate: float = STEER_RATE
) -> Limits:
    """Limits from a data sheet; `max_speed` [m/s] below the car's own, `steer_rate` [rad/s] of the road wheel."""
    speed = car.max_speed if max_speed is None else min(max_speed, car.max_speed)
    return Limits(
        car.max_steer, steer_rate, car.wheelbase, speed, car.max_acceleration, car.max_deceleration,
        stop_deceleration=car.max_deceleration, area=area,
    )  # fmt: skip


class GuardedVehicle:
    """A vehicle that obeys the gate only. `record` gets every decision; arguments are those of Gate.

    keys  asks a vehicle that is not real for both keys and an area as well: a rehearsal of what a real one needs
    """

    def __init__(
        self,
        vehicle: Vehicle,
        limits: Limits,
        *,
        name: str,
        scenario: str,
        record: Callable[[Decision], None],
        keys: bool = False,
    ) -> None:
        self._vehicle = vehicle
        self._keys = keys or vehicle.is_real
        self._gate = Guard(limits, vehicle=name, scenario=scenario, record=record, real=self._keys)
        self._sequence = 0
        self._motion: Measured | None = None
        self._t = 0.0
        self._asked: float | None = None  # when the gate was asked last

    @property
    def description(self) -> VehicleDescription:
        """The vehicle's."""
        return self._vehicle.description

    @property
    def is_real(self) -> bool:
        """The vehicle's."""
        return self._vehicle.is_real

    @property
    def position_sigma(self) -> float:
        """The vehicle's [m]."""
        return position_sigma_of(self._vehicle)

    @property
    def needs_keys(self) -> bool:
        """Whether it is armed by both keys only: a real car, or a rehearsal of one."""
        return self._keys

    @property
    def armed(self) -> bool:
        """False in a dry run: nothing reaches the actuators."""
        return self._gate.state is not State.DRY

    def reset(self, state: VehicleState, *, named: str | None = None, arming: Arming | None = None) -> None:
        """Reset the vehicle, then arm the gate: a vehicle that needs no keys at once, any other with both.

        One without any key stays dry. One that needs keys is armed from what it measures itself, not from `state`: it
        is let go on without a command until it tells, and reset a second time. That its measurement is recent is
        judged without the second reset: the one that arms may be older by as long as that takes (a LiveCar: 0.2 s and a
        little), until the first of the run replaces it. Raises ArmingRefused if keys were given and do not fit, or if
        no measurement comes.
        """
        self._gate.disarm()
        self._vehicle.reset(state)
        self._t, self._sequence, self._asked = state.t, 0, None
        self._motion = Measured(state.t, state.x, state.y, state.yaw, state.v, state.steer)
        if self._keys and named is None and arming is None:
            return
        if self._keys:
            self._motion = self._measure(state)
        self.arm(named, arming)
        self._motion = dataclasses.replace(self._motion, t=state.t)  # the run begins with it

    def _measure(self, state: VehicleState) -> Measured:
        """How the car says that it stands, as old at `state.t` as it was when it came. Raises ArmingRefused."""
        for cycles in range(1, MEASURING + 1):
            rows = self._vehicle.step(CYCLE)
            if len(rows):
                measured = _motion_of(rows)
                self._vehicle.reset(state)
                return dataclasses.replace(measured, t=measured.t - cycles * CYCLE)
        raise ArmingRefused(f"the car's own measurement is missing: no motion within {MEASURING * CYCLE:g} s")

    def arm(self, named: str | None = None, arming: Arming | None = None) -> None:
        """Arm again, after an override or an emergency stop: with both keys. Raises ArmingRefused."""
        if self.is_real and not isinstance(self._vehicle, Supervised):
            raise ArmingRefused("a real car must report its driver's hands and emergency stop (Supervised)")
        measured = self._measured()
        if measured is None:
            raise ArmingRefused("reset comes first")
        self._gate.arm(self._t, measured, named, arming)

    def emergency_stop(self) -> None:
        """Latch the stop profile from the next cycle on."""
        self._gate.emergency_stop()

    def observe(self, surroundings: Surroundings) -> Observation:
        """The vehicle's sensors."""
        return self._vehicle.observe(surroundings)

    def apply(self, command: Command, sequence: int | None = None) -> None:
        """Ask the gate; what it decides goes to the vehicle. `sequence`: the sender's own number, where it has one.

        The gate is asked for no less deceleration than the brake pedal stands for: a vehicle may obey either.
        """
        self._sequence = self._sequence + 1 if sequence is None else sequence
        accel = command.accel
        if numbers(command, ("accel", "brake")) and accel <= 0.0:  # above it is for the gate, which says what it takes
            accel = brake_first(command, self._gate.limits.max_deceleration).accel
        self._ask(Request(command.t, self._sequence, command.steer, accel, command.throttle, command.brake))

    def step(self, dt: float) -> FloatArray:
        """Let `dt` [s] pass, in cycles of 20 ms at most; the gate is asked between them.

        Returns rows (n, 12) of TRACE_COLUMNS. Raises ValueError if `dt` is not positive.
        """
        if dt <= 0.0:
            raise ValueError(f"dt = {dt!r} s is not positive")
        rows: list[FloatArray] = []
        left = dt
        while left > 1e-9:
            if self._asked != self._t:
                self._ask(None)
            cycle = min(left, CYCLE)
            part = self._vehicle.step(round(cycle, 9))
            rows.append(part)
            self._t += cycle
            if len(part):
                self._motion = _motion_of(part)
            left -= cycle
        return np.concatenate(rows)

    def stop(self) -> None:
        """Bring the car to a halt with what it can do; in a dry run, and where the driver has it, nothing."""
        if self._gate.state in (State.ARMED, State.STOPPED):
            self._vehicle.stop()

    def close(self) -> None:
        """Back to a dry run, and free the vehicle."""
        self._gate.disarm()
        self._vehicle.close()

    def _ask(self, request: Request | None) -> None:
        self._asked = self._t
        decision = self._gate.cycle(self._t, request, self._measured())
        if decision.live:
            out = decision.output
            self._vehicle.apply(Command(self._t, out.steer, out.accel, out.throttle, out.brake))

    def _measured(self) -> Measured | None:
        """The newest motion, however old, with the driver's hands as they are now."""
        if self._motion is None:
            return None
        hands = self._vehicle.hands if isinstance(self._vehicle, Supervised) else Hands(False, False)
        return dataclasses.replace(self._motion, override=hands.override, emergency_stop=hands.emergency_stop)


def _motion_of(rows: FloatArray) -> Measured:
    """The newest of rows (n, 12) of TRACE_COLUMNS; the driver's hands are not in them."""
    t, x, y, yaw, v, steer = (float(rows[-1, TRACE_COLUMNS.index(name)]) for name in MOTION)
    return Measured(t, x, y, yaw, v, steer)
