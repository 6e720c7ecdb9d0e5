"""Any element of the model, made at random from its own table, is written and reads back equal.

`DVP_FUZZ` sets how many elements in all (the nightly target takes 100,000; default: three of each class).
"""

from __future__ import annotations

import dataclasses
import os
import typing
from collections.abc import Mapping
from pathlib import Path
from types import UnionType
from typing import Any, Final, Literal, Union

import hypothesis
import pytest
from hypothesis import strategies as st

from openscenario import model
from openscenario.findings import Findings
from openscenario.model import enums, kinds
from openscenario.model.kinds import Element, Moment, Quantity, Xml
from openscenario.parameters import Scope
from openscenario.plan import plan_of, tag_path
from openscenario.read.context import Context
from openscenario.read.elements import ElementReader
from openscenario.write import _Writer
from openscenario.xml import Node, parse_xml, write_xml

FILES: Final = (model.Scenario, model.DistributionFile, model.CatalogFile)  # more than one element
CLASSES: Final = sorted(
    {cls for cls in vars(model).values() if isinstance(cls, type) and issubclass(cls, Element)} - {Element, *FILES},
    key=lambda cls: cls.__name__,
)
NAMES: Final[Mapping[str, Any]] = {**vars(enums), **vars(kinds), **vars(model)}
DEEPEST: Final = 5  # below it nothing optional is made, so that a storyboard ends
EXAMPLES: Final = max(3, int(os.environ.get("DVP_FUZZ", "0")) // len(CLASSES))  # of each class
EVERY: Final = hypothesis.settings(
    database=None,
    deadline=None,
    suppress_health_check=list(hypothesis.HealthCheck),
    derandomize="DVP_FUZZ" not in os.environ,  # the same in every `make test`, new every night
)
LARGEST: Final = 1e12  # no number of a scenario is larger

# What XML can hold. A value that begins with `$` is a parameter's, and no model has one: it was resolved when read.
characters = st.characters(exclude_categories=("Cs", "Cc", "Cn"))
words = st.text(characters, max_size=8).filter(lambda text: not text.startswith("$"))


def number(quantity: Quantity | None, whole: bool) -> st.SearchStrategy[Any]:
    low = -LARGEST if quantity is None or quantity.low is None else quantity.low
    high = LARGEST if quantity is None or quantity.high is None else quantity.high
    if whole:
        return st.integers(int(low), int(high))
    above = quantity is not None and quantity.above is not None
    if quantity is not None and quantity.above is not None:
        low = quantity.above
    return st.floats(low, high, exclude_min=above, allow_subnormal=False)


@st.composite
def elements(draw: st.DrawFn, cls: type[Element], depth: int = 0) -> Element:
    """An element of a class, within the bounds of its quantities; names refer to nothing in particular."""
    hints = typing.get_type_hints(cls, localns=dict(NAMES), include_extras=True)
    values: dict[str, Any] = {}
    for field in dataclasses.fields(cls):
        spelling = field.metadata.get("xml", Xml())
        if field.name == "at" or spelling is None:
            continue
        required = field.default is dataclasses.MISSING
        if not required and (depth >= DEEPEST or not draw(st.booleans())):
            continue
        values[field.name] = draw(_values(hints[field.name], spelling, required, depth))
    if cls is model.ParameterDeclaration:
        values["parameter_type"] = "string"  # of which every text is a value
    return cls(**values)


def _values(hint: Any, spelling: Xml, required: bool, depth: int) -> st.SearchStrategy[Any]:
    kind, meta, optional = hint, (), False
    if typing.get_origin(kind) in (Union, UnionType) and type(None) in typing.get_args(kind):
        rest = [member for member in typing.get_args(kind) if member is not type(None)]
        kind, optional = (rest[0] if len(rest) == 1 else Union[tuple(rest)]), True  # noqa: UP007
    if typing.get_origin(kind) is typing.Annotated:
        kind, *marks = typing.get_args(kind)
        meta = tuple(marks)
    made = _made(kind, meta, spelling, required, depth)
    return st.none() | made if optional and depth < DEEPEST else (st.none() if optional else made)


def _made(kind: Any, meta: tuple[Any, ...], spelling: Xml, required: bool, depth: int) -> st.SearchStrategy[Any]:
    if kind is str:
        if any(isinstance(mark, Moment) for mark in meta):
            return st.datetimes().map(lambda moment: moment.isoformat())
        # text between tags is read without the white space around it
        return words.map(str.strip) if spelling.text else words
    if kind is bool:
        return st.booleans()
    if kind in (int, float):
        return number(next((mark for mark in meta if isinstance(mark, Quantity)), None), kind is int)
    if typing.get_origin(kind) is Literal:
        return st.sampled_from(typing.get_args(kind))
    if typing.get_origin(kind) is tuple:
        inner = _member(typing.get_args(kind)[0], depth)
        declared = typing.get_args(kind)[0] is model.ParameterDeclaration
        unique: Any = (lambda declaration: declaration.name) if declared else None
        most = 2 if depth < DEEPEST else 1
        return st.lists(inner, min_size=int(required), max_size=most, unique_by=unique).map(tuple)
    return _member(kind, depth)


def _member(kind: Any, depth: int) -> st.SearchStrategy[Any]:
    members = typing.get_args(kind) if typing.get_origin(kind) in (Union, UnionType) else (kind,)
    return st.sampled_from(members).flatmap(lambda cls: elements(cls, depth + 1))


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
@hypothesis.settings(EVERY, max_examples=EXAMPLES)
@hypothesis.given(data=st.data())
@pytest.mark.nightly(by_day=8)
def test_a_random_element_survives_writing_and_reading(
    cls: type[Element], tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    element = data.draw(elements(cls))
    path = tmp_path_factory.getbasetemp() / "element.xosc"
    root = Node("OpenSCENARIO", 0, {}, "", None)
    _Writer(Path()).element(element, tag_path(cls)[-1], root)
    write_xml(root, path)
    node = parse_xml(path.read_bytes(), "element.xosc").root.children[0]
    findings = Findings()
    read = ElementReader(Context(findings), "element.xosc").read(plan_of(cls), node, Scope(), cls.__name__)
    assert read == element, [str(finding) for finding in findings.found]
