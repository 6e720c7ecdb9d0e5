"""Small functions that effects share. Plain Python here; the compiler learns them in `vehicle.model.effect_compiler`.

A signal over one step is a straight line: its mean, and its lead, the value at the start minus the mean (a command that
is held has lead 0).
"""

from __future__ import annotations

import math
from typing import Any

from vehicle.model.bus import GRAVITY

DELAY_LINE = 1024  # steps in a delay line: 1.02 s at 1 kHz
CLOCK = 1e-9  # s, stamps closer than this are the same


def clip(value: float, low: float, high: float) -> float:
    """`value` limited to low..high."""
    return min(max(value, low), high)


def lag_end(y: float, u: float, tau: float, dt: float) -> float:
    """Output of tau y' = u - y after `dt` [s] of constant input u, from y; tau <= 0 [s] passes u through. Exact."""
    if tau <= 0.0:
        return u
    return u + (y - u) * math.exp(-dt / tau)


def lag(y: float, u: float, lead: float, tau: float, dt: float) -> tuple[float, float]:
    """Mean and end of tau y' = input - y over a step of `dt` [s], from y; tau > 0 [s]. Exact.

    The input runs straight from u + lead to u - lead.
    """
    beta = dt / tau
    gone = -math.expm1(-beta)  # share of a step that is through at the end
    share = gone / beta
    start = u + lead
    end = start + (y - start) * (1.0 - gone) - 2.0 * lead * (1.0 - share)
    mean = start + (y - start) * share - 2.0 * lead * (0.5 - (1.0 - share) / beta)
    return mean, end


def limit_rate(y: float, u: float, lead: float, limit: float, dt: float) -> tuple[float, float]:
    """Mean and end over a step of `dt` [s] of what follows u from y no faster than `limit` [1/s]. Exact for lead 0."""
    target = u - lead
    way, most = target - y, limit * dt
    if way > most:
        return y + 0.5 * most, y + most
    if way < -most:
        return y - 0.5 * most, y - most
    if lead != 0.0 or most <= 0.0:
        return u, target
    return u - 0.5 * way * abs(way) / most, u


def delayed(m: Any, u: float, lead: float, delay: float, t: float, dt: float) -> tuple[float, float]:
    """Mean and lead of the input of `delay` [s] ago over the step t..t+dt [s], whose own input is (u, lead). Exact.

    `m` is a memory with DELAY_MEMORY's fields. Steps may differ in length, the delay need be no multiple of one.
    """
    n = int(m.head)
    at = n % DELAY_LINE
    m.ring[at], m.leads[at], m.ends[at], m.spans[at] = u, lead, t + dt, dt
    m.head = n + 1.0
    if delay <= 0.0:
        m.tail = n
        return u, lead
    begin, until = t - delay, t + dt - delay
    j = max(int(m.tail), n + 1 - DELAY_LINE)
    while j < n and m.ends[j % DELAY_LINE] <= begin + CLOCK:
        j += 1
    m.tail = j
    i = j % DELAY_LINE
    first = m.ends[i] - m.spans[i]
    if begin < first - CLOCK:  # before the first step there was m.before
        start = m.before
        now = min(first, until)
    else:
        start = m.ring[i] + m.leads[i] * (1.0 - 2.0 * min(max((begin - first) / m.spans[i], 0.0), 1.0))
        now = begin
    above = 0.0
    while now < until - CLOCK:
        i = j % DELAY_LINE
        end, span = m.ends[i], m.spans[i]
        stop = min(end, until)
        s1 = min(max((now - end) / span + 1.0, 0.0), 1.0)
        s2 = min(max((stop - end) / span + 1.0, 0.0), 1.0)
        above += (stop - now) * (m.ring[i] + m.leads[i] * (1.0 - s1 - s2) - start)
        now = stop
        if j == n:
            break
        j += 1
    mean = start + above / dt
    return mean, start - mean


def arrived(m: Any, delay: float, t: float, dt: float) -> float:
    """Input of `delay` [s] ago at the end of the step t..t+dt [s]; asked after `delayed`, of inputs that are held."""
    n = int(m.head)
    j = max(int(m.tail), n - DELAY_LINE)
    while j < n - 1 and m.ends[j % DELAY_LINE] < t + dt - delay - CLOCK:
        j += 1
    return float(m.ring[j % DELAY_LINE])


def remember(m: Any, t: float) -> int:
    """Place in a record of the past for what is seen at time t [s]; its fields are those of HISTORY_MEMORY."""
    n = int(m.head)
    at = n % DELAY_LINE
    m.times[at] = t
    m.head = n + 1.0
    return at


def recall(m: Any, t: float) -> tuple[int, int, float]:
    """The two places of a record around time t [s] and the share of the second: straight lines between stamps."""
    newest = int(m.head) - 1
    j = max(int(m.tail), newest + 1 - DELAY_LINE, 0)
    while j < newest and m.times[(j + 1) % DELAY_LINE] <= t:
        j += 1
    m.tail = j
    k = min(j + 1, newest)
    first, second = j % DELAY_LINE, k % DELAY_LINE
    span = m.times[second] - m.times[first]
    if span <= 0.0:
        return first, second, 0.0
    return first, second, min(max((t - m.times[first]) / span, 0.0), 1.0)


def spin_up(x: Any) -> float:
    """Force at the wheels [N] that speeds turning parts up with the car, so that the road need not hold it."""
    if x.rotating_mass == 0.0 or x.vx == 0.0:
        return 0.0
    held = x.brake + x.resistance
    along = x.traction + x.drag - x.mass * GRAVITY * math.sin(x.grade) - (held if x.vx > 0.0 else -held)
    return float(x.rotating_mass * along / (x.mass + x.rotating_mass))


def held_across(x: Any) -> float:
    """What the tyres hold across over the weight [-]: in the curve that is driven, on a bank, against a side wind."""
    held = x.vx * x.yaw_rate / GRAVITY + math.sin(x.bank)
    return float(held if x.push == 0.0 else held - x.push / (x.mass * GRAVITY))
