"""A file that appears whole or not at all, or one line that says why it cannot be written."""

from __future__ import annotations

import contextlib
import os
import threading
from pathlib import Path


class WriteError(OSError):
    """A file that cannot be written: `NAME: cannot be written: why`."""

    def __str__(self) -> str:
        return f"{self.filename}: cannot be written: {self.strerror}"


def write_whole(path: Path, data: bytes) -> None:
    """Write beside the target, then rename: a reader, a full disk or a kill never leaves half a file.

    A link stays one: what it points to is written. What is no file (/dev/null, a pipe) is written to as it is, not
    replaced. Raises WriteError, and leaves nothing behind.
    """
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not target.is_file() and not target.is_dir():
            target.write_bytes(data)
            return
        # of the name a beginning: with what is put around it, it must not get longer than names may be
        # and the number of the thread, as two may write the same file at once
        partial = target.with_name(f".{target.name[:40]}.{threading.get_native_id()}.part")
        try:
            with partial.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            partial.replace(target)
        except BaseException:
            _drop(partial)
            raise
    except OSError as error:
        raise WriteError(error.errno, error.strerror or str(error), str(path)) from None


def write_page(path: Path | str, page: str) -> None:
    """The same for a text, with names from a file system that are no UTF-8 spelled out. Raises WriteError."""
    write_whole(Path(path), page.encode("utf-8", "backslashreplace"))


def _drop(partial: Path) -> None:
    """Remove what was begun; where that fails too, the error that led here tells more."""
    with contextlib.suppress(OSError):
        partial.unlink(missing_ok=True)
