"""Paths as a user would type them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path


def shown(path: Path) -> str:
    """A path as a user would type it here: relative to the current folder where that is shorter."""
    full = path.absolute()
    here = Path.cwd()
    return full.relative_to(here).as_posix() if full.is_relative_to(here) else str(path)


def told_apart(path: Path, others: Iterable[Path], base: Path) -> str:
    """A name for a file among others (itself may be one): its stem, or its path from `base` where they share the stem.

    The path is one word: `north--crossing` of `north/crossing.xosc`.
    """
    full = Path(os.path.abspath(path))
    if all(Path(os.path.abspath(other)) == full for other in others if other.stem.lower() == path.stem.lower()):
        return path.stem
    from_base = full.relative_to(base) if full.is_relative_to(base) else Path(*full.parts[1:])
    return "--".join(from_base.with_suffix("").parts)
