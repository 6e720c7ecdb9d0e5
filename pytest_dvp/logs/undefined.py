"""A figure that a log does not define."""

from __future__ import annotations


class Undefined(ValueError):
    """Raised inside a metric: this log does not define it. The text is the reason."""
