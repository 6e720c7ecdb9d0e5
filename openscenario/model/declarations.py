"""File header, parameter, variable and monitor declarations, properties."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from openscenario.model.enums import ParameterType, Rule
from openscenario.model.kinds import Element, RawText, xml


@dataclass(frozen=True, slots=True)
class Property(Element):
    name: str
    value: str


@dataclass(frozen=True, slots=True)
class File(Element):
    filepath: str


@dataclass(frozen=True, slots=True)
class CustomContent(Element):
    content: str = field(metadata=xml(text=True), default="")


@dataclass(frozen=True, slots=True)
class Properties(Element):
    properties: tuple[Property, ...] = ()
    files: tuple[File, ...] = ()
    custom_content: tuple[CustomContent, ...] = ()

    def get(self, name: str) -> str | None:
        """The value of the first property called `name`, or None."""
        return next((entry.value for entry in self.properties if entry.name == name), None)


NO_PROPERTIES: Final = Properties()


@dataclass(frozen=True, slots=True)
class License(Element):
    name: str
    resource: str = ""
    spdx_id: str = ""
    content: str = field(metadata=xml(text=True), default="")


@dataclass(frozen=True, slots=True)
class FileHeader(Element):
    """`rev_minor`: the version the file was written in; what older versions spell otherwise reads the same."""

    rev_major: int
    rev_minor: int = field(compare=False)
    date: str
    description: str
    author: str
    license: License | None = None
    properties: Properties | None = None


@dataclass(frozen=True, slots=True)
class ValueConstraint(Element):
    rule: Rule
    value: RawText


@dataclass(frozen=True, slots=True)
class ValueConstraintGroup(Element):
    """A value is allowed if it meets all constraints of at least one group."""

    value_constraints: tuple[ValueConstraint, ...]


@dataclass(frozen=True, slots=True)
class ParameterDeclaration(Element):
    """`value` is the value in force (overridden, assigned, expressions computed), in the file's spelling."""

    name: str
    parameter_type: ParameterType
    value: RawText
    constraint_groups: tuple[ValueConstraintGroup, ...] = field(metadata=xml("ConstraintGroup"), default=())


@dataclass(frozen=True, slots=True)
class VariableDeclaration(Element):
    name: str
    variable_type: ParameterType
    value: str


@dataclass(frozen=True, slots=True)
class MonitorDeclaration(Element):
    name: str
    value: bool
