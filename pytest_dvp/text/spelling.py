"""The valid name that a misspelt one most likely means."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The valid name closest to `name`, or None if none is close."""
    known = sorted(names)
    folded = {candidate.lower(): candidate for candidate in reversed(known)}
    found = difflib.get_close_matches(name.lower(), list(folded), n=1, cutoff=0.5)
    return folded[found[0]] if found else None


def unknown(what: str, name: str, names: Iterable[str]) -> str:
    """One sentence for an unknown name: the nearest valid one, or all of them when they are few."""
    known = sorted(names)
    near = nearest(name, known)
    if near is not None:
        return f"unknown {what} {name!r}, did you mean {near!r}?"
    if not known:
        return f"unknown {what} {name!r}: there is none to set"
    listed = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    return f"unknown {what} {name!r}, allowed: {listed}"


def misspelt(names: Iterable[str], known: Iterable[str]) -> str | None:
    """First of `names` that is none of `known` but nearly one of them, with the one meant."""
    right = sorted(known)
    for name in sorted(names):
        if name not in right:
            found = difflib.get_close_matches(name, right, n=1, cutoff=0.85)
            if found:
                return f"unknown setting {name!r}, did you mean {found[0]!r}?"
    return None
