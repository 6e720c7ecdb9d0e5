"""docs/reliability.md has a place for each part, and what makes the mutants makes those that one expects."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.make_reliability_page import PAGE, replaced
from scripts.mutate import mutants


def changed(source: str) -> set[str]:
    return {mutant.source for mutant in mutants(source)}


@pytest.mark.parametrize("part", ["gate", "faults"])
def test_each_part_is_written_between_its_own_markers(part: str) -> None:
    page = PAGE.read_text(encoding="utf-8")
    new = replaced(page, part, "measured")
    assert f"<!-- {part} -->\nmeasured\n<!-- /{part} -->" in new
    assert replaced(new, part, "x") == replaced(page, part, "x")


def test_a_part_without_a_place_is_an_error() -> None:
    with pytest.raises(SystemExit, match="no markers <!-- other -->"):
        replaced("# page\n", "other", "text")


def test_the_page_names_the_file_of_the_gate() -> None:
    assert (Path(__file__).parents[3] / "vehicle" / "guard" / "guard.py").exists()
    assert "`vehicle/guard/guard.py`" in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (
            "if a < b:\n    go()",
            {"if a <= b:\n    go()", "if a >= b:\n    go()", "if True:\n    go()", "if False:\n    go()"},
        ),
        ("return_ = a * 2.0", {"return_ = a / 2.0", "return_ = a * 3.0", "return_ = a * 1.8", "pass"}),
        ("x = min(a, b)", {"x = max(a, b)", "pass"}),
        ("go(not a)", {"go(a)", "pass"}),
        ("go(a and b)", {"go(a or b)", "go(a)", "go(b)", "pass"}),
    ],
)
def test_a_mutant_is_one_change(source: str, expected: set[str]) -> None:
    assert expected <= changed(source)
    assert len(changed(source)) <= len(expected) + 1


def test_docstrings_and_imports_are_left_alone() -> None:
    assert changed('"""Text."""\nimport math') == set()
