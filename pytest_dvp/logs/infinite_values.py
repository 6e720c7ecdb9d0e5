"""Infinite values of a file, which no sensor measures: they count as not measured, and that is told."""

from __future__ import annotations

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.logs.log_contents import FloatArray


def without_infinite(
    values: FloatArray, file: str, lines: np.ndarray | None, element: str, findings: Findings
) -> FloatArray:  # fmt: skip
    """The values (n,) in their own unit, NaN in place of infinite ones, with a warning that names the first of them.

    lines: of each row in the file; None where it has none.
    """
    endless = np.flatnonzero(np.isinf(values))
    if not len(endless):
        return np.ascontiguousarray(values)
    findings.add(
        "value.not_finite", file, None if lines is None else int(lines[endless[0]]), element,
        f"{len(endless)} values are infinite; they count as not measured", found=str(values[endless[0]]),
        allowed="finite numbers", severity="warning",
    )  # fmt: skip
    kept = np.array(values)
    kept[endless] = np.nan
    return kept
