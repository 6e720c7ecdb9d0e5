"""Small mutants of a Python file, one change each, and whether its tests notice.

Made from the syntax tree: comparisons, arithmetic, logic, conditions, constants, min and max, calls of one argument
less, and statements left out. Docstrings, annotations, imports and texts of errors are left alone.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from dataclasses import dataclass

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
ARITHMETIC: dict[type[ast.operator], tuple[type[ast.operator], ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
}
NAMES = {"min": "max", "max": "min", "all": "any", "any": "all", "cos": "sin", "sin": "cos", "abs": "float"}


@dataclass(frozen=True)
class Mutant:
    """One change: its line before and after as source (unparsed), and the whole file."""

    line: int
    before: str
    after: str
    source: str

    @property
    def name(self) -> str:
        """What tells it from others, whatever line it stands on."""
        return f"{self.before}  ->  {self.after}"


def mutants(source: str) -> Iterator[Mutant]:
    """Every mutant of the source, in the order of the file; no two with the same text."""
    tree = ast.parse(source)
    seen = {ast.unparse(tree)}
    for path, node in _walk(tree):
        for changed in _changes(node):
            other = copy.deepcopy(tree)
            _put(other, path, changed)
            ast.fix_missing_locations(other)
            text = ast.unparse(other)
            if text not in seen:
                seen.add(text)
                before, after = _statement(tree, path), _statement(other, path)
                yield Mutant(getattr(node, "lineno", 0), before, after, text)


Path = tuple[tuple[str, int | None], ...]


def _walk(tree: ast.Module) -> Iterator[tuple[Path, ast.AST]]:
    def below(node: ast.AST, path: Path) -> Iterator[tuple[Path, ast.AST]]:
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "exc", "bases", "keywords") and not (
                field == "keywords" and isinstance(node, ast.Call)
            ):
                continue
            items = value if isinstance(value, list) else [value]
            for k, item in enumerate(items):
                if not isinstance(item, ast.AST) or isinstance(item, (ast.Import, ast.ImportFrom, ast.JoinedStr)):
                    continue
                if isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant):
                    continue
                here = (*path, (field, k if isinstance(value, list) else None))
                yield here, item
                yield from below(item, here)

    yield from below(tree, ())


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    match node:
        case ast.Compare(left, operators, right):
            for k, op in enumerate(operators):
                for other in COMPARISONS[type(op)]:
                    yield ast.Compare(left, [*operators[:k], other(), *operators[k + 1 :]], right)
        case ast.BinOp(left, op, right):
            for swap in ARITHMETIC.get(type(op), ()):
                yield ast.BinOp(left, swap(), right)
        case ast.BoolOp(op, values):
            yield ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), values)
            for k in range(len(values)):
                left_out = values[:k] + values[k + 1 :]
                yield left_out[0] if len(left_out) == 1 else ast.BoolOp(op, left_out)
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            yield operand
        case ast.Constant(bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(int() | float() as value):
            yield ast.Constant(value + 1)
            yield ast.Constant(value - 1 if isinstance(value, int) else value * 0.9)
        case ast.Constant(str() as text):
            yield ast.Constant(text + "X")
        case ast.Call(ast.Name(name), arguments, keywords) if name in NAMES:
            yield ast.Call(ast.Name(NAMES[name]), arguments, keywords)
        case ast.If() | ast.IfExp():
            for value in (True, False):
                other_if = copy.copy(node)
                other_if.test = ast.Constant(value)
                yield other_if
        case ast.Return(ast.expr()):
            yield ast.Return(ast.Constant(None))
        case ast.Assign() | ast.AugAssign() | ast.Expr() | ast.Raise():
            yield ast.Pass()
        case ast.AnnAssign(target, _, ast.expr(), _) if isinstance(target, ast.Attribute):
            yield ast.Pass()


def _at(tree: ast.AST, path: Path) -> ast.AST:
    node: ast.AST = tree
    for field, k in path:
        value = getattr(node, field)
        node = value if k is None else value[k]
    return node


def _put(tree: ast.AST, path: Path, new: ast.AST) -> None:
    parent, (field, k) = _at(tree, path[:-1]), path[-1]
    if k is None:
        setattr(parent, field, new)
    else:
        getattr(parent, field)[k] = new


def _statement(tree: ast.AST, path: Path) -> str:
    """First line of the innermost statement around the place."""
    for end in range(len(path), 0, -1):
        node = _at(tree, path[:end])
        if isinstance(node, ast.stmt):
            return ast.unparse(node).splitlines()[0]
    return ""
