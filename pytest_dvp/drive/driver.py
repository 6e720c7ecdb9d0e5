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
    def trace(self) -> Mapping[str, float]: ...

    @property
    def path(self) -> FloatArray | None: ...

    @property
    def detections(self) -> Sequence[Detection]: ...

    @property
    def nets(self) -> list[Any]: ...

    @property
    def seconds(self) -> float: ...

    def end_by(self, wall: float, limit: float) -> None: ...

    def tick(self, observation: Observation) -> Command: ...

    def close(self) -> None: ...
