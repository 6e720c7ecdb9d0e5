"""Docstrings of the public API state shape and unit of arrays, and the errors that a function raises.

Held for what `pytest_dvp` exports and for every name that a page imports in an example. For all other public functions
`python tests/unit/docs/test_docstrings.py` counts what is missing.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

import pytest_dvp

ROOT = Path(__file__).parents[3]
PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp")
Function = ast.FunctionDef | ast.AsyncFunctionDef

ARRAY = re.compile(r"\b(?:\w*Array|NDArray|ndarray)\b")
SHAPE = re.compile(r"\([\w+* ]+,(?: ?[\w+*]+)*\)")  # (n,), (n, 8), (m, 2)
UNIT = re.compile(r"\[[^\]]+\]|\bSI\b|\bunits?\b|\bmetres\b|\bmask\b|\bindex|\brows?\b")


def missing(function: Function) -> list[str]:
    """What the docstring of a function does not say; [] if it says all."""
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
    errors = {name(node.exc) for node in ast.walk(function) if isinstance(node, ast.Raise) and node.exc is not None}
    caught = {name(node) for handler in ast.walk(function) if isinstance(handler, ast.ExceptHandler)
              for node in ast.walk(handler.type or handler) if isinstance(node, ast.Name)}  # fmt: skip
    return {error for error in errors if error[:1].isupper()} - caught


def name(node: ast.expr) -> str:
    """`ModelError` of `ModelError(...)` and of `errors.ModelError`."""
    node = node.func if isinstance(node, ast.Call) else node
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def functions_of(thing: object) -> list[tuple[str, Function]]:
    """A function itself, or the public methods and properties of a class, from its source; [] for anything else."""
    if not inspect.isclass(thing) and not inspect.isfunction(thing):
        return []
    (node,) = ast.parse(textwrap.dedent(inspect.getsource(thing))).body
    if isinstance(node, Function):
        return [(node.name, node)]
    assert isinstance(node, ast.ClassDef)
    methods = [child for child in node.body if isinstance(child, Function) and not child.name.startswith("_")]
    overloads = [child for child in methods if any(name(d) == "overload" for d in child.decorator_list)]
    return [(f"{node.name}.{child.name}", child) for child in methods if child not in overloads]


def public_things() -> dict[str, object]:
    """What `pytest_dvp` exports, and what the examples of the pages import from our packages, by dotted name."""
    things = {f"pytest_dvp.{key}": getattr(pytest_dvp, key) for key in pytest_dvp.__all__}
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    for module, names in re.findall(rf"^from ((?:{'|'.join(PACKAGES)})[\w.]*) import (.+)$", text, re.MULTILINE):
        for key in names.split("#")[0].split(","):
            things[f"{module}.{key.strip()}"] = getattr(importlib.import_module(module), key.strip())
    return things


PUBLIC = {
    f"{thing.__module__}.{label}": function
    for thing in public_things().values()
    for label, function in functions_of(thing)
}


@pytest.mark.parametrize("label", sorted(PUBLIC))
def test_a_public_docstring_states_shapes_units_and_errors(label: str) -> None:
    assert missing(PUBLIC[label]) == []


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


def main() -> None:
    """Print how many public functions of each package have a gap, and how many there are."""
    for package in PACKAGES:
        counts: dict[str, int] = {}
        functions = 0
        for path in sorted((ROOT / package).rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            bodies = [tree.body, *(n.body for n in tree.body if isinstance(n, ast.ClassDef) and n.name[0] != "_")]
            for node in (n for body in bodies for n in body if isinstance(n, Function) and n.name[0] != "_"):
                functions += 1
                for kind in {gap.split()[0] for gap in missing(node)}:
                    counts[kind] = counts.get(kind, 0) + 1
        print(package, functions, counts)


if __name__ == "__main__":
    main()
