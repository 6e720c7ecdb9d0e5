"""Request: everything that was asked of one run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from openscenario.storyboard.reading import USUAL, Reading
from pytest_dvp.drive.compute_delay import ComputeDelay
from pytest_dvp.drive.deadline import TICK_LIMIT
from pytest_dvp.drive.stages import SURROGATE

if TYPE_CHECKING:
    from pytest_dvp.drive.chosen_stack import Ads


@dataclasses.dataclass(frozen=True)
class Request:
    """What was asked for; see `pytest_dvp.drive.run.run`."""

    path: Path
    stage: str
    seed: int
    parameters: Mapping[str, str | float | bool]
    P: Mapping[str, str | float]
    S: Mapping[str, str | float]
    model: Path | None
    gates: Path | None
    library: tuple[Path, ...]
    rootdir: Path | None
    ego: str | None
    ads: Ads | None = None  # None: the reference stack
    effects: tuple[Path, ...] = ()
    vehicle: str = SURROGATE  # of stages pe and rw
    clock: str = "stepped"  # of stages pe and rw
    arming: Path | None = None  # of a real car
    envelope: Path | None = None  # of a real car
    dbc: Path | None = None  # of a vehicle on CAN
    fault: str | None = None  # put on the wire
    gated: bool = False  # the twin behind the command gate, too
    reading: Reading = USUAL  # of the scenario
    tick_limit: float = TICK_LIMIT  # s of wall time for a tick of the stack
    stack_process: str | None = None  # "on" or "off" where that was asked for
    compute_delay: ComputeDelay | None = None  # of the stack's commands, on stage dt
