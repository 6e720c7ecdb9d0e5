"""Reading a parameter value distribution, and whether the scenario that it varies can take its values."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, NamedTuple

from openscenario.distributions import MOST, WHOLE, Steps, count_of
from openscenario.findings import Findings, ScenarioError, listed, nearest
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.distributions import (
    Deterministic,
    DeterministicMultiParameterDistribution,
    DistributionFile,
    DistributionRange,
    DistributionSet,
    ParameterValueDistribution,
    ProbabilityDistributionSet,
    ScenarioFile,
    Stochastic,
)
from openscenario.model.kinds import At
from openscenario.parameters import Scope, allows, constraints
from openscenario.paths import PathError
from openscenario.plan import plan_of
from openscenario.read.header import read_header
from openscenario.read.scenario import Reading, declarations_of, open_reading
from openscenario.values import BadValue, check_type, spelled

TAG: Final = "ParameterValueDistribution"
_SECTIONS: Final = ("FileHeader", TAG)


class Given(NamedTuple):
    """A value that a distribution gives to a parameter, and where it says so."""

    name: str
    value: str
    at: At
    attribute: str


class Varied(NamedTuple):
    """A parameter that a distribution names, and where."""

    name: str
    at: At
    attribute: str


def is_distribution(reading: Reading) -> bool:
    """Whether the file is a parameter value distribution."""
    return reading.root.find(TAG) is not None


def read_distribution_file(reading: Reading) -> tuple[DistributionFile | None, tuple[ParameterDeclaration, ...]]:
    """The distribution and the parameters of its scenario; what is wrong is in the context, and None comes back."""
    context = reading.context
    header = read_header(reading.root.find("FileHeader"), reading.reader, reading.at())
    if header is None:
        return None, ()
    _check_sections(reading)
    node = reading.root.find(TAG)
    distribution: ParameterValueDistribution | None = (
        None if node is None else reading.reader.read(plan_of(ParameterValueDistribution), node, Scope(), _path())
    )
    if distribution is None:
        # the distribution has a slip; whether the scenario is there at all is still worth knowing
        _scenario_alone(reading)
        return None, ()
    definition = distribution.definition
    _check_count(definition, reading)
    _check_varied_once(definition, reading)
    scenario, declared = _scenario(distribution.scenario_file, reading)
    if declared is None:
        _unresolved(definition, reading)
    else:
        _check_parameters(definition, declared, reading)
    if context.findings.errors or scenario is None:
        return None, ()
    file = DistributionFile(
        header,
        dataclasses.replace(distribution, scenario_file=scenario),
        Path(reading.document.file),
        reading.document.sha256,
        at=reading.at(),
    )
    return file, declared or ()


def parameters_of(definition: Deterministic | Stochastic) -> Iterator[Varied]:
    """Every parameter that a distribution names, in the file's order, as often as it is named."""
    if isinstance(definition, Stochastic):
        for each in definition.stochastic_distributions:
            yield Varied(each.parameter_name, each.at, "@parameterName")
        return
    for distribution in definition.distributions:
        if isinstance(distribution, DeterministicMultiParameterDistribution):
            for row in distribution.value_set_distribution.parameter_value_sets:
                for assignment in row.parameter_assignments:
                    yield Varied(assignment.parameter_ref.removeprefix("$"), assignment.at, "@parameterRef")
        else:
            yield Varied(distribution.parameter_name, distribution.at, "@parameterName")


def values_of(definition: Deterministic | Stochastic) -> Iterator[Given]:
    """The values that stand in the file: all listed ones, and both ends of every range of steps."""
    if isinstance(definition, Stochastic):
        for drawn in definition.stochastic_distributions:
            if isinstance(drawn.distribution, ProbabilityDistributionSet):
                for weighed in drawn.distribution.elements:
                    yield Given(drawn.parameter_name, weighed.value, weighed.at, "@value")
        return
    for distribution in definition.distributions:
        if isinstance(distribution, DeterministicMultiParameterDistribution):
            for row in distribution.value_set_distribution.parameter_value_sets:
                for assignment in row.parameter_assignments:
                    name = assignment.parameter_ref.removeprefix("$")
                    yield Given(name, assignment.value, assignment.at, "@value")
        elif isinstance(distribution.distribution, DistributionSet):
            for element in distribution.distribution.elements:
                yield Given(distribution.parameter_name, element.value, element.at, "@value")
        elif isinstance(distribution.distribution, DistributionRange):
            steps = Steps.of(distribution.parameter_name, distribution.distribution)
            limits = distribution.distribution.range
            if steps.count:
                yield Given(steps.name, spelled(steps.value(0)), limits.at, "@lowerLimit")
                yield Given(steps.name, spelled(steps.value(steps.count - 1)), limits.at, "@upperLimit")


def _path() -> str:
    return f"OpenSCENARIO/{TAG}"


def _check_sections(reading: Reading) -> None:
    seen: set[str] = set()
    for child in reading.root.children:
        at = reading.at(child, child.tag)
        if child.tag not in _SECTIONS:
            reading.context.error(
                "xml.unknown_element",
                at,
                "",
                "a distribution has no such section",
                found=child.tag,
                allowed=", ".join(_SECTIONS),
                hint=nearest(child.tag, _SECTIONS),
            )
        elif child.tag in seen:
            reading.context.error(
                "xml.too_many", at, "", "only one element of its kind may stand here", found=child.tag
            )
        seen.add(child.tag)


def _check_count(definition: Deterministic | Stochastic, reading: Reading) -> None:
    if count_of(definition) > MOST:
        reading.context.error(
            "dist.too_many_cases",
            definition.at,
            "",
            "the combinations cannot be numbered",
            found=f"{float(count_of(definition)):.3g} cases" if count_of(definition) < 10**300 else "over 1e300 cases",
            allowed="below 2^63",
        )


def _check_varied_once(definition: Deterministic | Stochastic, reading: Reading) -> None:
    """Two distributions of one parameter would overwrite each other, and cases repeat. Sets of one table may."""
    owner: dict[str, tuple[int, At]] = {}
    parts = definition.stochastic_distributions if isinstance(definition, Stochastic) else definition.distributions
    for number, part in enumerate(parts):
        alone = Deterministic((part,)) if not isinstance(definition, Stochastic) else None  # type: ignore[arg-type]
        named = (
            parameters_of(alone) if alone is not None else [Varied(part.parameter_name, part.at, "@parameterName")]  # type: ignore[union-attr]
        )
        for name, at, attribute in named:
            first, where = owner.setdefault(name, (number, at))
            if first != number:
                reading.context.error(
                    "dist.varied_twice",
                    at,
                    attribute,
                    "another distribution varies the parameter too",
                    found=name,
                    hint=f"in line {where.line}",
                )
                break


def _scenario(
    written: ScenarioFile, reading: Reading
) -> tuple[ScenarioFile | None, tuple[ParameterDeclaration, ...] | None]:
    """The scenario file with its path, and the parameters it declares; None: it is missing or wrong."""
    context = reading.context
    try:
        path = reading.roots.find(written.filepath, reading.roots.base)
    except PathError as error:
        context.error(
            error.code,
            written.at,
            "@filepath",
            error.text,
            found=written.filepath,
            allowed=error.allowed,
            hint=error.hint,
        )
        return None, None
    found = Findings()
    inner = open_reading(path, (), None, found)
    declared: tuple[ParameterDeclaration, ...] = ()
    if inner is not None and inner.root.find("Storyboard") is None:
        context.error(
            "file.not_a_scenario",
            written.at,
            "@filepath",
            "what is varied is no scenario",
            found=written.filepath,
            allowed="a file with a <Storyboard>",
        )
        return None, None
    if inner is not None:
        declared = declarations_of(inner)
    if found.errors:
        context.findings.found.extend(found.found)
        return None, None
    return dataclasses.replace(written, path=path), declared


def _scenario_alone(reading: Reading) -> None:
    below = reading.root.find(TAG)
    node = None if below is None else below.find("ScenarioFile")
    if node is not None and node.get("filepath"):
        at = At(reading.document.file, node.line, f"{_path()}/ScenarioFile")
        _scenario(ScenarioFile(node.get("filepath"), at=at), reading)


def _unresolved(definition: Deterministic | Stochastic, reading: Reading) -> None:
    """Without the scenario nothing declares the parameters: said once, at the first."""
    names = list(dict.fromkeys(varied.name for varied in parameters_of(definition)))
    first = next(parameters_of(definition), None)
    if first is not None:
        reading.context.error(
            "param.undefined",
            first.at,
            first.attribute,
            "no scenario could be read that declares " + ("the parameter" if len(names) == 1 else "the parameters"),
            found=listed(names, most=3),
        )


def _check_parameters(
    definition: Deterministic | Stochastic, declared: tuple[ParameterDeclaration, ...], reading: Reading
) -> None:
    known = {declaration.name: declaration for declaration in declared}
    reported: set[str] = set()
    for name, at, attribute in parameters_of(definition):
        if name not in known and name not in reported:
            reported.add(name)
            reading.context.error(
                "param.undefined",
                at,
                attribute,
                "the scenario declares no such parameter",
                found=name,
                allowed=listed(sorted(known)) or "none is declared",
                hint=nearest(name, known),
            )
    _check_values(definition, known, reading)
    if isinstance(definition, Deterministic):
        _check_whole_steps(definition, known, reading)
    else:
        _check_drawn(definition, known, reading)


def _check_values(
    definition: Deterministic | Stochastic, known: Mapping[str, ParameterDeclaration], reading: Reading
) -> None:
    for name, value, at, attribute in values_of(definition):
        declaration = known.get(name)
        if declaration is None:
            continue
        try:
            check_type(value, declaration.parameter_type)
        except BadValue as error:
            allowed = f"{error.allowed} ({declaration.parameter_type})"
            text = f"the value for parameter '{name}' is {error.text}"
            reading.context.error(error.code, at, attribute, text, found=value or "nothing", allowed=allowed)
            continue
        if not allows(declaration, value):
            reading.context.error(
                "param.outside_constraint",
                at,
                attribute,
                f"the value for parameter '{name}' is outside its constraints",
                found=value,
                allowed=constraints(declaration),
            )


def _check_whole_steps(definition: Deterministic, known: Mapping[str, ParameterDeclaration], reading: Reading) -> None:
    for distribution in definition.distributions:
        if isinstance(distribution, DeterministicMultiParameterDistribution):
            continue
        steps, declaration = distribution.distribution, known.get(distribution.parameter_name)
        if not isinstance(steps, DistributionRange) or declaration is None or declaration.parameter_type not in WHOLE:
            continue
        if not steps.step_width.is_integer():
            reading.context.error(
                "value.not_an_integer",
                steps.at,
                "@stepWidth",
                f"parameter '{distribution.parameter_name}' is a whole number",
                found=spelled(steps.step_width),
                allowed="a whole step",
            )


def _check_drawn(definition: Stochastic, known: Mapping[str, ParameterDeclaration], reading: Reading) -> None:
    """Numbers are drawn for numbers, or for texts; a truth value or a moment has listed values."""
    for drawn in definition.stochastic_distributions:
        declaration = known.get(drawn.parameter_name)
        if declaration is None or isinstance(drawn.distribution, ProbabilityDistributionSet):
            continue
        if declaration.parameter_type in ("boolean", "dateTime"):
            reading.context.error(
                "dist.wrong_type",
                drawn.at,
                "@parameterName",
                f"numbers are drawn for a parameter of type {declaration.parameter_type}",
                found=drawn.parameter_name,
                allowed="ProbabilityDistributionSet",
            )


def refuse(findings: Findings) -> ScenarioError:
    """All findings as one error, errors first."""
    return ScenarioError(sorted(findings.in_order(), key=lambda finding: finding.severity))
