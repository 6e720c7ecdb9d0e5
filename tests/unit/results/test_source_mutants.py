"""Changes of a stack's source: each does what it says while it lasts, and nothing is left of it."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from pytest_dvp.mutation.source_mutants import SourceError, SourceMutant, mutant_named, mutants_of, planted, sample

SOURCE = '''"""A part of a stack."""

GAIN = 2.0
NAMES = ("a", "b")


def law(error: float, least: float = 0.5) -> float:
    """Docstring with 1 number."""
    if error < 1.0 and not error == 0.0:
        return GAIN * error + 3
    return min(error, -least)


class Part:
    """A class."""

    def __init__(self) -> None:
        self.on = True

    @property
    def twice(self) -> int:
        return 2 * 4
'''


@pytest.fixture
def part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    (tmp_path / "a_part.py").write_text(SOURCE)
    (tmp_path / "a_user.py").write_text("from a_part import GAIN, law\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("a_part")
    for name in ("a_part", "a_user"):
        sys.modules.pop(name, None)


def results(part: ModuleType) -> tuple[Any, ...]:
    made = part.Part()
    return part.GAIN, part.law(0.0), part.law(0.5), part.law(1.0), part.law(2.0), made.on, made.twice


def test_every_change_shows_and_none_stays(part: ModuleType) -> None:
    before = results(part)
    found = mutants_of("a_part")
    assert [m.change for m in found] == [
        "2.0 -> 3.0", "and -> or", "< -> <=", "1.0 -> 1.5", "without not", "== -> !=", "0.0 -> 1.0", "+ -> -",
        "* -> /", "3 -> 4", "min -> max", "without -", "True -> False", "* -> /", "2 -> 3", "4 -> 5",
    ]  # fmt: skip
    for mutant in found:
        with planted(mutant_named(mutant.name)):
            assert results(part) != before, mutant.name
        assert results(part) == before, mutant.name


def test_a_constant_is_another_one_where_it_was_imported_too(part: ModuleType) -> None:
    user = importlib.import_module("a_user")
    constant = mutants_of("a_part")[0]
    with planted(constant):
        assert (user.GAIN, user.law(0.5)) == (3.0, 4.5)
    assert (user.GAIN, user.law(0.5)) == (2.0, 4.0)


def test_a_sample_is_the_same_each_time(part: ModuleType) -> None:
    assert sample(["a_part"], 5) == sample(["a_part"], 5)
    assert len(sample(["a_part"], 5)) == 5
    assert len(sample(["a_part"], 100)) == 16


@pytest.mark.parametrize(
    ("word", "said"),
    [("no_such_module", "no source of module 'no_such_module'"), ("nowhere.py", "no file 'nowhere.py'")],
)
def test_a_module_that_is_not_there_is_one_line(word: str, said: str) -> None:
    with pytest.raises(SourceError, match=said):
        mutants_of(word)


def test_a_change_that_the_source_has_no_more_is_said(part: ModuleType) -> None:
    with pytest.raises(SourceError, match="its source is another one"):
        mutant_named(SourceMutant("a_part", 3, 8, "2.0 -> 7.0").name)


def test_constants_that_machine_code_reads_stay_as_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What numba compiles keeps the constants of that moment, also for the drives that come after."""
    (tmp_path / "of_two.py").write_text(
        "def compiled(function):\n    return function\n\nSIZE, FREE = 4.0, 5\nOTHER = 2.0\n\n"
        "@compiled\ndef whole(x):\n    return SIZE * x\n\ndef half(x):\n    return OTHER * FREE * x\n",
        "utf-8",
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    changes = {mutant.change for mutant in mutants_of("of_two")}
    assert changes == {"2.0 -> 3.0", "* -> /"}
    assert {mutant.change for mutant in mutants_of(str(tmp_path / "of_two.py"))} == changes
