"""LogFormat: what a reader declares of its format, and all formats that have a file in this folder."""

from __future__ import annotations

import dataclasses
import functools
import importlib
import pkgutil
from collections.abc import Callable, Sequence
from pathlib import Path

from openscenario.findings import Findings
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.table import Table

Read = Callable[[Path, Findings, Sequence[Path], Budget | None], "list[Stream] | Log"]
"""read(path, findings, msg_dirs, budget): what the file holds before any mapping. Raises LogError with one line."""


@dataclasses.dataclass(frozen=True, slots=True)
class LogFormat:
    """A format of logs. A package that not everybody has is imported inside `read`, so that others need not have it.

    kind     its name in `meta["import"]["format"]`
    endings  of file names, in lower case and with the dot
    begins   (first bytes, what the file then is, as in "an MDF file"); () if nothing marks its beginning
    read     see Read
    table    reads a file that is one table, with its lines, where a log is made without any mapping; None: only `read`
    common   endings that files of other kinds bear as well: in a folder, `dvp check` takes one for a log only if its
             first column is the time
    folder   name of the file that makes its folder a log of this format; "" if no folder is one
    """

    kind: str
    endings: tuple[str, ...]
    begins: tuple[tuple[bytes, str], ...]
    read: Read
    table: Callable[[Path, Budget | None], Table] | None = None
    common: tuple[str, ...] = ()
    folder: str = ""


@functools.cache
def log_formats() -> tuple[LogFormat, ...]:
    """All formats, by the names of their files; the first call loads these."""
    folder = importlib.import_module(str(__package__)).__path__
    names = sorted(module.name for module in pkgutil.iter_modules(folder) if module.name != "log_format")
    found: list[LogFormat] = [importlib.import_module(f"{__package__}.{name}").FORMAT for name in names]
    return tuple(found)


def format_of_kind(kind: str) -> LogFormat:
    """The format that is called `kind`. Raises KeyError if none is."""
    return {one.kind: one for one in log_formats()}[kind]
