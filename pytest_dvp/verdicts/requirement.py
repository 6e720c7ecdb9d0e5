"""Ids of requirements that gates verify: `requirement = "SR-12"`."""

from __future__ import annotations

LONGEST = 200  # characters; an id, not the text of a requirement


def wrong_requirement(value: object) -> str:
    """What is wrong with the id of a requirement in a gate file; empty if nothing is."""
    if not isinstance(value, str):
        return f'requirement must be an id in quotes, requirement = "SR-12"; found {str(value)[:80]!r}'
    if not value.strip():
        return "requirement is empty: name one, or leave the key out"
    if len(value) > LONGEST or not value.isprintable():
        return f"requirement must be one line of at most {LONGEST} printable characters"
    return ""
