"""Storyboard: init, stories, acts, maneuver groups, maneuvers, events, actions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.actions import PrivateAction
from openscenario.model.conditions import Trigger
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.entities import EntityRef
from openscenario.model.enums import Priority
from openscenario.model.global_actions import GlobalAction, UserDefinedAction
from openscenario.model.kinds import Element, EntityName, Executions, xml

AnyAction: TypeAlias = PrivateAction | GlobalAction | UserDefinedAction


@dataclass(frozen=True, slots=True)
class Action(Element):
    """`action` is directly the leaf: SpeedAction, EntityAction, CustomCommandAction, ..."""

    name: str
    action: AnyAction = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class Event(Element):
    """Without start trigger it starts with its maneuver."""

    name: str
    priority: Priority
    actions: tuple[Action, ...]
    maximum_execution_count: Executions = 1
    start_trigger: Trigger | None = None


@dataclass(frozen=True, slots=True)
class Maneuver(Element):
    name: str
    events: tuple[Event, ...]
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class Actors(Element):
    select_triggering_entities: bool
    entity_refs: tuple[EntityRef, ...] = ()


@dataclass(frozen=True, slots=True)
class ManeuverGroup(Element):
    """Maneuvers of catalogues stand among the others, in the file's order."""

    name: str
    maximum_execution_count: Executions
    actors: Actors
    maneuvers: tuple[Maneuver, ...] = field(metadata=xml(catalog=True), default=())


@dataclass(frozen=True, slots=True)
class Act(Element):
    """Without start trigger it starts with the simulation (1.3)."""

    name: str
    maneuver_groups: tuple[ManeuverGroup, ...]
    start_trigger: Trigger | None = None
    stop_trigger: Trigger | None = None


@dataclass(frozen=True, slots=True)
class Story(Element):
    name: str
    acts: tuple[Act, ...]
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class Private(Element):
    """Init actions of one entity."""

    entity_ref: EntityName
    private_actions: tuple[PrivateAction, ...] = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class InitActions(Element):
    global_actions: tuple[GlobalAction, ...] = field(metadata=xml(inline=True), default=())
    user_defined_actions: tuple[UserDefinedAction, ...] = field(metadata=xml(inline=True), default=())
    privates: tuple[Private, ...] = ()


@dataclass(frozen=True, slots=True)
class Init(Element):
    actions: InitActions


@dataclass(frozen=True, slots=True)
class Storyboard(Element):
    init: Init
    stories: tuple[Story, ...] = ()
    stop_trigger: Trigger | None = None
