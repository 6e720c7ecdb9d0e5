"""What several metrics need of one log, worked out once for it."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

from pytest_dvp.logs.log import Log

P = ParamSpec("P")
R = TypeVar("R")


def once_a_log(function: Callable[Concatenate[Log, P], R]) -> Callable[Concatenate[Log, P], R]:
    """A function of a log that is worked out once for each log and further arguments, and kept while the log lives.

    A log never changes, and neither may the answer. Further arguments are numbers or words. An exception is not kept.
    """
    known: weakref.WeakKeyDictionary[Log, dict[Any, R]] = weakref.WeakKeyDictionary()

    @functools.wraps(function)
    def kept(log: Log, /, *args: P.args, **options: P.kwargs) -> R:
        of_log = known.setdefault(log, {})
        key = (args, tuple(sorted(options.items())))
        if key not in of_log:
            of_log[key] = function(log, *args, **options)
        return of_log[key]

    return kept
