"""Dry, armed, overridden, stopped: the gate's states against a model of four lines, by Hypothesis."""

from __future__ import annotations

import os

from command_gate_bounds import LIMITS, broken
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from vehicle.guard.guard import ArmingRefused, Guard
from vehicle.guard.messages import Arming, Decision, Measured, Outcome, Output, Request, State

EXAMPLES = int(os.environ.get("DVP_STATE_EXAMPLES", "60"))
floats = st.floats(allow_nan=True, allow_infinity=True)
near = st.floats(-2.0, 2.0) | floats


class Arms(RuleBasedStateMachine):
    """A real car: what only keys may open, what every button shuts, and what stays so."""

    def __init__(self) -> None:
        super().__init__()
        self.log: list[Decision] = []
        self.gate = Guard(LIMITS, vehicle="car", scenario="a", record=self.log.append)
        self.expected = State.DRY
        self.now, self.sequence = 0.0, 0
        self.key = 0  # when the arming used last was written
        self.gate._last_arming = 0
        self.before = Output()
        self.override = self.emergency = False
        self.fresh = -1.0  # when the last good command was made

    def motion(self) -> Measured:
        return Measured(self.now, 0.0, 0.0, 0.0, 3.0, self.before.steer, self.override, self.emergency)

    def cycle(self, request: Request | None) -> Decision:
        self.now += 0.02
        motion = self.motion()
        if self.expected is not State.DRY:
            if self.emergency:
                self.expected = State.STOPPED
            elif self.override and self.expected is State.ARMED:
                self.expected = State.OVERRIDDEN
        decision = self.gate.cycle(self.now, request, motion)
        assert broken(self.before, decision, motion, 0.02) == []
        self.before = decision.output
        return decision

    @rule(steer=near, accel=near, throttle=near, brake=near)
    def command(self, steer: float, accel: float, throttle: float, brake: float) -> None:
        self.sequence += 1
        decision = self.cycle(Request(self.now + 0.02, self.sequence, steer, accel, throttle, brake))
        self.fresh = self.now if decision.outcome in (Outcome.PASSED, Outcome.CLAMPED) else -1.0

    @rule(cycles=st.integers(1, 8))
    def silence(self, cycles: int) -> None:
        for _ in range(cycles):
            decision = self.cycle(None)
            if self.now - self.fresh > 0.12 and self.expected is not State.OVERRIDDEN:
                assert decision.outcome is Outcome.STOP

    @rule(override=st.booleans(), emergency=st.booleans())
    def buttons(self, override: bool, emergency: bool) -> None:
        self.override, self.emergency = override, emergency
        self.cycle(None)

    @rule()
    def let_go(self) -> None:
        self.override = self.emergency = False

    @rule(
        named=st.sampled_from(["car", "car", "cart", None]),
        scenario=st.sampled_from(["a", "a", "b"]),
        new=st.booleans(),
    )
    def arm(self, named: str | None, scenario: str, new: bool) -> None:
        key = self.key + 1 if new else self.key
        allowed = named == "car" and scenario == "a" and new and not self.override and not self.emergency
        before = self.gate.state
        try:
            self.gate.arm(self.now, self.motion(), named, Arming("car", scenario, key))
        except ArmingRefused:
            assert not allowed
            assert self.gate.state is before
        else:
            assert allowed
            self.expected, self.key, self.fresh = State.ARMED, key, -1.0
            assert self.gate._out.brake == self.before.brake
            self.before = self.gate._out

    @precondition(lambda self: self.expected is not State.DRY)
    @rule()
    def stop_button_of_the_harness(self) -> None:
        self.gate.emergency_stop()
        self.expected = State.STOPPED

    @rule()
    def disarm(self) -> None:
        self.gate.disarm()
        self.expected, self.before, self.fresh, self.sequence = State.DRY, Output(), -1.0, 0

    @invariant()
    def state_is_as_expected(self) -> None:
        assert self.gate.state is self.expected

    @invariant()
    def nothing_is_live_without_keys(self) -> None:
        if self.log:
            last = self.log[-1]
            assert last.live == (last.state is not State.DRY)
            assert last.engaged == (last.state in (State.ARMED, State.STOPPED))
            assert last.state is not State.STOPPED or last.outcome is Outcome.STOP
            assert (last.state is State.OVERRIDDEN) == (last.outcome is Outcome.HANDED_OVER)


TestArms = Arms.TestCase
TestArms.settings = settings(
    max_examples=EXAMPLES, stateful_step_count=40, deadline=None, derandomize=EXAMPLES < 100, database=None
)
