"""docs/openscenario.md says of every element of the standard what happens to it, and says it truly."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

import pytest

from openscenario import model
from openscenario.model.kinds import Element
from openscenario.plan import Leaf, Table, plan_of
from openscenario.storyboard.registry import action_factories, condition_factories
from scripts.make_openscenario_page import FILES, PAGE, actions, conditions, page, rows, status

CLASSES = {cls for cls in vars(model).values() if isinstance(cls, type) and issubclass(cls, Element)} - {Element}
SECTIONS = {"FileHeader", "CatalogLocations", "RoadNetwork", "Entities", "Storyboard", "ParameterValueDistribution"}
ROOTS = SECTIONS | {"OpenSCENARIO", "OpenScenario", "Catalog"}  # the root under both spellings of the schema
DECLARED = {"VariableDeclarations", "VariableDeclaration", "MonitorDeclarations", "MonitorDeclaration"}


def tags(table: Table) -> Iterator[str]:
    for tag, entry in table.items():
        yield tag
        if not isinstance(entry, Leaf):
            yield from tags(entry)


def test_the_page_is_what_the_code_says() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "python -m scripts.make_openscenario_page"


def test_every_element_of_the_model_is_on_the_page() -> None:
    words = set(re.findall(r"\w+", page()))
    assert {cls.__name__ for cls in CLASSES - set(FILES)} - words == set()


def test_the_page_knows_every_element_of_the_schema() -> None:
    """The schema of 1.3.1 as packaged with `scenariogeneration`, an independent list."""
    try:
        found = files("scenariogeneration") or []
    except PackageNotFoundError:
        pytest.skip("scenariogeneration is not installed")
    schema = next((Path(str(file.locate())) for file in found if file.name == "OpenSCENARIO_1_3_1.xsd"), None)
    if schema is None:
        pytest.skip("no OpenSCENARIO schema installed")
    named = set(re.findall(r'<xsd:element name="(\w+)"', schema.read_text(encoding="utf-8")))
    known = {tag for cls in CLASSES - set(FILES) for tag in tags(plan_of(cls).children)}
    assert named - known - ROOTS - DECLARED == set()


def test_what_runs_is_what_the_storyboard_registers() -> None:
    registered = {**action_factories(), **condition_factories()}
    for cls in (*actions(), *conditions()):
        assert (status(cls)[0] == "refused") == (cls not in registered), cls.__name__
    assert set(registered) <= {*actions(), *conditions()}


def test_no_element_has_two_rows() -> None:
    listed = [cls for group in rows().values() for cls in group]
    assert len(listed) == len(set(listed))
