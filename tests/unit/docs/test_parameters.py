"""No function takes more than eight parameters, but for kernels and for declarations made by keyword."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp", "scenarios")
MOST = 8

DECLARATIONS = {
    "pytest_dvp/gap/assert_matches.py:assert_matches": "public: what a user asserts of a model, each by its name",
    "pytest_dvp/gap/extend/extend.py:extend": "public: what is done to a model, each by its name",
    "vehicle/model/effect.py:effect": "public decorator: the declaration of an effect",
    "vehicle/adapters/process.py:__init__": "the declaration of a car in a process of its own",
    "ads/stack.py:__init__": "the parts that a reference stack is made of, each of which a test may exchange",
}
"""Functions that may take more, and why; what they take beyond four is given by name."""

PACKAGES_WITH_KERNELS = ("openscenario/road", "vehicle", "ads", "pytest_dvp/gap", "pytest_dvp/metrics")
"""Where compiled functions take more: numba compiles functions of numbers and arrays, and knows no dataclass."""


def functions(package: str) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """One after the other: all trees at once keep the garbage collector busy for three times as long as parsing."""
    for path in sorted((ROOT / package).rglob("*.py")):
        for node in defined_in(ast.parse(path.read_text(encoding="utf-8"))):
            yield f"{path.relative_to(ROOT).as_posix()}:{node.name}", node


def defined_in(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """Functions at whatever depth; only statements hold others, so expressions are not looked through."""
    todo = [tree]
    while todo:
        node = todo.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node
        for block in ("body", "orelse", "finalbody", "handlers", "cases"):
            inner = getattr(node, block, None)
            todo += inner if isinstance(inner, list) else []  # an expression of a lambda is none


def parameters(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    listed = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return len([one for one in listed if one.arg not in ("self", "cls")])


def is_compiled(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    names = [one.func if isinstance(one, ast.Call) else one for one in node.decorator_list]
    return any(isinstance(name, ast.Name) and name.id in ("compiled", "njit") for name in names)


@pytest.fixture(scope="module")
def long_ones() -> dict[str, ast.FunctionDef | ast.AsyncFunctionDef]:
    return {name: node for package in PACKAGES for name, node in functions(package) if parameters(node) > MOST}


def test_what_takes_more_is_compiled_or_a_declaration(long_ones: dict[str, ast.FunctionDef]) -> None:
    assert {name for name, node in long_ones.items() if not is_compiled(node)} == set(DECLARATIONS)
    for name in DECLARATIONS:
        assert len(long_ones[name].args.args) <= 4, name


def test_compiled_ones_are_where_kernels_are(long_ones: dict[str, ast.FunctionDef]) -> None:
    compiled = [name for name, node in long_ones.items() if is_compiled(node)]
    assert len(compiled) > 10
    assert [name for name in compiled if not name.startswith(PACKAGES_WITH_KERNELS)] == []


def test_functions_are_found_at_any_depth() -> None:
    deep = "class A:\n def a(): ...\ntry: ...\nexcept E:\n def b():\n  while 1:\n   async def c(): ..."
    match = "match x:\n case 1:\n  with y:\n   def d(): ...\ntry: ...\nfinally:\n def e(): ...\nx = lambda: 1"
    assert sorted(node.name for text in (deep, match) for node in defined_in(ast.parse(text))) == list("abcde")


def test_the_count_leaves_out_self_and_counts_keywords() -> None:
    (node,) = ast.parse("def f(self, a, /, b, *, c=1, **d): ...").body
    assert isinstance(node, ast.FunctionDef)
    assert parameters(node) == 3
    (compiled,) = ast.parse("@compiled(inline='always')\ndef f(): ...").body
    assert isinstance(compiled, ast.FunctionDef)
    assert is_compiled(compiled)
