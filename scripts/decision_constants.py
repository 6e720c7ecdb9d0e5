"""Constants that decide what is named, judged or refused, each moved up and down:  part of scripts.mutants --constants

A constant is bounded from both sides if a test fails when it is half as large again, and another when it is two thirds
of what it is. A whole number up to 10 is moved by one. cosmic-ray moves every number by one, which says little about a
share of 0.05: hence these.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from scripts.mutant_sample import ROOT

FILES = (
    "pytest_dvp/gap/diagnose/search.py",
    "pytest_dvp/gap/diagnose/candidates.py",
    "pytest_dvp/gap/diagnose/held_out.py",
    "pytest_dvp/gap/compare/compare.py",
    "pytest_dvp/verdicts/judging.py",
    *(
        f"pytest_dvp/doctor/{name}.py"
        for name in (
            "angle_units",
            "missing_values",
            "position_drift",
            "redundant_motion",
            "sensor_faults",
            "signs_and_axes",
            "smoothing",
            "speed_and_acceleration",
            "time_base",
            "excitation",
        )
    ),
)
FACTOR = 1.5
_NO_DECISION = ("_SEED", "_DRAWS")  # any other value of these is as good
_SMALL = 10  # up to here a whole number is moved by one


@dataclass(frozen=True)
class MovedConstant:
    """A number in the value of a module's constant, in a place given by line and column, and another one for it."""

    path: str
    line: int
    column: int
    end: int
    constant: str
    value: float
    moved: float

    @property
    def folder(self) -> str:
        """Folder whose unit tests judge it."""
        return "/".join(self.path.split("/")[:2])

    @property
    def operator(self) -> str:
        """What is done to the number."""
        return f"{self.constant} {self.value:g} -> {self.moved:g}"

    @property
    def occurrence(self) -> int:
        """Column of the number, for constants with several."""
        return self.column

    @property
    def name(self) -> str:
        """A text that tells it from all others."""
        return f"{self.path}:{self.line} {self.operator}"

    def source(self, original: str) -> str:
        """The file's text with the other number."""
        lines = original.splitlines(keepends=True)
        line = lines[self.line - 1]
        lines[self.line - 1] = f"{line[: self.column]}{self.moved!r}{line[self.end :]}"
        return "".join(lines)


def moved_constants() -> Iterator[MovedConstant]:
    """Each number of each constant of FILES, once larger and once smaller."""
    for path in FILES:
        yield from moved_in(path, (ROOT / path).read_text(encoding="utf-8"))


def moved_in(path: str, source: str) -> Iterator[MovedConstant]:
    """Each number of each constant of a file with this text."""
    for statement in ast.parse(source).body:
        target = statement.targets[0] if isinstance(statement, ast.Assign) else getattr(statement, "target", None)
        value = getattr(statement, "value", None)
        if target is None or value is None:
            continue
        # Several names may stand in one statement: A, B = 1.0, 2.0
        name = ", ".join(node.id for node in ast.walk(target) if isinstance(node, ast.Name))
        if not name.isupper() or name in _NO_DECISION:
            continue
        for node in ast.walk(value):
            if isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.end_col_offset:
                for moved in _others(node.value):
                    yield MovedConstant(
                        path, node.lineno, node.col_offset, node.end_col_offset, name, node.value, moved
                    )


def _others(value: float) -> tuple[float, ...]:
    if isinstance(value, int):
        return (value + 1, value - 1) if value <= _SMALL else (round(value * FACTOR), round(value / FACTOR))
    return () if value == 0.0 else (value * FACTOR, value / FACTOR)
