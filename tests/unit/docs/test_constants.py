"""A number at the head of a module says what it is and where it comes from, in a comment or its own docstring."""

from __future__ import annotations

import ast
import itertools
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("ads", "openscenario", "pytest_dvp", "reports", "vehicle")


def unsaid(source: str) -> list[str]:
    """Constants of a module whose value is a plain number, with neither a comment behind nor a docstring below it."""
    lines, body = source.splitlines(), ast.parse(source).body
    found = []
    for node, after in itertools.zip_longest(body, body[1:]):
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name) or not plain(node.value):
            continue
        told = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        if node.targets[0].id.isupper() and "#" not in lines[node.lineno - 1] and not told:
            found.append(f"{node.lineno} {node.targets[0].id}")
    return found


def plain(value: ast.expr) -> bool:
    """True for a number such as 3, -0.25 or 1 << 16; False for one that is computed from names."""
    if isinstance(value, ast.BinOp):
        return plain(value.left) and plain(value.right)
    value = value.operand if isinstance(value, ast.UnaryOp) else value
    return (
        isinstance(value, ast.Constant) and isinstance(value.value, int | float) and not isinstance(value.value, bool)
    )


@pytest.mark.parametrize("package", PACKAGES)
def test_a_number_says_where_it_comes_from(package: str) -> None:
    files = sorted((ROOT / package).rglob("*.py"))
    assert files
    told = {str(path.relative_to(ROOT)): unsaid(path.read_text(encoding="utf-8")) for path in files}
    assert {path: names for path, names in told.items() if names} == {}


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("FAR = 0.8", ["1 FAR"]),
        ("_PIECE = 1 << 16", ["1 _PIECE"]),
        ("FAR = 0.8  # m; chosen", []),
        ('FAR = 0.8\n"""m; chosen."""', []),
        ("TURN = 2.0 * math.pi", []),
        ("QUIET = True", []),
    ],
)
def test_a_number_without_a_word_is_found(source: str, expected: list[str]) -> None:
    assert unsaid(source) == expected
