"""What a metric is: a documented function of one log, or of two."""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from types import SimpleNamespace
from typing import Annotated, Any, Literal, TypeAlias, get_args, get_origin, get_type_hints

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


Positive: TypeAlias = Annotated[float, Range(0.0, above=True)]
NotNegative: TypeAlias = Annotated[float, Range(0.0)]


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
    types            of an option without a default, by its name: str or float, where its function says so
    words            the words that an option may be, by its name: those of its type `Literal["mean", "greatest"]`
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
    types: Mapping[str, type] = dataclasses.field(default_factory=dict)
    words: Mapping[str, tuple[str, ...]] = dataclasses.field(default_factory=dict)

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
) -> Callable[[Callable[..., Measured]], Metric]:
    """Make a metric of a function `f(log, *, options...)` or `f(model, measured, *, options...)`.

    The function raises Undefined where the log does not define the metric. `note` may hold `{option}` fields.
    The numbers that an option may be stand in its type: `Annotated[float, Range(0.0)]`. A type that cannot be resolved
    with the names of the function's module states none.
    """

    def wrap(function: Callable[..., Measured]) -> Metric:
        parameters = inspect.signature(function).parameters.values()
        known = getattr(inspect.unwrap(function), "__globals__", {})
        logs = sum(p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters)
        options = {p.name: p.default for p in parameters if p.kind == p.KEYWORD_ONLY}
        hints = {p.name: _hint(p.annotation, known) for p in parameters if p.kind == p.KEYWORD_ONLY}
        ranges = {
            key: next((part for part in _parts(hint) if isinstance(part, Range)), None) for key, hint in hints.items()
        }
        plain = {key: getattr(hint, "__origin__", hint) for key, hint in hints.items()}  # of an Annotated its type
        return Metric(
            name=name,
            unit=unit,
            bigger_is_worse=bigger_is_worse,
            logs=logs,
            definition=inspect.cleandoc(function.__doc__ or ""),
            note=note,
            options=options,
            function=function,
            miss=miss,
            open_loop=open_loop,
            ideal=ideal,
            scale=scale,
            ranges={key: allowed for key, allowed in ranges.items() if allowed is not None},
            words={key: get_args(hint) for key, hint in hints.items() if get_origin(hint) is Literal},
            types={key: kind for key, kind in plain.items() if options[key] is REQUIRED and kind in (str, float)},
        )

    return wrap


def _hint(annotation: Any, known: dict[str, Any]) -> Any:
    """The type of one option; None if it has none, or one that names what is not `known`.

    Each option by itself: the log's type is often imported for type checkers alone, and need not be resolved.
    """
    holder = SimpleNamespace(__annotations__={"option": annotation})
    try:
        return get_type_hints(holder, known, include_extras=True)["option"]
    except Exception:  # a type of another package may be any expression
        return None


def _parts(hint: Any) -> Iterator[Any]:
    """What a type is made of, in any depth: of `Annotated[float, Range(0.0)] | None` also the range."""
    for part in get_args(hint):
        yield part
        yield from _parts(part)
