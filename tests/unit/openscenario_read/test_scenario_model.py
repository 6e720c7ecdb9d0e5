"""The model as a table: every physical number has a unit, every element can be named with its place."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator

import pytest

from openscenario import model
from openscenario.model import enums, kinds
from openscenario.model.kinds import Element, Quantity
from openscenario.plan import ElementPlan, Leaf, Table, plan_of

CLASSES = sorted(
    (cls for cls in vars(model).values() if isinstance(cls, type) and issubclass(cls, Element) and cls is not Element),
    key=lambda cls: cls.__name__,
)


def leaves(table: Table) -> Iterator[Leaf]:
    for entry in table.values():
        if isinstance(entry, Leaf):
            yield entry
        else:
            yield from leaves(entry)


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_every_number_has_a_unit(cls: type[Element]) -> None:
    names = {**vars(enums), **vars(kinds), **vars(model)}
    hints = typing.get_type_hints(cls, localns=names, include_extras=True)
    for field in dataclasses.fields(cls):
        members = typing.get_args(hints[field.name]) or (hints[field.name],)
        assert float not in members or any(isinstance(mark, Quantity) for mark in members), field.name


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_every_element_is_frozen_and_knows_its_place(cls: type[Element]) -> None:
    assert cls.__dataclass_params__.frozen  # type: ignore[attr-defined]
    at = next(field for field in dataclasses.fields(cls) if field.name == "at")
    assert not at.compare


def test_every_element_of_the_model_can_be_read() -> None:
    """No class is out of reach from the sections of a file and the entries of a catalogue."""
    seen: set[type[Element]] = set()
    rows = (model.FileHeader, model.CatalogLocations, model.VariableDeclaration, model.MonitorDeclaration)
    rows += (model.ParameterValueDistribution, model.Catalog)
    stack: list[ElementPlan] = [plan_of(cls) for cls in (*rows, model.RoadNetwork, model.Entities, model.Storyboard)]
    while stack:
        plan = stack.pop()
        if plan.cls in seen:
            continue
        seen.add(plan.cls)
        for leaf in leaves(plan.children):
            stack.append(leaf.plan)
            stack.extend((leaf.variants or {}).values())
    assert {cls for cls in CLASSES if cls not in seen} == {model.Scenario, model.DistributionFile, model.CatalogFile}
