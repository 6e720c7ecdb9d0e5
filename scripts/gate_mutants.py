"""Mutation test of the guard:  python -m scripts.gate_mutants [--jobs 2]

Each mutant takes the place of its module in a process of its own, where the gate's tests run. It is killed if a test
fails or takes longer than LONGEST. What survives stands in gate_equivalents.toml with the reason why no test could tell
it from the original, or the command fails.
"""

from __future__ import annotations

import argparse
import importlib
import io
import os
import resource
import sys
import tomllib
import types
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from scripts.mutate import Mutant, mutants

ROOT = Path(__file__).resolve().parents[1]
MODULES = ("vehicle.guard.messages", "vehicle.guard.guard", "vehicle.guard.arming")
TESTS = sorted(str(path) for path in (ROOT / "tests/unit/vehicle").glob("test_command_gate*.py"))
EQUIVALENT = Path(__file__).with_name("gate_equivalents.toml")
LONGEST = 30  # s of CPU time; the tests take about two


@dataclass(frozen=True)
class Report:
    """Per module: mutants made, killed, and those that survive with the reason (empty: none)."""

    made: dict[str, int]
    killed: dict[str, int]
    survivors: tuple[tuple[str, Mutant, str], ...]

    @property
    def unexplained(self) -> tuple[tuple[str, Mutant, str], ...]:
        """Survivors without a reason."""
        return tuple(survivor for survivor in self.survivors if not survivor[2])

    def plain(self) -> dict[str, Any]:
        """As JSON values."""
        left = [[module, m.line, m.before, m.after, reason] for module, m, reason in self.survivors]
        return {"made": self.made, "killed": self.killed, "survivors": left}

    @classmethod
    def of(cls, plain: dict[str, Any]) -> Report:
        """From JSON values; the sources of the mutants are not in them."""
        left = tuple((row[0], Mutant(row[1], row[2], row[3], ""), row[4]) for row in plain["survivors"])
        return cls(plain["made"], plain["killed"], left)


def reasons() -> dict[str, str]:
    """Name of each mutant that is the same in all that can be seen, and why."""
    listed = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["equivalent"]
    return {f"{row['before']}  ->  {row['after']}": row["reason"] for row in listed}


def survives(module: str, source: str) -> bool:
    """Whether all tests pass with this source in place of the module."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    status = 1
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            _replace(module, source)
            options = [
                "-x",
                "-q",
                "--noconftest",
                "-p",
                "no:cacheprovider",
                "-p",
                "no:randomly",
                "--rootdir",
                str(ROOT),
            ]
            status = int(pytest.main([*options, *TESTS]))
    finally:
        os._exit(status)


def _replace(module: str, source: str) -> None:
    original = sys.modules[module].__file__ if module in sys.modules else None
    for name in [name for name in sys.modules if name.startswith("vehicle")]:
        del sys.modules[name]
    parent = importlib.import_module("vehicle")
    mutated = types.ModuleType(module)
    mutated.__file__ = original or str(ROOT / (module.replace(".", "/") + ".py"))
    sys.modules[module] = mutated
    setattr(parent, module.rpartition(".")[2], mutated)
    exec(compile(source, mutated.__file__, "exec"), mutated.__dict__)  # noqa: S102  our own file, changed by one node


def examine(jobs: int = 2) -> Report:
    """Make and try every mutant."""
    known = reasons()
    made: dict[str, int] = {}
    killed: dict[str, int] = {}
    survivors: list[tuple[str, Mutant, str]] = []
    for module in MODULES:
        source = (ROOT / (module.replace(".", "/") + ".py")).read_text(encoding="utf-8")
        if not survives(module, source):
            raise SystemExit(f"{module}: its tests fail without any change")
        every = list(mutants(source))
        with ThreadPoolExecutor(jobs) as pool:
            alive = list(pool.map(partial(survives, module), [mutant.source for mutant in every]))
        left = [mutant for mutant, lives in zip(every, alive, strict=True) if lives]
        made[module], killed[module] = len(every), len(every) - len(left)
        survivors += [(module, mutant, known.get(mutant.name, "")) for mutant in left]
    return Report(made, killed, tuple(survivors))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2)
    report = examine(parser.parse_args().jobs)
    for module, made in report.made.items():
        print(f"{module}: {made} mutants, {report.killed[module]} killed")
    for module, mutant, reason in report.survivors:
        print(f"{module}:{mutant.line}: {mutant.name}\n    {reason or 'SURVIVES, no reason is listed'}")
    return 1 if report.unexplained else 0


if __name__ == "__main__":
    sys.exit(main())
