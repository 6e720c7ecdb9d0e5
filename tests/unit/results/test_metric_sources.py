"""Metrics against computations that share nothing with them (scripts/metric_sources.py), on random logs."""

from __future__ import annotations

import math
import os

import pytest

from scripts.metric_sources import compared

CASES = (
    int(os.environ.get("DVP_CASES", "200")) // 10
)  # logs; `make nightly` takes 1,000, docs/metrics.md tells of 10,000


@pytest.fixture(scope="module")
def both() -> dict[str, list[tuple[float | None, float | None]]]:
    """By metric: its value and that of its peer in each log; None: undefined."""
    found: dict[str, list[tuple[float | None, float | None]]] = {}
    for seed in range(CASES):
        for name, value, expected in compared(seed):
            found.setdefault(name, []).append((value, expected))
    return found


def test_metrics_agree_with_their_independent_sources(
    both: dict[str, list[tuple[float | None, float | None]]],
) -> None:
    assert len(both) >= 46
    for name, pairs in both.items():
        for value, expected in pairs:
            assert value == (None if expected is None else pytest.approx(expected, rel=1e-6, abs=1e-6)), name


def test_the_logs_define_each_metric_and_do_not_leave_it_at_nought(
    both: dict[str, list[tuple[float | None, float | None]]],
) -> None:
    """A comparison of what is never defined, or always 0, would show nothing."""
    sizes = {name: max((abs(v) for v, _ in pairs if v is not None), default=math.nan) for name, pairs in both.items()}
    rare = {"start_up_delay", "red_light", "stop_error", "creep", "lane_time_outside"}
    assert {name for name, size in sizes.items() if not size > 0.0} <= rare
