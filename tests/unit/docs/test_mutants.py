"""How mutants are made, sampled and judged; and five of them that the tests must notice."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from math import sqrt

import pytest

from scripts import mutant_tests
from scripts.decision_constants import MovedConstant
from scripts.fixed_mutants import FIXED
from scripts.mutant_sample import FOLDERS, ROOT, Mutant, mutants, stratified
from scripts.mutants import wilson


def changes(source: str) -> set[str]:
    return {"".join(mutant.source(source).split()) for mutant in mutants("pytest_dvp/gap/x.py", source)}


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = a + b", {"x=a-b"}),
        ("x = a < b", {"x=a<=b", "x=a>=b"}),
        ("x = a and b", {"x=aorb"}),
        ("x = 7", {"x=8", "x=6"}),
        ("if a: b()", {"ifnota:b()"}),
        ("for k in a: go(k)", {"forkin[]:go(k)"}),
        ("@compiled\ndef f(a): return a * b", {"@compileddeff(a):returna/b"}),
    ],
)
def test_a_mutant_is_one_change(source: str, expected: set[str]) -> None:
    assert changes(source) == expected


@pytest.mark.parametrize(
    "source",
    [
        '"""Seven is 7."""',
        "def f(a: int | None) -> str | None: ...",
        "x: Literal[1, 2]",
        "X: TypeAlias = int | float",
        "@dataclass(frozen=True)\nclass A: ...",
        "if TYPE_CHECKING:\n    x = 1",
        "def f(a, *, b, **c): ...",
        "x = f(*a, **{**b})",
    ],
)
def test_what_cannot_change_a_result_is_left_alone(source: str) -> None:
    assert changes(source) == set()


def test_each_beginning_of_the_sample_has_the_proportions_of_the_whole() -> None:
    sizes = dict(zip(FOLDERS, (300, 60, 40, 150, 50), strict=True))
    every = {f: [Mutant(f"{f}/x.py", n, "NumberReplacer", n) for n in range(size)] for f, size in sizes.items()}
    ordered = stratified(every, 19)
    assert len(set(ordered)) == 600
    assert stratified(every, 19) == ordered
    assert stratified(every, 20) != ordered
    for length in (60, 150, 300):
        counts = Counter(mutant.folder for mutant in ordered[:length])
        assert all(abs(counts[folder] - size * length / 600.0) <= 1.0 for folder, size in sizes.items())


def test_a_moved_constant_changes_its_number_alone() -> None:
    moved = MovedConstant("pytest_dvp/gap/x.py", 2, 4, 7, "A", 0.5, 0.75)
    assert moved.source("B = 1\nA = 0.5  # m\n") == "B = 1\nA = 0.75  # m\n"


def test_tests_that_import_a_module_by_its_name_judge_it_first(monkeypatch: pytest.MonkeyPatch) -> None:
    near, quick, slow = (f"tests/unit/gap/test_{name}.py" for name in ("iso18571", "regimes", "diagnose"))
    monkeypatch.setattr(mutant_tests, "importers", dict)
    monkeypatch.setattr(mutant_tests, "times", lambda: {quick: 0.1, near: 5.0, slow: 60.0})
    assert mutant_tests.judges("pytest_dvp/gap/compare/iso18571.py", "pytest_dvp/gap") == [near, quick]


@pytest.mark.parametrize(("killed", "count"), [(540, 600), (0, 10), (10, 10), (7, 9)])
def test_the_interval_ends_where_the_count_is_196_standard_deviations_off(killed: int, count: int) -> None:
    """Wilson 1927: the shares p of which what was counted lies 1.96 of sqrt(p (1 - p) / n) away."""
    low, high = wilson(killed, count)
    assert 0.0 <= low < high <= 1.0 + 1e-12
    for end in (low, high):
        if 1e-9 < end < 1.0 - 1e-9:
            assert abs(killed / count - end) == pytest.approx(1.959964 * sqrt(end * (1.0 - end) / count))


def test_five_mutants_are_killed() -> None:
    run = subprocess.run([sys.executable, "-m", "scripts.fixed_mutants"], cwd=ROOT, capture_output=True, text=True)
    assert run.stdout.count("killed: ") == len(FIXED) == 5, run.stdout + run.stderr
    assert run.returncode == 0
