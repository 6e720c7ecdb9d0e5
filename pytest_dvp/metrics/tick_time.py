"""How long the stack took for its ticks: of the run, not of the log."""

from __future__ import annotations

from typing import Literal

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, MetricError, metric

STATISTICS = ("median", "p99", "worst")


@metric(name="tick_time", unit="s", bigger_is_worse=True, note="wall time, {statistic}", open_loop=True)
def tick_time(log: Log, *, statistic: Literal["median", "p99", "worst"] = "p99") -> Measured:
    """Wall time of the stack's own computing for a tick, the first tick aside; its cycle is 0.05 s.

    `statistic` is median, p99 (99 % of the ticks are within it) or worst; all three are in `extra`, with `exceeded`,
    the number of ticks that took longer than the cycle. Time in which numba compiles or loads compiled code does not
    count, nor does the way to a process of its own and back. It is another on each machine and in each run, and
    therefore in result.json and not in the log: undefined for a bare log.

    Raises MetricError for another `statistic`, and Undefined for a bare log or if there was no tick but the first.
    """
    if statistic not in STATISTICS:
        raise MetricError(f"option 'statistic' of metric 'tick_time': found {statistic!r}, allowed: median, p99, worst")
    figures = log.tick_time
    if figures is None:
        raise Undefined("a log knows no wall clock; the tick times of a run are in its result.json")
    value = figures.get(statistic)
    if value is None:
        raise Undefined("no tick but the first")
    extra = {name: float(figures[name]) for name in (*STATISTICS, "exceeded")}
    return Measured(float(value), extra=extra)
