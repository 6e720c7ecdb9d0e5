"""Manoeuvres of the steering wheel."""

from __future__ import annotations

import math

from pytest_dvp.gap.manoeuvres.simulated_driver import Driver, Driving, Shape, Test

USUAL = 0.6  # of the lateral acceleration allowed


def step_steer(d: Driver) -> Driving:
    """Steps to both sides and back, at 3 m/s, at half and at the highest speed there is room for."""
    tests = [Test(v, 4.0, _doublet(d.angle(v, USUAL * d.lateral), 1.3)) for v in (3.0, 0.55 * d.top)]
    v = d.fitting(4.0)
    return d.tests(
        [*tests, *(Test(v, 4.0, _doublet(d.angle(v, USUAL * d.lateral) * side, 1.3)) for side in (1.0, -1.0))]
    )


def growing_steps(d: Driver) -> Driving:
    """Steps of growing size at 3 m/s."""
    sizes = (0.05, 0.1, 0.2, 0.35)
    return d.tests([Test(3.0, 3.2, _doublet(min(size, d.angle(3.0, USUAL * d.lateral)) * side, 1.0)) for size in sizes
                    for side in (1.0, -1.0)])  # fmt: skip


def full_lock(d: Driver) -> Driving:
    """Slowly to full lock and back, to both sides, at 2 m/s or less."""
    v = min(2.0, math.sqrt(0.8 * d.lateral * d.wheelbase / d.lock))

    def ramp(side: float) -> Shape:
        return lambda tau: side * d.lock * max(min(tau / 2.5, 1.0, (8.0 - tau) / 2.0), 0.0)

    return d.tests([Test(v, 8.0, ramp(1.0)), Test(v, 8.0, ramp(-1.0))])


def slow_ramp(d: Driver) -> Driving:
    """Slowly increasing steering to one side, to the other and back, up to nearly the lateral acceleration allowed."""
    tests = []
    for share in (0.6, 1.0):
        v = d.fitting(6.0, share=share)
        tests += [Test(v, 6.0, _triangle(d.angle(v, 0.95 * d.lateral) * side, 5.6)) for side in (1.0, -1.0)]
    return d.tests(tests)


def sine_sweep(d: Driver) -> Driving:
    """A wave of growing frequency, 0.4 to 2.5 Hz, at two speeds."""
    tests = []
    for share in (0.6, 1.0):
        v = d.fitting(6.0, share=share)
        tests += 2 * [Test(v, 6.0, _sweep(d.angle(v, USUAL * d.lateral), 0.4, 2.5, 6.0))]
    return d.tests(tests)


def sine_with_dwell(d: Driver) -> Driving:
    """One sine of 0.7 Hz that waits half a second at its second peak, both sides first, of two sizes."""
    v = d.fitting(3.5)
    return d.tests([Test(v, 3.5, _dwell(d.angle(v, share * d.lateral) * side)) for share in (0.4, 0.85)
                    for side in (1.0, -1.0)])  # fmt: skip


def slalom(d: Driver) -> Driving:
    """Waves of 0.5 and 1 Hz, near the lateral acceleration allowed."""
    tests = []
    for hertz, seconds in ((0.5, 5.0), (1.0, 4.0)):
        v = d.fitting(seconds)
        tests += 2 * [Test(v, seconds, _wave(d.angle(v, 0.8 * d.lateral), hertz))]
    return d.tests(tests)


def small_steer(d: Driver) -> Driving:
    """Slow triangles of small and growing size, that reverse often."""
    v = min(8.0, d.fitting(5.0))
    return d.tests([Test(v, 5.0, _triangle(size, 1.25)) for size in (0.006, 0.012, 0.025, 0.05)])


def small_steps(d: Driver) -> Driving:
    """Stairs of small steps up and down, each held for a second: what starts to move, and where it comes to rest."""
    v = min(7.0, d.fitting(6.5))

    def stairs(size: float) -> Shape:
        places = (1.0, 2.0, 1.0, 0.0, -1.0, -2.0, -1.0, 0.0)
        return lambda tau: size * places[min(int(tau / 0.8), len(places) - 1)]

    return d.tests([Test(v, 6.5, stairs(size)) for size in (0.004, 0.01, 0.02, 0.04)])


def _doublet(angle: float, hold: float) -> Shape:
    """To one side, to the other, and straight."""
    return lambda tau: angle if tau < hold else -angle if tau < 2.0 * hold else 0.0


def _wave(angle: float, hertz: float) -> Shape:
    """Begins at its peak: so the heading swings about that of the lane."""
    return lambda tau: angle * math.cos(2.0 * math.pi * hertz * tau)


def _sweep(angle: float, first: float, last: float, seconds: float) -> Shape:
    """A wave with a frequency [Hz] that grows evenly."""
    return lambda tau: angle * math.cos(2.0 * math.pi * (first * tau + 0.5 * (last - first) / seconds * tau**2))


def _triangle(angle: float, period: float) -> Shape:
    return lambda tau: angle * 2.0 / math.pi * math.asin(math.sin(2.0 * math.pi * tau / period))


def _dwell(angle: float) -> Shape:
    hertz, wait = 0.7, 0.5
    peak = 0.75 / hertz

    def shape(tau: float) -> float:
        if tau < peak:
            return angle * math.sin(2.0 * math.pi * hertz * tau)
        late = max(tau - wait, peak)
        return angle * math.sin(2.0 * math.pi * hertz * late) if late < 1.0 / hertz else 0.0

    return shape
