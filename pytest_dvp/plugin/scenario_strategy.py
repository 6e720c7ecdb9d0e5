"""Variants of a scenario as a Hypothesis strategy, and a failing one as a file that runs."""

from __future__ import annotations

import dataclasses
import hashlib
import math
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypothesis import strategies as st

from pytest_dvp.campaigns.cases import excluded_by
from pytest_dvp.campaigns.constraint_range import WORDS, FuzzError, Range, range_of
from pytest_dvp.campaigns.variant import Value, Variant

if TYPE_CHECKING:
    from openscenario.model.declarations import ParameterDeclaration
    from pytest_dvp.drive.request import Request

_STEPS = 50  # least number of values between the ends of a range: fine enough to find, coarse enough to read
_LONGEST = 60  # chosen: characters of a test's name in that of its file
_HASH = 8  # chosen: hexadecimal digits that tell tests of one name apart


__all__ = ["FuzzError", "Variant", "keep", "kept_name", "scenario_variants"]


@dataclasses.dataclass(frozen=True)
class Grid:
    """Values of a number: round steps from its nominal value (or the end of the range nearest to it), with both ends.

    first, last  steps of the two ends; step 0 is the value where it starts
    """

    allowed: Range
    home: float
    step: float
    first: int
    last: int

    @classmethod
    def of(cls, allowed: Range, nominal: float) -> Grid:
        """The grid over an allowed range around `nominal`; a nominal value outside it is replaced by the nearest end.

        Steps are 1 for whole numbers and round ones otherwise; a range of one value has step 0.
        """
        home = min(max(nominal, allowed.low), allowed.high)
        step = 1.0 if allowed.whole else _round_step((allowed.high - allowed.low) / _STEPS)
        if step <= 0.0:
            return cls(allowed, home, 0.0, 0, 0)
        first = -math.ceil((home - allowed.low) / step - 1e-9)
        return cls(allowed, home, step, first, math.ceil((allowed.high - home) / step - 1e-9))

    def value(self, k: int) -> Value:
        """The value `k` steps from the start."""
        raw = min(max(self.home + k * self.step, self.allowed.low), self.allowed.high)
        if self.allowed.whole:
            return round(raw)
        digits = max(0, -math.floor(math.log10(self.step))) if self.step else 0
        rounded = round(raw, digits)
        return rounded if k and self.allowed.low <= rounded <= self.allowed.high else raw

    def step_of(self, value: float) -> int | None:
        """The step that has this value, None if none has."""
        near = round((value - self.home) / self.step) if self.step else 0
        around = range(max(near - 1, self.first), min(near + 1, self.last) + 1)
        return next((k for k in around if self.value(k) == value), None)


@dataclasses.dataclass(frozen=True)
class Course:
    """The values of a grid from one of them on, away from the nominal value; the nearest first, the last is the end."""

    grid: Grid
    start: int
    side: int

    def __len__(self) -> int:
        return abs((self.grid.last if self.side > 0 else self.grid.first) - self.start)

    def __getitem__(self, index: int) -> Value:
        return self.grid.value(self.start + self.side * (index + 1))


def scenario_variants(scenario: str | Path, only: Sequence[str] | None = None) -> st.SearchStrategy[Variant]:
    """Strategy over the declared parameters of a scenario that have constraint groups; shrinks to the nominal variant.

    scenario: a path; a relative one is looked for beside the calling test, in the current folder, and among the
    scenarios that ship. only: names of the parameters to vary; default all. Values of a constrained number lie on a
    round grid around its nominal value, which is the simplest one. Values that exclude each other are not drawn.

    Raises FuzzError when drawn from: no such file, nothing to vary, a name in `only` that is not declared.
    """
    caller = sys._getframe(1).f_globals.get("__file__")
    beside = Path(caller).parent if caller else Path.cwd()

    def build() -> st.SearchStrategy[Variant]:
        path = _find(Path(scenario), beside)
        strategies, nominal = _strategies(path, only)
        variants = st.fixed_dictionaries(strategies).map(lambda values: _variant(path, values, nominal))
        return variants.filter(is_allowed) if _has_holes(path) else variants

    return st.deferred(build)


def is_allowed(variant: Variant) -> bool:
    """Whether no constraint of its scenario excludes a variant; constraints may compare parameters."""
    return not excluded_by(variant.scenario, {name: _text(value) for name, value in variant.values.items()})


def kept_name(test: str, node_id: str, names: Iterable[str]) -> str:
    """What the files of a test are called: its name, with a hash of its node id if another test could have that name.

    names: those of all tests of the session, this one among them. The hash is that of every session and worker.
    """
    name = re.sub(r"[^A-Za-z0-9_]+", "-", test).strip("-")
    if name == test and len(name) <= _LONGEST and sum(name.lower() == other.lower() for other in names) < 2:
        return name
    return f"{name[:_LONGEST]}-{hashlib.sha256(node_id.encode()).hexdigest()[:_HASH]}"


def keep(variant: Variant, options: Mapping[str, Any], runs: Path, name: str) -> str:
    """Write the variant as a runnable .xosc below the folder `runs` and return the command that replays it.

    options: those of `pytest_dvp.drive.run.run` it was driven with. name: what `kept_name` calls the test.
    One file a test: Hypothesis ends with the smallest failing variant, and that is the one that stays.
    """
    from openscenario.findings import ScenarioError
    from pytest_dvp.drive.result import replay_command

    asked = _request(variant, options)
    source = variant.scenario
    target = runs / "variants" / f"{name}-{source.stem}.xosc"
    try:
        _write(asked, target)
    except (OSError, ValueError, ScenarioError):
        # A file that cannot be written must not hide the failure; the values alone replay it as well.
        return replay_command(asked)
    library, gates = asked.spec.library, asked.spec.gates or source.with_name(f"{source.stem}.gates.toml")
    if asked.rootdir is None or not source.resolve().is_relative_to(asked.rootdir.resolve()):
        library = (*library, source.parent)
    spec = dataclasses.replace(asked.spec, gates=gates if gates.is_file() else None, library=library)
    written = dataclasses.replace(asked, path=target, parameters={}, spec=spec)
    return replay_command(written)


def _request(variant: Variant, options: Mapping[str, Any]) -> Request:
    from pytest_dvp.drive.request import request_of

    parameters = {**variant.values, **(options.get("parameters") or {})}
    return request_of(
        variant.scenario, {**options, "parameters": {name: _text(value) for name, value in parameters.items()}}
    )


def _write(asked: Request, target: Path) -> None:
    from openscenario.read import read_scenario
    from openscenario.write import write_scenario

    scenario = read_scenario(asked.path, library=asked.spec.library, rootdir=asked.rootdir, parameters=asked.parameters)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_scenario(scenario, target)


def _has_holes(path: Path) -> bool:
    """Whether values inside the ranges can be excluded: parameters depend on each other, or a range has a gap."""
    from openscenario.xml import read_xml

    declared = read_xml(path).root.findall("ParameterDeclarations")
    nodes = [node for each in declared for node in each.walk()]
    return any("$" in node.get("value") or node.get("rule") == "notEqualTo" for node in nodes)


def _variant(path: Path, values: Mapping[str, Value], nominal: Mapping[str, Value]) -> Variant:
    return Variant(path, {name: value for name, value in values.items() if value != nominal[name]}, tuple(nominal))


def _find(scenario: Path, beside: Path) -> Path:
    for folder in (beside, Path.cwd()):
        if (folder / scenario).is_file():
            return folder / scenario
    from scenarios import path

    try:
        return path(scenario.as_posix())
    except FileNotFoundError:
        raise FuzzError(f"no scenario {scenario}; looked in {beside}, {Path.cwd()} and what ships") from None


def _strategies(path: Path, only: Sequence[str] | None) -> tuple[dict[str, st.SearchStrategy[Any]], dict[str, Value]]:
    from openscenario.read import read_declarations
    from pytest_dvp.text.spelling import unknown

    if isinstance(only, str):
        raise FuzzError(f"only: found {only!r}, expected a list of names: only=[{only!r}]")
    declared = {declaration.name: declaration for declaration in read_declarations(path)}
    for name in only or ():
        if name not in declared:
            raise FuzzError(f"{path.name}: {unknown('parameter', name, declared)}")
        if not declared[name].constraint_groups:
            raise FuzzError(f"{path.name}: {name} has no ConstraintGroup, so there is no range to vary it in")
    varied = [d for d in declared.values() if d.constraint_groups and (only is None or d.name in only)]
    if not varied:
        raise FuzzError(f"{path.name}: no parameter has a ConstraintGroup, so there is nothing to vary")
    strategies: dict[str, st.SearchStrategy[Any]] = {}
    nominal: dict[str, Value] = {}
    for declaration in varied:
        nominal[declaration.name], strategies[declaration.name] = _values(declaration)
    return strategies, nominal


def _values(declaration: ParameterDeclaration) -> tuple[Value, st.SearchStrategy[Any]]:
    """Nominal value and strategy of one parameter; its nominal value is what the strategy shrinks to."""
    if declaration.parameter_type in WORDS:
        words = [c.value for group in declaration.constraint_groups for c in group.value_constraints]
        return declaration.value, st.sampled_from(list(dict.fromkeys([declaration.value, *words])))
    nominal, grids = _grids(declaration)
    # integers shrink towards 0, and 0 is the nominal value; one_of shrinks to its first.
    return nominal, st.one_of([st.integers(grid.first, grid.last).map(grid.value) for grid in grids])


def _grids(declaration: ParameterDeclaration) -> tuple[Value, list[Grid]]:
    """Nominal value and the grids of a number, that of the group which holds the nominal value first."""
    whole = declaration.parameter_type not in ("double", "float")
    nominal: Value = int(declaration.value) if whole else float(declaration.value)
    ranges = [range_of(group, whole, declaration) for group in declaration.constraint_groups]
    home = [r for r in ranges if r.low <= float(nominal) <= r.high]
    return nominal, [Grid.of(r, float(nominal)) for r in home + [r for r in ranges if r not in home]]


def course(path: Path, name: str, value: Value) -> Course | None:
    """Where a number among a scenario's parameters can go from `value`, within the same range; None for a word."""
    from openscenario.read import read_declarations

    declaration = next(d for d in read_declarations(path) if d.name == name)
    if declaration.parameter_type in WORDS or not declaration.constraint_groups:
        return None
    for grid in _grids(declaration)[1]:
        k = grid.step_of(float(value))
        if k is not None:
            return Course(grid, k, 1 if k > 0 or (k == 0 and grid.last > 0) else -1)
    return None


def _round_step(step: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `step`."""
    if step <= 0.0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(step))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= step * (1 + 1e-12))


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value) if isinstance(value, float) else str(value)
