"""Metrics: Log -> value, unit, time and object of the worst moment, validity.

A new metric is one file with a decorated function:

    from pytest_dvp.metrics import Measured, metric

    @metric(name="max_speed", unit="m/s", bigger_is_worse=True)
    def max_speed(log):
        "Greatest speed of the run."
        worst = log["v"].argmax()
        return Measured(log["v"][worst], t=log.t[worst])

A package of its own offers its module under the entry point group `pytest_dvp.metrics`.
"""

from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Metric, MetricError, MetricValue, Range, Series, metric
from pytest_dvp.metrics.registry import compute, find_metric, known_metrics

__all__ = [
    "Measured",
    "Metric",
    "MetricError",
    "MetricValue",
    "Range",
    "Series",
    "Undefined",
    "compute",
    "find_metric",
    "known_metrics",
    "metric",
]
