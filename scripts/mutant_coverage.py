"""Which tests execute a line: chosen to judge a mutant there, the fastest first.

What a test executes is measured once (`Session.measure`) and kept in runs/mutants as long as neither a module of ours
nor the test's file has changed. Where tests of a file share something (a fixture of the module, a cached function),
only the first one that uses it executes the code behind it. So in such files each test counts as executing all that
any of them does, and they are run together; where that takes longer than the budget, the ones that executed the line
themselves are run alone.
"""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from scripts.mutant_sample import FOLDERS, ROOT
from scripts.mutant_session import Session, outermost
from scripts.mutant_tests import HOMES, ROOMS, imports

_SHARING = ("cache", 'scope="module"', 'scope="session"', 'scope="class"')


@dataclass(frozen=True)
class Tests:
    """Tests that judge a mutant, in their order, and the CPU time [s] that they take together."""

    items: tuple[str, ...]
    seconds: float

    @property
    def files(self) -> list[str]:
        """The files that they are in."""
        return list(dict.fromkeys(name.partition("::")[0] for name in self.items))


class Coverage:
    """What each test executes, measured where it is not known.

    path: file that keeps it.
    """

    def __init__(self, path: Path, files: Sequence[str], session: Session) -> None:
        kept: dict[str, list[dict[str, Any]]] = {}
        if path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                row = json.loads(line)
                kept[row["state"]] = row["tests"]
        self._files: dict[str, list[dict[str, Any]]] = {}
        for file in files:
            tests = kept.get(state(file))
            if tests is None:
                tests = session.measure(file)
                failed = [row["item"] for row in tests if row["failed"]]
                if failed:
                    print(
                        f"{len(failed)} of {file} fail without any change, and judge nothing: {failed[0]}", flush=True
                    )
                if tests:
                    with path.open("a", encoding="utf-8") as out:
                        out.write(json.dumps({"state": state(file), "file": file, "tests": tests}) + "\n")
                else:  # it is measured again next time
                    print(f"{file}: no test could be measured, and none judges", flush=True)
            self._files[file] = tests

    @property
    def seconds(self) -> Mapping[str, float]:
        """CPU time of each test file [s]."""
        return {file: sum(row["seconds"] for row in tests) for file, tests in self._files.items()}

    def tests(self, path: str, line: int, budget: float) -> Tests:
        """Tests that execute a line: those that take least, until `budget` [s of CPU] is used up.

        Of a constant these are the tests that execute a line which reads it, in whichever module, and, first, the tests
        of files that import it, for they may read it themselves.
        """
        source = (ROOT / path).read_text(encoding="utf-8")
        lines = {path: _executed_with(source, line)}
        module = path.removesuffix(".py").replace("/", ".") if outermost(ast.parse(source), line) is None else ""
        bound = _bound(source, line) if module else frozenset()
        if module:
            lines = readers(module, path, bound) or lines
        wanted = {f"{module}.{name}" for name in bound} or {module}
        chosen: list[tuple[bool, float, list[str]]] = []
        for file, tests in self._files.items():
            passed = [row for row in tests if not row["failed"]]
            whole = sum(row["seconds"] for row in passed)
            imported = bool(module and passed) and not wanted.isdisjoint(imports(ROOT / file))
            near = [row for row in passed if imported or _meets(row["lines"], lines)]
            if near and _shares(file) and whole <= budget:
                chosen.append((not imported, whole, [row["item"] for row in passed]))
            else:
                chosen += [(not imported, row["seconds"], [row["item"]]) for row in near]
        items: list[str] = []
        spent = 0.0
        for _, seconds, names in sorted(chosen):
            if not items or spent + seconds <= budget:
                items += names
                spent += seconds
        return Tests(tuple(items), spent)


def candidates(folder: str) -> list[str]:
    """Test files that may judge a mutant of a folder: unit tests of its home, and others that import some of it."""
    package = folder.replace("/", ".")
    found = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        name = path.relative_to(ROOT).as_posix()
        uses = name.startswith("tests/unit/") and any(module.startswith(package) for module in imports(path))
        if uses or name.startswith(HOMES[folder]):
            found.append(name)
    return found


@cache
def state(test: str) -> str:
    """Digest of a test file and of all modules: a test that has passed in this state need not be run again."""
    return hashlib.sha256(_sources() + test.encode() + (ROOT / test).read_bytes()).hexdigest()[:20]


@cache
def _sources() -> bytes:
    digest = hashlib.sha256()
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


@cache
def _shares(file: str) -> bool:
    """Whether tests of a file share something, by their file or by what they import from a file beside them."""
    source = (ROOT / file).read_text(encoding="utf-8")
    beside = [path.read_text(encoding="utf-8") for path in (ROOT / file).parent.glob("*.py")
              if not path.name.startswith("test_") and path.stem in source]  # fmt: skip
    return any(word in text for text in (source, *beside) for word in _SHARING)


def _executed_with(source: str, line: int) -> frozenset[int]:
    """Lines of which at least one is executed when the line is: of its statement; of the body of its function for a
    line of a function's head; of all functions for what runs when the module is imported."""
    tree = ast.parse(source)
    place = outermost(tree, line)
    if place is None:
        every = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
        return frozenset(number for node in every for number in _lines(node.body))
    _, function = place
    spans = [_span(node) for node in ast.walk(function) if isinstance(node, ast.stmt) and node is not function]
    around = [span for span in spans if line in span]
    return frozenset(min(around, key=len)) if around else _lines(function.body)


def _bound(source: str, line: int) -> frozenset[str]:
    """Names that the statement of a module at a line gives a value to."""
    for node in ast.parse(source).body:
        if node.lineno <= line <= (node.end_lineno or node.lineno) and isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            return frozenset(n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name))
    return frozenset()


def readers(module: str, path: str, names: frozenset[str]) -> dict[str, frozenset[int]]:
    """Lines in functions of each file of FOLDERS that read one of some names of a module, with those that go with them;
    none if one of the names is read by what runs when a module is imported, or by no function at all."""
    found = {}
    files = [path, *(file.relative_to(ROOT).as_posix() for folder in FOLDERS for file in (ROOT / folder).rglob("*.py"))]
    for file in dict.fromkeys(files):
        source = (ROOT / file).read_text(encoding="utf-8")
        if file != path and module not in imports(ROOT / file):
            continue
        tree = ast.parse(source)
        lines = [node.lineno for node in ast.walk(tree)
                 if (isinstance(node, ast.Name) and node.id in names and isinstance(node.ctx, ast.Load))
                 or (isinstance(node, ast.Attribute) and node.attr in names)]  # fmt: skip
        if any(outermost(tree, line) is None for line in lines):
            return {}
        if lines:
            found[file] = frozenset(number for line in lines for number in _executed_with(source, line))
    return found


def _meets(executed: Mapping[str, Sequence[int]], lines: Mapping[str, frozenset[int]]) -> bool:
    return any(not wanted.isdisjoint(executed.get(file, ())) for file, wanted in lines.items())


def _span(node: ast.stmt) -> range:
    """Lines of a statement, without those of a block in it."""
    blocks: Iterable[ast.stmt] = getattr(node, "body", []) or []
    last = min((block.lineno for block in blocks), default=(node.end_lineno or node.lineno) + 1)
    return range(node.lineno, max(last, node.lineno + 1))


def _lines(body: Sequence[ast.stmt]) -> frozenset[int]:
    return frozenset(number for node in body for number in range(node.lineno, (node.end_lineno or node.lineno) + 1))
