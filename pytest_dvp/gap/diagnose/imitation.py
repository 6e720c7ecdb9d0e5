"""Which values of effects the known remainder of a twin imitates: each effect asked for on drives that hide nothing.

The twin was learnt on drives without anything new. What a fit of an effect finds there is made of the remainder alone,
and on another drive of the same car as much of it is to be expected again: a control without treatment, as in a trial
with placebos. To first order, at two places of the effect's range, in the metric of `lasting_remainder`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pytest_dvp.gap.diagnose.candidates import Candidate, says_how
from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.diagnose.lasting_remainder import rounded_imitation
from pytest_dvp.gap.diagnose.least_squares import STEP
from pytest_dvp.gap.diagnose.linear_algebra import gram, row_products, square

SHOWN = 25.0  # of chi^2 per square of an effect's range: with less, these drives say nothing of it
FARTHEST = 1.0  # of a key's range: beyond it a first order means nothing
_RIDGE = 1e-6  # of the diagonal, for keys that cannot be told apart


def imitation(groups: Iterable[ExperimentSet], tried: Sequence[Candidate]) -> dict[str, dict[str, float]]:
    """Root mean square over the groups of logs of what each key of an effect is off by, in its unit."""
    found: dict[tuple[str, str], list[float]] = {}
    for group in groups:
        target = group.lasting()
        target.settle({})
        rest = target.whitened({})
        for candidate in tried:
            for place in sorted({0, len(candidate.points) // 2}):
                point = candidate.points[place]
                here = target.whitened(point)
                rows = []
                for c in candidate.coordinates:
                    u = c.to_unit(point[c.name])
                    step = STEP if u < 0.5 else -STEP
                    rows.append((target.whitened({**point, c.name: c.value(u + step)}) - here) / step)
                jacobian = np.array(rows)
                seen = [k for k in range(len(rows)) if square(jacobian[k]) > SHOWN]
                sized = [k for k in seen if not says_how(candidate.coordinates[k].key)]
                if not sized and len(seen) < len(rows):
                    continue
                normal = gram(jacobian[seen])
                normal += _RIDGE * np.diag(np.diag(normal))
                moved = -np.linalg.solve(normal, row_products(jacobian[seen], rest))
                for k, u in zip(seen, np.clip(moved, -FARTHEST, FARTHEST), strict=True):
                    c = candidate.coordinates[k]
                    found.setdefault(c.name, []).append(float(u) * c.slope(c.to_unit(point[c.name])))
    return rounded_imitation(found)
