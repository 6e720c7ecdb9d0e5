"""Two logs that should be the same: where they first are not."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from pytest_dvp.logs.log import Log


class FirstDifference(NamedTuple):
    """What differs first, at `t` [s] (None: from before the start), with its value in both logs as text."""

    t: float | None
    what: str
    before: str
    now: str

    def __str__(self) -> str:
        when = "before the start" if self.t is None else f"t={self.t:.3f} s"
        return f"first difference at {when}: {self.what}, {self.before} then, {self.now} now"


def first_difference(before: Log, now: Log) -> FirstDifference | None:
    """The earliest difference of meta, columns, events and tracks of road users; None if there is none."""
    found = list(_all(before, now))
    return min(found, key=lambda one: -1.0 if one.t is None else one.t, default=None)


def _all(before: Log, now: Log) -> Iterator[FirstDifference]:
    yield from _meta("meta", dict(before.meta), dict(now.meta))
    for name in sorted(set(before.columns) | set(now.columns)):
        if name not in before.columns or name not in now.columns:
            yield FirstDifference(None, f"column {name}", *_there(name in before.columns))
        else:
            yield from _series(f"column {name}", before.t, now.t, before[name], now[name])
    for first, second in zip(before.events, now.events, strict=False):
        if first != second:
            said = [f"{event.kind} {event.element} ({event.text})" for event in (first, second)]
            yield FirstDifference(min(first.t, second.t), "event", *said)
            break
    else:
        longer = before.events if len(before.events) > len(now.events) else now.events
        shorter = min(len(before.events), len(now.events))
        if len(longer) > shorter:
            event = longer[shorter]
            yield FirstDifference(event.t, f"event {event.kind} {event.element}", *_there(longer is before.events))
    for name in sorted(set(before.objects) | set(now.objects)):
        if name not in before.objects or name not in now.objects:
            yield FirstDifference(None, f"road user {name}", *_there(name in before.objects))
            continue
        one, other = before.objects[name], now.objects[name]
        for part in ("x", "y", "yaw"):
            yield from _series(f"{part} of {name}", one.t, other.t, getattr(one, part), getattr(other, part))


def _series(what: str, t0: Any, t1: Any, first: Any, second: Any) -> Iterator[FirstDifference]:
    size = min(len(t0), len(t1))
    apart = (first[:size] != second[:size]) & ~(np.isnan(first[:size]) & np.isnan(second[:size]))
    apart |= t0[:size] != t1[:size]
    if apart.any():
        k = int(np.argmax(apart))
        yield FirstDifference(float(min(t0[k], t1[k])), what, f"{first[k]:.9g}", f"{second[k]:.9g}")
    elif len(t0) != len(t1):
        end = t0[-1] if len(t0) > len(t1) else t1[-1]
        yield FirstDifference(float(end), f"length of {what}", f"{len(t0)} samples", f"{len(t1)}")


def _meta(where: str, before: Any, now: Any) -> Iterator[FirstDifference]:
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted(set(before) | set(now)):
            if key not in before or key not in now:
                yield FirstDifference(None, f"{where}.{key}", *_there(key in before))
            else:
                yield from _meta(f"{where}.{key}", before[key], now[key])
    elif before != now:
        yield FirstDifference(None, where, _short(before), _short(now))


def _there(in_before: bool) -> tuple[str, str]:
    return ("there", "missing") if in_before else ("missing", "there")


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
