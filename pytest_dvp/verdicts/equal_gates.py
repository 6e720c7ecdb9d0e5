"""Gates of one file that ask the same twice: the second one of them is a slip, and tests nothing."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from openscenario.findings import Finding
from pytest_dvp.metrics import find_metric
from pytest_dvp.metrics.metric import REQUIRED
from pytest_dvp.verdicts.gate import Gate


def repeated(gates: Sequence[Gate]) -> Iterator[Finding]:
    """Findings of a file's gates: an error where two are equal on a stage, a warning where one can never decide.

    Equal gates have the same metric with the same options, and the same bounds. One whose bounds another one implies
    on all of its stages can never decide.
    """
    for first, second in itertools.combinations(gates, 2):
        if (first.metric, first.between, _options(first)) != (second.metric, second.between, _options(second)):
            continue
        common = [stage for stage in first.stages if stage in second.stages]
        if not common:
            continue
        if _bounds(first) == _bounds(second):
            text = f"the same gate on {second.metric} as in line {first.line}, on stage {', '.join(common)}"
            yield _finding("equal", "error", second, text, "another bound, other options, or other stages; or one gate")
            continue
        for loose, tight in ((second, first), (first, second)):
            if set(loose.stages) <= set(tight.stages) and _implies(tight, loose):
                text = f"this gate on {loose.metric} never decides: that of line {tight.line} is tighter"
                yield _finding("never_decides", "warning", loose, text, "")


def _finding(code: str, severity: Any, gate: Gate, text: str, allowed: str) -> Finding:
    return Finding(f"dvp.gates.{code}", severity, gate.file, gate.line, "gate", text=text, allowed=allowed)


def _options(gate: Gate) -> Mapping[str, Any]:
    """The options in force, those with a default as well; names in a list are meant in any order."""
    defaults = {name: value for name, value in find_metric(gate.metric).options.items() if value is not REQUIRED}
    return {
        name: sorted(value) if isinstance(value, list | tuple) else value
        for name, value in {**defaults, **gate.options}.items()
    }


def _bounds(gate: Gate) -> tuple[float, float, float]:
    """Lower bound, upper bound and allowed difference; infinite where there is none."""
    return (
        -math.inf if gate.min is None else gate.min,
        math.inf if gate.max is None else gate.max,
        math.inf if gate.max_difference is None else gate.max_difference,
    )


def _implies(tight: Gate, loose: Gate) -> bool:
    """Whether what meets the bounds of one gate meets those of the other."""
    (low, high, apart), (lower, higher, further) = _bounds(tight), _bounds(loose)
    return low >= lower and high <= higher and apart <= further
