"""Random and boundary commands, NaN, Inf and None among them: no output leaves its bounds.

`make test` asks a few thousand times, `make reliability` a million (DVP_COMMANDS).
"""

from __future__ import annotations

import os
import random
from collections import Counter
from math import inf, nan, nextafter, pi

from command_gate_bounds import LIMITS, broken

from vehicle.guard.guard import Guard
from vehicle.guard.messages import Decision, Measured, Outcome, Request

COMMANDS = int(os.environ.get("DVP_COMMANDS", "6000"))
DRIVE = 200  # commands, then a new gate
BAD = (nan, inf, -inf, None, 1e300, -1e300, 10**400, "0", True)
EDGES = (0.0, -0.0, 5e-324, 1.0, 0.35, 2.5, -4.0, -8.0, -20.0, 1e11, -1e11, 0.1, 0.02)
AROUND = tuple(nextafter(edge, way) for edge in EDGES for way in (-inf, inf))


def value(dice: random.Random, low: float, high: float) -> float:
    """Mostly something that a stack asks, often an edge, seldom no number."""
    kind = dice.random()
    if kind < 0.985:
        return dice.uniform(low, high) if kind < 0.85 else dice.choice(EDGES + AROUND)
    return dice.choice(BAD)  # type: ignore[return-value]


def drive(dice: random.Random, commands: int, seen: Counter[str]) -> None:
    log: list[Decision] = []
    gate = Guard(LIMITS, vehicle="car", scenario="a", record=log.append, real=False)
    x, y, yaw, v = dice.uniform(-40, 40), dice.uniform(-40, 40), dice.uniform(-pi, pi), dice.uniform(-3, 23)
    now, sequence = dice.uniform(-10, 10), 0
    gate.arm(now, Measured(now, x, y, yaw, v, dice.uniform(-0.4, 0.4)))
    before, last, wish = gate._out, now, 0.0
    for k in range(commands):
        step = dice.choice((0.02, 0.02, 0.02, 0.05, 0.0, 0.09, 0.1, 0.3, -0.01)) if dice.random() < 0.2 else 0.02
        now += step
        v = min(max(v + dice.uniform(-0.2, 0.25), -5.0), 23.0)
        x, y = x + dice.uniform(-0.3, 0.3), y + dice.uniform(-0.3, 0.3)
        wish = value(dice, -0.5, 0.5) if dice.random() < 0.2 else wish
        sequence += dice.choice((1, 1, 1, 7, 0, -1)) if dice.random() < 0.1 else 1
        stamp = now - (dice.choice((0.05, 0.099, 0.1, 0.2, -0.02, -0.03)) if dice.random() < 0.05 else 0.0)
        stamp = stamp if dice.random() < 0.998 else dice.choice(BAD)
        pedal = dice.choice(((0.0, 1.3, 0.0, 0.0), (0.0, 0.0, -0.2, 1.2), (-0.5, 1.5, -0.5, 1.5)))
        asked = Request(
            stamp, sequence, wish, value(dice, -12, 5), value(dice, *pedal[:2]), value(dice, *pedal[2:])
        )  # fmt: skip
        motion: Measured | None = Measured(now, x, y, yaw, v, before.steer, override=dice.random() < 0.001)
        if dice.random() < 0.005:
            motion = dice.choice((None, Measured(now, x, nan, yaw, v, 0.0), Measured(now - 0.2, x, y, yaw, v, 0.0)))
        request = None if dice.random() < 0.1 else asked
        decision = gate.cycle(now, request, motion)
        wrong = broken(before, decision, motion, now - last if k else 0.0)  # the first finds no time to move
        assert not wrong, (wrong, before, decision, motion)
        assert log[-1] is decision
        seen.update((decision.outcome.value, *decision.reasons))
        before, last = decision.output, now


def test_no_command_leaves_its_bounds() -> None:
    seen: Counter[str] = Counter()
    for seed in range(COMMANDS // DRIVE):
        drive(random.Random(seed), DRIVE, seen)
    assert sum(seen[outcome.value] for outcome in Outcome) == COMMANDS // DRIVE * DRIVE
    # the test has reached beyond each bound, or it would show nothing
    reached = {"passed", "clamped", "stop", "handed_over", "command_not_finite", "measurement_not_finite"}
    reached |= {
        "clock_stepped_back",
        "measurement_not_fresh",
        "no_command",
        "command_not_fresh",
        "command_out_of_order",
    }
    reached |= {"area", "overspeed", "speed", "angle", "traction", "brake", "steer_rate", "jerk", "brake_release"}
    reached |= {"brake_wins", "lateral_acceleration", "lateral_jerk", "override"}
    assert reached - set(seen) == set()
