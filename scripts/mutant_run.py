"""Judge mutants: each takes the place of its file in a copy of the checkout, where a forked process runs its tests.

The process that forks has imported pytest, numba and the like, and nothing of ours, so that every module of ours is
read anew from the copy. Processes that a test starts see the copy too. Machine code is kept by the digest of its source
(machine_code/), so a mutant of a compiled function is compiled and the original's code stays as it is.
"""

from __future__ import annotations

import contextlib
import fcntl
import importlib
import importlib.util
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from scripts.mutant_sample import ROOT, Mutant

OWN = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp", "scenarios", "tests", "scripts",
       "benchmarks")  # fmt: skip
WARM = ("pytest", "_pytest.junitxml", "hypothesis", "numpy", "scipy.optimize", "scipy.signal", "numba", "pandas",
        "lxml.etree", "pymunk", "mcap.writer", "mcap.reader", "msgspec", "jinja2", "rich.console")  # fmt: skip
_LATER = 1_000  # s after the original's time stamp: no byte code of the original is taken for the mutant's


class Checkout:
    """A copy of the files under version control, in which one file at a time is changed."""

    def __init__(self, place: Path) -> None:
        self.place = place
        self._locks: dict[Path, int] = {}
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True,
                                text=True, check=True)  # fmt: skip
        names = set(listed.stdout.splitlines())
        for name in sorted(names):
            self._copy(name)
        for path in [p for p in place.rglob("*.py") if p.relative_to(place).as_posix() not in names]:
            path.unlink()

    def _copy(self, name: str) -> None:
        source, target = ROOT / name, self.place / name
        if not source.is_file():
            return
        if target.exists() and target.stat().st_mtime_ns == source.stat().st_mtime_ns:
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source, target)
        if source.suffix == ".py":  # byte code is valid for any file with the source's size and time stamp
            code = Path(importlib.util.cache_from_source(str(source)))
            for made in (code, code.with_name(f"{code.stem}-pytest-{pytest.__version__}.pyc")):
                if made.exists():
                    (target.parent / "__pycache__").mkdir(exist_ok=True)
                    shutil.copy2(made, target.parent / "__pycache__" / made.name)

    @contextlib.contextmanager
    def changed(self, mutant: Mutant) -> Iterator[None]:
        """Have the mutant in place of its file."""
        target, original = self.place / mutant.path, ROOT / mutant.path
        times = original.stat()
        try:
            target.write_text(mutant.source(original.read_text(encoding="utf-8")), encoding="utf-8")
            os.utime(target, (times.st_atime + _LATER, times.st_mtime + _LATER))
            yield
        finally:
            shutil.copy2(original, target)

    def keep_machine_code(self) -> None:
        """Have no process remove machine code of the originals because it has some of a mutant, which is newer."""
        for folder in self.place.rglob("__pycache__/*-numba-*"):
            if folder not in self._locks:
                self._locks[folder] = os.open(folder, os.O_RDONLY)
                fcntl.flock(self._locks[folder], fcntl.LOCK_SH)


def warm_up() -> None:
    """Import what every test run needs and what is not ours, and let numba collect what it knows how to compile: in
    each forked process that would be some 0.3 s of the first test that runs compiled code."""
    for name in WARM:
        importlib.import_module(name)
    target = importlib.import_module("numba.core.registry").cpu_target
    target.typing_context.refresh()
    target.target_context.refresh()


def run_tests(checkout: Path, tests: Sequence[str], *, seconds: float, keep: bool = False) -> tuple[str, str]:
    """Run tests in a forked process until one fails: "survived" if all pass, else "killed", or "killed by time"
    after that many seconds of CPU (or ten times as many of any time). And the test that failed, "" if none did.

    keep: write byte code, for runs of the originals.
    """
    failed = checkout / ".failed"
    failed.write_text("", encoding="utf-8")
    child = os.fork()
    if child == 0:
        _be_a_test_run(checkout, tests, seconds, keep, failed)
    ends = time.monotonic() + 10.0 * seconds
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > ends:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            status = signal.SIGKILL
            break
        time.sleep(0.02)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(child, signal.SIGKILL)  # what the tests started and did not end
    code = os.waitstatus_to_exitcode(status)
    if code in (-signal.SIGKILL, -signal.SIGXCPU):
        return "killed by time", ""
    return ("survived", "") if code == 0 else ("killed", failed.read_text(encoding="utf-8"))


class _FirstFailure:
    """A plugin of pytest that writes the name of the first failed test, or of what could not be imported, to a file."""

    def __init__(self, place: Path) -> None:
        self._place = place

    def pytest_runtest_logreport(self, report: Any) -> None:
        self._write(report)

    def pytest_collectreport(self, report: Any) -> None:
        self._write(report)

    def _write(self, report: Any) -> None:
        if report.failed and not self._place.read_text(encoding="utf-8"):
            self._place.write_text(report.nodeid, encoding="utf-8")


def enter(checkout: Path, keep: bool) -> None:
    """Make this process one that reads all modules of ours from a checkout and writes nothing to its streams.

    keep: write byte code.
    """
    os.chdir(checkout)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    for name in [name for name in sys.modules if name.partition(".")[0] in OWN]:
        del sys.modules[name]
    sys.path[:] = [str(checkout), *(entry for entry in sys.path if Path(entry or ".").resolve() != ROOT)]
    sys.dont_write_bytecode = not keep
    os.environ["PYTHONPATH"] = str(checkout)
    os.environ.pop("PYTEST_CURRENT_TEST", None)
    if not keep:
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"


def _be_a_test_run(checkout: Path, tests: Sequence[str], seconds: float, keep: bool, failed: Path) -> None:
    status = 1
    try:
        os.setpgid(0, 0)
        limit = int(seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        enter(checkout, keep)
        plain = ["-p", "no:cacheprovider", "-p", "no:randomly", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
        options = ["-x", "-q", "--tb=no", *plain, "--rootdir", str(checkout)]
        status = int(pytest.main([*options, *tests], plugins=[_FirstFailure(failed)]))
    finally:
        os._exit(status)
