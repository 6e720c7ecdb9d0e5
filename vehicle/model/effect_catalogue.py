"""Finding effects: those of this package, those that other packages announce, and those of a user's file."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import pkgutil
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType

from vehicle.model import effects as effects_package
from vehicle.model.effect import Effect
from vehicle.model.errors import ModelError, nearest_name

ENTRY_POINT_GROUP = "pytest_dvp.effects"


def _effects_of(module: ModuleType) -> list[Effect]:
    return [value for value in vars(module).values() if isinstance(value, Effect)]


def _collect(found: Iterable[tuple[Effect, str]]) -> dict[str, Effect]:
    table: dict[str, Effect] = {}
    for item, where in found:
        known = table.setdefault(item.name, item)
        if known is not item:
            raise ModelError("two effects have this name", key=item.name, found=where)
    return dict(sorted(table.items()))


@cache
def catalogue() -> Mapping[str, Effect]:
    """All effects by name: built-in ones and those announced under the entry point `pytest_dvp.effects`.

    An entry point names a module with decorated functions, or one effect. Raises ModelError on a name used twice and
    on a package whose effects do not load.
    """
    found: list[tuple[Effect, str]] = []
    for info in sorted(pkgutil.iter_modules(effects_package.__path__), key=lambda i: i.name):
        module = importlib.import_module(f"{effects_package.__name__}.{info.name}")
        found += [(e, module.__name__) for e in _effects_of(module)]
    for point in sorted(entry_points(group=ENTRY_POINT_GROUP), key=lambda p: (p.name, p.value)):
        try:
            loaded = point.load()
        except Exception as error:
            reason = f"announced effects cannot be loaded: {type(error).__name__}: {error}"
            raise ModelError(reason, key=point.value, file=point.dist.name if point.dist else "") from error
        items = [loaded] if isinstance(loaded, Effect) else _effects_of(loaded)
        found += [(e, point.value) for e in items]
    return MappingProxyType(_collect(found))


def perception_effect_names() -> frozenset[str]:
    """Names of the effects that act on what the car sees, not on how it moves."""
    return frozenset(name for name, effect in catalogue().items() if effect.slot == "perception")


@cache
def run_setups() -> frozenset[str]:
    """Names of the effects whose values may differ from run to run of the same car: zeros and mountings."""
    return frozenset(name for name, effect in catalogue().items() if effect.diagnosed.run_setup)


def effects_of_file(path: Path) -> Mapping[str, Effect]:
    """The effects of a user's Python file. Raises ModelError if it is missing, fails or holds none.

    The file is run: only name files that you trust.
    """
    if not path.is_file():
        raise ModelError("no such file", file=str(path))
    name = "dvp_effects_" + hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ModelError("not a Python file", file=str(path))
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except ModelError as error:
        raise error.at(str(path), None) from error
    except Exception as error:
        raise ModelError(f"cannot be loaded: {type(error).__name__}: {error}", file=str(path)) from error
    found = _collect((e, str(path)) for e in _effects_of(module))
    if not found:
        raise ModelError("holds no function decorated with @effect", file=str(path))
    return MappingProxyType(found)


def effects_of_files(paths: Iterable[Path]) -> dict[str, Effect]:
    """The effects of several files of the user's own, by name.

    Raises ModelError (one line naming the file) if a file is missing, fails, holds none, or takes a name that is taken.
    """
    found: dict[str, Effect] = {}
    for path in paths:
        for name, effect in effects_of_file(path).items():
            if name in found or name in catalogue():
                raise ModelError("there is an effect of this name already", file=str(path), key=name)
            found[name] = effect
    return found


WHERE = "see `dvp effects`; effects of your own come with --effects FILE.py"


def find_effect(name: str, extra: Mapping[str, Effect] | None = None) -> Effect:
    """The effect called `name`. Raises ModelError with the nearest name."""
    known = {**catalogue(), **(extra or {})}
    if name not in known:
        near = nearest_name(name, known)
        raise ModelError("unknown effect", key=name, found=name, allowed=WHERE, nearest=near)
    return known[name]
