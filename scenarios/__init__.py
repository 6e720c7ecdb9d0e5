"""Scenarios, roads, catalogues, gate files and vehicle models that ship with pytest_dvp. Data; this is all the code."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def path(name: str) -> Path:
    """File of a shipped scenario, e.g. `path("overtaking.xosc")` or `path("models/tabby_evo.toml")`.

    Raises:
        FileNotFoundError: nothing of that name ships.
    """
    found = Path(str(files(__name__) / name))
    if not found.is_file():
        raise FileNotFoundError(f"no scenario file {name!r} ships with pytest_dvp")
    return found
