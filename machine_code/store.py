"""Where machine code is kept: a folder for each function, named by the digest of what went into it.

    PLACE / cpython-311-numba-0.68.1-1a2b3c4d / vehicle.model.step_maths.lag-SIGNATURE-DIGEST / files of numba

PLACE is NUMBA_CACHE_DIR if the user has set it, else `__pycache__` of the function's package; where that cannot be
written, numba's folder in the user's cache. Where nothing can be written each process compiles for itself.

Several processes may work at once. numba writes a file whole and then renames it; a folder holds one function for one
kind of arguments and one source, so that two processes that write it write the same. Each process that uses a place
holds a shared lock on it until it ends. Who wrote or loaded a function removes its older folders, but only under an
exclusive lock, that is, while no other process is there that may still need one; else a later process removes them.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import importlib.util
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import llvmlite  # type: ignore[import-untyped,unused-ignore]
import numba
import numpy as np
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _Cache, _CacheLocator
from numba.misc.appdirs import AppDirs

from machine_code.fingerprint import fingerprint, plain_name

try:
    import fcntl
except ImportError:  # Windows: folders are not locked, so old ones stay
    fcntl = None  # type: ignore[assignment]

config: Any = numba.config
SETTINGS = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO_DEFAULT")
"""Settings of numba (NUMBA_...) that change machine code."""


class StoredCode(_Cache):  # type: ignore[misc, unused-ignore]
    """The cache of one compiled function, as numba asks for it. Nothing that is wrong with a disk ends a run."""

    def __init__(self, function: Callable[..., Any], options: Mapping[str, Any]) -> None:
        self._function, self._options = function, dict(options)
        self._folders: dict[str, list[_Folder]] = {}  # by signature
        self._enabled = True

    @property
    def cache_path(self) -> str | None:
        """Folder of one of the signatures that were asked for, None before."""
        return next((str(folders[0].path) for folders in self._folders.values() if folders), None)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code for the signature, None if there is none yet."""
        folders = list(self._places(sig, target_context)) if self._enabled else []
        self._folders[repr(sig)] = folders
        for folder in folders:
            folder.hold()
            try:
                found = folder.files(self._function).load_overload(sig, target_context)
            except Exception:  # whatever a crash or a full disk has made of the files
                shutil.rmtree(folder.path, ignore_errors=True)
                continue
            if found is not None:
                return found
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, in the first place that can be written."""
        for folder in self._folders.get(repr(sig), ()):
            with contextlib.suppress(OSError):
                folder.files(self._function).save_overload(sig, data)
                folder.hold()
                _remove_old(folder.place, {folder.function})
                return

    def enable(self) -> None:
        """Load and save from now on."""
        self._enabled = True

    def disable(self) -> None:
        """Neither load nor save from now on."""
        self._enabled = False

    def flush(self) -> None:
        """Forget what is kept for the signatures that were asked for."""
        for folders in self._folders.values():
            for folder in folders:
                shutil.rmtree(folder.path, ignore_errors=True)

    def _places(self, sig: Any, target_context: Any) -> Iterator[_Folder]:
        source = self._function.__code__.co_filename
        asked = repr(sig)
        # Source that is no file; a type that is known by its address; a user's file that was run by its path, whose
        # stored code could not be loaded because no module of its name can be imported.
        if source.startswith("<") or " at 0x" in asked or self._function.__module__ not in sys.modules:
            return
        digest = fingerprint(self._function, self._options)
        name = re.sub(r"[^\w.]", "", f"{plain_name(self._function.__module__)}.{self._function.__qualname__}")
        function = f"{name[-100:]}-{hashlib.sha256(asked.encode()).hexdigest()[:8]}"
        for place in places(_home(self._function)):
            yield _Folder(place / kind_of_machine(target_context.codegen()), function, digest[:32])


class _Folder:
    """Machine code of one function, for one kind of arguments, from one state of the sources."""

    def __init__(self, place: Path, function: str, digest: str) -> None:
        self.place, self.function = place, function
        self.path = place / f"{function}-{digest}"

    def files(self, function: Callable[..., Any]) -> FunctionCache:
        return _Files(function, self.path)

    def hold(self) -> None:
        """Keep others from removing the folder until this process ends."""
        if self.place not in _held and fcntl is not None:
            with contextlib.suppress(OSError):  # it does not exist yet, or is on a disk without locks
                handle = os.open(self.place, os.O_RDONLY)
                fcntl.flock(handle, fcntl.LOCK_SH)
                _held[self.place] = handle
        _used.setdefault(self.place, {}).setdefault(self.function, set()).add(self.path.name)


_held: dict[Path, int] = {}
_used: dict[Path, dict[str, set[str]]] = {}


def _remove_old(place: Path, functions: set[str]) -> None:
    """Remove what these functions had in `place` from older sources, if no other process is there."""
    handle = _held.get(place)
    if handle is None:
        return
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        used = _used[place]
        since = {f: max(_written(place / name) for name in used[f]) for f in functions}
        for name in os.listdir(place):
            function = name.rpartition("-")[0]
            if function in since and name not in used[function] and _written(place / name) < since[function]:
                shutil.rmtree(place / name, ignore_errors=True)
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_SH)


def _written(folder: Path) -> int:
    """When something was last put into a folder [ns]; 0 if it is gone."""
    try:
        return folder.stat().st_mtime_ns
    except OSError:
        return 0


@atexit.register
def _leave() -> None:
    for place, functions in _used.items():
        _remove_old(place, set(functions))


def places(home: Path) -> list[Path]:
    """Where machine code of the sources below `home` may be kept, best first."""
    beside = _CacheLocator.get_suitable_cache_subpath(str(home / "source.py"))
    users = Path(AppDirs("numba", False).user_cache_dir, beside)
    if config.CACHE_DIR:
        return [Path(config.CACHE_DIR, beside), users]
    return [Path(importlib.util.cache_from_source(str(home / "source.py"))).parent, users]


def _home(function: Callable[..., Any]) -> Path:
    """Folder of the package to which a function belongs; of its file, if it belongs to none."""
    file = Path(function.__code__.co_filename)
    module = function.__module__
    top = module.removesuffix(plain_name(module)) + plain_name(module).partition(".")[0]
    package = getattr(sys.modules.get(top), "__file__", None)
    if package is not None and file.is_relative_to(Path(package).parent):
        return Path(package).parent
    return file.parent


@functools.cache
def kind_of_machine(codegen: Any) -> str:
    """Name of the folder for what cannot share machine code: interpreter, numba, its libraries, settings, processor."""
    settings = [(name, getattr(config, name, None)) for name in SETTINGS]
    rest = repr((llvmlite.__version__, np.__version__, codegen.magic_tuple(), settings))
    interpreter = f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}"
    return f"{interpreter}-numba-{numba.__version__}-{hashlib.sha256(rest.encode()).hexdigest()[:8]}"


class _Files(FunctionCache):  # type: ignore[misc, unused-ignore]
    """numba's own files, in a folder of our choice."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._impl_class = functools.partial(_Implementation, folder=folder)  # type: ignore[assignment]
        super().__init__(function)  # type: ignore[no-untyped-call, unused-ignore]


class _Implementation(CompileResultCacheImpl):  # type: ignore[misc, unused-ignore]
    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        # Not numba's own __init__: NUMBA_CACHE_LOCATOR_CLASSES, which is for a user's functions, would count there.
        self._lineno = function.__code__.co_firstlineno
        self._locator = _Locator(function, folder)
        self._filename_base = "code"


class _Locator(_CacheLocator):  # type: ignore[misc, unused-ignore]
    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._py_file, self._folder = function.__code__.co_filename, folder

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return ""  # the folder's name says it

    def get_disambiguator(self) -> str:
        return ""
