"""How all packages compile: `@compiled` for functions, `compiled_callback` for what is called by address.

Machine code is kept on disk between processes. numba alone would look only at the file of the function itself, although
the machine code also holds every function that it calls and every constant that it reads, from whatever file. Here each
compiled function has a folder of its own, whose name holds a digest of all of that (`fingerprint.py`), so that after an
edit no machine code of the old source runs. `store.py` says where the folders are and when old ones are removed.

A user's own numba functions are left alone: nothing of numba is changed, and no environment variable is set.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, overload

import numba
from numba.core.ccallback import CFunc
from numba.core.sigutils import normalize_signature

from machine_code.store import StoredCode

F = TypeVar("F", bound=Callable[..., Any])


@overload
def compiled(function: F) -> F: ...


@overload
def compiled(*, inline: str) -> Callable[[F], F]: ...


def compiled(function: F | None = None, *, inline: str = "never") -> F | Callable[[F], F]:
    """Compile a function on its first call with arguments of a kind, or load what an earlier process compiled.

    Without fast-math, so that the same input gives the same bytes. A division by zero gives inf or nan, as in numpy.
    The wrapper for C callers is left out, which nobody needs. Other threads of Python go on meanwhile.
    `inline="always"` puts the function into its callers.
    With NUMBA_DISABLE_JIT=1 the function stays as it is.
    """

    def compile_later(python: F) -> F:
        options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, "inline": inline, "nogil": True}
        made: Any = numba.njit(**options)(python)
        if made is not python:
            made._cache = StoredCode(python, made.targetoptions)
        result: F = made
        return result

    return compile_later if function is None else compile_later(function)


def compiled_callback(signature: Any, function: Callable[..., Any]) -> Any:
    """Compile a function of numba's `signature` now, or load it; `.address` is where C code can call it.

    Raises numba's NumbaError, or KeyError for a field that a record lacks.
    """
    options = {"error_model": "numpy"}
    made: Any = CFunc(function, normalize_signature(signature), locals={}, options=options)
    made._cache = StoredCode(function, options)
    made.compile()
    return made
