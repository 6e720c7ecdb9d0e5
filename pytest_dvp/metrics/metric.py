"""What a metric is: a documented function of one log, or of two."""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

from pytest_dvp.logs.log_contents import FloatArray

Miss: TypeAlias = Literal["FAIL", "INCONCLUSIVE"]
"""What a broken bound on a metric means: the ADS failed, or what was to be tested did not take place."""


class MetricError(ValueError):
    """A metric was asked for wrongly (unknown name or option); the message names the nearest valid one."""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Series:
    """Course of a metric for pictures: arrays (n,) of t [s] and of the value in the metric's unit."""

    t: FloatArray
    value: FloatArray


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Measured:
    """What a metric's function returns: value, time [s] and object of the worst moment, course, further figures; the
    unit where it depends on the options."""

    value: float
    t: float | None = None
    object: str = ""
    series: Series | None = None
    extra: Mapping[str, float] = dataclasses.field(default_factory=dict)
    unit: str = ""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class MetricValue:
    """A metric of a log. `value` is finite if `valid`, else None and `reason` says why.

    `note` tells what the number depends on (a filter, a threshold); `extra` holds the same quantity under other
    choices of it.
    """

    name: str
    value: float | None
    unit: str
    t: float | None
    object: str
    valid: bool
    reason: str
    series: Series | None
    extra: Mapping[str, float]
    note: str

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able data, as reports and result files hold it."""
        course = None
        if self.series is not None:
            course = {"t": self.series.t.tolist(), "value": self.series.value.tolist()}
        return {
            "value": self.value,
            "unit": self.unit,
            "t": self.t,
            "object": self.object,
            "valid": self.valid,
            "reason": self.reason,
            "note": self.note,
            "extra": dict(self.extra),
            "series": course,
        }


@dataclasses.dataclass(frozen=True, slots=True)
class Range:
    """Numbers that an option of a metric may be, in the option's unit: from `low` to `high`, both included.

    above: `low` itself is excluded. `str()` says it in words: "> 0 and <= 0.1".
    """

    low: float = -math.inf
    high: float = math.inf
    above: bool = False

    def holds(self, value: float) -> bool:
        """Whether a number is in the range."""
        return (value > self.low if self.above else value >= self.low) and value <= self.high

    def __str__(self) -> str:
        ends = [f"{'>' if self.above else '>='} {self.low:g}"] if math.isfinite(self.low) else []
        ends += [f"<= {self.high:g}"] if math.isfinite(self.high) else []
        return " and ".join(ends)


POSITIVE = Range(0.0, above=True)
NOT_NEGATIVE = Range(0.0)
LOW_PASS = Range(0.1)  # Hz, chosen: a low pass of less leaves nothing of a manoeuvre that takes seconds


@dataclasses.dataclass(frozen=True, slots=True)
class Metric:
    """A metric of the catalogue.

    bigger_is_worse  direction; None if neither (a time lag)
    logs             1, or 2 for a comparison (model, measured)
    definition       its docstring: meaning, source, filter
    miss             verdict of a broken bound: FAIL, or INCONCLUSIVE if it says that the test itself did not take place
    ideal            the value that could not be better, where that is not 0 for "smaller is better": 1 of a likeness
    open_loop        says something of stack or car even where the ego's motion is a recording's, not the stack's doing
    scale            how much of it, in its unit, counts as one whole margin in a campaign where a gate's bound is 0
    options          keyword arguments of the function with their defaults; REQUIRED for those without
    ranges           the numbers that an option may be, by its name; any finite number for one that is not named
    """

    name: str
    unit: str
    bigger_is_worse: bool | None
    logs: int
    definition: str
    note: str
    options: Mapping[str, Any]
    function: Callable[..., Measured]
    miss: Miss = "FAIL"
    open_loop: bool = False
    ideal: float | None = None
    scale: float = 1.0
    ranges: Mapping[str, Range] = dataclasses.field(default_factory=dict)

    def __call__(self, *logs: Any, **options: Any) -> Measured:
        return self.function(*logs, **options)


REQUIRED = inspect.Parameter.empty
"""Default of an option that has none."""


def metric(
    *,
    name: str,
    unit: str,
    bigger_is_worse: bool | None,
    note: str = "",
    miss: Miss = "FAIL",
    open_loop: bool = False,
    ideal: float | None = None,
    scale: float = 1.0,
    ranges: Mapping[str, Range] = MappingProxyType({}),
) -> Callable[[Callable[..., Measured]], Metric]:
    """Make a metric of a function `f(log, *, options...)` or `f(model, measured, *, options...)`.

    The function raises Undefined where the log does not define the metric. `note` may hold `{option}` fields.
    Raises ValueError for a range of what is no option.
    """

    def wrap(function: Callable[..., Measured]) -> Metric:
        parameters = inspect.signature(function).parameters.values()
        logs = sum(p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters)
        options = {p.name: p.default for p in parameters if p.kind == p.KEYWORD_ONLY}
        text = inspect.cleandoc(function.__doc__ or "")
        if not ranges.keys() <= options.keys():
            raise ValueError(
                f"ranges of metric {name!r} name {sorted(ranges.keys() - options.keys())}: no option of it"
            )
        return Metric(
            name,
            unit,
            bigger_is_worse,
            logs,
            text,
            note,
            options,
            function,
            miss,
            open_loop,
            ideal,
            scale,
            dict(ranges),
        )

    return wrap
