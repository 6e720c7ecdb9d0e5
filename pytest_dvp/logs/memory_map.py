"""A file as bytes that are read from disk where they are looked at: a large log takes no memory by itself."""

from __future__ import annotations

import mmap
from pathlib import Path
from typing import TypeAlias

from pytest_dvp.logs.log_error import LogError

Mapped: TypeAlias = bytes | mmap.mmap


def mapped(path: Path) -> Mapped:
    """The bytes of a file; slices of it are `bytes`. Raises LogError."""
    try:
        with path.open("rb") as file:
            if not path.stat().st_size:  # nothing can be mapped of an empty file
                return b""
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise LogError(f"{path}: the log cannot be read: {reason}", "log.unreadable") from error
