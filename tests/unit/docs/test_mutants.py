"""How mutants are made, sampled and judged; and five of them that the tests must notice."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from math import sqrt
from pathlib import Path
from typing import Any

import pytest

from scripts import mutant_coverage, mutant_session, mutant_tests
from scripts.decision_constants import MovedConstant, moved_in
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


def test_a_change_that_makes_no_python_is_no_mutant() -> None:
    source = "if x := f():\n    pass\n"
    assert "AddNot" not in {mutant.operator for mutant in mutants("a.py", source)}
    assert "AddNot" in {mutant.operator for mutant in mutants("a.py", "if f():\n    pass\n")}


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


def test_every_number_of_a_constant_is_moved_up_and_down() -> None:
    """By a half and to two thirds, whole numbers up to 10 by one; also where two names stand in one statement."""
    source = "A, B = 1.5, 20\nC = (3, 0.0)\n_SEED = 4\nd = 5\nE: int = 9\n"
    moved = {(one.constant, one.value, one.moved) for one in moved_in("pytest_dvp/gap/x.py", source)}
    assert moved == {("A, B", 1.5, 2.25), ("A, B", 1.5, 1.0), ("A, B", 20, 30), ("A, B", 20, 13), ("C", 3, 4),
                     ("C", 3, 2), ("E", 9, 10), ("E", 9, 8)}  # fmt: skip


def test_tests_that_import_a_module_by_its_name_judge_it_first(monkeypatch: pytest.MonkeyPatch) -> None:
    near, quick, slow = (f"tests/unit/gap/test_{name}.py" for name in ("iso18571", "regimes", "diagnose"))
    monkeypatch.setattr(mutant_tests, "importers", dict)
    seconds = {quick: 0.1, near: 5.0, slow: 60.0}
    assert mutant_tests.judges("pytest_dvp/gap/compare/iso18571.py", "pytest_dvp/gap", seconds) == [near, quick]


READING = """A, B = 3, 4
C = 5
D = 6
E = D
def f():
    x = A
    return x
def g():
    return (C +
            x.B)
"""


@pytest.mark.parametrize(("line", "lines"), [(1, {6, 9, 10}), (2, {9, 10}), (3, set()), (4, set())])
def test_a_constant_is_judged_where_it_is_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, line: int, lines: set[int]
) -> None:
    """D is read where the module is imported, and E nowhere: all of the module is asked then."""
    (tmp_path / "x.py").write_text(READING)
    monkeypatch.setattr(mutant_coverage, "ROOT", tmp_path)
    found = mutant_coverage.readers("x", "x.py", mutant_coverage._bound(READING, line))
    assert found == ({"x.py": lines} if lines else {})


SOURCE = """A = 3
def f(a, b=2):
    if a:
        b = (a +
             4)
    return b
"""


@pytest.mark.parametrize(
    ("line", "executed"), [(1, {3, 4, 5, 6}), (2, {3, 4, 5, 6}), (3, {3}), (4, {4, 5}), (5, {4, 5}), (6, {6})]
)
def test_a_mutant_is_judged_by_tests_that_execute_its_statement(line: int, executed: set[int]) -> None:
    """What runs when the module is imported, a default value too, shows wherever one of its functions runs."""
    assert mutant_coverage._executed_with(SOURCE, line) == executed


Ran = dict[str, list[tuple[str, float, bool, list[int]]]]


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[Ran | None], mutant_coverage.Coverage]:
    """The coverage of x.py by tests, each with its seconds, whether it failed, and its lines; None: as kept."""
    (tmp_path / "x.py").write_text(SOURCE)
    monkeypatch.setattr(mutant_coverage, "ROOT", tmp_path)
    monkeypatch.setattr(mutant_coverage, "state", str)
    monkeypatch.setattr(mutant_coverage, "_shares", lambda file: file == "shared")
    monkeypatch.setattr(mutant_coverage, "imports", lambda path: {"x", "x.A"} if path.name == "reader" else {"x"})
    files = []

    def make(ran: Ran | None) -> mutant_coverage.Coverage:
        class Measuring:
            def measure(self, file: str) -> list[dict[str, object]]:
                return [dict(zip(("item", "seconds", "failed", "lines"), (*row[:3], {"x.py": row[3]}), strict=True))
                        for row in (ran or {})[file]]  # fmt: skip

        files.extend(ran or {})
        session: Any = Measuring() if ran else None
        return mutant_coverage.Coverage(tmp_path / "kept.jsonl", files, session)

    return make


def test_the_fastest_tests_that_execute_a_line_judge_it(
    measured: Callable[[Ran | None], mutant_coverage.Coverage],
) -> None:
    found = measured({
        "slow": [("slow::a", 9.0, False, [3, 4])],
        "quick": [("quick::a", 0.1, False, [3, 6]), ("quick::b", 0.2, False, [3, 4]), ("quick::c", 0.1, True, [3, 4])],
        "shared": [("shared::a", 0.5, False, [3, 4]), ("shared::b", 0.5, False, [6])],
    })  # fmt: skip
    assert found.tests("x.py", 4, 10.0).items == ("quick::b", "shared::a", "shared::b")
    assert found.tests("x.py", 4, 11.0).items == ("quick::b", "shared::a", "shared::b", "slow::a")
    assert found.tests("x.py", 4, 0.1).files == ["quick"]
    assert measured(None).tests("x.py", 4, 10.0) == found.tests("x.py", 4, 10.0)


def test_of_a_file_that_shares_and_takes_longer_than_the_budget_those_that_execute_the_line_judge_it(
    measured: Callable[[Ran | None], mutant_coverage.Coverage],
) -> None:
    found = measured({"shared": [("shared::a", 0.5, False, [3, 4]), ("shared::b", 9.0, False, [6])]})
    assert found.tests("x.py", 4, 9.6).items == ("shared::a", "shared::b")
    assert found.tests("x.py", 4, 9.4).items == ("shared::a",)


def test_a_constant_is_judged_by_tests_that_import_its_module_and_execute_none_of_it(
    measured: Callable[[Ran | None], mutant_coverage.Coverage],
) -> None:
    found = measured({"quick": [("quick::a", 0.1, False, [3])], "reader": [("reader::a", 0.2, False, [])]})
    assert found.tests("x.py", 1, 1.0).items == ("reader::a", "quick::a")
    assert found.tests("x.py", 3, 1.0).items == ("quick::a",)


def test_tests_that_compiled_are_measured_again(tmp_path: Path) -> None:
    """The first time has the seconds of the compiler in it."""
    session: Any = mutant_session.Session.__new__(mutant_session.Session)
    session._place = tmp_path
    asked: list[str] = []

    def question(**question: Any) -> dict[str, Any]:
        asked.append(question["measure"])
        (tmp_path / "__pycache__" / "cpython-311-numba-0" / "a").mkdir(parents=True, exist_ok=True)
        return {"lines": [{"seconds": 9.0 if len(asked) == 1 else 0.1}]}

    session._question = question
    assert session.measure("test_a.py") == [{"seconds": 0.1}]
    assert asked == ["test_a.py"] * 2
    session.measure("test_b.py")
    assert asked[2:] == ["test_b.py"]


def test_a_function_has_the_code_of_the_mutant_and_what_runs_at_import_is_left_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    path, space = tmp_path / "x.py", dict[str, Any]()
    exec(compile(SOURCE, str(path), "exec", dont_inherit=True), space)  # noqa: S102
    functions = {(str(path), "f", 2): [space["f"]]}
    for line, old, new, swapped in ((2, "b=2", "b=3", False), (1, "3", "4", False), (5, "4)", "5)", True)):
        path.write_text(SOURCE.replace(old, new))
        swap = mutant_session._swap("x.py", line, functions)
        assert (swap is not None) is swapped
        if swap is not None:
            assert space["f"](1) == 5
            swap()
            assert space["f"](1) == 6


def test_functions_are_found_though_the_garbage_collector_was_told_to_leave_them_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Else each mutant would have to be imported, which takes most of the time."""
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {}
    exec(compile(SOURCE, str(tmp_path / "x.py"), "exec", dont_inherit=True), space)  # noqa: S102
    gc.freeze()
    assert mutant_session._functions()[str(tmp_path / "x.py"), "f", 2] == [space["f"]]


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
