"""Parameter value distributions: a file of its own that says with which values a scenario is to run."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, TypeAlias

from openscenario.model.catalogs import ParameterAssignment
from openscenario.model.declarations import FileHeader
from openscenario.model.kinds import Element, NonNegative, Number, Quantity, Weight, xml
from openscenario.model.traffic import Range

Step: TypeAlias = Annotated[float, Quantity("1", above=0.0, rule="dist.step_not_positive")]
Runs: TypeAlias = Annotated[int, Quantity("1", low=1.0, high=float(2**32 - 1))]
Rate: TypeAlias = Annotated[float, Quantity("1", low=0.0, high=1e6)]


@dataclass(frozen=True, slots=True)
class ScenarioFile(Element):
    """`filepath` as written; `path` what it leads to, inside the allowed folders."""

    filepath: str = field(compare=False)
    path: Path | None = field(default=None, metadata={"xml": None})


@dataclass(frozen=True, slots=True)
class DistributionSetElement(Element):
    value: str


@dataclass(frozen=True, slots=True)
class DistributionSet(Element):
    elements: tuple[DistributionSetElement, ...] = field(metadata=xml("Element"))


@dataclass(frozen=True, slots=True)
class DistributionRange(Element):
    """Lower limit, lower limit + step, ... up to the upper limit, which belongs to it if a step ends there."""

    step_width: Step
    range: Range


@dataclass(frozen=True, slots=True)
class UserDefinedDistribution(Element):
    type: str
    content: str = field(metadata=xml(text=True), default="")


SingleParameterDistribution: TypeAlias = DistributionSet | DistributionRange | UserDefinedDistribution


@dataclass(frozen=True, slots=True)
class DeterministicSingleParameterDistribution(Element):
    parameter_name: str
    distribution: SingleParameterDistribution = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class ParameterValueSet(Element):
    parameter_assignments: tuple[ParameterAssignment, ...]


@dataclass(frozen=True, slots=True)
class ValueSetDistribution(Element):
    parameter_value_sets: tuple[ParameterValueSet, ...]


@dataclass(frozen=True, slots=True)
class DeterministicMultiParameterDistribution(Element):
    value_set_distribution: ValueSetDistribution


DeterministicParameterDistribution: TypeAlias = (
    DeterministicMultiParameterDistribution | DeterministicSingleParameterDistribution
)


@dataclass(frozen=True, slots=True)
class Deterministic(Element):
    """Every combination of the values of its distributions is a case."""

    distributions: tuple[DeterministicParameterDistribution, ...] = field(metadata=xml(inline=True), default=())


@dataclass(frozen=True, slots=True)
class ProbabilityDistributionSetElement(Element):
    value: str
    weight: Weight


@dataclass(frozen=True, slots=True)
class ProbabilityDistributionSet(Element):
    elements: tuple[ProbabilityDistributionSetElement, ...] = field(metadata=xml("Element"))


@dataclass(frozen=True, slots=True)
class NormalDistribution(Element):
    """`range`: what lies outside is never drawn."""

    expected_value: Number
    variance: NonNegative
    range: Range | None = None


@dataclass(frozen=True, slots=True)
class LogNormalDistribution(Element):
    """Expected value and variance of the log-normal distribution itself, not of its logarithm."""

    expected_value: Annotated[float, Quantity("1", above=0.0)]
    variance: NonNegative
    range: Range | None = None


@dataclass(frozen=True, slots=True)
class UniformDistribution(Element):
    range: Range


@dataclass(frozen=True, slots=True)
class PoissonDistribution(Element):
    expected_value: Rate
    range: Range | None = None


@dataclass(frozen=True, slots=True)
class HistogramBin(Element):
    weight: Weight
    range: Range


@dataclass(frozen=True, slots=True)
class Histogram(Element):
    """A bin is chosen by its weight, the value evenly inside it."""

    bins: tuple[HistogramBin, ...] = field(metadata=xml("Bin"))


StochasticDistributionType: TypeAlias = (
    ProbabilityDistributionSet
    | NormalDistribution
    | LogNormalDistribution
    | UniformDistribution
    | PoissonDistribution
    | Histogram
    | UserDefinedDistribution
)


@dataclass(frozen=True, slots=True)
class StochasticDistribution(Element):
    parameter_name: str
    distribution: StochasticDistributionType = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class Stochastic(Element):
    """`random_seed`: None lets whoever runs it choose."""

    number_of_test_runs: Runs
    stochastic_distributions: tuple[StochasticDistribution, ...]
    random_seed: Number | None = None


@dataclass(frozen=True, slots=True)
class ParameterValueDistribution(Element):
    scenario_file: ScenarioFile
    definition: Deterministic | Stochastic = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class DistributionFile(Element):
    """A file that varies the parameters of a scenario; `sha256` of its own bytes."""

    file_header: FileHeader
    distribution: ParameterValueDistribution
    path: Path = field(default=Path(), compare=False)
    sha256: str = field(default="", compare=False)
