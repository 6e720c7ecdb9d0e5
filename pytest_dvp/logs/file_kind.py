"""Which kind of file this is by its first bytes, where its name says another."""

from __future__ import annotations

import re
from pathlib import Path

from pytest_dvp.logs.formats.log_format import log_formats
from pytest_dvp.logs.log_error import LogError

# First bytes of files that are no logs, and what they are; those of logs are in `formats/`.
_MAGIC: tuple[tuple[bytes, str], ...] = (
    (b"PK\x03\x04", "a ZIP archive or an Excel sheet"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\x28\xb5\x2f\xfd", "a zstd archive"),
    (b"\xfd7zXZ\x00", "an xz archive"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Word file"),
    (b"\x89HDF\r\n", "an HDF5 file"),
    (b"PAR1", "a Parquet file"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"%PDF", "a PDF"),
    (b"\x7fELF", "a program"),
    (b"MZ", "a program"),
)
_WORDS = (
    (re.compile(rb"\s*(<!doctype html|<html)", re.IGNORECASE), "a web page"),
    (re.compile(rb"\s*<[?!a-zA-Z]"), "an XML file"),
    (re.compile(rb'\s*[{\[]\s*["{\[\]}]'), "a JSON file"),
)
_HEAD = 512  # bytes that are looked at


def refuse_other_kind(path: Path, kind: str) -> None:
    """Raises LogError for a file that begins like one of another kind than `kind` ("csv", "mcap", ...), its name's."""
    if not path.is_file():
        return
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
    except OSError as error:
        raise LogError(f"{path}: the log cannot be read: {error.strerror or error}", "log.unreadable") from None
    what, is_kind = _kind(head)
    if what and is_kind != kind:
        unpack = "; unpack it first" if "archive" in what else "; rename it" if is_kind else ""
        raise LogError(f"{path}: this is {what}, not what {path.suffix or 'its name'} says{unpack}", "log.other_kind")


def _kind(head: bytes) -> tuple[str, str]:
    """What a file that begins like this is, and the kind of log that this is, "" for none; both "" if unknown."""
    logs = ((begin, what, one.kind) for one in log_formats() for begin, what in one.begins)
    for begin, what, kind in (*logs, *((begin, what, "") for begin, what in _MAGIC)):
        if head.startswith(begin):
            return what, kind
    head = head.removeprefix(b"\xef\xbb\xbf")
    return next(((what, "") for pattern, what in _WORDS if pattern.match(head)), ("", ""))
