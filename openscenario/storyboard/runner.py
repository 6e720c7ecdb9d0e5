"""A running action: what the storyboard asks of it, and the simplest one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Runner(Protocol):
    """A running action of one actor. `domains`: what it holds, of "longitudinal", "lateral" and kinds of light."""

    domains: tuple[str, ...]

    def start(self) -> bool:
        """Take hold; True if that was all."""

    def step(self, dt: float) -> bool:
        """Go on by `dt` [s]; True when done."""

    def stop(self) -> None:
        """Let go before the end."""


class Instant:
    """An action that is over as soon as it has begun."""

    __slots__ = ("_do",)
    domains: tuple[str, ...] = ()

    def __init__(self, do: Callable[[], object] | None = None) -> None:
        self._do = do

    def start(self) -> bool:
        """Do it; True, as that was all."""
        if self._do is not None:
            self._do()
        return True

    def step(self, dt: float) -> bool:
        """Do nothing in a step of `dt` [s]; True, as it is over."""
        return True

    def stop(self) -> None:
        """Do nothing: nothing is held."""
