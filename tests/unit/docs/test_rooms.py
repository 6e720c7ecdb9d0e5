"""The rooms of the house: no file and no room imports another in a circle, lazy and type-only imports counted."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp")


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    graph = grimp.build_graph(*PACKAGES, exclude_type_checking_imports=False, cache_dir=None)
    return {module: set(graph.find_modules_directly_imported_by(module)) for module in graph.modules}


def circle(imports: dict[str, set[str]]) -> list[str]:
    """One circle of imports, [] if there is none."""
    try:
        tuple(TopologicalSorter(imports).static_order())
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_file_imports_another_in_a_circle(imports: dict[str, set[str]]) -> None:
    assert len(imports) > 600  # lazy imports inside functions are found, too:
    assert "pytest_dvp.logs.mcap_read" in imports["pytest_dvp.logs.log"]
    assert circle(imports) == []


def test_no_room_imports_another_in_a_circle(imports: dict[str, set[str]]) -> None:
    rooms: dict[str, set[str]] = {}
    for module, others in imports.items():
        rooms.setdefault(room(module), set()).update(room(other) for other in others if room(other) != room(module))
    assert {"pytest_dvp.drive", "pytest_dvp.gap", "vehicle.guard", "openscenario.storyboard", "ads"} <= rooms.keys()
    assert circle(rooms) == []


def test_a_circle_is_found() -> None:
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}})


def room(module: str) -> str:
    """`PACKAGE.ROOM` of a file in a room of a package with rooms; a file that lies outside of them is its own."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] in ("pytest_dvp", "openscenario", "vehicle") else parts[0]


def test_nothing_lies_loose_in_the_harness() -> None:
    assert [path.name for path in (ROOT / "pytest_dvp").glob("*.py")] == ["__init__.py"]


@pytest.mark.parametrize("folder", sorted({path.parent for path in (ROOT / "pytest_dvp").rglob("*.py")}))
def test_each_room_says_what_it_is_for(folder: Path) -> None:
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
    assert len(text.split()) >= 8, folder
