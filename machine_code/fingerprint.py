"""What goes into the machine code of a function, as one digest.

numba takes from Python: the byte code of the function and of every function that it calls, directly or not; the value
of every global name and closure variable that they read, such as a constant imported from another module; default
arguments; and the options of the compiler. All of this is taken from what Python has loaded, not from files. So neither
the time nor the size of a file matters, nor whether the source was found in a folder, an archive or a test.

The digest may change without need, and then a function is compiled again. It must never stay the same by mistake. So a
name that is read as an attribute counts as a global name, too, if there is one.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Mapping
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

VERSIONED = frozenset({"llvmlite", "numba", "numpy"})
"""Packages whose functions numba replaces by its own; `store.kind_of_machine` holds their versions."""
PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))
CODE = (
    "co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_flags", "co_code", "co_names", "co_varnames",
    "co_freevars", "co_cellvars", "co_exceptiontable",
)  # fmt: skip


PREFIX = __name__.removesuffix("machine_code.fingerprint")
"""What stands before the names of all our packages where a project has packages of the same names; else nothing."""


def plain_name(module: str) -> str:
    """Name of a module without PREFIX, so that the same source has the same machine code under both names."""
    return module.removeprefix(PREFIX)


def fingerprint(function: Callable[..., Any], options: Mapping[str, Any]) -> str:
    """64 hex digits of all that becomes machine code when `function` is compiled with `options` now."""
    walk = _Walk()
    walk.function(function)
    walk.value(sorted((name, repr(value)) for name, value in options.items()), ())
    return hashlib.sha256(repr(walk.parts).encode()).hexdigest()


class _Walk:
    """Goes from a function to everything that it reads, each thing once, always in the same order."""

    def __init__(self) -> None:
        self.parts: list[str | int] = []  # their representation as a list is unambiguous
        self._seen: dict[tuple[int, str], tuple[int, Any]] = {}  # by id; the object is held, so no other gets its id

    def _write(self, *parts: str | int) -> None:
        self.parts += parts

    def _known(self, value: Any, attribute: str = "") -> bool:
        """Whether it was met before; then its number says which it is, and a recursion ends."""
        before = len(self._seen)
        number, _ = self._seen.setdefault((id(value), attribute), (before, value))
        self._write("met", number)
        return number != before

    def function(self, function: Any) -> None:
        """A Python function: its name, code, defaults, and what its names stand for."""
        self._write("function", plain_name(function.__module__), function.__qualname__)
        if self._known(function):
            return
        names, code = _read(function.__code__)
        self._write(code)
        self.value(function.__defaults__, names)
        self.value(sorted((function.__kwdefaults__ or {}).items()), names)
        for name in names:
            if name in function.__globals__:
                self._write("global", name)
                self.value(function.__globals__[name], names)
        for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
            self._write("closure", name)
            try:
                self.value(cell.cell_contents, names)
            except ValueError:  # nothing was assigned yet
                self._write("empty")

    def value(self, value: Any, names: tuple[str, ...]) -> None:
        """A value that code with these `names` can read."""
        self._write(plain_name(type(value).__module__), type(value).__qualname__)
        if isinstance(value, PLAIN):
            self._write(repr(value))
        elif isinstance(value, (tuple, list)):
            self._write(len(value), repr(getattr(value, "_fields", ())))
            for each in value:
                self.value(each, names)
        elif isinstance(value, frozenset):
            self._write(_constant(value))
        elif isinstance(value, np.ndarray):
            self._write(repr((value.dtype, value.shape, value.strides)), hashlib.sha256(value.tobytes()).hexdigest())
        elif isinstance(value, FunctionType):
            self._place_or(self.function, value)
        elif isinstance(value, (ModuleType, type)):
            self._namespace(value, names)
        else:
            self._object(value)

    def _place_or(self, visit: Callable[[Any], None], value: Any) -> None:
        """Only the name of what belongs to Python or to a package whose version counts; all else is visited."""
        if _foreign(value.__module__):
            self._write(value.__module__, value.__qualname__)
        else:
            visit(value)

    def _namespace(self, space: Any, names: tuple[str, ...]) -> None:
        """A module or class: those of its attributes that are read."""
        module = space.__name__ if isinstance(space, ModuleType) else space.__module__
        self._write(plain_name(module), plain_name(space.__name__))
        if _foreign(module):
            return
        for name in (*names, "_fields"):
            # A class may inherit what it has; a module may load what is asked of it, so it is not asked.
            if name not in vars(space) and (isinstance(space, ModuleType) or not hasattr(space, name)):
                continue
            self._write("attribute", name)
            if not self._known(space, name):
                self.value(getattr(space, name), names)

    def _object(self, value: Any) -> None:
        """A compiled function, an intrinsic or a callback: its Python function. Anything else: its representation."""
        for attribute in ("py_func", "_defn", "__wrapped__"):
            inner = getattr(value, attribute, None)
            if isinstance(inner, FunctionType):
                self._write(repr(sorted(getattr(value, "targetoptions", {}).items(), key=lambda item: item[0])))
                self._place_or(self.function, inner)
                return
        shown = repr(value)
        # An address differs from process to process. numba freezes nothing into machine code that shows one.
        self._write("" if " at 0x" in shown else shown)


_codes: dict[int, tuple[CodeType, tuple[str, ...], str]] = {}  # by id; the object is held, so no other gets its id


def _read(code: CodeType) -> tuple[tuple[str, ...], str]:
    """Names of globals and attributes that the code reads, and a digest of the code; of functions inside it, too."""
    if id(code) not in _codes:
        names = dict.fromkeys(code.co_names)
        parts = [repr(getattr(code, field)) for field in CODE]
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                inner, digest = _read(constant)
                names.update(dict.fromkeys(inner))
                parts.append(digest)
            else:
                parts.append(_constant(constant))
        _codes[id(code)] = (code, tuple(names), hashlib.sha256(repr(parts).encode()).hexdigest())
    return _codes[id(code)][1:]


def _constant(value: object) -> str:
    """A literal of the source; the order of a set is not the same in all processes."""
    if isinstance(value, frozenset):
        return f"set {sorted(map(_constant, value))}"
    if isinstance(value, tuple):
        return f"tuple {list(map(_constant, value))}"
    return f"{type(value).__name__} {value!r}"


def _foreign(module: str | None) -> bool:
    top = (module or "").partition(".")[0]
    return top in VERSIONED or top in sys.stdlib_module_names
