"""What is to become small: declared metrics with weights and scales, and what must never happen."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

from pytest_dvp.workers.errors import TuneError

Kind: TypeAlias = Literal["performance", "alignment"]
Metrics: TypeAlias = Mapping[str, float | None]
"""Metrics of one simulation or one replayed log by name; None where undefined."""

FORBIDDEN = 1e6
"""Score of a point that breaks a hard constraint or leaves a term undefined, before what it broke is added: behind
every point that does not."""

BROKE_OFF = "broke_off"
"""Among the metrics of a simulation that broke off: 1."""

BLIND = ("mncc",)
"""Metrics that must not decide alone: they are blind to gain, delay and bias."""
SIGHTED = ("chi2_per_n", "nrmse")
"""Of these an alignment needs one."""


@dataclasses.dataclass(frozen=True, slots=True)
class Term:
    """`weight * |value - target| / scale` of one metric, mean over the simulations.

    above: only what is more than the target costs. A chi^2/N below 1 is no better than 1: whoever turns a parameter
    for it fits noise, and whoever turns one to bring it up to 1 spoils the twin.
    """

    metric: str
    scale: float
    weight: float = 1.0
    target: float = 0.0
    above: bool = False

    def cost(self, value: float) -> float:
        """What a value of the metric costs, >= 0, for a positive weight and scale."""
        if self.above and value < self.target:
            return 0.0
        return self.weight * abs(value - self.target) / self.scale


@dataclasses.dataclass(frozen=True, slots=True)
class Constraint:
    """Bounds that hold in every simulation: low <= value <= high, in the metric's unit."""

    metric: str
    high: float = math.inf
    low: float = -math.inf

    def excess(self, value: float | None) -> float:
        """By how much it is broken, 0 if it holds; an undefined value breaks it by 1."""
        if value is None or not math.isfinite(value):
            return 1.0
        return max(0.0, value - self.high, self.low - value)

    def broken(self, values: Sequence[float]) -> list[str]:
        """Which of its bounds defined values break, in words: `tet > 0`, `recall < 0.9`."""
        above = [f"{self.metric} > {self.high:g}"] if any(value > self.high for value in values) else []
        below = [f"{self.metric} < {self.low:g}"] if any(value < self.low for value in values) else []
        return above + below


@dataclasses.dataclass(frozen=True, slots=True)
class Score:
    """How good a point is: `value`, smaller is better; `parts` what each term adds; `broken` in words, empty if
    nothing that must hold is broken."""

    value: float
    parts: Mapping[str, float]
    broken: tuple[str, ...] = ()

    @property
    def allowed(self) -> bool:
        """Whether nothing that must hold is broken."""
        return not self.broken


@dataclasses.dataclass(frozen=True, slots=True)
class Objective:
    """Terms and constraints of one kind. Raises TuneError for an alignment that only MNCC judges."""

    kind: Kind
    terms: tuple[Term, ...]
    constraints: tuple[Constraint, ...] = ()

    def __post_init__(self) -> None:
        if not self.terms:
            raise TuneError("objective: no [[term]], so nothing could become better")
        seen = {word for term in self.terms if term.weight > 0.0 for word in term.metric.split(".")}
        if self.kind == "alignment" and not seen & set(SIGHTED):
            raise TuneError(
                f"objective: an alignment needs a term {' or '.join(SIGHTED)}: {', '.join(BLIND)} alone is blind to "
                "gain, delay and bias"
            )

    @property
    def metrics(self) -> tuple[str, ...]:
        """The metrics that it looks at, each once: of the terms, then of the constraints."""
        names = [*(term.metric for term in self.terms), *(constraint.metric for constraint in self.constraints)]
        return tuple(dict.fromkeys(names))

    def score(self, results: Sequence[Metrics]) -> Score:
        """Of the simulations of one point."""
        broken: list[str] = []
        undefined: list[str] = []
        excess = float(sum(BROKE_OFF in metrics for metrics in results))
        if excess:
            broken.append("the drive broke off")
        for constraint in self.constraints:
            values = [metrics.get(constraint.metric) for metrics in results]
            excess += sum(constraint.excess(value) for value in values)
            known = [value for value in values if value is not None and math.isfinite(value)]
            broken += constraint.broken(known)
            undefined += [] if len(known) == len(values) else [constraint.metric]
        parts: dict[str, float] = {}
        for term in self.terms:
            costs = [_cost(term, metrics.get(term.metric)) for metrics in results]
            defined = [cost for cost in costs if cost is not None]
            if len(defined) < len(costs):
                undefined.append(term.metric)
                excess += float(len(costs) - len(defined))
            cost = sum(defined) / len(defined) if defined else 0.0
            parts[term.metric] = parts.get(term.metric, 0.0) + cost
        broken += [f"{name} undefined" for name in dict.fromkeys(undefined)]
        total = sum(parts.values())
        return Score(FORBIDDEN + 1e3 * excess + total if broken else _below_forbidden(total), parts, tuple(broken))


def _below_forbidden(total: float) -> float:
    """The sum of the terms; one beyond half of FORBIDDEN, as a tiny scale gives it, is drawn below it in its order."""
    return total if total <= 0.5 * FORBIDDEN else FORBIDDEN * (1.0 - 0.25 * FORBIDDEN / total)


def metrics_of(result: Mapping[str, Any]) -> Metrics:
    """The metrics of a job's result: of one that broke off none is defined, as the part that was driven shows nothing
    of the rest, and a drive that ends at once has no jerk and hits nobody."""
    metrics: Metrics = result["metrics"]
    return {**dict.fromkeys(metrics), BROKE_OFF: 1.0} if result.get("error") else metrics


def _cost(term: Term, value: float | None) -> float | None:
    return term.cost(value) if value is not None and math.isfinite(value) else None


PERFORMANCE = Objective(
    "performance",
    (
        Term("lateral_rmse_path", 0.30, 1.0),
        Term("max_jerk", 1.8, 1.0),
        Term("max_ttc_inverse", 0.37, 1.0),
        Term("completion_time", 107.0, 1.0),
        Term("detection_error", 0.2, 0.5),
    ),
    (
        Constraint("collision", 0.0),
        Constraint("tet", 0.0),
        Constraint("road_departure", 0.0),
        Constraint("missed_events", 0.0),
    ),
)
"""Ego performance as the paper's last table has it, and where its perception puts others; scales are what is to be
reached."""

ALIGNMENT = Objective(
    "alignment",
    (
        Term("log10.chi2_per_n", 1.0, 1.0, above=True),
        *(Term(f"nrmse.{name}", 0.01, 0.1) for name in ("x", "y", "v", "steer", "yaw_rate")),
        *(Term(f"mncc.{name}", 0.01, 0.1, target=1.0) for name in ("v", "steer", "yaw_rate")),
        *(Term(f"gain.{name}", 0.02, 0.1, target=1.0) for name in ("v", "steer")),
        *(Term(f"lag.{name}", 0.05, 0.1) for name in ("v", "steer")),
    ),
)
"""Likeness of twin and car, open loop: chi^2/N on a logarithmic scale, as it falls over decades, then the rest."""
