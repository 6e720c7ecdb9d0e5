"""Searchers: each asks for points and is told how good they were. Begin with `search.py`.

Every other file here is a searcher: a study calls it by the name of the file, whose function `make(knobs, start, seed)`
returns it.
"""

from __future__ import annotations

import pkgutil


def search_names() -> tuple[str, ...]:
    """The names of all searchers, without loading any: some need packages that are not installed."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__) if module.name != "search"))
