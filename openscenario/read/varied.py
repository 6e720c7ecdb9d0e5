"""What a distribution varies, and whether the scenario can take it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from openscenario.distributions import MOST, WHOLE, Steps, count_of
from openscenario.findings import listed, nearest
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.distributions import (
    Deterministic,
    DeterministicMultiParameterDistribution,
    DistributionRange,
    DistributionSet,
    ProbabilityDistributionSet,
    Stochastic,
)
from openscenario.model.kinds import At
from openscenario.parameters import allows, constraints
from openscenario.read.context import Context
from openscenario.values import BadValue, check_type, spelled


def check_varied(
    definition: Deterministic | Stochastic, declared: tuple[ParameterDeclaration, ...] | None, context: Context
) -> None:
    """Notes what is wrong with the parameters and values of a distribution. `declared` None: no scenario was found."""
    _check_count(definition, context)
    _check_varied_once(definition, context)
    if declared is None:
        _unresolved(definition, context)
    else:
        _check_parameters(definition, declared, context)


class Value(NamedTuple):
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


def parameters_of(definition: Deterministic | Stochastic) -> Iterator[Varied]:
    """Every parameter that a distribution names, in the file's order, as often as it is named."""
    for part in _parts(definition):
        yield from part


def _parts(definition: Deterministic | Stochastic) -> Iterator[list[Varied]]:
    """The same, one list for each of its parts."""
    if isinstance(definition, Stochastic):
        for each in definition.stochastic_distributions:
            yield [Varied(each.parameter_name, each.at, "@parameterName")]
        return
    for distribution in definition.distributions:
        if isinstance(distribution, DeterministicMultiParameterDistribution):
            yield [
                Varied(assignment.parameter_ref.removeprefix("$"), assignment.at, "@parameterRef")
                for row in distribution.value_set_distribution.parameter_value_sets
                for assignment in row.parameter_assignments
            ]
        else:
            yield [Varied(distribution.parameter_name, distribution.at, "@parameterName")]


def values_of(definition: Deterministic | Stochastic) -> Iterator[Value]:
    """The values that stand in the file: all listed ones, and both ends of every range of steps."""
    if isinstance(definition, Stochastic):
        for drawn in definition.stochastic_distributions:
            if isinstance(drawn.distribution, ProbabilityDistributionSet):
                for weighed in drawn.distribution.elements:
                    yield Value(drawn.parameter_name, weighed.value, weighed.at, "@value")
        return
    for distribution in definition.distributions:
        if isinstance(distribution, DeterministicMultiParameterDistribution):
            for row in distribution.value_set_distribution.parameter_value_sets:
                for assignment in row.parameter_assignments:
                    name = assignment.parameter_ref.removeprefix("$")
                    yield Value(name, assignment.value, assignment.at, "@value")
        elif isinstance(distribution.distribution, DistributionSet):
            for element in distribution.distribution.elements:
                yield Value(distribution.parameter_name, element.value, element.at, "@value")
        elif isinstance(distribution.distribution, DistributionRange):
            steps = Steps.of(distribution.parameter_name, distribution.distribution)
            limits = distribution.distribution.range
            if steps.count:
                yield Value(steps.name, spelled(steps.value(0)), limits.at, "@lowerLimit")
                yield Value(steps.name, spelled(steps.value(steps.count - 1)), limits.at, "@upperLimit")


def _check_count(definition: Deterministic | Stochastic, context: Context) -> None:
    if count_of(definition) > MOST:
        context.error(
            "dist.too_many_cases",
            definition.at,
            "",
            "the combinations cannot be numbered",
            found=f"{float(count_of(definition)):.3g} cases" if count_of(definition) < 10**300 else "over 1e300 cases",
            allowed="below 2^63",
        )


def _check_varied_once(definition: Deterministic | Stochastic, context: Context) -> None:
    """Two distributions of one parameter would overwrite each other, and cases repeat. Sets of one table may."""
    owner: dict[str, tuple[int, At]] = {}
    for number, part in enumerate(_parts(definition)):
        for name, at, attribute in part:
            first, where = owner.setdefault(name, (number, at))
            if first != number:
                context.error(
                    "dist.varied_twice",
                    at,
                    attribute,
                    "another distribution varies the parameter too",
                    found=name,
                    hint=f"in line {where.line}",
                )
                break


def _unresolved(definition: Deterministic | Stochastic, context: Context) -> None:
    """Without the scenario nothing declares the parameters: said once, at the first."""
    names = list(dict.fromkeys(varied.name for varied in parameters_of(definition)))
    first = next(parameters_of(definition), None)
    if first is not None:
        context.error(
            "param.undefined",
            first.at,
            first.attribute,
            "no scenario could be read that declares " + ("the parameter" if len(names) == 1 else "the parameters"),
            found=listed(names, most=3),
        )


def _check_parameters(
    definition: Deterministic | Stochastic, declared: tuple[ParameterDeclaration, ...], context: Context
) -> None:
    known = {declaration.name: declaration for declaration in declared}
    reported: set[str] = set()
    for name, at, attribute in parameters_of(definition):
        if name not in known and name not in reported:
            reported.add(name)
            context.error(
                "param.undefined",
                at,
                attribute,
                "the scenario declares no such parameter",
                found=name,
                allowed=listed(sorted(known)) or "none is declared",
                hint=nearest(name, known),
            )
    _check_values(definition, known, context)
    if isinstance(definition, Deterministic):
        _check_whole_steps(definition, known, context)
    else:
        _check_drawn(definition, known, context)


def _check_values(
    definition: Deterministic | Stochastic, known: Mapping[str, ParameterDeclaration], context: Context
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
            context.error(error.code, at, attribute, text, found=value or "nothing", allowed=allowed)
            continue
        if not allows(declaration, value):
            context.error(
                "param.outside_constraint",
                at,
                attribute,
                f"the value for parameter '{name}' is outside its constraints",
                found=value,
                allowed=constraints(declaration),
            )


def _check_whole_steps(definition: Deterministic, known: Mapping[str, ParameterDeclaration], context: Context) -> None:
    for distribution in definition.distributions:
        if isinstance(distribution, DeterministicMultiParameterDistribution):
            continue
        steps, declaration = distribution.distribution, known.get(distribution.parameter_name)
        if not isinstance(steps, DistributionRange) or declaration is None or declaration.parameter_type not in WHOLE:
            continue
        if not steps.step_width.is_integer():
            context.error(
                "value.not_an_integer",
                steps.at,
                "@stepWidth",
                f"parameter '{distribution.parameter_name}' is a whole number",
                found=spelled(steps.step_width),
                allowed="a whole step",
            )


def _check_drawn(definition: Stochastic, known: Mapping[str, ParameterDeclaration], context: Context) -> None:
    """Numbers are drawn for numbers, or for texts; a truth value or a moment has listed values."""
    for drawn in definition.stochastic_distributions:
        declaration = known.get(drawn.parameter_name)
        if declaration is None or isinstance(drawn.distribution, ProbabilityDistributionSet):
            continue
        if declaration.parameter_type in ("boolean", "dateTime"):
            context.error(
                "dist.wrong_type",
                drawn.at,
                "@parameterName",
                f"numbers are drawn for a parameter of type {declaration.parameter_type}",
                found=drawn.parameter_name,
                allowed="ProbabilityDistributionSet",
            )
