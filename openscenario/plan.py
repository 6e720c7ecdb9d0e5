"""Tables for reading and writing, made once from the dataclasses of the model."""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias, Union

from openscenario import model
from openscenario.model import enums, kinds
from openscenario.model.catalogs import CatalogReference
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.kinds import Element, Moment, Quantity, Raw, Ref, RefKind, Xml
from openscenario.values import BadValue, to_bool, to_double, to_int, to_limit, to_moment

Convert: TypeAlias = Callable[[str], Any]

RENAMED: Final[Mapping[str, str]] = {"overwrite": "override"}  # values of enumerations until 1.1
NAMES: Final[Mapping[type[Element], str]] = {
    model.ScenarioObject: "entity",
    model.EntitySelection: "entity",
    model.VariableDeclaration: "variable",
    model.MonitorDeclaration: "monitor",
    model.TrafficSignalController: "signal_controller",
    model.Story: "story",
    model.Act: "act",
    model.ManeuverGroup: "maneuverGroup",
    model.Maneuver: "maneuver",
    model.Event: "event",
    model.Action: "action",
}
NO_XML: Final = Xml()


@dataclass(frozen=True, slots=True)
class AttributePlan:
    """One attribute: its field, how its text becomes a value, what name it must refer to."""

    field: str
    name: str
    convert: Convert
    text: bool  # a string: expressions may join words
    number: bool
    raw: bool  # parameters in it are resolved later
    ref: RefKind | None
    allowed: tuple[str, ...] = ()
    truth: bool = False
    optional: bool = False


@dataclass(slots=True)
class Leaf:
    """A child element that fills a field; `variants` (by tag): what a CatalogReference may stand for here."""

    field: str
    many: bool
    plan: ElementPlan
    variants: dict[str, ElementPlan] | None = None


Table: TypeAlias = "dict[str, Leaf | Table]"


@dataclass(frozen=True, slots=True)
class FieldPlan:
    """One field as the writer sees it."""

    name: str
    attribute: str  # name, if it is an attribute
    path: tuple[str, ...]  # tags below the element, the last one the item's; empty for inline unions
    many: bool
    union: bool
    text: bool
    default: Any
    required: bool = False


@dataclass(slots=True)
class ElementPlan:
    """How one class is read and written."""

    cls: type[Element]
    attributes: dict[str, AttributePlan] = field(default_factory=dict)
    children: Table = field(default_factory=dict)
    required_attributes: list[tuple[str, str]] = field(default_factory=list)  # field, attribute
    required_children: list[tuple[str, str, str]] = field(default_factory=list)  # field, tag of the wrapper, allowed
    choices: set[str] = field(default_factory=set)  # tags of wrappers that stand for one of several elements
    fields: list[FieldPlan] = field(default_factory=list)
    unset: list[str] = field(default_factory=list)  # fields that may be None but have no default
    text_field: str = ""
    declares: bool = False
    names: str = ""  # what its attribute `name` names, if others refer to it


def camel(name: str) -> str:
    """lane_id -> laneId."""
    head, *rest = name.strip("_").split("_")
    return head + "".join(part.capitalize() for part in rest)


def pascal(name: str) -> str:
    """bounding_box -> BoundingBox."""
    return "".join(part[:1].upper() + part[1:] for part in name.strip("_").split("_"))


@functools.cache
def _namespace() -> dict[str, Any]:
    return {**vars(enums), **vars(kinds), **vars(model)}


_plans: Final[dict[type[Element], ElementPlan]] = {}


def plan_of(cls: type[Element]) -> ElementPlan:
    """The plan of a class, made on first use."""
    known = _plans.get(cls)
    if known is None:
        known = _plans[cls] = ElementPlan(
            cls, names=NAMES.get(cls, "")
        )  # before filling: classes refer to each other in circles
        _fill(known)
    return known


def tag_path(cls: type[Element]) -> tuple[str, ...]:
    """Tags of a class below its choice: ('PrivateAction', 'LongitudinalAction', 'SpeedAction')."""
    return tuple((cls.XML or cls.__name__).split("/"))


def _fill(plan: ElementPlan) -> None:
    hints = typing.get_type_hints(plan.cls, localns=_namespace(), include_extras=True)
    for entry in dataclasses.fields(plan.cls):
        spelling = entry.metadata.get("xml", NO_XML)
        if entry.name == "at" or spelling is None:
            continue
        required = entry.default is dataclasses.MISSING
        kind, optional, meta = _stripped(hints[entry.name])
        if required and optional:
            plan.unset.append(entry.name)
        required = required and not optional
        default = None if entry.default is dataclasses.MISSING else entry.default
        if spelling.text:
            plan.text_field = entry.name
            plan.fields.append(FieldPlan(entry.name, "", (), False, False, True, default))
        elif _is_scalar(kind):
            _fill_attribute(plan, entry.name, kind, meta, spelling, required, default)
        else:
            _fill_children(plan, entry.name, kind, spelling, required, default)


def _fill_attribute(
    plan: ElementPlan, name: str, kind: Any, meta: tuple[Any, ...], spelling: Xml, required: bool, default: Any
) -> None:
    attribute = spelling.path or camel(name)
    ref = next((mark.kind for mark in meta if isinstance(mark, Ref)), None)
    raw = any(isinstance(mark, Raw) for mark in meta)
    allowed = typing.get_args(kind) if typing.get_origin(kind) is Literal else ()
    entry = AttributePlan(
        name,
        attribute,
        _converter(kind, meta),
        text=kind is str,
        number=kind in (int, float),
        raw=raw,
        ref=ref,
        allowed=allowed,
        truth=kind is bool,
        optional=not required,
    )
    plan.attributes[attribute] = entry
    for former in spelling.former:
        plan.attributes[former] = entry
    if required:
        plan.required_attributes.append((name, attribute))
    plan.fields.append(FieldPlan(name, attribute, (), False, False, False, default, required))


def _fill_children(plan: ElementPlan, name: str, kind: Any, spelling: Xml, required: bool, default: Any) -> None:
    many = typing.get_origin(kind) is tuple
    item = typing.get_args(kind)[0] if many else kind
    members = _members(item)
    union = len(members) > 1
    if members == (ParameterDeclaration,):
        plan.declares = True
    variants = {tag_path(member)[-1]: plan_of(member) for member in members}
    if spelling.path:
        path = tuple(spelling.path.split("/"))
    elif spelling.inline:
        path = ()
    elif union:
        path = (pascal(name),)
    else:
        path = (members[0].__name__,) if many else (pascal(name),)
    for spelled in (path, *(tuple(former.split("/")) for former in spelling.former)):
        table = plan.children
        if union or not spelled:
            table = _descend(table, spelled)
            for member in members:
                steps = tag_path(member)
                plan.choices.update(steps[:-1])
                _descend(table, steps[:-1])[steps[-1]] = Leaf(name, many, plan_of(member))
        else:
            table = _descend(table, spelled[:-1])
            table[spelled[-1]] = Leaf(name, many, plan_of(members[0]))
        if spelling.catalog:
            table["CatalogReference"] = Leaf(name, many, plan_of(CatalogReference), variants)
    if required:
        starts = dict.fromkeys(tag_path(member)[0] for member in members)
        shown = sorted(starts) if union else [path[-1] if path else members[0].__name__]
        plan.required_children.append((name, path[0] if path else "", ", ".join(shown)))
    plan.fields.append(FieldPlan(name, "", path, many, union or not path, False, default))


def _descend(table: Table, steps: tuple[str, ...]) -> Table:
    for step in steps:
        below = table.setdefault(step, {})
        if not isinstance(below, dict):
            raise TypeError(f"<{step}> is an element and a wrapper at once")  # a slip in the model, found by its tests
        table = below
    return table


def _stripped(hint: Any) -> tuple[Any, bool, tuple[Any, ...]]:
    """The type without `| None` and marks; whether None is allowed; the marks."""
    optional = False
    if typing.get_origin(hint) in (Union, types.UnionType):
        members = [member for member in typing.get_args(hint) if member is not type(None)]
        optional = len(members) < len(typing.get_args(hint))
        hint = members[0] if len(members) == 1 else Union[tuple(members)]  # noqa: UP007
    if typing.get_origin(hint) is typing.Annotated:
        kind, *meta = typing.get_args(hint)
        return kind, optional, tuple(meta)
    return hint, optional, ()


def _members(item: Any) -> tuple[type[Element], ...]:
    if typing.get_origin(item) in (Union, types.UnionType):
        return typing.get_args(item)
    return (item,)


def _is_scalar(kind: Any) -> bool:
    return kind in (str, int, float, bool) or typing.get_origin(kind) is Literal


def _converter(kind: Any, meta: tuple[Any, ...]) -> Convert:
    if typing.get_origin(kind) is Literal:
        return _enumeration(typing.get_args(kind))
    if kind is str:
        return to_moment if any(isinstance(mark, Moment) for mark in meta) else str
    if kind is bool:
        return to_bool
    quantity = next((mark for mark in meta if isinstance(mark, Quantity)), None)
    endless = quantity is not None and quantity.endless
    convert: Convert = to_int if kind is int else to_limit if endless else to_double
    if quantity is None or (quantity.low, quantity.high, quantity.above) == (None, None, None):
        return convert
    return _bounded(convert, quantity)


def _enumeration(allowed: tuple[str, ...]) -> Convert:
    values = {**{old: new for old, new in RENAMED.items() if new in allowed}, **{name: name for name in allowed}}

    def convert(text: str) -> str:
        try:
            return values[text]
        except KeyError:
            raise BadValue("value.not_allowed", "not one of the allowed words", ", ".join(allowed)) from None

    return convert


def _bounded(convert: Convert, quantity: Quantity) -> Convert:
    low = float("-inf") if quantity.low is None else quantity.low
    high = float("inf") if quantity.high is None else quantity.high
    above = float("-inf") if quantity.above is None else quantity.above
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    bounds = [f">= {low:g}{unit}"] if quantity.low is not None else []
    bounds += [f"<= {high:g}{unit}"] if quantity.high is not None else []
    bounds += [f"> {above:g}{unit}"] if quantity.above is not None else []
    allowed = " and ".join(bounds)

    def checked(text: str) -> Any:
        value = convert(text)
        if not (low <= value <= high and value > above):
            raise BadValue(quantity.rule, "out of range", allowed)
        return value

    return checked
