"""What logs are called when several are named at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from pytest_dvp.logs.log_error import LogError


def log_names(arguments: Sequence[str]) -> list[str]:
    """A name for each log, as given on a command line: the file's name where only one log has it, else the whole
    argument.

    Raises LogError if a log is named twice: it would count twice, or hide the other.
    """
    for argument, count in Counter(str(Path(argument)) for argument in arguments).items():
        if count > 1:
            raise LogError(f"{argument}: the log is named {count} times, expected each log once", "log.named_twice")
    bare = Counter(Path(argument).name for argument in arguments)
    return [Path(text).name if bare[Path(text).name] == 1 else str(Path(text)) for text in arguments]
