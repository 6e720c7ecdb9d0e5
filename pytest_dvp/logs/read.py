"""read_log: any log file -> Log. The one entrance; a format is one module that is imported when its file comes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from pytest_dvp.log import Log, LogError
from pytest_dvp.logs.cut import cut_log, parse_argument
from pytest_dvp.logs.table import build_log

KINDS = {".csv": "csv", ".txt": "csv", ".tsv": "csv"}
"""Format by file name ending."""


def read_log(
    argument: str | Path, *, mapping: Path | None = None, msg_dirs: Sequence[Path] = (), strict: bool = True
) -> Log:
    """The log that `argument` names: a file, a bag's folder, or a part of one, `LOG@0:285` (seconds).

    mapping   TOML file that says which field of the file is which signal (see `dvp map`); needed for what names no unit
    msg_dirs  folders with the .msg files of custom ROS types
    strict    False (the doctor): keep errors of the time base as findings instead of raising

    `meta["import"]` of the result says what was converted, aliased and kept unknown, and holds the warnings.
    Raises LogError: one line with file, line, column and code; all findings in `.findings`.
    """
    part = parse_argument(argument)
    log = _whole(part.path, mapping, msg_dirs, strict)
    return log if part.whole else cut_log(log, part.start, part.stop, str(part.path))


def _whole(path: Path, mapping: Path | None, msg_dirs: Sequence[Path], strict: bool) -> Log:
    if not path.exists():
        raise LogError(f"{path}: no such log", "log.unreadable")
    kind = KINDS.get(path.suffix.lower())
    if kind == "csv":
        from pytest_dvp.logs.csv_file import read_csv

        log = build_log(read_csv(path), strict=strict)
    else:
        log = Log.load(path)
    if "import" in log.meta and path.is_file():
        log.meta["import"] |= {"file": path.name, "sha256": sha256(path)}
    return log


def sha256(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
