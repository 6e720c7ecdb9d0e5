"""Sensors beyond those with a message of their own: each file of this folder that has a function `default`."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Mapping
from types import MappingProxyType, ModuleType


@functools.cache
def further_sensors() -> Mapping[str, ModuleType]:
    """The modules of further sensors by name; `default()` of each is that sensor as the default car has it."""
    folder = importlib.import_module(str(__package__)).__path__
    names = sorted(module.name for module in pkgutil.iter_modules(folder))
    modules = {name: importlib.import_module(f"{__package__}.{name}") for name in names}
    return MappingProxyType({name: module for name, module in modules.items() if hasattr(module, "default")})
