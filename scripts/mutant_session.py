"""A session of pytest that has imported and collected everything once, and forks for each mutant.

To import our packages and to collect a folder's tests takes longer than most mutants need to be killed. So one process
does both. For each mutant it forks, puts the mutated code of one function in place of the old one, and runs the tests
that execute this function until one fails. It forks as well to find out which test executes which lines.

Only the code of a function is changed like that. What runs while a module is imported (constants, default values) and
compiled functions are left to `mutant_run.run_tests`, which imports everything anew.
"""

from __future__ import annotations

import ast
import contextlib
import gc
import importlib
import json
import os
import resource
import signal
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NoReturn

import coverage
import pytest
from _pytest.runner import runtestprotocol

from scripts.mutant_run import Checkout, enter
from scripts.mutant_sample import FOLDERS

MEASURING = 90.0  # s of CPU for the tests of one file, part of it to compile; what comes later judges no mutant
_UNFREEZE = gc.unfreeze  # tests/conftest.py freezes all objects after the collection, and lets nobody undo it
Functions = Mapping[tuple[str, str, int], list[FunctionType]]  # by file, qualified name and first line


class Session:
    """The process that has collected the tests, seen from outside. Raises SystemExit if a file cannot be collected."""

    def __init__(self, checkout: Checkout, files: Sequence[str]) -> None:
        self._place = checkout.place
        questions, self._ask = os.pipe()
        self._hear, answers = os.pipe()
        self._process = os.fork()
        if self._process == 0:
            os.close(self._ask)
            os.close(self._hear)
            enter(checkout.place, keep=True)
            options = ["-q", "--tb=no", "--capture=sys", "-p", "no:cacheprovider", "-p", "no:randomly",
                       "-W", "ignore::pytest.PytestAssertRewriteWarning", "--rootdir", str(checkout.place)]  # fmt: skip
            pytest.main([*options, *files], plugins=[_Judging(questions, answers)])
            os._exit(0)
        os.close(questions)
        os.close(answers)
        self._answers = os.fdopen(self._hear, encoding="utf-8")
        missing = sorted(set(files) - set(self._answer()["files"]))
        if missing:
            raise SystemExit(f"cannot be collected, or has no test: {', '.join(missing)}")

    def measure(self, file: str) -> list[dict[str, Any]]:
        """The tests of a file, run one after the other without any change: "item", "seconds" of CPU, whether it
        "failed", and the "lines" that it executed in each file of FOLDERS.

        Measured again if code was compiled meanwhile: what that took is not the test's own time, and would make it
        too slow to judge anything.
        """
        before = self._compiled()
        answer = self._question(measure=file, seconds=MEASURING)
        if self._compiled() - before:
            answer = self._question(measure=file, seconds=MEASURING)
        lines: list[dict[str, Any]] = answer["lines"]
        return lines

    def judge(self, path: str, line: int, items: Sequence[str], seconds: float) -> tuple[str, str] | None:
        """ "survived", or "killed" and by which test, or "killed by time"; None if it is no code of a plain function.

        The mutant is in place of its file in the checkout.
        """
        answer = self._question(path=path, line=line, items=list(items), seconds=seconds)
        if "cannot" in answer:
            return None
        by = "".join(row.get("by", "") for row in answer["lines"])
        if by or answer["late"]:
            return ("killed", by) if by else ("killed by time", "")
        return ("survived", "") if any("ended" in row for row in answer["lines"]) else ("killed", "")

    def _compiled(self) -> set[Path]:
        """What machine code there is."""
        return set(self._place.rglob("__pycache__/*-numba-*/*"))

    def end(self) -> None:
        """End the process."""
        os.close(self._ask)
        self._answers.close()
        os.waitpid(self._process, 0)

    def _question(self, **question: Any) -> dict[str, Any]:
        os.write(self._ask, (json.dumps(question) + "\n").encode())
        return self._answer()

    def _answer(self) -> dict[str, Any]:
        line = self._answers.readline()
        if not line:
            raise SystemExit("the session of pytest has ended")
        answer: dict[str, Any] = json.loads(line)
        return answer


class _Judging:
    """A plugin of pytest whose session answers questions, each a line of JSON, instead of running its tests."""

    def __init__(self, questions: int, answers: int) -> None:
        self._questions = os.fdopen(questions, encoding="utf-8")
        self._answers = os.fdopen(answers, "w", encoding="utf-8")

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        collected = {item.nodeid: item for item in session.items}
        functions = _functions()
        self._answer({"files": sorted({name.partition("::")[0] for name in collected})})
        for line in self._questions:
            self._answer(_reply(json.loads(line), collected, functions))
        return True

    def _answer(self, answer: Mapping[str, Any]) -> None:
        self._answers.write(json.dumps(answer) + "\n")
        self._answers.flush()


def _reply(question: Mapping[str, Any], collected: Mapping[str, pytest.Item], functions: Functions) -> dict[str, Any]:
    if "measure" in question:
        tests = [item for name, item in collected.items() if name.partition("::")[0] == question["measure"]]
        return _in_child(lambda out: _measure(tests, out), question["seconds"])
    swap = _swap(question["path"], question["line"], functions)
    if swap is None:
        return {"cannot": True}
    judges = [collected[name] for name in question["items"]]

    def judge(out: int) -> None:
        swap()
        for item, _, failed in _outcomes(judges):
            if failed:
                return _write(out, by=item.nodeid)
        return _write(out, ended=True)

    return _in_child(judge, question["seconds"])


def _outcomes(items: Sequence[pytest.Item]) -> Iterator[tuple[pytest.Item, float, bool]]:
    """Run tests in their order: each with its CPU time [s] and whether it failed."""
    for item, following in zip(items, [*items[1:], None], strict=True):
        begun = sum(os.times()[:4])
        reports = runtestprotocol(item, log=False, nextitem=following)
        yield item, sum(os.times()[:4]) - begun, any(report.failed for report in reports)


def _measure(items: Sequence[pytest.Item], out: int) -> None:
    here = Path.cwd()
    cover = coverage.Coverage(data_file=None, config_file=False, include=[f"{here}/{f}/*" for f in FOLDERS])
    cover.set_option("run:disable_warnings", ["no-data-collected"])  # which pytest's settings make an error
    cover.start()
    cover.switch_context("0")
    for number, (item, seconds, failed) in enumerate(_outcomes(items)):
        data = cover.get_data()
        data.set_query_context(str(number))
        cover.switch_context(str(number + 1))
        lines = {Path(file).relative_to(here).as_posix(): data.lines(file) or [] for file in data.measured_files()}
        executed = {file: sorted(numbers) for file, numbers in lines.items() if numbers}
        _write(out, item=item.nodeid, seconds=round(seconds, 3), failed=failed, lines=executed)


def _write(out: int, **line: Any) -> None:
    data = (json.dumps(line) + "\n").encode()
    while data:
        data = data[os.write(out, data) :]


def _in_child(work: Callable[[int], None], seconds: float) -> dict[str, Any]:
    """What a forked process wrote as lines of JSON ("lines"), and whether it took longer than that ("late")."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        _be_child(work, write, seconds)
    os.close(write)
    os.set_blocking(read, False)
    ends = time.monotonic() + 15.0 * seconds
    parts = b""
    status = None
    while status is None:
        done, code = os.waitpid(child, os.WNOHANG)
        status = code if done else None
        with contextlib.suppress(BlockingIOError):
            while part := os.read(read, 1 << 16):
                parts += part
        if status is None and time.monotonic() > ends:
            os.kill(child, signal.SIGKILL)
        if status is None:
            time.sleep(0.005)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(child, signal.SIGKILL)  # what the tests started and did not end
    os.close(read)
    late = os.waitstatus_to_exitcode(status) in (-signal.SIGKILL, -signal.SIGXCPU)
    return {"lines": [json.loads(line) for line in parts.decode().splitlines() if line.endswith("}")], "late": late}


def _be_child(work: Callable[[int], None], write: int, seconds: float) -> NoReturn:
    try:
        os.setpgid(0, 0)
        limit = int(seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        work(write)
    finally:
        os._exit(0)


def _functions() -> Functions:
    """All functions that were made from files of this folder, also of modules that no test has imported so far."""
    for path in (path for folder in FOLDERS for path in sorted(Path(folder).rglob("*.py"))):
        importlib.import_module(".".join(path.with_suffix("").parts).removesuffix(".__init__"))
    here = f"{Path.cwd()}/"
    _UNFREEZE()  # or none of them would be seen
    found: dict[tuple[str, str, int], list[FunctionType]] = {}
    for each in gc.get_objects():
        if isinstance(each, FunctionType) and each.__code__.co_filename.startswith(here):
            code = each.__code__
            found.setdefault((code.co_filename, code.co_qualname, code.co_firstlineno), []).append(each)
    gc.freeze()
    return found


def _swap(path: str, line: int, functions: Functions) -> Callable[[], None] | None:
    """A function that gives the functions at a line the code that the file has now; None where that is not all."""
    file = str(Path.cwd() / path)
    source = Path(file).read_text(encoding="utf-8")
    place = outermost(ast.parse(source), line)
    if place is None:
        return None
    name, node = place
    if any("compiled" in ast.unparse(decorator) for decorator in node.decorator_list):
        return None
    first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a mutant may compare a number by `is`, for example
        codes = _codes(compile(source, file, "exec", dont_inherit=True))
    new = next((code for code in codes if (code.co_qualname, code.co_firstlineno) == (name, first)), None)
    old = functions.get((file, name, first), [])
    if (
        new is None
        or not old
        or any(each.__code__ == new or each.__code__.co_freevars != new.co_freevars for each in old)
    ):
        return None

    def swap() -> None:
        for each in old:
            each.__code__ = new

    return swap


def outermost(tree: ast.Module, line: int) -> tuple[str, ast.FunctionDef] | None:
    """Qualified name and node of the function or method around a line, the outer one of nested ones."""
    pending: list[tuple[str, ast.AST]] = [("", tree)]
    while pending:
        prefix, node = pending.pop()
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                pending.append((f"{prefix}{child.name}.", child))
            elif isinstance(child, ast.FunctionDef):
                first = min([child.lineno, *(decorator.lineno for decorator in child.decorator_list)])
                if first <= line <= (child.end_lineno or first):
                    return f"{prefix}{child.name}", child
    return None


def _codes(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes(constant)
