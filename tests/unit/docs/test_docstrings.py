"""Docstrings of the public API state shape and unit of arrays, and the errors that a function raises.

Held for what `pytest_dvp` exports, for every name that a page imports in an example, and for each public function of
our packages.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import pytest_dvp
from pytest_dvp.rooms.side_by_side import PREFIX

ROOT = Path(__file__).parents[3]
PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp")
Function = ast.FunctionDef | ast.AsyncFunctionDef

ARRAY = re.compile(r"\b(?:\w*Array|NDArray|ndarray)\b")
SHAPE = re.compile(r"\([\w+* ]+,(?: ?[\w+*]+)*\)")  # (n,), (n, 8), (m, 2)
UNIT = re.compile(r"\[[^\]]+\]|\bSI\b|\bunits?\b|\bmetres\b|\bmask\b|\bindex|\brows?\b")


def missing(function: Function) -> list[str]:
    """What the docstring of a function does not say; [] if it says all.

    The declaration of a vehicle effect (physics, equation, source, keys with units) stands for its docstring: it cannot
    be left out, and the page of effects prints it.
    """
    if any(name(decorator) == "effect" for decorator in function.decorator_list):
        return []
    text = ast.get_docstring(function) or ""
    gaps = [] if text else ["docstring"]
    if any(ARRAY.search(annotation) for annotation in types_of(function)):
        gaps += [] if SHAPE.search(text) else ["shape"]
        gaps += [] if UNIT.search(text) else ["unit"]
    return gaps + [f"raises {name}" for name in sorted(raised(function)) if not re.search(rf"\b{name}\b", text)]


def types_of(function: Function) -> Iterator[str]:
    """Annotations of parameters and result, as they are written."""
    arguments = (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)
    yield from (ast.unparse(node) for a in arguments if (node := a.annotation) is not None)
    if function.returns is not None:
        yield ast.unparse(function.returns)


def raised(function: Function) -> set[str]:
    """Names of the errors that the function raises itself; those that it catches itself are left out."""
    nodes = list(ast.walk(function))
    errors = {name(node.exc) for node in nodes if isinstance(node, ast.Raise) and node.exc is not None}
    caught = {name(node) for handler in nodes if isinstance(handler, ast.ExceptHandler)
              for node in ast.walk(handler.type or handler) if isinstance(node, ast.Name)}  # fmt: skip
    return {error for error in errors if error[:1].isupper()} - caught


def name(node: ast.expr) -> str:
    """`ModelError` of `ModelError(...)` and of `errors.ModelError`."""
    node = node.func if isinstance(node, ast.Call) else node
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


@cache
def contents(module: str) -> tuple[list[ast.stmt], list[ast.ImportFrom]]:
    """Statements of a module, and its imports at whatever depth; `pytest_dvp.rooms.vehicle` is `vehicle`."""
    plain = module.removeprefix(PREFIX)
    path = ROOT / (plain if plain.partition(".")[0] in PACKAGES else module).replace(".", "/")
    tree = ast.parse((path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text(encoding="utf-8"))
    return tree.body, [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]


def definition(module: str, key: str) -> tuple[str, ast.stmt]:
    """Module and node of a name that a module defines or imports from one of ours."""
    body, imports = contents(module)
    for node in imports:
        if node.module and any(a.name == key for a in node.names):
            return definition(node.module, key)
    for node in body:
        defined = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", node)]
        if key in [getattr(node, "name", ""), *(getattr(target, "id", "") for target in defined)]:
            return module, node
    raise LookupError(f"{module} has no {key}")


def functions_of(node: ast.stmt) -> dict[str, Function]:
    """A function itself, or the public methods and properties of a class, by name; nothing for anything else."""
    if isinstance(node, Function):
        return {node.name: node}
    methods = [n for n in node.body if isinstance(n, Function)] if isinstance(node, ast.ClassDef) else []
    kept = [n for n in methods if n.name[0] != "_" and all(name(d) != "overload" for d in n.decorator_list)]
    return {f"{getattr(node, 'name', '')}.{n.name}": n for n in kept}


def functions_in(folder: str) -> Iterator[tuple[str, Function]]:
    """Public functions and methods in the files of a folder, each with its file and line."""
    for path in sorted((ROOT / folder).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        bodies = [tree.body, *(n.body for n in tree.body if isinstance(n, ast.ClassDef) and n.name[0] != "_")]
        for node in (n for body in bodies for n in body if isinstance(n, Function) and n.name[0] != "_"):
            if all(name(d) != "overload" for d in node.decorator_list):
                yield f"{path.relative_to(ROOT)}:{node.lineno} {node.name}", node


def public_names() -> set[tuple[str, str]]:
    """Module and name of what `pytest_dvp` exports, and of what the examples of the pages import from our packages."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    lines = re.findall(rf"^from ((?:{'|'.join(PACKAGES)})[\w.]*) import (.+)$", text, re.MULTILINE)
    named = {(module, key.strip()) for module, keys in lines for key in keys.split("#")[0].split(",")}
    return named | {("pytest_dvp", key) for key in pytest_dvp.__all__}


PUBLIC = {
    f"{module}.{label}": function
    for module, node in (definition(*names) for names in public_names())
    for label, function in functions_of(node).items()
}


@pytest.mark.parametrize("label", sorted(PUBLIC))
def test_a_public_docstring_states_shapes_units_and_errors(label: str) -> None:
    assert missing(PUBLIC[label]) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_docstring_of_a_package_says_all(package: str) -> None:
    gaps = {label: missing(node) for label, node in functions_in(package)}
    assert gaps  # a package that has moved must not look like one that is done
    assert {label: said for label, said in gaps.items() if said} == {}


def test_the_public_things_are_found() -> None:
    assert {"pytest_dvp.drive.run.run", "pytest_dvp.logs.log.Log.load"} <= PUBLIC.keys()
    assert "pytest_dvp.logs.read_log.read_log" in PUBLIC  # from an example of a page


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ('def f(a: FloatArray):\n    """Values (n,) [m]."""', []),
        ('def f(a: FloatArray):\n    """Values."""', ["shape", "unit"]),
        ('def f(a: FloatArray | None):\n    """Values [m]."""', ["shape"]),
        ('def f() -> int:\n    """Nothing."""\n    raise LogError("x")', ["raises LogError"]),
        ('def f() -> int:\n    """Raises LogError."""\n    raise LogError("x")', []),
        ("def f() -> int:\n    return 1", ["docstring"]),
    ],
)
def test_a_gap_in_a_docstring_is_found(source: str, expected: list[str]) -> None:
    (function,) = ast.parse(source).body
    assert isinstance(function, Function)
    assert missing(function) == expected
