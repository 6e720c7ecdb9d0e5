"""Independent simulations on all cores: compiled code runs without the lock of Python.

Each result is that of the function alone, so what is found does not depend on the number of cores.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TypeVar

import numba

A = TypeVar("A")
B = TypeVar("B")

MOST = 8  # threads; chosen: between the simulations Python itself works, which only one thread can do at a time

_here = threading.local()


def cores() -> int:
    """Threads that `mapped` uses: the cores that this process may use, fewer with NUMBA_NUM_THREADS."""
    return max(min(int(vars(numba.config)["NUMBA_NUM_THREADS"]), MOST), 1)


def mapped(function: Callable[[A], B], items: Iterable[A]) -> list[B]:
    """The function's result for each item, in their order. It must not change what others read. Called from within
    itself it goes on in the same thread."""
    todo = list(items)
    if len(todo) < 2 or cores() < 2 or getattr(_here, "busy", False):
        return [function(item) for item in todo]
    return list(_pool(os.getpid()).map(function, todo))


@lru_cache(maxsize=1)
def _pool(process: int) -> ThreadPoolExecutor:
    """The threads of a process; a forked one has none of its parent's."""
    return ThreadPoolExecutor(cores(), "dvp", initializer=lambda: setattr(_here, "busy", True))
