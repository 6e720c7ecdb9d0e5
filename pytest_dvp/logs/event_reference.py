"""When a name that a user wrote means an event of the storyboard."""

from __future__ import annotations


def means_event(reference: str, name: str) -> bool:
    """Whether a name that a user wrote means the event of this name: the name itself, or the end of it."""
    return name == reference or name.endswith(f"::{reference}")
