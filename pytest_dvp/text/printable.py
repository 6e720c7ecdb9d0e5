"""Text from a file as a terminal may show it."""

from __future__ import annotations


def clean(text: object) -> str:
    """Text from a file without control characters, so that it cannot steer a terminal."""
    return "".join(c if c.isprintable() else "?" for c in str(text))
