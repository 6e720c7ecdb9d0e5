"""A TOML file of a user: its content, or one line that says what is wrong and where."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

MOST = 4_000_000  # bytes of a file that is read
_MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
_PLACE = re.compile(r" \(at line (\d+), column \d+\)$| \(at end of document\)$")


class TomlError(ValueError):
    """What is wrong, without the file's name.

    kind  "unreadable", "too_large", "not_utf8", "not_toml", "too_deep"; line: counts from 1, None where there is none
    """

    def __init__(self, text: str, kind: str, line: int | None = None) -> None:
        super().__init__(text)
        self.kind, self.line = kind, line

    def at(self, path: Path) -> str:
        """`FILE:LINE`, or the file alone."""
        return str(path) if self.line is None else f"{path}:{self.line}"


def read_toml(path: Path) -> tuple[dict[str, Any], str]:
    """The tables of a TOML file and its text. A UTF-8 byte order mark, which editors put in front, is passed over.

    Raises TomlError.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MOST + 1)
    except OSError as error:
        raise TomlError(error.strerror or str(error), "unreadable") from None
    if len(data) > MOST:
        raise TomlError(f"larger than {MOST // 1_000_000} MB", "too_large")
    if data[:2] in _MARKS:
        raise TomlError(f"not UTF-8 text but {_MARKS[data[:2]]}: save it as UTF-8", "not_utf8")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise TomlError("not UTF-8 text", "not_utf8", data.count(b"\n", 0, error.start) + 1) from None
    return parse_toml(text), text


def parse_toml(text: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises TomlError."""
    try:
        found = tomllib.loads(text)
        if _too_large(found):
            raise TomlError("not TOML: a whole number of more than 64 bits", "not_toml")
        return found
    except tomllib.TOMLDecodeError as error:
        place = _PLACE.search(str(error))
        line = int(place[1]) if place and place[1] else text.count("\n") + 1
        raise TomlError(f"not TOML: {_PLACE.sub('', str(error))}", "not_toml", line) from None
    except RecursionError:
        raise TomlError("not TOML: nested too deeply", "too_deep") from None
    except TomlError:
        raise
    except ValueError:  # of Python, for a whole number of thousands of digits
        raise TomlError("not TOML: a number with too many digits", "not_toml") from None


def _too_large(value: Any) -> bool:
    if isinstance(value, dict | list):
        return any(map(_too_large, value.values() if isinstance(value, dict) else value))
    return isinstance(value, int) and not -(1 << 63) <= value < 1 << 63
