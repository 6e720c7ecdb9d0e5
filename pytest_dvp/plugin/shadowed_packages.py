"""Whether a package of the project stands in the way of one of ours: `pytest_dvp.rooms` prevents nearly all of it."""

from __future__ import annotations

import importlib.util
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

from pytest_dvp.rooms.side_by_side import APART, PACKAGES, ROOT, VARIABLE, is_apart, make_room


def hidden_package() -> str | None:
    """One line about a package of ours that Python finds elsewhere, None if ours can be imported.

    This is left where some of our packages were loaded under their own names before the project's package was in sight.
    A module hides a package as well as a package does: `vehicle.py`.
    """
    make_room()
    if is_apart():
        return None
    for name in PACKAGES:
        module = sys.modules.get(name)
        try:
            spec = module.__spec__ if module is not None else importlib.util.find_spec(name)
        except (ImportError, ValueError):
            continue
        places = _places(spec) if spec is not None else []
        if places and ROOT / name not in places:
            cure = f"set the environment variable {VARIABLE}={APART}, or import pytest_dvp before both"
            return f"{places[0]} hides the package {name!r} that pytest_dvp needs: {cure}"
    return None


def _places(spec: ModuleSpec) -> list[Path]:
    """The folders of a package, or the file of a module."""
    if spec.submodule_search_locations is not None:
        return [Path(place).resolve() for place in spec.submodule_search_locations]
    return [Path(spec.origin).resolve()] if spec.has_location and spec.origin else []
