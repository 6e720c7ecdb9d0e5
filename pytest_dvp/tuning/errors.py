"""What a user can do wrong with a study."""

from __future__ import annotations


class TuneError(ValueError):
    """A study that cannot be tuned; one line with file, place, what was found and what is allowed."""
