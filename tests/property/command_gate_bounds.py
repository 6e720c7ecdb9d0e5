"""What must hold of every output of the guard, whatever was asked: checked by the property tests."""

from __future__ import annotations

from math import isfinite, tan

from vehicle.guard.messages import Decision, Limits, Measured, Outcome, Output

LIMITS = Limits(0.35, 0.4, 2.5, 20.0, 2.5, 8.0, 4.0, area=((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0)))
ROUNDING = 1e-9


def broken(before: Output, decision: Decision, measured: Measured | None, dt: float) -> list[str]:
    """Names of the promises that one output breaks. `dt` [s] since the decision before, at most 0.1 s count."""
    out, asked, car = decision.output, decision.request, LIMITS
    dt = min(max(dt, 0.0), 0.1)
    passed = decision.outcome in (Outcome.PASSED, Outcome.CLAMPED)
    fade = 5.0 * dt + ROUNDING
    promises = {
        "finite": all(isfinite(value) for value in (out.steer, out.accel, out.throttle, out.brake)),
        "angle": abs(out.steer) <= car.max_steer,
        "traction": 0.0 <= out.throttle <= 1.0 and -20.0 <= out.accel <= car.max_acceleration,
        "brake": 0.0 <= out.brake <= 1.0,
        "one pedal": out.throttle == 0.0 or out.brake == 0.0,
        "the brake wins": out.brake == 0.0 or (out.throttle == 0.0 and out.accel <= 0.0),
        "traction comes slowly": out.accel <= before.accel + fade and out.throttle <= before.throttle + fade / 2.5,
        "brake goes slowly": out.brake >= before.brake - fade / 8.0,
        "findings have a reason": decision.outcome is Outcome.PASSED or bool(decision.reasons),
    }
    if decision.outcome is Outcome.STOP:
        promises["stop holds the wheel"] = out.steer == before.steer
        promises["stop brakes"] = out.throttle == 0.0 and out.brake >= max(before.brake, 0.5) and out.accel <= -4.0
    if decision.outcome is Outcome.HANDED_OVER:
        promises["the driver gets no traction"] = out.throttle == 0.0 and out.accel <= 0.0
    if passed:
        assert measured is not None
        bend = measured.v**2 * abs(tan(out.steer)) / car.wheelbase
        was = measured.v**2 * abs(tan(before.steer)) / car.wheelbase
        swing = measured.v**2 * abs(tan(out.steer) - tan(before.steer)) / car.wheelbase
        promises["wheel rate"] = abs(out.steer - before.steer) <= 0.4 * dt + ROUNDING
        promises["lateral acceleration"] = bend <= max(3.0, was) + ROUNDING
        promises["lateral jerk"] = swing <= 5.0 * dt + ROUNDING or was > 3.0
        promises["a bend too fast is opened"] = was <= 3.0 + ROUNDING or dt == 0.0 or bend < was
        promises["speed"] = abs(measured.v) < 20.0 or (out.throttle == 0.0 and out.accel <= 0.0)
        promises["area"] = abs(measured.x) <= 60.0 and abs(measured.y) <= 60.0
    if passed and asked is not None:
        promises["more braking passes"] = out.brake >= min(asked.brake, 1.0) and out.accel <= max(asked.accel, -20.0)
        pressed = asked.accel > 0.0 and asked.brake > 0.0
        promises["the brake brakes by acceleration"] = not pressed or out.accel <= -8.0 * min(asked.brake, 1.0)
        promises["no more than asked"] = out.throttle <= max(asked.throttle, 0.0)
        numbers = (asked.t, asked.sequence, asked.steer, asked.accel, asked.throttle, asked.brake)
        promises["finite commands only"] = all(type(value) in (int, float) and isfinite(value) for value in numbers)
        promises["fresh commands only"] = -0.02 <= decision.t - asked.t < 0.1
    return [name for name, holds in promises.items() if not holds]
