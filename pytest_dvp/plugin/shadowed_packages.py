"""The packages beside this one, whose names are common: a project may have its own of the same name before them."""

from __future__ import annotations

import importlib.util
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "scenarios")


def hidden_package() -> str | None:
    """One line about a package of ours that Python finds elsewhere, None if all are where they belong.

    A module hides a package as well as a package does: `vehicle.py`. The folder that has it is on Python's path by
    PYTHONPATH, or because `python -m` puts the current one there.
    """
    ours = Path(__file__).resolve().parents[2]
    for name in PACKAGES:
        module = sys.modules.get(name)
        try:
            spec = module.__spec__ if module is not None else importlib.util.find_spec(name)
        except (ImportError, ValueError):
            continue
        places = _places(spec) if spec is not None else []
        if places and ours / name not in places:
            cure = "rename it, or keep its folder off Python's path (PYTHONPATH; pytest in place of python -m pytest)"
            return f"{places[0]} hides the package {name!r} that pytest_dvp needs: {cure}"
    return None


def _places(spec: ModuleSpec) -> list[Path]:
    """The folders of a package, or the file of a module."""
    if spec.submodule_search_locations is not None:
        return [Path(place).resolve() for place in spec.submodule_search_locations]
    return [Path(spec.origin).resolve()] if spec.has_location and spec.origin else []
