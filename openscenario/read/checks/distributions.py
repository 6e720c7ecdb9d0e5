"""Distributions: something to draw, from ranges and weights that make sense."""

from __future__ import annotations

import itertools

from openscenario.draws import NothingToDraw, inverse
from openscenario.model.distributions import (
    Deterministic,
    DistributionSet,
    Histogram,
    LogNormalDistribution,
    NormalDistribution,
    ParameterValueSet,
    PoissonDistribution,
    ProbabilityDistributionSet,
    UserDefinedDistribution,
)
from openscenario.read.checks.registry import check
from openscenario.read.context import Context


@check(UserDefinedDistribution)
def known_only_to_its_tool(distribution: UserDefinedDistribution, context: Context) -> None:
    """Refuse a user-defined distribution: only its own tool knows what it means."""
    context.error(
        "dist.user_defined",
        distribution.at,
        "@type",
        "what a user-defined distribution means is known to its own tool only",
        found=distribution.type,
        hint="write its values as a DistributionSet or a Histogram",
    )


@check(Deterministic)
def something_varied(deterministic: Deterministic, context: Context) -> None:
    """Warn of a file that varies nothing."""
    if not deterministic.distributions:
        context.warning("dist.empty", deterministic.at, "", "nothing is varied: the scenario is the only case")


@check(DistributionSet)
def no_value_twice(distribution: DistributionSet, context: Context) -> None:
    """Warn of a value that a set lists twice."""
    seen: set[str] = set()
    for element in distribution.elements:
        if element.value in seen:
            context.warning(
                "dist.repeated_value", element.at, "@value", "the value stands here twice", found=element.value
            )
        seen.add(element.value)


@check(ParameterValueSet)
def no_parameter_twice(row: ParameterValueSet, context: Context) -> None:
    """Refuse a set that gives one parameter two values."""
    seen: set[str] = set()
    for assignment in row.parameter_assignments:
        name = assignment.parameter_ref.removeprefix("$")
        if name in seen:
            context.error(
                "name.duplicate", assignment.at, "@parameterRef", "the set gives the parameter two values", found=name
            )
        seen.add(name)


@check(Histogram)
def bins_apart(histogram: Histogram, context: Context) -> None:
    """Refuse bins of a histogram that overlap."""
    bins = sorted(histogram.bins, key=lambda each: each.range.lower_limit)
    for one, other in itertools.pairwise(bins):
        if other.range.lower_limit < one.range.upper_limit:
            context.error(
                "dist.bins_overlap",
                other.range.at,
                "@lowerLimit",
                "the bin overlaps another",
                found=f"{other.range.lower_limit:g}",
                allowed=f">= {one.range.upper_limit:g}, the end of the bin in line {one.at.line}",
            )


@check(ProbabilityDistributionSet, Histogram, NormalDistribution, LogNormalDistribution, PoissonDistribution)
def something_to_draw(
    distribution: (
        ProbabilityDistributionSet | Histogram | NormalDistribution | LogNormalDistribution | PoissonDistribution
    ),
    context: Context,
) -> None:
    """Refuse a distribution from which no value can be drawn within its limits."""
    limits = getattr(distribution, "range", None)
    if limits is not None and limits.upper_limit < limits.lower_limit:
        return  # has its finding
    try:
        inverse(distribution)
    except NothingToDraw as error:
        context.error("dist.nothing_to_draw", distribution.at, "", f"no value can be drawn: {error}")
