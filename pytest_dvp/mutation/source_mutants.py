"""Changes of a Python stack's own source: one operator, comparison, constant or function name at a time.

As mutmut makes them, with larger steps of numbers, but nothing is written: the code object of a function that is
already loaded is exchanged, and so is a constant, wherever it was imported. What numba compiles stays as it is, and so
do the constants that it reads: machine code keeps those that it was compiled with, in this drive and in later ones.
"""

from __future__ import annotations

import ast
import copy
import dataclasses
import functools
import importlib
import inspect
import random
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

WORD = "source"  # begins the name of such a fault: "source ads.control.lqr 57:10 + -> -"

_OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Div, ast.Pow: ast.Mult,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
_SIGNS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Pow: "**", ast.Lt: "<",
    ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.Is: "is", ast.IsNot: "is not",
    ast.In: "in", ast.NotIn: "not in", ast.And: "and", ast.Or: "or",
}  # fmt: skip
_FUNCTIONS = {"min": "max", "max": "min", "sin": "cos", "cos": "sin", "floor": "ceil", "ceil": "floor"}
_STEP = 1.5  # a number becomes 1.5 times itself, 0 becomes 1, a whole one the next


class SourceError(ValueError):
    """A module cannot be changed: there is none, or no source of it; one line."""


@dataclasses.dataclass(frozen=True)
class SourceMutant:
    """One change: the module as the user names it (a.b, or FILE.py), line and column (from 1), what becomes of it."""

    module: str
    line: int
    column: int
    change: str

    @property
    def name(self) -> str:
        """The name of the fault."""
        return f"{WORD} {self.module} {self.line}:{self.column} {self.change}"


def mutants_of(module: str) -> list[SourceMutant]:
    """All changes of a module's functions and constants, in the order of its source. Raises SourceError."""
    tree = ast.parse(_text(module))
    kept = _names_in_machine_code(module)
    return [SourceMutant(module, node.lineno, node.col_offset + 1, told) for node, told, _ in _changes(tree, kept)]


def sample(modules: Sequence[str], count: int, seed: int = 0) -> list[SourceMutant]:
    """At most `count` of the changes of the modules, by chance, the same for the same seed. Raises SourceError."""
    every = [mutant for module in modules for mutant in mutants_of(module)]
    return every if len(every) <= count else sorted(
        random.Random(seed).sample(every, count), key=lambda m: (m.module, m.line, m.column, m.change)
    )  # fmt: skip


def mutant_named(name: str) -> SourceMutant:
    """The change that a name tells. Raises SourceError for one that the module does not have."""
    _, module, place, change = name.split(" ", 3)
    found = [mutant for mutant in mutants_of(module) if mutant.name == name]
    if not found:
        raise SourceError(f"{module} has no change {change!r} at {place}: its source is another one")
    return found[0]


@contextmanager
def planted(mutant: SourceMutant) -> Iterator[None]:
    """The change is in the loaded module while this lasts; load the stack before. Raises SourceError."""
    tree = ast.parse(_text(mutant.module))
    kept = _names_in_machine_code(mutant.module)
    for node, told, change in _changes(tree, kept):
        if (node.lineno, node.col_offset + 1, told) == (mutant.line, mutant.column, mutant.change):
            change()
            break
    loaded = _loaded(mutant.module)
    code = compile(ast.fix_missing_locations(tree), str(loaded.__file__), "exec")
    undo: list[Any] = []
    other = {(c.co_qualname, c.co_firstlineno): c for c in _codes(code)}
    for function in _functions(loaded):
        old = function.__code__
        new = other.get((old.co_qualname, old.co_firstlineno))
        if new is not None and new != old and new.co_freevars == old.co_freevars:
            function.__code__ = new
            undo.append(lambda f=function, c=old: setattr(f, "__code__", c))
    undo += _with_constants(loaded, code, kept)
    try:
        yield
    finally:
        for back in undo:
            back()


def _names_in_machine_code(module: str) -> frozenset[str]:
    """Names that functions read which numba compiles: of all files of the module's package, or beside a lone file."""
    file = Path(module if module.endswith(".py") else str(importlib.import_module(module).__file__)).resolve()
    package = file.parent
    while (package.parent / "__init__.py").is_file():
        package = package.parent
    files = package.rglob("*.py") if (package / "__init__.py").is_file() else package.glob("*.py")
    return _names_read(tuple(sorted(files)))


@functools.cache
def _names_read(files: tuple[Path, ...]) -> frozenset[str]:
    names: set[str] = set()
    for file in files:
        try:
            tree = ast.parse(file.read_text("utf-8"))
        except (SyntaxError, UnicodeDecodeError):  # a file beside the stack that is none of it
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and _is_compiled(node):
                names |= {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
                names |= {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)}
    return frozenset(names)


def _is_compiled(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return any("compiled" in ast.unparse(d) or "jit" in ast.unparse(d) for d in function.decorator_list)


def _assigned(node: ast.AST) -> set[str]:
    """Names that a statement of a module gives a value."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", node)]
    return {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}


def _changes(tree: ast.Module, kept: frozenset[str]) -> Iterator[tuple[Any, str, Any]]:
    """Each node that can be changed, what the change is called, and what makes it; not the constants `kept`."""
    for node in _body(tree, kept):
        if isinstance(node, ast.BinOp | ast.AugAssign | ast.BoolOp) and type(node.op) in _OPERATORS:
            yield node, *_operator(node)
        elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in _OPERATORS:
            old, new = type(node.ops[0]), _OPERATORS[type(node.ops[0])]
            yield node, f"{_SIGNS[old]} -> {_SIGNS[new]}", lambda n=node, o=new: n.ops.__setitem__(0, o())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
            sign = "not" if isinstance(node.op, ast.Not) else "-"
            yield node, f"without {sign}", lambda n=node: setattr(n, "op", _Nothing.of(n))
        elif isinstance(node, ast.Constant) and type(node.value) in (bool, int, float):
            new = _number(node.value)
            yield node, f"{node.value!r} -> {new!r}", lambda n=node, v=new: setattr(n, "value", v)
        elif isinstance(node, ast.Call) and (name := _called(node.func)) in _FUNCTIONS:
            other = _FUNCTIONS[name]
            yield node, f"{name} -> {other}", lambda n=node, o=other: _call(n.func, o)


class _Nothing:
    """A sign that is left out: `+x` of a number, `not not x` of a truth."""

    @staticmethod
    def of(node: ast.UnaryOp) -> ast.unaryop:
        if isinstance(node.op, ast.Not):
            node.operand = ast.UnaryOp(ast.Not(), copy.deepcopy(node.operand))
            return ast.Not()
        return ast.UAdd()


def _operator(node: Any) -> tuple[str, Any]:
    old, new = type(node.op), _OPERATORS[type(node.op)]
    return f"{_SIGNS[old]} -> {_SIGNS[new]}", lambda: setattr(node, "op", new())


def _number(value: Any) -> Any:
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    return float(f"{value * _STEP:.12g}") if value else 1.0


def _called(function: ast.expr) -> str:
    return (
        function.id if isinstance(function, ast.Name) else function.attr if isinstance(function, ast.Attribute) else ""
    )


def _call(function: Any, name: str) -> None:
    setattr(function, "id" if isinstance(function, ast.Name) else "attr", name)


def _body(tree: ast.Module, kept: frozenset[str]) -> Iterator[ast.AST]:
    """Nodes of functions and constants: no decorators, annotations, defaults, docstrings, nor what numba compiles."""
    constants = ast.Assign | ast.AnnAssign | ast.AugAssign
    waiting: list[ast.AST] = [n for n in reversed(tree.body) if not (isinstance(n, constants) and _assigned(n) & kept)]
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            children: list[ast.AST] = [] if _is_compiled(node) else list(node.body)
        elif isinstance(node, ast.AnnAssign):
            children = [node.value] if node.value is not None else []
        elif isinstance(node, ast.ClassDef):
            children = [child for child in node.body if isinstance(child, ast.FunctionDef)]
        elif isinstance(node, ast.JoinedStr):
            children = []
        else:
            children = list(ast.iter_child_nodes(node))
        waiting += reversed(children)


def _text(module: str) -> str:
    if module.endswith(".py"):
        if not Path(module).is_file():
            raise SourceError(f"--source: no file {module!r}")
        return Path(module).read_text("utf-8")
    try:
        return inspect.getsource(importlib.import_module(module))
    except (ImportError, OSError, TypeError) as error:
        raise SourceError(f"--source: no source of module {module!r}: {error}") from None


def _loaded(module: str) -> ModuleType:
    if not module.endswith(".py"):
        return importlib.import_module(module)
    file = Path(module).resolve()
    for loaded in list(sys.modules.values()):
        name = getattr(loaded, "__file__", None)
        if name and Path(name).resolve() == file:
            return loaded
    raise SourceError(f"--source: the stack does not load {module!r}")


def _codes(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes(constant)


def _functions(module: ModuleType) -> Iterator[FunctionType]:
    """Python functions and methods that the module defines, behind whatever wraps them."""
    for holder in (
        module,
        *(v for v in vars(module).values() if inspect.isclass(v) and v.__module__ == module.__name__),
    ):
        for value in list(vars(holder).values()):
            for part in (value, *(getattr(value, name, None) for name in ("fget", "__func__", "func", "__wrapped__"))):
                plain = getattr(part, "__wrapped__", part)
                if isinstance(plain, FunctionType) and plain.__code__.co_filename == module.__file__:
                    yield plain


def _with_constants(module: ModuleType, code: CodeType, kept: frozenset[str]) -> list[Any]:
    """Exchange what the changed module holds otherwise, but what is `kept`, here and where it was imported by name;
    what undoes it."""
    namespace: dict[str, Any] = {"__name__": module.__name__, "__file__": module.__file__}
    namespace |= {"__package__": module.__package__, "__builtins__": __builtins__}
    stand_in = ModuleType(module.__name__)
    stand_in.__dict__.update(namespace)
    exec(code, stand_in.__dict__)  # noqa: S102 the user's own module, as its import runs it
    undo: list[Any] = []
    for name, new in list(vars(stand_in).items()):
        old = vars(module).get(name)
        if (
            name in kept
            or name.startswith("__")
            or callable(old)
            or isinstance(old, ModuleType)
            or not _differs(old, new)
        ):
            continue
        for holder in [m for m in list(sys.modules.values()) if m is not None and vars(m).get(name) is old]:
            setattr(holder, name, new)
            undo.append(lambda h=holder, n=name, v=old: setattr(h, n, v))
    return undo


def _differs(old: Any, new: Any) -> bool:
    try:
        return repr(old) != repr(new) and bool(old != new)
    except Exception:  # arrays and the like compare in their own way
        return repr(old) != repr(new)
