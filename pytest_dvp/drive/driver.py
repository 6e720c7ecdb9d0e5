"""Driver: a driving stack as the loop sees it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from vehicle.messages import Command, Detection, FloatArray, Observation


class Driver(Protocol):
    """A driving stack: one observation in, one command out, 20 times a second.

    Only `tick` is asked of a stack of one's own; `pytest_dvp.drive.stack_host` adds the rest.
    """

    @property
    def trace(self) -> Mapping[str, float]:
        """What the stack offers for the log after the last tick: channel to number."""
        ...

    @property
    def path(self) -> FloatArray | None:
        """The planned path after the last tick, rows x, y [m] of shape (n, 2); None if the stack offers none."""
        ...

    @property
    def detections(self) -> Sequence[Detection]:
        """The road users that the stack says it saw in the last tick."""
        ...

    @property
    def nets(self) -> list[Any]:
        """What the log tells of the neural nets that the stack drives with; empty without one."""
        ...

    @property
    def seconds(self) -> float:
        """Wall time of the last tick [s], without that of compiling."""
        ...

    def end_by(self, wall: float, limit: float) -> None:
        """The whole run must be over at `wall` (`time.monotonic`), after its `limit` [s]."""
        ...

    def tick(self, observation: Observation) -> Command:
        """The stack's command for an observation."""
        ...

    def close(self) -> None:
        """Give back what the stack holds; nothing is asked of it afterwards."""
        ...
