"""Global and user-defined actions: what happens to the world."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.environment import Environment
from openscenario.model.kinds import (
    Element,
    EntityName,
    MonitorName,
    Number,
    ParameterName,
    SignalControllerName,
    VariableName,
    xml,
)
from openscenario.model.positions import Position
from openscenario.model.traffic import TrafficAction


@dataclass(frozen=True, slots=True)
class EnvironmentAction(Element):
    XML = "GlobalAction/EnvironmentAction"

    environment: Environment = field(metadata=xml(catalog=True))


@dataclass(frozen=True, slots=True)
class AddEntityAction(Element):
    position: Position


@dataclass(frozen=True, slots=True)
class DeleteEntityAction(Element):
    pass


@dataclass(frozen=True, slots=True)
class EntityAction(Element):
    XML = "GlobalAction/EntityAction"

    entity_ref: EntityName
    action: AddEntityAction | DeleteEntityAction = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class ParameterSetAction(Element):
    XML = "SetAction"

    value: str


@dataclass(frozen=True, slots=True)
class ParameterAddValueRule(Element):
    XML = "AddValue"

    value: Number


@dataclass(frozen=True, slots=True)
class ParameterMultiplyByValueRule(Element):
    XML = "MultiplyByValue"

    value: Number


ModifyRule: TypeAlias = ParameterAddValueRule | ParameterMultiplyByValueRule


@dataclass(frozen=True, slots=True)
class ParameterModifyAction(Element):
    XML = "ModifyAction"

    rule: ModifyRule


@dataclass(frozen=True, slots=True)
class ParameterAction(Element):
    """Deprecated since 1.2, where variables took over what changes at run time."""

    XML = "GlobalAction/ParameterAction"

    parameter_ref: ParameterName
    action: ParameterSetAction | ParameterModifyAction = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class VariableSetAction(Element):
    XML = "SetAction"

    value: str


@dataclass(frozen=True, slots=True)
class VariableAddValueRule(Element):
    XML = "AddValue"

    value: Number


@dataclass(frozen=True, slots=True)
class VariableMultiplyByValueRule(Element):
    XML = "MultiplyByValue"

    value: Number


VariableModifyRule: TypeAlias = VariableAddValueRule | VariableMultiplyByValueRule


@dataclass(frozen=True, slots=True)
class VariableModifyAction(Element):
    XML = "ModifyAction"

    rule: VariableModifyRule


@dataclass(frozen=True, slots=True)
class VariableAction(Element):
    XML = "GlobalAction/VariableAction"

    variable_ref: VariableName
    action: VariableSetAction | VariableModifyAction = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class SetMonitorAction(Element):
    XML = "GlobalAction/SetMonitorAction"

    monitor_ref: MonitorName
    value: bool


@dataclass(frozen=True, slots=True)
class TrafficSignalStateAction(Element):
    XML = "GlobalAction/InfrastructureAction/TrafficSignalAction/TrafficSignalStateAction"

    name: str
    state: str


@dataclass(frozen=True, slots=True)
class TrafficSignalControllerAction(Element):
    XML = "GlobalAction/InfrastructureAction/TrafficSignalAction/TrafficSignalControllerAction"

    traffic_signal_controller_ref: SignalControllerName
    phase: str


@dataclass(frozen=True, slots=True)
class CustomCommandAction(Element):
    XML = "UserDefinedAction/CustomCommandAction"

    type: str
    content: str = field(metadata=xml(text=True), default="")


GlobalAction: TypeAlias = (
    EnvironmentAction
    | EntityAction
    | ParameterAction
    | VariableAction
    | SetMonitorAction
    | TrafficSignalStateAction
    | TrafficSignalControllerAction
    | TrafficAction
)
UserDefinedAction: TypeAlias = CustomCommandAction
