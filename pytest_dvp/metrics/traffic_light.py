"""Red lights: lines crossed, how near to a line or beyond it the ego came while it was red, and when it set off."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._ego_box import ego_size
from pytest_dvp.metrics.metric import Measured, Positive, metric
from vehicle.messages import lit_lamps

BACK = 50.0  # m before the line from which on a red light is the ego's
ROLLING = 0.5  # m/s; faster has set off


@metric(name="red_light", unit="-", bigger_is_worse=True)
def red_light(log: Log) -> Measured:
    """Number of traffic lights whose stop line the front of the ego crossed in driving direction while they were red.

    Lines from meta `stop_lines` (where the OpenDRIVE signal stands), phases from the events "signal"; red is red alone
    and red with amber. Source: Vienna Convention on Road Signs and Signals (1968), article 23(1)(a)(ii) and (iii): red
    means that vehicles may not proceed beyond the stop line, and amber beside it does not affect that. Undefined if no
    light of the map was ever in a state.
    """
    first: dict[str, float] = {}
    for name, t, ahead, beside, red in _lights(log):
        crossed = np.flatnonzero((ahead[:-1] < 0.0) & (ahead[1:] >= 0.0) & beside[1:] & red[1:]) + 1
        if len(crossed):
            first[name] = float(t[crossed[0]])
    if not first:
        return Measured(0.0)
    earliest = min(first, key=lambda name: first[name])
    return Measured(float(len(first)), first[earliest], earliest)


@metric(name="stop_line", unit="m", bigger_is_worse=True)
def stop_line(log: Log) -> Measured:
    """How far the front of the ego was at most beyond the stop line of a light that turned red before it got there.

    Below 0: how far before the line it stayed. Counts from a red light with the ego before the line, by 50 m at most,
    until it is no longer red. Lines, phases and source as in `red_light`. Undefined if no light was red ahead of the
    ego.
    """
    best, when, who = -np.inf, None, ""
    for name, t, ahead, beside, red in _lights(log):
        edge = np.diff(np.concatenate([[False], red, [False]]).astype(np.int64))
        for a, b in zip(np.flatnonzero(edge == 1), np.flatnonzero(edge == -1), strict=True):
            meant = np.flatnonzero((ahead[a:b] < 0.0) & (ahead[a:b] > -BACK) & beside[a:b])
            if not len(meant):
                continue
            part = np.where(beside[a + meant[0] : b], ahead[a + meant[0] : b], -np.inf)
            k = int(np.argmax(part))
            if part[k] > best:
                best, when, who = float(part[k]), float(t[a + meant[0] + k]), name
    if when is None:
        raise Undefined("no traffic light was red ahead of the ego")
    return Measured(best, when, who)


@metric(name="start_up_delay", unit="s", bigger_is_worse=True, note="faster than {slow} m/s")
def start_up_delay(log: Log, *, slow: Positive = ROLLING) -> Measured:
    """Longest time from a light turning green until an ego that waits for it is faster than `slow` [m/s].

    It waits if it is slower than `slow` when the light turns green, with its front before the line, by 50 m at most; an
    ego that never sets off counts until the end of the log. Lines and phases as in `red_light`. Source: start-up
    response time, Transportation Research Board, Highway Capacity Manual (2016), chapter 19, of which the first vehicle
    is meant. Undefined if the ego waited for no light that turned green.
    """
    best, when, who = -1.0, None, ""
    v = np.abs(log["v"])
    for name, t, ahead, beside, _ in _lights(log):
        phases = sorted((e for e in log.events if e.kind == "signal" and e.element == name), key=lambda e: e.t)
        for before, event in itertools.pairwise(phases):
            k = int(np.searchsorted(t, event.t - 1e-6))
            if is_green(before.text) or not is_green(event.text) or k >= len(t):
                continue
            if not (beside[k] and -BACK < ahead[k] < 0.0 and v[k] < slow):
                continue
            off = np.flatnonzero(v[k:] > slow)
            delay = float(t[k + off[0]] if len(off) else t[-1]) - event.t
            if delay > best:
                best, when, who = delay, event.t, name
    if when is None:
        raise Undefined("the ego waited for no traffic light that turned green")
    return Measured(best, when, who)


def _lights(log: Log) -> Iterator[tuple[str, FloatArray, FloatArray, NDArray[np.bool_], NDArray[np.bool_]]]:
    """Of each light with a line and a state: t, how far the ego's front is beyond the line, whether beside it, red."""
    lines = log.meta.get("stop_lines")
    if not isinstance(lines, list) or not lines:
        raise Undefined("the map has no traffic light with a stop line (meta: stop_lines)")
    length, _, middle = ego_size(log)
    front = middle + 0.5 * length
    x, y = log["x"] + front * np.cos(log["yaw"]), log["y"] + front * np.sin(log["yaw"])
    told = False
    for line in lines:
        try:
            name = str(line["signal"])
            px, py, heading, width = (float(line[key]) for key in ("x", "y", "heading", "width"))
        except (TypeError, KeyError, ValueError):
            raise Undefined("meta stop_lines is not what a run writes: signal, x, y, heading, width") from None
        red = np.zeros(len(log.t), dtype=bool)
        phases = [event for event in log.events if event.kind == "signal" and event.element == name]
        for event in sorted(phases, key=lambda event: event.t):
            red[log.t >= event.t - 1e-6] = is_red(event.text)
        if not phases:
            continue
        told = True
        dx, dy = x - px, y - py
        ahead = dx * np.cos(heading) + dy * np.sin(heading)
        beside = np.abs(dy * np.cos(heading) - dx * np.sin(heading)) <= 0.5 * width
        yield name, log.t, ahead, beside, red
    if not told:
        raise Undefined("no traffic light of the map was ever in a state")


def is_red(state: str) -> bool:
    """Whether red is lit in a state of a signal, amber beside it or not."""
    return "red" in lit_lamps(state)


def is_green(state: str) -> bool:
    """Whether a state of a signal lets traffic go."""
    return "green" in lit_lamps(state)
