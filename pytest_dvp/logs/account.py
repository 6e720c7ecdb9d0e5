"""Account: what one log file may still unpack to and take in memory, kept while the file is read."""

from __future__ import annotations

import stat
from pathlib import Path

from pytest_dvp.logs.budget import (
    CONTAINER,
    FLOOR,
    HELD,
    RATIO,
    ROWS,
    TEXT,
    Budget,
    budget_in_force,
    shown_apart,
    shown_size,
)
from pytest_dvp.logs.log_error import LogError

_WHOLE = frozenset((".csv", ".tsv", ".txt", ".mat"))  # files that are read as a whole


class Account:
    """What a reader charges before it takes memory. Raises LogError ("log.too_large") when more is asked for.

    file    as the messages name it
    size    bytes on disk
    budget  None: that of the command or session
    """

    def __init__(self, file: str | Path, size: int, budget: Budget | None = None) -> None:
        chosen = budget_in_force() if budget is None else budget
        self.file, self.size = str(file), size
        self.unpacked = self.held = 0
        self._most_unpacked = chosen.log_bytes or max(FLOOR, RATIO * size)
        self._most_held = chosen.log_bytes or min(HELD, self._most_unpacked)
        self._stated = chosen.log_bytes is not None
        self._rows = chosen.log_rows or ROWS

    @property
    def left(self) -> int:
        """Bytes that the log may still unpack to."""
        return self._most_unpacked - self.unpacked

    def unpack(self, count: int) -> None:
        """Charge `count` bytes that are about to be unpacked."""
        self.unpacked += count
        if self.unpacked > self._most_unpacked:
            of = f" from {shown_size(self.size)}" if self.size < self.unpacked else ""
            self._refuse("unpacks to", self.unpacked, f"{of} or more", self._most_unpacked)

    def hold(self, count: int) -> None:
        """Charge `count` bytes that are about to be kept."""
        self.held += count
        if self.held > self._most_held:
            self._refuse("takes", self.held, " of memory or more", self._most_held)

    def rows(self, count: int) -> None:
        """Compare a number of rows, or of messages, with what is allowed.

        Raises LogError (`log.too_large`) if it is more.
        """
        if count > self._rows:
            text = f"{self.file}: the log has {count} rows or more, allowed: {self._rows}"
            raise LogError(f"{text} (--max-log-rows allows more)", "log.too_large")

    def table(self, rows: int, columns: int) -> None:
        """Charge a table of numbers of 8 bytes that is about to be made."""
        self.rows(rows)
        self.hold(8 * rows * columns)

    def _refuse(self, verb: str, count: int, rest: str, most: int) -> None:
        why = "" if self._stated or most == HELD else f", {RATIO} times the file" if most > FLOOR else ""
        found, allowed = shown_apart(count, most)
        text = f"{self.file}: the log {verb} {found}{rest}, allowed: {allowed}{why}"
        raise LogError(f"{text} (--max-log-bytes allows more)", "log.too_large")


def open_account(path: Path, budget: Budget | None = None) -> Account:
    """The account of a file, or of a bag's folder. Raises LogError: cannot be read, no regular file, larger than
    allowed."""
    chosen = budget_in_force() if budget is None else budget
    try:
        files = [file for file in path.iterdir() if file.is_file()] if path.is_dir() else [path]
        size = 0
        for file in files:
            info = file.stat()
            if not stat.S_ISREG(info.st_mode):
                raise LogError(f"{file}: not a regular file", "log.unreadable")
            size += info.st_size
    except OSError as error:
        raise LogError(f"{path}: the log cannot be read: {error.strerror or error}", "log.unreadable") from error
    most = chosen.file_bytes or (TEXT if path.suffix.lower() in _WHOLE else CONTAINER)
    if size > most:
        found, allowed = shown_apart(size, most)
        text = f"{path}: the log is a file of {found}, allowed: {allowed}"
        raise LogError(f"{text} (--max-file-bytes allows more)", "log.too_large")
    return Account(path, size, chosen)
