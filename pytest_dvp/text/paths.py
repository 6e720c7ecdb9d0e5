"""Paths as a user would type them."""

from __future__ import annotations

from pathlib import Path


def shown(path: Path) -> str:
    """A path as a user would type it here: relative to the current folder where that is shorter."""
    full = path.absolute()
    here = Path.cwd()
    return full.relative_to(here).as_posix() if full.is_relative_to(here) else str(path)
