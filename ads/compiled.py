"""How the stack is compiled: cached machine code without fast-math, so that the same input gives the same bytes.

The machine code of a function holds that of the functions it calls, and numba's cache looks only at the file of the
outer one: after a change to an inner function in another file, delete the caches (`*.nbi`, `*.nbc` in `__pycache__`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile a function on its first call; the wrapper for C callers is left out, which nobody needs."""
    options: dict[str, Any] = {"cache": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    made: F = numba.njit(**options)(function)
    return made
