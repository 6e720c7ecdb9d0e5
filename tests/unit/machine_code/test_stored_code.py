"""Machine code on disk: an edit of anything that goes into it counts, old folders go, and no disk ends a run.

A package of three small files stands for the product: a function that calls one of another file and reads constants of
a third. Python's own byte code files are switched off, so that the only memory between two imports is the one tested.
"""

from __future__ import annotations

import fcntl
import importlib
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numba
import pytest

from machine_code import compiled

PACKAGE = "numbers_of_three_files"
FILES = {
    "outer.py": """
from machine_code import compiled
from numbers_of_three_files import constants
from numbers_of_three_files.constants import FACTOR, PAIR, Kind
from numbers_of_three_files.inner import inner, plain

@compiled
def outer(x):
    if x < 0.0:
        return plain(x)
    return inner(x) * FACTOR + constants.OFFSET + PAIR[1] + Kind.SHARE.value
""",
    "inner.py": """
from numba.extending import register_jitable
from machine_code import compiled

@compiled
def inner(x, more=0.5):
    return x + more + 3.0

@register_jitable
def plain(x):
    return 9.0 * x
""",
    "constants.py": """
from enum import IntEnum

FACTOR, OFFSET, PAIR = 2.0, 1.0, (0.0, 4.0)

class Kind(IntEnum):
    SHARE = 25
""",
}
NOW = (1.0 + 0.5 + 3.0) * 2.0 + 1.0 + 4.0 + 25.0  # of 1.0


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "sources" / PACKAGE
    folder.mkdir(parents=True)
    for name, text in {"__init__.py": "", **FILES}.items():
        (folder / name).write_text(text)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "users"))
    monkeypatch.syspath_prepend(folder.parent)
    yield folder
    forget()


def forget() -> None:
    for name in [name for name in sys.modules if name.startswith(PACKAGE)]:
        del sys.modules[name]


def fresh() -> ModuleType:
    """The package as a new process would see it."""
    forget()
    importlib.invalidate_caches()
    return importlib.import_module(f"{PACKAGE}.outer")


def edit(file: Path, old: str, new: str) -> None:
    """Another content, with the same size and the same time of change."""
    text, stat = file.read_text(), file.stat()
    assert text.count(old) == 1
    assert len(old) == len(new)
    file.write_text(text.replace(old, new))
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def folders(below: Path, function: str = "outer") -> list[Path]:
    return sorted(below.rglob(f"{PACKAGE}.{function}.{function}-*"))


def hits(function: object) -> int:
    return sum(function.stats.cache_hits.values())  # type: ignore[attr-defined]


def test_what_was_compiled_is_loaded(package: Path) -> None:
    assert fresh().outer(1.0) == NOW
    again = fresh()
    assert again.outer(1.0) == NOW
    assert hits(again.outer) == 1


@pytest.mark.parametrize(
    ("file", "old", "new", "x", "after"),
    [
        ("inner.py", "more + 3.0", "more - 3.0", 1.0, NOW - 12.0),
        ("inner.py", "more=0.5", "more=2.5", 1.0, NOW + 4.0),
        ("inner.py", "9.0 * x", "8.0 * x", -1.0, -8.0),
        ("constants.py", "= 2.0,", "= 4.0,", 1.0, NOW + 9.0),
        ("constants.py", " 1.0,", " 7.0,", 1.0, NOW + 6.0),
        ("constants.py", "4.0)", "5.0)", 1.0, NOW + 1.0),
        ("constants.py", "25", "75", 1.0, NOW + 50.0),
        ("outer.py", "PAIR[1]", "PAIR[0]", 1.0, NOW - 4.0),
    ],
    ids=["callee", "default", "helper", "imported", "of a module", "in a tuple", "of a class", "own"],
)
def test_an_edit_counts_whatever_the_size_and_time(
    package: Path, file: str, old: str, new: str, x: float, after: float
) -> None:
    fresh().outer(x)
    edit(package / file, old, new)
    assert fresh().outer(x) == after


def test_a_comment_compiles_nothing_anew(package: Path) -> None:
    fresh().outer(1.0)
    (package / "outer.py").write_text("# a line more\n" + (package / "outer.py").read_text())
    again = fresh()
    assert (again.outer(1.0), hits(again.outer)) == (NOW, 1)


def start(package: Path) -> subprocess.Popen[str]:
    """Another process, which calls the function once its input ends."""
    code = f"import sys; from {PACKAGE}.outer import outer; sys.stdin.read(); print(outer(1.0))"
    path = os.pathsep.join((str(package.parent), str(Path(__file__).parents[3])))
    environment = os.environ | {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", code], env=environment, text=True, stdin=pipe, stdout=pipe)


@pytest.mark.nightly
def test_older_folders_go_unless_another_process_is_there(package: Path) -> None:
    assert start(package).communicate("", timeout=300)[0] == f"{NOW}\n"
    (first,) = folders(package)
    other = os.open(first.parent, os.O_RDONLY)
    fcntl.flock(other, fcntl.LOCK_SH)  # as a process that still runs the older source does
    edit(package / "inner.py", "more + 3.0", "more - 3.0")
    fresh().outer(1.0)
    assert first in folders(package)
    os.close(other)
    edit(package / "inner.py", "more - 3.0", "more * 3.0")
    fresh().outer(1.0)
    assert first not in folders(package)
    assert folders(package)


@pytest.mark.nightly
def test_two_processes_that_begin_at_once(package: Path) -> None:
    both = [start(package) for _ in range(2)]
    for process in both:
        assert process.stdin is not None
        process.stdin.close()
        process.stdin = None
    for process in both:
        assert process.communicate(timeout=300)[0] == f"{NOW}\n"
    again = fresh()
    assert (again.outer(1.0), hits(again.outer)) == (NOW, 1)


def test_a_package_that_cannot_be_written_uses_the_users_cache(package: Path, tmp_path: Path) -> None:
    (package / "__pycache__").write_text("a file here: no folder can be made, not even by root")
    fresh().outer(1.0)
    assert len(folders(tmp_path / "users")) == 1
    again = fresh()
    assert (again.outer(1.0), hits(again.outer)) == (NOW, 1)


def test_nothing_can_be_written_at_all(package: Path, tmp_path: Path) -> None:
    (package / "__pycache__").write_text("")
    (tmp_path / "users").write_text("")
    assert fresh().outer(1.0) == NOW


def test_a_folder_that_the_user_names_comes_first(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "named"))
    fresh().outer(1.0)
    assert len(folders(tmp_path / "named")) == 1
    assert not folders(package)


def test_files_that_were_cut_short_are_made_anew(package: Path) -> None:
    fresh().outer(1.0)
    for file in folders(package)[0].iterdir():
        file.write_bytes(file.read_bytes()[:100])
    assert fresh().outer(1.0) == NOW


def test_the_users_own_compiled_functions_are_left_alone(package: Path) -> None:
    (package / "own.py").write_text("from numba import njit\n\n@njit(cache=True)\ndef own(x):\n    return x\n")
    fresh()
    own = importlib.import_module(f"{PACKAGE}.own").own
    own(1.0)
    assert Path(own.stats.cache_path) == package / "__pycache__"
    assert list((package / "__pycache__").glob("own.own-*.nbi"))


def test_without_compiling_functions_stay_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    def function(x: float) -> float:
        return x

    monkeypatch.setattr(numba.config, "DISABLE_JIT", True)
    assert compiled(function) is function
    assert compiled(inline="always")(function) is function
