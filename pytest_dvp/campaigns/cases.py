"""Which cases of a parameter distribution run, and what each is called."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.errors import SettingError

if TYPE_CHECKING:
    from openscenario.distributions import Cases
    from openscenario.findings import ScenarioError

MOST = 1000
"""Cases of one file that run without being asked for; more take hours, and come from a slip more often than a wish."""

AT_ONCE = 1_000_000  # cases of one file that a session can hold at all

_LONGEST = 100  # characters of a case's name


@dataclasses.dataclass(frozen=True)
class Case:
    """One case: its 1-based number in the file, the values of its parameters, a name that is unique in its file."""

    number: int
    values: Mapping[str, str]
    name: str


@dataclasses.dataclass(frozen=True)
class Chosen:
    """The cases of a file that run. `count`: how many the file has; iterating makes the chosen ones, one by one.

    gates  the gate file beside the distribution, which stands before that of the scenario; None if there is none

    A case that the constraints of the scenario exclude is left out, and told to `say`.
    """

    scenario: Path
    count: int
    size: int
    gates: Path | None
    _stem: str
    _cases: Cases
    _seed: int
    _set: Mapping[str, str]
    say: Callable[[str], None] = lambda text: None

    def folder_name(self, case: Case) -> str:
        """`my_sweep-07`: what the run folder of a case is called."""
        return f"{self._stem}-{case.number:0{len(str(self.count))}}"

    def __iter__(self) -> Iterator[Case]:
        digits, excluded, first = len(str(self.count)), 0, ""
        for index in self._cases.sample(self.size, self._seed):
            values = self._cases[index]
            why = excluded_by(self.scenario, {**self._set, **values})
            if why:
                excluded, first = excluded + 1, first or why
                continue
            yield Case(index + 1, values, _name(index + 1, digits, values, self._cases.varied))
        if excluded:
            self.say(_left_out(excluded, self.size, first))


def is_distribution(path: Path) -> bool:
    """Whether a file is a parameter distribution; False for one that cannot be read: its reader says why."""
    from openscenario.findings import ScenarioError
    from openscenario.xml import read_xml

    try:
        return read_xml(path).root.find("ParameterValueDistribution") is not None
    except ScenarioError:
        return False


def excluded_by(scenario: Path, values: Mapping[str, str]) -> str:
    """The constraint of a scenario that excludes values, as a sentence; "" if none does, or more is wrong."""
    from openscenario.findings import ScenarioError
    from openscenario.read import read_declarations

    try:
        declared = {each.name for each in read_declarations(scenario)}
        read_declarations(scenario, {name: value for name, value in values.items() if name in declared})
    except ScenarioError as error:
        return outside(error)
    return ""


def outside(error: ScenarioError) -> str:
    """Why the values of a case exclude each other, "" if that is not all that is wrong.

    A constraint may compare parameters ("slower than the ego"). Distributions of single parameters then make cases
    that are none; who made them expects that a generator leaves these out (ALKS scenarios of openMSL, 4.4.1).
    """
    wrong = [finding for finding in error.findings if finding.severity == "error"]
    if not wrong or any(finding.code != "param.outside_constraint" for finding in wrong):
        return ""
    return wrong[0].message


def choose(
    path: Path, settings: RunSpec, option: str = "--cases", say: Callable[[str], None] = lambda text: None
) -> Chosen:
    """The cases of a distribution file that the settings ask for: all, or a sample by the seed. say: is told what is
    left out.

    Raises ScenarioError for a file that is wrong, SettingError if there are too many to run them all unasked.
    """
    from openscenario.read import read_cases

    cases = read_cases(path, library=settings.library, rootdir=settings.rootdir, seed=settings.seed)
    wanted = cases.count if settings.cases is None else min(settings.cases, cases.count)
    if settings.cases is None and cases.count > MOST:
        everything = f", {option} {cases.count} all" if cases.count <= AT_ONCE else ""
        raise SettingError(
            f"{path}: {cases.count} cases, more than the {MOST} that run unasked; "
            f"{option} 100 runs a random sample of 100 (the same for the same seed){everything}"
        )
    if wanted > AT_ONCE:
        raise SettingError(
            f"{option} is {settings.cases}, expected at most {AT_ONCE} of the {cases.count} cases at once"
        )
    for name in settings.set.scenario:
        if name in cases.varied:
            raise SettingError(f"{option.removesuffix('cases')}set {name}: {path.name} varies it")
    if cases.scenario is None:
        raise SettingError(f"{path}: names no scenario")
    beside = path.with_name(f"{path.stem}.gates.toml")
    gates = beside if beside.is_file() else None
    return Chosen(
        cases.scenario, cases.count, wanted, gates, path.stem, cases, settings.seed, settings.set.scenario, say
    )


def _left_out(excluded: int, size: int, first: str) -> str:
    """How many cases are not driven, and why the first of them is not."""
    return f"{excluded} of {size} cases are left out, outside the scenario's constraints; the first: {first}"


def _name(number: int, digits: int, values: Mapping[str, str], varied: tuple[str, ...]) -> str:
    """`07-EgoSpeed=70-Road=straight`: what differs between cases, as far as it fits, in letters that need no quotes."""
    words = [f"{number:0{digits}}"]
    for name in varied:
        value = values.get(name)
        if value is not None:
            word = re.sub(r"[^\w.+-]+", "_", name) + "=" + re.sub(r"[^\w.+-]+", "_", value.rsplit("/", 1)[-1])
            if len("-".join(words)) + len(word) >= _LONGEST:
                break
            words.append(word)
    return "-".join(words)
