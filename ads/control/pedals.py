"""Pedals: throttle and brake that make the car follow the wanted acceleration."""

from __future__ import annotations

from typing import Protocol

from vehicle.messages import VehicleDescription

KP = 0.6  # 1/s
KI = 0.25  # 1/s^2
INTEGRAL_LIMIT = 1.5  # m/s^2
FORGET = 1.5  # s; how fast the expected speed follows the measured one
ROLLING = 0.12  # m/s^2
DRAG_AREA = 0.45  # kg/m; half of air density times drag area of a passenger car
HOLD_BRAKE = 0.35  # of full braking, which keeps a standing car in place; chosen, not measured
STOPPED = 0.03  # m/s
SLOPE = 0.5  # m/s^2; what the integral holds beyond it is a slope (5 %), and still there when the car sets off again


class Pedals(Protocol):
    """Turns a wanted acceleration into pedal positions."""

    def press(self, accel: float, v: float, standing: bool, dt: float) -> tuple[float, float]:
        """Throttle and brake in [0, 1] for `accel` [m/s^2] at speed `v` [m/s]; `standing`: hold the car."""


class PiPedals:
    """Feed-forward from the car's data sheet and PI on the speed that the wanted acceleration should have given."""

    def __init__(self, vehicle: VehicleDescription) -> None:
        self._vehicle = vehicle
        self._expected: float | None = None
        self._integral = 0.0
        # wanted accelerations still on their way through the actuator
        self._pending = [0.0] * (round(vehicle.drive_delay / 0.05) + 1)

    def press(self, accel: float, v: float, standing: bool, dt: float) -> tuple[float, float]:
        """See Pedals."""
        if standing or (v < STOPPED and accel < 0.0):
            self._expected = v
            self._integral = self._integral if self._integral > SLOPE else 0.0
            self._pending = [0.0] * len(self._pending)
            return 0.0, max(HOLD_BRAKE, -accel / self._vehicle.max_deceleration)
        expected = v if self._expected is None else self._expected
        self._pending.append(accel)
        expected += self._pending.pop(0) * dt + (v - expected) * dt / FORGET
        expected = max(expected, 0.0)
        error = expected - v
        self._expected = expected
        car = self._vehicle
        demand = accel + KP * error + self._integral + ROLLING + DRAG_AREA * v * v / car.mass
        throttle = min(max(demand / car.max_acceleration, 0.0), 1.0)
        brake = min(max(-demand / car.max_deceleration, 0.0), 1.0)
        saturated = (throttle >= 1.0 and error > 0.0) or (brake >= 1.0 and error < 0.0)
        if not saturated:
            self._integral += KI * error * dt
            self._integral = min(max(self._integral, -INTEGRAL_LIMIT), INTEGRAL_LIMIT)
        return throttle, brake
