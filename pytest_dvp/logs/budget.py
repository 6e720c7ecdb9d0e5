"""Budget: how large a log may be on disk, and how large it may become when it is unpacked.

Imports the standard library only: the settings read it at start-up.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Iterator, Mapping

FLOOR = 32 << 20
"""Bytes that any log may unpack to, however small its file: 4 million numbers."""
RATIO = 200
"""Unpacked bytes for each byte of the file. Recorded drives unpack to 2 to 60 times their size (a car at rest,
stored by zstd, to 60); a file made to unpack to more than memory holds has 1,000 (zlib) to 30,000 (zstd)."""
HELD = 4 << 30
"""Bytes that a log may take in memory: 30 columns at 100 Hz for 49 hours."""
ROWS = 50_000_000
"""Rows of a log, or messages of a recording: 100 Hz for 139 hours."""
TEXT = 512 << 20
"""Bytes of a file that is read as a whole (CSV, .mat): 11 hours of 11 columns at 100 Hz."""
CONTAINER = 64 << 30
"""Bytes of a file that is read piece by piece (MCAP, bags, MDF): an hour of cameras and LiDAR."""


@dataclasses.dataclass(frozen=True)
class Budget:
    """The most that a log may take; None: the default, which depends on the format and on the size of the file.

    log_bytes   bytes that it may unpack to, and may take in memory
    log_rows    rows, or messages of a recording
    file_bytes  bytes of its file
    """

    log_bytes: int | None = None
    log_rows: int | None = None
    file_bytes: int | None = None

    def __post_init__(self) -> None:
        for name, value in dataclasses.asdict(self).items():
            if value is not None and (not isinstance(value, int) or value < 1):
                raise ValueError(f"{name} is {value}, expected a whole number >= 1")


def parse_size(text: str) -> int:
    """Bytes of `250000`, `500MB` (10^6), `2GiB` (2^30).

    Raises ValueError, whose text is what is allowed, for anything else, and for less than 1.
    """
    # here, because a session without scenarios loads nothing of openscenario (tests/plugin/test_load.py)
    from openscenario.file_budget import parse_size as size

    return size(text)


def shown_size(count: int) -> str:
    """A number of bytes for people: `33 kB`, `1.07 GB`; exact below 1 kB."""
    for unit, size in (("TB", 10**12), ("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if count >= size:
            shown = count / size
            return f"{shown:.3g} {unit}" if shown < 999.5 else f"{shown:.0f} {unit}"
    return f"{count} byte{'' if count == 1 else 's'}"


def shown_apart(found: int, allowed: int) -> tuple[str, str]:
    """Two numbers of bytes for people, to the byte where rounding would make them look the same."""
    told = shown_size(found), shown_size(allowed)
    return told if told[0] != told[1] or found == allowed else (f"{found} bytes", f"{allowed} bytes")


def environment_of(budget: Budget) -> dict[str, str]:
    """The environment variables that hand a budget on to child processes."""
    given = dataclasses.asdict(budget).items()
    return {f"DVP_MAX_{name.upper()}": str(value) for name, value in given if value is not None}


@contextlib.contextmanager
def in_force(budget: Budget) -> Iterator[None]:
    """Within it, logs are read with this budget unless the caller names another, in child processes, too."""
    told = environment_of(budget)
    before = {name: os.environ.get(name) for name in told}
    os.environ.update(told)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def budget_in_force(environ: Mapping[str, str] = os.environ) -> Budget:
    """The budget of the session or command that reads. Raises ValueError for a variable that is no size."""
    found: dict[str, int] = {}
    for field in dataclasses.fields(Budget):
        name = f"DVP_MAX_{field.name.upper()}"
        text = environ.get(name)
        if text:
            try:
                found[field.name] = parse_size(text)
            except ValueError as error:
                raise ValueError(f"environment {name} is {text!r}, expected {error}") from None
    return Budget(**found)
