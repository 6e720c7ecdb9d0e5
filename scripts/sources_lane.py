"""The lane, its light and standing still, computed once more (scripts/metric_sources.py): loops over rows."""

from __future__ import annotations

import cmath
import math

from pytest_dvp.logs.log import Log
from scripts.drawn_logs import STEP
from scripts.sources_boxes import pose, ring, size_of


def lane_time_outside(log: Log) -> float | None:
    a, b = (complex(*point) for point in log.reference)
    along, out, known, last = (b - a) / abs(b - a), 0, 0, False
    for k in range(len(log.t)):
        m, axis, _ = pose(log, k)
        seen = [(p - a) / along for p in ring(m, axis, size_of(log))]
        beside = [abs(p.imag) for p in seen if 0.0 <= p.real <= abs(b - a)]
        known += bool(beside)
        outside = bool(beside) and max(beside) > log["lane_width"][k] / 2
        out, last = out + (outside and k < len(log.t) - 1), last or outside
    return max(out, 1 if last else 0) * STEP if known else None  # one that ends outside was outside for a step


def at_line(log: Log, k: int) -> tuple[float, bool]:
    """How far the ego's front is beyond the line, and whether it is beside the middle of the lane."""
    line = log.meta["stop_lines"][0]
    m, axis, _ = pose(log, k)
    p = (m + log.meta["ego"]["length"] / 2 * axis - complex(line["x"], line["y"])) * cmath.exp(-1j * line["heading"])
    return p.real, abs(p.imag) <= line["width"] / 2


def lamp(log: Log, t: float) -> str:
    """red (amber beside it or not), green or other at a time: the last state told."""
    state = next(e.text for e in reversed(log.events) if e.t <= t + 1e-6)
    red = dict.fromkeys(("red", "red;amber", "on;off;off", "on;on;off"), "red")
    return (red | {"green": "green", "off;off;on": "green"}).get(state, "other")


def red_light(log: Log) -> float | None:
    for k in range(1, len(log.t)):
        (before, _), (now, beside) = at_line(log, k - 1), at_line(log, k)
        if before < 0.0 <= now and beside and lamp(log, log.t[k]) == "red":
            return 1.0
    return 0.0


def stop_line(log: Log) -> float | None:
    best, meant = -math.inf, False
    for k, t in enumerate(log.t):
        place, beside = at_line(log, k)
        red = lamp(log, t) == "red"
        meant = red and (meant or (beside and -50.0 < place < 0.0))
        if meant and beside:
            best = max(best, place)
    return best if best > -math.inf else None


def start_up_delay(log: Log) -> float | None:
    found = []
    for k in range(1, len(log.t)):
        if lamp(log, log.t[k - 1]) != "green" and lamp(log, log.t[k]) == "green":
            place, beside = at_line(log, k)
            if beside and -50.0 < place < 0.0 and log["v"][k] < 0.5:
                turned_at = max(e.t for e in log.events if e.t <= log.t[k] + 1e-6)
                off_at = next((log.t[j] for j in range(k, len(log.t)) if log["v"][j] > 0.5), log.t[-1])
                found.append(off_at - turned_at)
    return max(found, default=None)


def stop_error(log: Log) -> float | None:
    if log["v"][-1] > 0.05:
        return None
    a, b = (complex(*point) for point in log.reference)
    return abs(((complex(log["x"][-1], log["y"][-1]) - b) * (b - a).conjugate() / abs(b - a)).real)


def creep(log: Log) -> float | None:
    found, k = [], 0
    while k < len(log.t):
        j = k
        while j < len(log.t) and log["v"][j] < 0.3:
            j += 1
        if (j - 1 - k) * STEP >= 1.0 - 1e-9:
            found.append(sum((log["v"][i] + log["v"][i + 1]) / 2 * STEP for i in range(k, j - 1)))
        k = max(j, k + 1)
    return max(found, default=None)
