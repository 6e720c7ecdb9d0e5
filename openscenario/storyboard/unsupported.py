"""Unsupported: what an action, condition or position cannot do, raised before anything runs."""

from __future__ import annotations


class Unsupported(Exception):
    """An element, or an option of it, that this storyboard cannot run; `found` and `allowed` as in a Finding."""

    def __init__(self, text: str, found: str = "", allowed: str = "", element: object = None) -> None:
        super().__init__(text)
        self.text = text
        self.found = found
        self.allowed = allowed
        self.element = element
