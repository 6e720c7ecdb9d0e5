"""A time that is written in two columns, whole seconds and nanoseconds, as ROS has it."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.column_names import Header
from pytest_dvp.logs.table import RawColumn

_SECONDS = re.compile(r"(?P<of>(.*[._ ])?)(s|sec|secs|seconds)", re.IGNORECASE)
_NANOSECONDS = re.compile(r"(?P<of>(.*[._ ])?)(ns|nsec|nsecs|nanosec|nanosecs|nanoseconds)", re.IGNORECASE)


def one_time(columns: Sequence[RawColumn]) -> list[RawColumn]:
    """The columns with `t [s]` first in place of two columns such as `s` and `ns` or `stamp.sec` and `stamp.nanosec`.

    As they are if there is no such pair, or if the two do not hold what their names say: whole numbers, nanoseconds
    from 0 to 1e9. Values (n,) of a column have its own unit.
    """
    seconds = {m["of"]: c for c in columns if (m := _SECONDS.fullmatch(c.header.text.strip()))}
    parts = {m["of"]: c for c in columns if (m := _NANOSECONDS.fullmatch(c.header.text.strip()))}
    for of, whole in seconds.items():
        part = parts.get(of)
        if part is None or not _whole(whole) or not _whole(part):
            continue
        known = part.values[np.isfinite(part.values)]
        if not len(known) or known.min() < 0.0 or known.max() >= 1e9:
            continue
        stamp = RawColumn(
            Header(f"{whole.header.text}, {part.header.text}", "t", "s"), whole.values + 1e-9 * part.values
        )
        return [stamp, *(c for c in columns if c is not whole and c is not part)]
    return list(columns)


def _whole(column: RawColumn) -> bool:
    known = column.values[np.isfinite(column.values)]
    return bool(len(known)) and bool(np.all(known == np.round(known)))
