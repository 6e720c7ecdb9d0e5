"""Mutants of the files whose errors would cost most, by the operators of cosmic-ray, and a repeatable sample of them.

cosmic-ray makes mutants from the source text, so it also reaches compiled and decorated functions. What cannot change a
result is left out: annotations, type aliases, decorators, and what only a type checker reads. Of each kind of
operator only the nearest neighbours are used: `<<` in place of `+` would fail in any test.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.provider import OperatorProvider

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("pytest_dvp/gap", "pytest_dvp/metrics", "pytest_dvp/verdicts", "openscenario/storyboard", "vehicle/model")
SEED = 19
SIZE = 600
_NEIGHBOURS = {
    "Binary": ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Mul", "Mod_FloorDiv", "Pow_Mul", "BitOr_BitAnd",
               "BitAnd_BitOr"),
    "Comparison": ("Lt_LtE", "Lt_GtE", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_LtE", "GtE_Gt", "GtE_Lt", "Eq_NotEq",
                   "NotEq_Eq", "Is_IsNot", "IsNot_Is"),
    "Unary": ("USub_UAdd", "Delete_Not", "Delete_Invert"),
}  # fmt: skip
_BINARY = (
    "arith_expr",
    "term",
    "power",
    "expr",
    "xor_expr",
    "and_expr",
)  # else a star unpacks or parts parameters
OPERATORS = (
    *(f"Replace{kind}Operator_{change}" for kind, changes in _NEIGHBOURS.items() for change in changes),
    "AddNot",
    "ReplaceTrueWithFalse",
    "ReplaceFalseWithTrue",
    "ReplaceAndWithOr",
    "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak",
    "ExceptionReplacer",
    "NumberReplacer",
    "ZeroIterationForLoop",
)


@dataclass(frozen=True, order=True)
class Mutant:
    """One change of one file: the place of the change, and which of the operator's possible changes it is."""

    path: str
    line: int
    operator: str
    occurrence: int

    @property
    def folder(self) -> str:
        """The folder of FOLDERS that the file belongs to."""
        return next(folder for folder in FOLDERS if self.path.startswith(folder + "/"))

    @property
    def name(self) -> str:
        """A text that tells this mutant from all others of the same sources."""
        return f"{self.path}:{self.line} {self.operator} {self.occurrence}"

    def source(self, original: str) -> str:
        """The file's text with the change. Raises ValueError if the text has no such place."""
        changed = mutate_code(original, operator(self.operator), self.occurrence)
        if changed is None:
            raise ValueError(f"{self.name}: there is no such place")
        return str(changed)


@cache
def operator(name: str) -> Any:
    """The operator of cosmic-ray with this name."""
    return OperatorProvider()[name]()


def files(folder: str) -> list[Path]:
    """The Python files of a folder and of the folders in it."""
    return sorted((ROOT / folder).rglob("*.py"))


def mutants(path: str, original: str) -> Iterator[Mutant]:
    """Every mutant of a file that could change what it does, by operator."""
    idle = _without_effect(original)
    counts = dict.fromkeys(OPERATORS, 0)
    for node in ast_nodes(get_ast(original)):
        for name in OPERATORS:
            for start, _ in operator(name).mutation_positions(node):
                if not (idle(start) or ("Binary" in name and node.parent.type not in _BINARY) or _is_none(name, node)):
                    yield Mutant(path, start[0], name, counts[name])
                counts[name] += 1


def _is_none(name: str, node: Any) -> bool:
    """True if the change makes no Python: `if not x := y` wants parentheses."""
    return name == "AddNot" and any(child.type == "namedexpr_test" for child in getattr(node, "children", ()))


def sample(size: int = SIZE, seed: int = SEED) -> list[Mutant]:
    """`size` mutants, from each folder in proportion to how many it has.

    They are ordered so that the first N, for any N, are again in that proportion: a run that was cut short is a
    smaller sample of the same kind.
    """
    every = {
        folder: [
            mutant
            for file in files(folder)
            for mutant in mutants(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8"))
        ]
        for folder in FOLDERS
    }
    return stratified(every, seed)[:size]


def stratified(every: Mapping[str, Sequence[Mutant]], seed: int) -> list[Mutant]:
    """All mutants in an order of which each beginning has as large a share of each folder as the whole."""
    rng = random.Random(seed)
    placed = [
        ((rank + 0.5) / len(found), folder, mutant)
        for folder, found in every.items()
        for rank, mutant in enumerate(rng.sample(found, len(found)))
    ]
    return [mutant for _, _, mutant in sorted(placed)]


def _without_effect(source: str) -> Callable[[tuple[int, int]], bool]:
    """A function that is true for a place (line, column) in an annotation, a decorator, or what only a type checker
    reads."""
    spans: list[tuple[tuple[int, int], tuple[int, int]]] = []

    def leave_out(node: ast.AST | None) -> None:
        if node is not None:
            end = getattr(node, "end_lineno", 0), getattr(node, "end_col_offset", 0)
            spans.append(((getattr(node, "lineno", 0), getattr(node, "col_offset", 0)), end))

    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.AnnAssign(annotation=annotation, value=value):
                leave_out(annotation)
                if "TypeAlias" in ast.unparse(annotation):
                    leave_out(value)
            case ast.arg(annotation=annotation):
                leave_out(annotation)
            case ast.FunctionDef() | ast.ClassDef():
                for decorator in node.decorator_list:
                    leave_out(decorator)
                if isinstance(node, ast.FunctionDef):
                    leave_out(node.returns)
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                leave_out(node)
    return lambda place: any(start <= place < end for start, end in spans)
