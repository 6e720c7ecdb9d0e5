"""The model as a table: every physical number has a unit, every element can be named with its place."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator

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


def test_every_number_has_a_unit() -> None:
    names = {**vars(enums), **vars(kinds), **vars(model)}
    bare = []
    for cls in CLASSES:
        hints = typing.get_type_hints(cls, localns=names, include_extras=True)
        for field in dataclasses.fields(cls):
            members = typing.get_args(hints[field.name]) or (hints[field.name],)
            if float in members and not any(isinstance(mark, Quantity) for mark in members):
                bare.append(f"{cls.__name__}.{field.name}")
    assert bare == []


def test_every_element_is_frozen_and_knows_its_place() -> None:
    """Two elements from different lines are equal if they say the same, so the place takes no part in comparing."""
    assert [cls.__name__ for cls in CLASSES if not cls.__dataclass_params__.frozen] == []  # type: ignore[attr-defined]
    places = {cls.__name__: [field for field in dataclasses.fields(cls) if field.name == "at"] for cls in CLASSES}
    assert [name for name, at in places.items() if [field.compare for field in at] != [False]] == []


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
