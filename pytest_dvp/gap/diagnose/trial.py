"""Trial: a set of effects, fitted jointly."""

from __future__ import annotations

import dataclasses

from pytest_dvp.gap.diagnose.least_squares import Fit
from pytest_dvp.logs.log_contents import FloatArray


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """A set of effects, fitted jointly. values: all that make the model what it is, fitted or not; rest (m,): sum of
    squares by segment."""

    names: tuple[str, ...]
    values: dict[tuple[str, str], float]
    fit: Fit
    segment_chi2: FloatArray

    @property
    def chi2(self) -> float:
        """Sum of squares."""
        return self.fit.chi2
