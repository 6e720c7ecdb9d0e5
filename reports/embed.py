"""Data inside a page: JSON that cannot end its script element, long lists of numbers in one compressed block.

A page of a run of 300 s would carry 2 MB of digits. Lists are written as differences of whole numbers, then all of
them together as gzip in base64: a tenth of that, and `contents()` of templates/theme.js gives back the same numbers.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

LONG = 32  # numbers of a list from which on it goes into the block; shorter ones stay readable
MOST_DIGITS = 6  # decimals of a list that is written as differences
ARRAYS = "@arrays"  # key of the block in the page's data
ARRAY = "@array"  # {"@array": 3} stands for the block's list number 3


def embed(data: Any) -> str:
    """JSON that may stand inside a script element: no `<`, `>`, `&`, no line separators, no NaN."""
    return _json(data).replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def compact(data: Mapping[str, Any]) -> dict[str, Any]:
    """The same data with its long lists of numbers in one compressed block; same input, same output.

    The block is JSON: of each list either {"digits": d, "steps": [first, differences ...]}, whole numbers in units of
    10^-d with null where the list has None, or the list itself, where it is nested or has finer numbers.
    """
    lists: list[Any] = []
    out: dict[str, Any] = _without_long_lists(data, lists)
    return out | {ARRAYS: packed(_json(lists))} if lists else out


def packed(text: str) -> str:
    """gzip in base64, without a time stamp."""
    return base64.b64encode(gzip.compress(text.encode("utf-8"), mtime=0)).decode("ascii")


def _without_long_lists(value: Any, lists: list[Any]) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_long_lists(entry, lists) for key, entry in value.items()}
    if not isinstance(value, list | tuple):
        return value
    if _count(value) < LONG:
        return [_without_long_lists(entry, lists) for entry in value]
    lists.append(_steps(value))
    return {ARRAY: len(lists) - 1}


def _count(value: Any) -> int:
    """Numbers in a list, nested or not; less than 0 if it holds anything else."""
    total = 0
    for entry in value:
        if entry is None or (isinstance(entry, int | float) and not isinstance(entry, bool)):
            total += 1
        elif isinstance(entry, list | tuple) and (inside := _count(entry)) >= 0:
            total += inside
        else:
            return -1
    return total


def _steps(values: list[Any] | tuple[Any, ...]) -> Any:
    if any(isinstance(entry, list | tuple) for entry in values):
        return values
    array = np.array(values, dtype=np.float64)  # None becomes NaN
    known = ~np.isnan(array)
    numbers = array[known]
    for digits in range(MOST_DIGITS + 1):
        whole = np.rint(numbers * 10.0**digits)
        if (whole / 10.0**digits == numbers).all() and (np.abs(whole) < 2.0**53).all():
            steps = np.full(len(array), None, dtype=object)
            steps[known] = np.diff(whole.astype(np.int64), prepend=0).tolist()
            return {"digits": digits, "steps": steps.tolist()}
    return values


def _json(data: Any) -> str:
    return json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"), default=str)
