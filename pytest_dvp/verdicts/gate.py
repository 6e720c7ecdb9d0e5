"""What a gate file says, as data."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from openscenario.findings import Finding
from vehicle.messages import RoadPoint

Stage = Literal["dt", "pe", "rw"]
STAGES: tuple[Stage, ...] = ("dt", "pe", "rw")


@dataclasses.dataclass(frozen=True, slots=True)
class Gate:
    """One bound on one metric. `max` and `min` in the metric's unit, both inclusive.

    stages   where it applies
    between  two stages: a metric of two logs compares theirs (model, measured), one of one log may differ between them
             by `max_difference` at most, in its unit
    options  keyword arguments of the metric
    requirement  id of the requirement that the gate verifies, as the user names it: "SR-12"
    parameters  of a gate between stages: effects, or "effect.key", that it is to validate
    only_if_logged, only_with  of a bound of clean drives: a column that the stack must state ("" for none), and the
             values of the scenario's parameters with which they were driven; it does not apply to another drive
    key      what the gate file calls it where that is not the metric's name: rmse for open_loop_error
    """

    metric: str
    max: float | None = None
    min: float | None = None
    stages: tuple[Stage, ...] = STAGES
    between: tuple[Stage, Stage] | None = None
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    file: str = ""
    line: int | None = None
    key: str = ""
    max_difference: float | None = None
    requirement: str = ""
    parameters: tuple[str, ...] = ()
    only_if_logged: str = ""
    only_with: Mapping[str, float] | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class GateTask:
    """What the ego is asked to do beyond the scenario: OpenDRIVE places [road, lane, s in m]; `lane` is its lane id."""

    start: RoadPoint | None = None
    goal: RoadPoint | None = None
    lane: int | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class GateTraffic:
    """Background traffic: a SUMO net and its routes, files beside the gate file."""

    net: str
    routes: str


@dataclasses.dataclass(frozen=True, slots=True)
class GateFile:
    """A gate file's content; `file` as it was given."""

    task: GateTask | None
    gates: tuple[Gate, ...]
    file: str = ""
    traffic: GateTraffic | None = None


class GateError(ValueError):
    """A gate file cannot be used; `findings` say why, each with its line. The text is the first one, in one line."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = tuple(findings)
        self.line = self.findings[0].line
        self.code = self.findings[0].code
        more = (
            f" (and {len(self.findings) - 1} more: dvp check {self.findings[0].file})" if len(self.findings) > 1 else ""
        )
        super().__init__(str(self.findings[0]) + more)
