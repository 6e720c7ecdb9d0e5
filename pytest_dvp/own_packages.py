"""The packages beside this one, whose names are common: a project may have its own of the same name before them."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "scenarios")


def hidden_package() -> str | None:
    """One line about a package of ours that Python finds elsewhere, None if all are where they belong."""
    ours = Path(__file__).resolve().parent.parent
    for name in PACKAGES:
        module = sys.modules.get(name)
        try:
            spec = module.__spec__ if module is not None else importlib.util.find_spec(name)
        except (ImportError, ValueError):
            continue
        found = [Path(place).resolve() for place in (spec.submodule_search_locations or ())] if spec is not None else []
        if found and ours / name not in found:
            cure = "rename it, or keep its folder off Python's path (pytest in place of python -m pytest)"
            return f"{found[0]} hides the package {name!r} that pytest_dvp needs: {cure}"
    return None
