"""What one reading knows besides the element at hand: findings, catalogues, names and references met."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.catalogs import Catalogs
from openscenario.findings import Findings, Severity
from openscenario.model.actions import AbsoluteTargetLane
from openscenario.model.conditions import (
    StoryboardElementStateCondition,
    TrafficSignalCondition,
    TrafficSignalControllerCondition,
)
from openscenario.model.global_actions import TrafficSignalControllerAction, TrafficSignalStateAction
from openscenario.model.kinds import At, RefKind
from openscenario.model.positions import LanePosition, RoadPosition

OnRoad: TypeAlias = LanePosition | RoadPosition | TrafficSignalStateAction | TrafficSignalCondition | AbsoluteTargetLane
OfPhase: TypeAlias = TrafficSignalControllerAction | TrafficSignalControllerCondition


@dataclass(frozen=True, slots=True)
class Reference:
    """A name that an attribute refers to; `origin`: the parameter that it came from, with its place, or ""."""

    kind: RefKind
    name: str
    at: At
    attribute: str
    origin: str = ""


@dataclass(frozen=True, slots=True)
class TypedValue:
    """A value for a parameter or variable, at its attribute `value`, that must be one of the declared type.

    None: it is calculated with, so its type must be one of numbers.
    """

    kind: RefKind
    name: str
    value: str | None
    at: At


@dataclass(slots=True)
class Context:
    """State of one reading."""

    findings: Findings
    catalogs: Catalogs | None = None
    references: list[Reference] = field(default_factory=list)
    names: dict[str, list[tuple[str, At]]] = field(default_factory=dict)  # kind or storyboard type -> name, place
    state_conditions: list[StoryboardElementStateCondition] = field(default_factory=list)
    typed_values: list[TypedValue] = field(default_factory=list)
    of_phases: list[OfPhase] = field(default_factory=list)  # what names a phase of a signal controller
    on_road: list[OnRoad] = field(default_factory=list)  # what must exist on the road
    starts: set[At] = field(default_factory=set)  # positions that entities are put on
    nested_catalogs: int = 0

    def named(self, *kinds: str) -> dict[str, None]:
        """The names met of these kinds, in the files' order, also of elements that are wrong otherwise."""
        return {name: None for kind in kinds for name, _ in self.names.get(kind, ())}

    def error(
        self, code: str, at: At, attribute: str, text: str, *, found: str = "", allowed: str = "", hint: str = ""
    ) -> None:
        """Notes an error at an element or, with `@name`, at its attribute."""
        self._note("error", code, at, attribute, text, found, allowed, hint)

    def warning(
        self, code: str, at: At, attribute: str, text: str, *, found: str = "", allowed: str = "", hint: str = ""
    ) -> None:
        """Notes a warning at an element or, with `@name`, at its attribute."""
        self._note("warning", code, at, attribute, text, found, allowed, hint)

    def _note(
        self, severity: Severity, code: str, at: At, attribute: str, text: str, found: str, allowed: str, hint: str
    ) -> None:
        self.findings.add(
            code,
            at.file,
            at.line,
            at.element + attribute,
            text,
            found=found,
            allowed=allowed,
            hint=hint,
            severity=severity,
        )
