"""How large a scenario, road or catalogue may be: 64 MiB and 2 million elements, or what `DVP_MAX_FILE_BYTES` says.

The variable is how a command or session hands `--max-file-bytes` on, to its child processes, too. Imports the standard
library only.
"""

from __future__ import annotations

import os
import re
from typing import Final

VARIABLE: Final = "DVP_MAX_FILE_BYTES"
BYTES: Final = 64 << 20  # the largest public OpenDRIVE files have some 30 MB
ELEMENTS: Final = 2_000_000  # in that many bytes; the densest public files have an element in 40 bytes
SIZE_FORM: Final = "a whole number >= 1, or one with a unit: 500MB, 2GiB"
_SIZE = re.compile(r"(\d+(?:\.\d+)?)\s*(?:([kmgt])(i?)b?|b)?", re.IGNORECASE | re.ASCII)
_LONGEST = 64  # characters of a size; Python refuses numbers of thousands of digits
_POWERS = {"k": 1, "m": 2, "g": 3, "t": 4}


def parse_size(text: str) -> int:
    """Bytes of `250000`, `500MB` (10^6), `2GiB` (2^30).

    Raises ValueError, whose text is what is allowed, for anything else, and for less than 1.
    """
    found = _SIZE.fullmatch(text.strip())
    if found is None or len(text) > _LONGEST:
        raise ValueError(SIZE_FORM)
    base = 1024 if found[3] else 1000
    value = int(float(found[1]) * base ** _POWERS[found[2].lower()]) if found[2] else int(found[1])
    if value < 1:
        raise ValueError(SIZE_FORM)
    return value


def most_bytes() -> int:
    """Bytes of a file that is read. Raises ValueError for a variable that is no size."""
    text = os.environ.get(VARIABLE)
    if not text:
        return BYTES
    try:
        return parse_size(text)
    except ValueError as error:
        raise ValueError(f"environment {VARIABLE} is {text!r}, expected {error}") from None


def most_elements(bytes_allowed: int) -> int:
    """Elements of a file that is read; more where more bytes are allowed, in proportion."""
    return max(ELEMENTS, ELEMENTS * bytes_allowed // BYTES)
