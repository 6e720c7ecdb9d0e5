"""Bounds on a comparison: what `assert_matches` and the gate kind `model` judge."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import TypeAlias

from pytest_dvp.gap.compare.bound_values import KINDS, wrong_bound
from pytest_dvp.gap.compare.compare import Comparison
from pytest_dvp.gap.compare.segments import CHANNELS, UNITS
from pytest_dvp.gap.compare.time_alignment import MAX_LAG

Bound: TypeAlias = float | Mapping[str, float]

NO_SIGNAL = "every signal"  # in place of a name, where a number for all signals bounds none: nothing was judged
ALIKE = 0.5  # MNCC from which a signal tells a lag or a gain; chosen


@dataclasses.dataclass(frozen=True, slots=True)
class BoundCheck:
    """One bound on one signal. value None: the signal was not compared or the figure is not defined, `reason` says
    why; such a bound does not hold."""

    kind: str
    signal: str
    value: float | None
    bound: float
    unit: str
    holds: bool
    reason: str = ""

    def __str__(self) -> str:
        name = f"{self.kind} of {self.signal}"
        unit = "" if self.unit == "-" else f" {self.unit}"
        if self.value is None:
            return f"{name}: {self.reason}"
        relation = ("<=" if self.holds else ">") if self.kind != "mncc" else (">=" if self.holds else "<")
        value, bound = _apart(self.value, self.bound)
        return f"{name} {value}{unit} {relation} {bound}{unit}"


def _apart(value: float, bound: float) -> tuple[str, str]:
    """Both with as few digits as keep them apart: a value that broke its bound must not read like it."""
    for digits in range(4, 17):
        one, two = f"{value:.{digits}g}", f"{bound:.{digits}g}"
        if one != two or value == bound:
            break
    return one, two


def check_bounds(bounds: Mapping[str, Bound | None]) -> None:
    """Raises ValueError, one line, at the first bound that no comparison could keep or break, as a negative lag."""
    for kind, bound in bounds.items():
        for signal, value in bound.items() if isinstance(bound, Mapping) else [("", bound)]:
            wrong = wrong_bound(kind, value)
            if value is not None and wrong:
                raise ValueError(f"{kind}{f' of {signal}' if signal else ''} {wrong}; found {value!r}")


def judge_bounds(comparison: Comparison, bounds: Mapping[str, Bound | None]) -> list[BoundCheck]:
    """Each bound of each kind (see KINDS) held against a comparison, in order. A single number for lag or gain bounds
    every signal that tells it: those with an MNCC of at least 0.5. It does not hold if there is none."""
    return [_judged(comparison, *item) for item in _items(comparison, bounds)]


def _items(comparison: Comparison, bounds: Mapping[str, Bound | None]) -> Iterator[tuple[str, str, float]]:
    for kind in KINDS:
        bound = bounds.get(kind)
        if bound is None:
            continue
        if isinstance(bound, Mapping):
            yield from ((kind, signal, float(value)) for signal, value in bound.items())
            continue
        told = [
            signal
            for signal, score in comparison.signals.items()
            # Positions are known only up to each segment's start: they tell neither lag nor gain
            if kind in ("rmse", "mncc") or (signal not in ("x", "y") and (score.mncc or 0.0) >= ALIKE)
        ]
        yield from ((kind, signal, float(bound)) for signal in told or [NO_SIGNAL])


def _judged(comparison: Comparison, kind: str, signal: str, bound: float) -> BoundCheck:
    unit = {"rmse": UNITS.get(signal, "-"), "lag": "s"}.get(kind, "-")
    if signal == NO_SIGNAL:
        why = f"no signal tells it: none that is compared, x and y aside, has an MNCC of {ALIKE:g} or more"
        return BoundCheck(kind, signal, None, bound, unit, False, why)
    score = comparison.signals.get(signal)
    if score is None:
        why = comparison.not_compared.get(signal, "no such signal; known: " + ", ".join(CHANNELS))
        return BoundCheck(kind, signal, None, bound, unit, False, f"not compared ({why})")
    value = {"rmse": score.rmse, "mncc": score.mncc, "lag": score.lag, "gain": score.gain}[kind]
    if value is None or value != value:
        why = "the signal is constant or has no samples"
        if kind == "lag" and score.mncc is not None:
            why = f"the best lag is beyond the {MAX_LAG:g} s that are looked at"
        return BoundCheck(kind, signal, None, bound, unit, False, f"not defined: {why}")
    if kind == "mncc":
        return BoundCheck(kind, signal, value, bound, unit, value >= bound)
    value = {"rmse": value, "lag": abs(value), "gain": abs(value - 1.0)}[kind]
    return BoundCheck(kind, signal, value, bound, unit, value <= bound)
