"""A gate, and the cycles it is asked in: what the tests of the guard share."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import pytest

from vehicle.guard.guard import Guard
from vehicle.guard.messages import Arming, Decision, Limits, Measured, Outcome, Output, Request

# 0.35 rad and 0.4 rad/s of the wheel, 2.5 m wheelbase, 20 m/s, 2.5 and 8 m/s^2; the stop profile brakes with half of it
LIMITS = Limits(0.35, 0.4, 2.5, 20.0, 2.5, 8.0, stop_deceleration=4.0)
FIELD = replace(LIMITS, area=((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)))
KEY = Arming("car", "a.xosc", 1)
NOT_NUMBERS = [nan, inf, -inf, None, "1", True, 1e13, -1e13, 10**400]


class Drive:
    """A gate and the cycles it was asked in."""

    def __init__(self, limits: Limits = LIMITS, armed: bool = True, real: bool = False, **motion: float) -> None:
        self.log: list[Decision] = []
        self.gate = Guard(limits, vehicle="car", scenario="a.xosc", record=self.log.append, real=real)
        still = {"x": 0.0, "y": 0.0, "yaw": 0.0, "v": 0.0, "steer": 0.0}
        self.motion = Measured(0.0, **{**still, **motion})
        self.number = 0
        if armed:
            self.gate.arm(0.0, self.motion)

    def ask(self, t: float, *, stamp: float | None = None, sequence: int | None = None, **asked: float) -> Decision:
        """A new command, made just now, with a measurement made just now."""
        self.number = self.number + 1 if sequence is None else sequence
        values = {"steer": 0.0, "accel": 0.0, "throttle": 0.0, "brake": 0.0, **asked}
        request = Request(t if stamp is None else stamp, self.number, **values)
        return self.gate.cycle(t, request, replace(self.motion, t=t))

    def wait(self, t: float) -> Decision:
        """No new command."""
        return self.gate.cycle(t, None, replace(self.motion, t=t))

    def hold(self, until: float, since: float = 0.0, **asked: float) -> Decision:
        """Ask for the same in every cycle of 20 ms, `until` included."""
        for k in range(round((until - since) / 0.02) + 1):
            decision = self.ask(since + k * 0.02, **asked)
        return decision


def is_stop(decision: Decision, reason: str, steer: float = 0.0, brake: float = 0.5) -> bool:
    """No traction, wheel held, the stop brake, for this reason."""
    held = Output(steer, decision.output.accel, 0.0, brake)
    return (
        decision.outcome is Outcome.STOP
        and decision.reasons[0] == reason
        and decision.output == held
        and decision.output.accel <= -4.0
    )


def near(decision: Decision, steer: float = 0.0, accel: float = 0.0, throttle: float = 0.0, brake: float = 0.0) -> bool:
    """Output within rounding of these."""
    out = decision.output
    return (out.steer, out.accel, out.throttle, out.brake) == pytest.approx((steer, accel, throttle, brake), abs=1e-12)
