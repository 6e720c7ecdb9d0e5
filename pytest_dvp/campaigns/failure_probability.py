"""How likely a failure is: intervals of a probability, from independent draws or from weighted ones."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

LEVEL = 0.95  # of every interval here


@dataclasses.dataclass(frozen=True)
class Probability:
    """A probability of failure with its interval at LEVEL.

    low, high    ends of the interval; an undecided drive counts as a pass in `low` and as a failure in `high`
    runs         drives that it rests on; failures and undecided: of them
    method       how it was estimated, as a phrase
    """

    estimate: float
    low: float
    high: float
    runs: int
    failures: int
    undecided: int
    method: str

    def as_dict(self) -> dict[str, float | int | str]:
        """Plain data."""
        return dataclasses.asdict(self)

    def text(self) -> str:
        """One sentence."""
        counted = f"{self.failures} failures in {self.runs} runs"
        counted += f", of which {self.undecided} decided nothing, which widens it" if self.undecided else ""
        if self.failures == 0:
            return f"probability of failure at most {self.high:.2g} (95 %), {counted}, {self.method}"
        return (
            f"probability of failure {self.estimate:.2g}, 95 % between {self.low:.2g} and {self.high:.2g}, {counted}, "
            f"{self.method}"
        )


def clopper_pearson(failures: int, undecided: int, runs: int) -> Probability:
    """The exact interval of a share of independent drives; with no failure, a bound from above alone.

    Two sides of 2.5 % each where there are failures. With none the lower end is 0 and all 5 % lie above: about 3/n, the
    rule of three. Source: Clopper and Pearson, Biometrika 26 (1934).

    Raises ValueError unless 0 <= failures + undecided <= runs and runs > 0.
    """
    from scipy.stats import beta

    if runs < 1 or failures < 0 or undecided < 0 or failures + undecided > runs:
        raise ValueError(f"{failures} failures and {undecided} undecided of {runs} runs: no share of them")
    worst = failures + undecided
    tail = (1.0 - LEVEL) / (2.0 if failures else 1.0)
    low = float(beta.ppf(tail, failures, runs - failures + 1)) if failures else 0.0
    high = float(beta.ppf(1.0 - tail, worst + 1, runs - worst)) if worst < runs else 1.0
    return Probability(failures / runs, low, high, runs, failures, undecided, "independent draws, Clopper-Pearson")


def weighted(weights: FloatArray, failed: FloatArray, undecided: FloatArray, runs: int, method: str) -> Probability:
    """The interval of a mean of independent weighted draws.

    weights, failed, undecided: arrays (n,): likelihood ratios without unit, and masks of 0 and 1. runs: all that were
    spent, with those that shaped the distribution drawn from.

    The weighted mean is divided by nothing, so it is unbiased. Its interval is symmetric in the logarithm, with
    Student's t for as many degrees of freedom as there are effective failures: a few heavy weights are few draws. Its
    upper end is that with one more failure, as heavy as the heaviest, as in the interval of Clopper and Pearson:
    weights are skewed, and the rare heavy ones that were not drawn leave no trace in the spread.
    """
    low_estimate, low, _ = _log_interval(weights * failed)
    worst = weights * np.maximum(failed, undecided)
    _, _, high = _log_interval(np.append(worst, worst.max(initial=0.0)))
    count = int(failed.sum())
    if count == 0:
        # What was drawn from may have missed the failures: only the plain bound of the draws with weights holds.
        heaviest = float(weights.max()) if len(weights) else 1.0
        high = max(high, min(1.0, -math.log(1.0 - LEVEL) / max(len(weights), 1) * max(heaviest, 1.0)))
        return Probability(0.0, 0.0, high, runs, 0, int(undecided.sum()), method)
    return Probability(min(low_estimate, 1.0), low, min(high, 1.0), runs, count, int(undecided.sum()), method)


def _log_interval(parts: FloatArray) -> tuple[float, float, float]:
    """Mean of (n,) parts >= 0 without unit, and the ends of its interval; 0, 0, 0 if all are 0."""
    from scipy.stats import t

    mean = float(parts.mean()) if len(parts) else 0.0
    if mean <= 0.0:
        return 0.0, 0.0, 0.0
    spread = float(parts.std(ddof=1)) / math.sqrt(len(parts)) / mean
    effective = float(parts.sum() ** 2 / (parts**2).sum())
    reach = float(t.ppf(0.5 + 0.5 * LEVEL, max(effective - 1.0, 1.0))) * spread
    return mean, mean * math.exp(-reach), mean * math.exp(reach)
