"""Times that a log writes as words: a time of day, a date with a time."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

_CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:\.\d+)?)")
_GERMAN = re.compile(r"(\d{2})\.(\d{2})\.(\d{4})[ T]")
_DAY = 86400.0  # s


def seconds_of(cells: Sequence[str]) -> FloatArray | None:
    """Seconds (n,) of stamps like 12:03:04.5, 2026-05-01T12:03:04.5+02:00 or 01.05.2026 12:03:04, NaN where a cell is
    empty; None if one is no such stamp, or if there is none.

    A date counts from 1970 (without a zone as if in UTC), a time of day from midnight, on beyond the next one.

    The result is in [s].
    """
    found = np.full(len(cells), np.nan)
    of_day = True
    for k, text in enumerate(cells):
        cell = text.strip()
        if not cell:
            continue
        clock = _CLOCK.fullmatch(cell)
        if clock is not None:
            found[k] = 3600.0 * int(clock[1]) + 60.0 * int(clock[2]) + float(clock[3])
            continue
        of_day = False
        try:
            stamp = datetime.datetime.fromisoformat(_GERMAN.sub(r"\3-\2-\1T", cell))
        except ValueError:
            return None
        if len(cell) <= len("2026-05-01"):
            return None  # a day is no time
        zone = stamp.tzinfo or datetime.UTC
        found[k] = (stamp.replace(tzinfo=zone) - datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)).total_seconds()
    known = np.isfinite(found)
    if not known.any():
        return None
    if of_day:
        found[known] += _DAY * np.cumsum(np.diff(found[known], prepend=found[known][0]) < -0.5 * _DAY)
    return found
