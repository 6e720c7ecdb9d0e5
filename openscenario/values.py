"""Numbers, truth values and moments as a file spells them."""

from __future__ import annotations

import math
import re
from datetime import datetime, timedelta
from typing import Final

LARGEST: Final = 1e12  # no figure of a scenario, in SI units, is larger; what is larger is a slip or an attack
LARGEST_COUNT: Final = 2**53
_MIDNIGHT: Final = re.compile(r"(\d{4}-\d\d-\d\d)T24:00:00(?:\.0+)?((?:Z|[-+]\d\d:\d\d)?)")  # xsd:dateTime
UNSIGNED_SHORT: Final = 65_535
UNSIGNED_INT: Final = 2**32 - 1


class BadValue(ValueError):
    """A text is not the value it should be; `code` and `allowed` go into the finding."""

    def __init__(self, code: str, text: str, allowed: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text
        self.allowed = allowed


def to_double(text: str) -> float:
    """A finite number of at most 1e12; `1_000`, `nan`, `inf` and digits of other scripts are none.

    Raises BadValue for any other text.
    """
    try:
        value = float(text)
    except ValueError:
        raise BadValue("value.not_a_number", "not a number", "a number") from None
    if not math.isfinite(value):
        raise BadValue("value.not_finite", "not a finite number", "a finite number")
    if not -LARGEST <= value <= LARGEST:
        raise BadValue("value.out_of_range", "absurd magnitude", f"at most {LARGEST:g} in magnitude")
    if "_" in text or not text.isascii():
        raise BadValue("value.not_a_number", "not a number", "a number")
    return value


def to_limit(text: str) -> float:
    """A number as `to_double` takes it; `INF` and what is larger than 1e12, which both say "no limit", are 1e12.

    Raises BadValue for any other text.
    """
    try:
        endless = float(text) > LARGEST and "_" not in text
    except ValueError:
        endless = False
    return LARGEST if endless else to_double(text)


def to_int(text: str) -> int:
    """A whole number; `3.0` is one, as computed values come so. Raises BadValue for any other text."""
    try:
        value = int(text)
    except ValueError:
        number = to_double(text)
        if number != int(number):
            raise BadValue("value.not_an_integer", "not a whole number", "a whole number") from None
        value = int(number)
    if "_" in text or not text.isascii():
        raise BadValue("value.not_a_number", "not a whole number", "a whole number")
    if not -LARGEST_COUNT <= value <= LARGEST_COUNT:
        raise BadValue("value.out_of_range", "absurd magnitude", "a whole number below 2^53")
    return value


def to_bool(text: str) -> bool:
    """`true`, `false`, `1`, `0`. Raises BadValue for any other text."""
    known = {"true": True, "1": True, "false": False, "0": False}.get(text.strip())
    if known is None:
        raise BadValue("value.not_a_boolean", "not a truth value", "true, false, 1, 0")
    return known


def to_moment(text: str) -> str:
    """The text itself, if it is a date and time in ISO 8601. Raises BadValue for any other."""
    try:
        moment(text)
    except ValueError:
        raise BadValue("value.not_a_moment", "not a date and time", "like 2026-01-31T18:30:00") from None
    return text


def moment(text: str) -> datetime:
    """The date and time that a text in ISO 8601 says; `24:00:00`, as XML has it, is the start of the next day.

    Raises ValueError for a text that is none, or beyond the year 9999.
    """
    written = text.strip()
    midnight = _MIDNIGHT.fullmatch(written)
    if midnight is None:
        return datetime.fromisoformat(written)
    try:
        return datetime.fromisoformat(f"{midnight[1]}T00:00:00{midnight[2]}") + timedelta(days=1)
    except OverflowError:
        raise ValueError("beyond the year 9999") from None


def check_type(text: str, kind: str) -> None:
    """Raises BadValue if `text` is no value of a ParameterType."""
    match kind:
        case "double":
            to_double(text)
        case "integer" | "int":
            to_int(text)
        case "unsignedInt" | "unsignedShort":
            value, most = to_int(text), UNSIGNED_INT if kind == "unsignedInt" else UNSIGNED_SHORT
            if not 0 <= value <= most:
                raise BadValue("value.out_of_range", "out of range", f"0 ... {most}")
        case "boolean":
            to_bool(text)
        case "dateTime":
            to_moment(text)


def spelled(value: float | bool | int | str) -> str:
    """A value as a file spells it: shortest text that reads back equal."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value)) if value else "0"
    return str(value)
