"""The packages beside pytest_dvp have common names: how a project's own package of the same name works beside them.

Python knows one module a name. As long as no project has a package of these names, ours are loaded as what they are,
`vehicle`, and `pytest_dvp.rooms.vehicle` is another name of the same module. Where another package of such a name is
found before ours are loaded, all of ours are loaded as `pytest_dvp.rooms.NAME` (mode "apart"), and then

- an import of `vehicle` in a module of ours gives ours: `builtins.__import__` is wrapped, and looks who imports;
- an import of `vehicle` anywhere else gives the project's package, wherever Python's path has it, and ours under a
  second name only if the project has none;
- processes that are started from here do the same, by the environment variable DVP_ROOMS.

Which of these were tried, and what does not work: docs/decisions/own-packages.md.
"""

from __future__ import annotations

import builtins
import functools
import importlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import CodeType, ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "scenarios")
ROOT = Path(__file__).resolve().parents[2]
"""The folder that has our packages: site-packages, or a checkout."""
PREFIX = "pytest_dvp.rooms."
VARIABLE = "DVP_ROOMS"
"""Environment variable: `apart` loads our packages as `pytest_dvp.rooms.NAME` even if nothing hides them."""
APART = "apart"

_python_import = builtins.__import__


def make_room(folders: Iterable[Path] = ()) -> None:
    """Load our packages as `pytest_dvp.rooms.NAME` from now on, if a package of the same name is in sight.

    In sight is what Python has loaded or would find, and what lies in `folders`, which Python may search later. Nothing
    happens once one of our packages has been loaded under its own name, as two copies of a class would be worse.
    """
    if is_apart() or any(_is_ours(sys.modules.get(name)) for name in PACKAGES):
        return
    if os.environ.get(VARIABLE) == APART or any(_in_sight(name, [*folders, Path(_here())]) for name in PACKAGES):
        os.environ[VARIABLE] = APART
        sys.meta_path[:] = [finder for finder in sys.meta_path if not isinstance(finder, _SecondNames)]
        sys.meta_path.insert(0, _ProjectFirst())
        builtins.__import__ = _import


def is_apart() -> bool:
    """Whether our packages are loaded as `pytest_dvp.rooms.NAME` in this process."""
    return any(isinstance(finder, _ProjectFirst) for finder in sys.meta_path)


def install() -> None:
    """Make `pytest_dvp.rooms.NAME` importable, and make room for what is in sight now."""
    if not any(isinstance(finder, _SecondNames | _ProjectFirst) for finder in sys.meta_path):
        sys.meta_path.insert(0, _SecondNames())
        sys.meta_path.append(_TooLate())
    make_room()


def load(point: EntryPoint) -> Any:
    """What an entry point names; one of ours is looked up in our packages. Raises whatever its module raises."""
    return type(point)(point.name, own_value(point), point.group).load()


def own_value(point: EntryPoint) -> str:
    """`module:name` of an entry point, as Python can import it in this process."""
    ours = point.dist is not None and point.dist.name == "pytest-dvp" and point.value.partition(".")[0] in PACKAGES
    return PREFIX + point.value if ours and is_apart() else point.value


def _import(
    name: str,
    globals: Mapping[str, object] | None = None,
    locals: Mapping[str, object] | None = None,
    fromlist: Sequence[str] | None = (),
    level: int = 0,
) -> ModuleType:
    """`builtins.__import__` in mode "apart"."""
    top = name.partition(".")[0]
    if level == 0 and top in PACKAGES and _by_us(globals):
        found = _python_import(PREFIX + name, globals, locals, fromlist, 0)
        return found if fromlist else sys.modules[PREFIX + top]
    return _python_import(name, globals, locals, fromlist, level)


def _by_us(globals: Mapping[str, object] | None) -> bool:
    """Whether the module with these globals is one of ours, run as a program included."""
    if globals is None:
        return False
    spec = globals.get("__spec__")
    name = spec.name if isinstance(spec, ModuleSpec) else str(globals.get("__name__"))
    if name == "__main__":  # a program that was started by its path
        file = globals.get("__file__")
        return isinstance(file, str) and Path(file).is_relative_to(ROOT / "pytest_dvp")
    return name == "pytest_dvp" or name.startswith("pytest_dvp.")


class _ProjectFirst:
    """Mode "apart": an import by its plain name finds the project's package, else ours under a second name."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        top = name.partition(".")[0]
        if top not in PACKAGES:
            return None
        if name == top:
            return _theirs(name) or _second_name(name, PREFIX + name)
        if sys.modules.get(top) is sys.modules.get(PREFIX + top):
            return _second_name(name, PREFIX + name)
        return None


class _SecondNames:
    """Otherwise: `pytest_dvp.rooms.vehicle` is the module `vehicle`."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        plain = name.removeprefix(PREFIX)
        if plain == name or plain.partition(".")[0] not in PACKAGES:
            return None
        return _second_name(name, plain)


class _TooLate:
    """Asked last: says why a module of the project's package is not found where ours was loaded before it was seen."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        top = name.partition(".")[0]
        if name == top or top not in PACKAGES or not _is_ours(sys.modules.get(top)):
            return None
        for place in dict.fromkeys([*sys.path, _here()]):
            folder, inside = Path(place or ".").absolute() / top, name.split(".")[1:]
            if folder.resolve() == ROOT / top:
                continue
            wanted = folder.joinpath(*inside)
            if wanted.with_suffix(".py").is_file() or wanted.is_dir():
                cure = f"put an empty __init__.py into it, or set the environment variable {VARIABLE}={APART}"
                message = f"{folder} is not searched: pytest_dvp has loaded its own package {top!r} before ({cure})"
                raise ModuleNotFoundError(message, name=name)
        return None


class _SecondName:
    """Loads nothing: puts a module under one more name (the protocol of loaders of `importlib`)."""

    def __init__(self, first: str) -> None:
        self._first = first

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        # importlib hands out what stands in sys.modules afterwards.
        sys.modules[module.__name__] = importlib.import_module(self._first)

    def get_code(self, name: str) -> CodeType | None:
        """What `python -m` runs."""
        spec = importlib.util.find_spec(self._first)
        code: CodeType | None = spec.loader.get_code(self._first) if spec is not None and spec.loader else None  # type: ignore[attr-defined]
        return code


def _second_name(name: str, first: str) -> ModuleSpec | None:
    try:
        found = importlib.util.find_spec(first)
    except ValueError:  # it was loaded, and has no spec
        return None
    if found is None:
        return None
    spec = ModuleSpec(name, _SecondName(first), origin=found.origin)  # type: ignore[arg-type]
    spec.submodule_search_locations = found.submodule_search_locations
    return spec


def _in_sight(name: str, folders: Iterable[Path]) -> bool:
    """Whether a package or module of this name is loaded, or would be found, that is not ours."""
    if name in sys.modules or _theirs(name) is not None:
        return True
    files = (Path(name, "__init__.py"), Path(f"{name}.py"))
    return any((folder / file).is_file() and folder.resolve() != ROOT for folder in folders for file in files)


def _theirs(name: str) -> ModuleSpec | None:
    """The package or module of this name that is not ours, wherever Python's path has it. A plain folder is none."""
    for finder in sys.meta_path:
        if isinstance(finder, _ProjectFirst | _SecondNames | _TooLate):
            continue
        if finder is PathFinder:
            spec = PathFinder.find_spec(name, _other_places(tuple(sys.path), _here()))
        else:
            spec = finder.find_spec(name, None)
        if spec is not None and spec.origin is not None and not _lies_here(spec.origin):
            return spec
    return None


@functools.lru_cache(maxsize=4)
def _other_places(path: tuple[str, ...], here: str) -> list[str]:
    """Python's path without the folder that has our packages; `here` is what "" stands for."""
    return [place for place in path if Path(here, place).resolve() != ROOT]


def _here() -> str:
    """The current folder; our own where it was removed, which hides nothing."""
    try:
        return os.getcwd()
    except OSError:
        return str(ROOT)


def _is_ours(module: ModuleType | None) -> bool:
    """Whether a module is one of ours."""
    file = getattr(module, "__file__", None)
    return file is not None and _lies_here(file)


def _lies_here(file: str) -> bool:
    """Whether a package with this __init__.py is ours."""
    return Path(file).resolve().parent.parent == ROOT
