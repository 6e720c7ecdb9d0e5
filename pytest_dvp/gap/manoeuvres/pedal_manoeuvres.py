"""Manoeuvres of the pedals, and straights."""

from __future__ import annotations

import math

from pytest_dvp.gap.manoeuvres.simulated_driver import Driver, Driving, Shape, Test


def coast_down(d: Driver) -> Driving:
    """Lift off from the highest speed and from half of it, and roll, in both directions."""
    tests = []
    for share, seconds in ((1.0, 2.5), (0.5, 5.0)):
        tests += 2 * [Test(d.fitting(seconds, share=share), seconds, pedal=_always(0.0))]
    return d.tests([*tests, Test(min(2.5, d.top), 6.0, pedal=_always(0.0), end=0.15)])


def full_throttle(d: Driver) -> Driving:
    """Full acceleration from standstill to the highest speed there is room for, and with half of it."""
    tests = []
    for share in (1.0, 0.5):
        tests += [Test(0.0, 1.5, pedal=_always(-1.0)), Test(0.0, 12.0, pedal=_always(share * d.push))]
        tests += [Test(0.0, 2.0, pedal=_always(-1.0))]
    return d.tests(tests)


def brake_steps(d: Driver) -> Driving:
    """Brake steps of growing size up to the hardest, each released once."""

    def step(size: float) -> Shape:
        return lambda tau: 0.0 if 0.7 <= tau <= 1.2 else -size * d.brake

    v = d.fitting(2.5, share=0.9)
    return d.tests([Test(v, 3.0, pedal=step(size), end=0.5) for size in (0.25, 0.5, 0.75, 1.0)])


def brake_ramps(d: Driver) -> Driving:
    """The brake pressed slowly up to the hardest, down to a standstill."""
    v = d.fitting(3.0, share=0.9)

    def ramp(seconds: float) -> Shape:
        return lambda tau: -d.brake * min(tau / seconds, 1.0)

    return d.tests([Test(v, 5.0, pedal=ramp(3.0), end=0.15), Test(v, 5.0, pedal=ramp(1.0), end=0.15)])


def pedal_steps(d: Driver) -> Driving:
    """Throttle and brake on and off in turn, equal steps of both signs, of three sizes."""
    tests = []
    for size in (0.3, 0.6, 1.0):
        tests.append(Test(0.45 * d.top, 6.0, pedal=_on_off(size * d.push, 1.0)))
    return d.tests(tests)


def held_steps(d: Driver) -> Driving:
    """Steps of the pedals that are held for two seconds, down to a roll and up again."""
    tests = []
    for size in (0.5, 1.0):
        tests.append(Test(0.4 * d.top, 8.0, pedal=_on_off(size * d.push, 2.0)))
    return d.tests(tests)


def small_pedal(d: Driver) -> Driving:
    """Small pedal steps of both signs around nought, growing."""
    v = min(5.0, d.fitting(6.0))
    return d.tests([Test(v, 6.0, pedal=_on_off(min(size, d.push), 1.0)) for size in (0.08, 0.16, 0.3, 0.5)])


def lift_offs(d: Driver) -> Driving:
    """Accelerate and lift off, from several speeds, each lift held for two seconds and a half."""

    def push(tau: float) -> float:
        return 0.5 * d.push if tau < 1.0 else 0.0

    return d.tests([Test(d.fitting(3.5, share=share), 3.5, pedal=push) for share in (0.3, 0.5, 0.7, 0.85)])


def both_directions(d: Driver) -> Driving:
    """The straight at two constant speeds, each in both directions."""
    return d.tests([Test(d.fitting(3.5, share=share), 3.5) for share in (0.35, 0.35, 1.0, 1.0)])


def standing_starts(d: Driver) -> Driving:
    """Standstill for three seconds, then a start; gently, and harder, and a stop after each."""
    tests = []
    for share in (0.25, 0.5, 1.0):
        tests += [Test(0.0, 3.0, pedal=_always(-1.0)), Test(0.0, 2.5, pedal=_always(share * d.push))]
        tests += [Test(d.slow, 4.0, pedal=_always(-0.5 * d.brake), end=0.1)]
    return d.tests(tests)


def city(d: Driver) -> Driving:
    """A drive about town: gentle starts, a swerve, a turn, a stop. What any log has; tells little."""
    v = min(7.0, d.fitting(5.0))
    angle = d.angle(v, 0.2 * d.lateral)

    def swerve(tau: float) -> float:
        return angle * math.sin(0.4 * math.pi * tau)

    return d.tests([Test(v, 5.0, swerve), Test(v, 3.0), Test(0.5 * v, 4.0)])


def _always(push: float) -> Shape:
    return lambda tau: push


def _on_off(size: float, hold: float) -> Shape:
    """On, off, brake, off, each for `hold` [s]."""
    signs = (1.0, 0.0, -1.0, 0.0)
    return lambda tau: size * signs[int(tau / hold) % 4]
