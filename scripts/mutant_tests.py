"""Which test files judge a mutant of a compiled function, whose lines nothing sees executed, and in which order.

First the test files that import the mutated module by its name, then those that import a module which itself imports
it, then the unit tests of its folder; in each group the fastest first. What would take longer than DIRECT or BUDGET is
left out: a survivor would cost all of it. So a mutant that only slow tests of other modules would notice counts as a
survivor, and the share of killed ones is what the quick tests alone reach.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from scripts.mutant_sample import ROOT

DIRECT = 30.0  # s, of the tests that import the mutated module
BUDGET = 25.0  # s, of all together, where the direct ones do not take longer
TIGHTER = {"pytest_dvp/gap": 10.0}  # s, where nearly half of all mutants are and the tests take longest
QUICK_TRUTH = ("noise_floor", "range_of_a_search", "uneven_stamps")  # each below 3 s, the others take a minute
HOMES = {
    "pytest_dvp/doctor": ("tests/unit/logs",),
    "pytest_dvp/gap": ("tests/unit/gap", *(f"tests/truth/test_{name}.py" for name in QUICK_TRUTH)),
    "pytest_dvp/metrics": ("tests/unit/results",),
    "pytest_dvp/verdicts": ("tests/unit/results",),
    "openscenario/storyboard": ("tests/unit/storyboard",),
    "vehicle/model": ("tests/unit/vehicle", "tests/physics"),
}
ROOMS = ("machine_code", "openscenario", "vehicle", "ads", "reports", "pytest_dvp")


@cache
def imports(path: Path) -> frozenset[str]:
    """Names of our modules that a file imports anywhere, in its functions too."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(name for name in found if name.partition(".")[0] in ROOMS)


@cache
def importers() -> Mapping[str, frozenset[str]]:
    """Name of each module -> names of our modules that import it."""
    found: dict[str, set[str]] = {}
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            module = path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".")
            for name in imports(path):
                found.setdefault(name, set()).add(module)
    return {name: frozenset(modules) for name, modules in found.items()}


def judges(path: str, folder: str, seconds: Mapping[str, float]) -> list[str]:
    """Test files that judge the mutants of a file, the first to run first.

    seconds: CPU time of each test file [s].
    """
    module = path.removesuffix(".py").replace("/", ".")
    near = importers().get(module, frozenset())
    home = {name for name in seconds if name.startswith(HOMES[folder])}
    direct = {name for name in seconds if (ROOT / name).exists() and module in imports(ROOT / name)}
    second = {name for name in home - direct if near & imports(ROOT / name)}
    chosen: list[str] = []
    spent = 0.0
    budget = TIGHTER.get(folder, BUDGET)
    for group, limit in ((direct, DIRECT), (second, budget), (home - direct - second, budget)):
        for name in sorted(group, key=lambda test: (seconds[test], test)):
            if not chosen or spent + seconds[name] <= limit:
                chosen.append(name)
                spent += seconds[name]
    return chosen
